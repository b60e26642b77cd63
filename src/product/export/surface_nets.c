// The zero of the signed distance as quads.
#include "core/numerics/surface_nets.h"
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "product/export/volume.h"

#define LEAST 1e-3F // truncations, of a point that a repair puts inside

// The distance's gradient over the cell, away from the object.
static void slope_of(const FfpNetGrid *g, const int cell[3], real normal[3]) {
    for (int k = 0; k < 3; k++) normal[k] = 0;
    for (int a = 0; a < 8; a++) {
        const real value =
            g->value[ffp_net_point(g, cell[0] + (a & 1), cell[1] + (a >> 1 & 1), cell[2] + (a >> 2))];
        for (int k = 0; k < 3; k++) normal[k] += (a >> k & 1 ? 1 : -1) * value;
    }
    ffp_normalise3(normal);
}

static void add_quad(void *context, const uint32_t vertices[4], bool flipped) {
    FfpSurface *mesh = context;
    uint32_t *quad = mesh->quads + 4 * (size_t)mesh->n_quads++;
    for (int k = 0; k < 4; k++) quad[k] = vertices[flipped ? 3 - k : k];
}

void ffp_surface_nets(FfpVolume *volume, FfpSurface *mesh) {
    const int *size = volume->size;
    const size_t points = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    uint8_t *inside = ffp_alloc(points, 1);
    for (size_t i = 0; i < points; i++) inside[i] = !(volume->distance[i] > 0);
    ffp_net_repair(size, volume->distance, inside, LEAST);
    const FfpNetGrid grid = {{size[0], size[1], size[2]}, volume->distance, inside};
    FfpNetCells cells = ffp_net_cells(&grid);
    mesh->n_vertices = (uint32_t)cells.count;
    mesh->position = ffp_alloc((size_t)cells.count + 1, 3 * sizeof(real));
    mesh->normal = ffp_alloc((size_t)cells.count + 1, 3 * sizeof(real));
    mesh->quads = ffp_alloc((size_t)ffp_net_count_quads(&grid) + 1, 4 * sizeof *mesh->quads);
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        const int *cell = cells.cells + 3 * i;
        real mean[3];
        ffp_net_crossing(&grid, cell, mean);
        for (int k = 0; k < 3; k++)
            mesh->position[3 * i + (size_t)k] = volume->low[k] + mean[k] * volume->cell;
        slope_of(&grid, cell, mesh->normal + 3 * i);
    }
    ffp_net_connect(&grid, &cells, add_quad, mesh);
    ffp_net_cells_free(&cells);
    ffp_free(inside);
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
    ffp_free(parent);
    ffp_free(quads);
}
