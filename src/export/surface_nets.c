// The zero of a signed distance as quads: a vertex in every cell that it crosses, at the mean of the
// crossings of the cell's edges; a quad for every edge between two points that it crosses (Gibson 1998).
#include <tgmath.h>

#include "base/alloc.h"
#include "base/vec.h"
#include "export/volume.h"

#define NONE UINT32_MAX

typedef struct Net {
    const FfpVolume *volume;
    uint32_t *vertex; // [cells] or NONE; a cell has the index of its lowest point
    FfpSurface *mesh;
    size_t room;
} Net;

static size_t index_of(const FfpVolume *v, int x, int y, int z) {
    return ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;
}

static real corner(const FfpVolume *v, const int cell[3], int k) {
    return v->distance[index_of(v, cell[0] + (k & 1), cell[1] + (k >> 1 & 1), cell[2] + (k >> 2))];
}

// Mean of the crossings in cell units from its lowest corner; false where there are none.
static bool crossing(const FfpVolume *v, const int cell[3], real mean[3]) {
    int n = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (int a = 0; a < 8; a++) {
        for (int axis = 0; axis < 3; axis++) {
            const int b = a | 1 << axis;
            if (b == a) continue;
            const real from = corner(v, cell, a), to = corner(v, cell, b);
            if ((from > 0) == (to > 0)) continue;
            for (int k = 0; k < 3; k++) mean[k] += (real)(a >> k & 1) + (k == axis ? from / (from - to) : 0);
            n++;
        }
    }
    for (int k = 0; k < 3 && n > 0; k++) mean[k] /= (real)n;
    return n > 0;
}

// The distance's gradient over the cell, away from the object.
static void slope_of(const FfpVolume *v, const int cell[3], real normal[3]) {
    for (int k = 0; k < 3; k++) normal[k] = 0;
    for (int a = 0; a < 8; a++)
        for (int k = 0; k < 3; k++) normal[k] += (a >> k & 1 ? 1 : -1) * corner(v, cell, a);
    ffp_normalise3(normal);
}

static void add_vertex(Net *net, const int cell[3], size_t at) {
    const FfpVolume *v = net->volume;
    FfpSurface *mesh = net->mesh;
    real mean[3];
    net->vertex[at] = NONE;
    if (!crossing(v, cell, mean)) return;
    if (mesh->n_vertices == net->room) {
        net->room = 2 * net->room + 1024;
        mesh->position = ffp_grow(mesh->position, net->room, 3 * sizeof(real));
        mesh->normal = ffp_grow(mesh->normal, net->room, 3 * sizeof(real));
    }
    const size_t i = 3 * (size_t)mesh->n_vertices;
    for (int k = 0; k < 3; k++)
        mesh->position[i + (size_t)k] = v->low[k] + ((real)cell[k] + mean[k]) * v->cell;
    slope_of(v, cell, mesh->normal + i);
    net->vertex[at] = mesh->n_vertices++;
}

static void add_vertices(Net *net) {
    const int *size = net->volume->size;
    for (int z = 0; z + 1 < size[2]; z++)
        for (int y = 0; y + 1 < size[1]; y++)
            for (int x = 0; x + 1 < size[0]; x++)
                add_vertex(net, (const int[3]){x, y, z}, index_of(net->volume, x, y, z));
}

// The quad around the edge from `at` along an axis, through the four cells that share it, in the order that
// turns right-handed about the axis; the other way round where the object is behind.
static void add_quad(Net *net, const int at[3], int axis, size_t *room) {
    static const int turns[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
    const FfpVolume *v = net->volume;
    FfpSurface *mesh = net->mesh;
    int beyond[3] = {at[0], at[1], at[2]};
    beyond[axis]++;
    const bool out = v->distance[index_of(v, at[0], at[1], at[2])] > 0;
    if (out == (v->distance[index_of(v, beyond[0], beyond[1], beyond[2])] > 0)) return;
    if (mesh->n_quads == *room) {
        *room = 2 * *room + 1024;
        mesh->quads = ffp_grow(mesh->quads, *room, 4 * sizeof *mesh->quads);
    }
    for (int k = 0; k < 4; k++) {
        int cell[3] = {at[0], at[1], at[2]};
        const int *turn = turns[out ? 3 - k : k];
        cell[(axis + 1) % 3] += turn[0], cell[(axis + 2) % 3] += turn[1];
        mesh->quads[4 * (size_t)mesh->n_quads + (size_t)k] =
            net->vertex[index_of(v, cell[0], cell[1], cell[2])];
    }
    mesh->n_quads++;
}

// The grid's two outermost layers are all outside, so that no crossed edge lies at its rim.
static void add_quads(Net *net) {
    const int *size = net->volume->size;
    size_t room = 0;
    for (int z = 1; z + 1 < size[2]; z++)
        for (int y = 1; y + 1 < size[1]; y++)
            for (int x = 1; x + 1 < size[0]; x++)
                for (int axis = 0; axis < 3; axis++) add_quad(net, (const int[3]){x, y, z}, axis, &room);
}

void ffp_surface_nets(const FfpVolume *volume, FfpSurface *mesh) {
    Net net = {.volume = volume, .mesh = mesh};
    net.vertex = ffp_alloc((size_t)volume->size[0] * (size_t)volume->size[1] * (size_t)volume->size[2],
                           sizeof *net.vertex);
    add_vertices(&net);
    add_quads(&net);
    ffp_free(net.vertex);
}

// --- Loose pieces. ---

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

void ffp_surface_drop_loose(FfpSurface *mesh) {
    const size_t n = mesh->n_vertices;
    uint32_t *parent = ffp_alloc(n + 1, sizeof *parent), *quads = ffp_alloc(n + 1, sizeof *quads), kept = 0,
             most = 0;
    for (uint32_t i = 0; i < mesh->n_vertices; i++) parent[i] = i;
    for (size_t q = 0; q < mesh->n_quads; q++)
        for (size_t k = 1; k < 4; k++)
            parent[root_of(parent, mesh->quads[4 * q])] = root_of(parent, mesh->quads[4 * q + k]);
    for (size_t q = 0; q < mesh->n_quads; q++) quads[root_of(parent, mesh->quads[4 * q])]++;
    for (size_t i = 0; i < n; i++) most = quads[i] > most ? quads[i] : most;
    for (size_t q = 0; q < mesh->n_quads; q++) {
        if (quads[root_of(parent, mesh->quads[4 * q])] < most / 20) continue;
        for (size_t k = 0; k < 4; k++) mesh->quads[4 * (size_t)kept + k] = mesh->quads[4 * q + k];
        kept++;
    }
    mesh->n_quads = kept;
    ffp_free(parent), ffp_free(quads);
}
