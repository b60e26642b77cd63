// The handles of a mesh's surface.
#include "world/shapes/mesh_measure.h"
#include <stdlib.h>
#include "core/base/arena.h"

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

typedef struct HalfEdge {
    uint32_t low, high;               // vertices
    uint32_t low_corner, high_corner; // of the triangle that it bounds, 3 * triangle + place
} HalfEdge;

static int compare_edges(const void *a, const void *b) {
    const HalfEdge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b) {
    parent[root_of(parent, a)] = root_of(parent, b);
}

static int count_roots(const uint32_t *parent, uint32_t count) {
    int roots = 0;
    for (uint32_t i = 0; i < count; i++) roots += parent[i] == i;
    return roots;
}

// V counts the fans of triangles around vertices, so that two sheets that touch in a vertex do not count as
// joined there.
int ffp_mesh_genus(const FfpMesh *mesh, int *components) {
    const uint32_t corners = 3 * (uint32_t)mesh->n_triangles;
    HalfEdge *edges = ffp_alloc(corners, sizeof *edges);
    uint32_t *fans = ffp_alloc(corners, sizeof *fans), *pieces = ffp_alloc(corners, sizeof *pieces);
    for (uint32_t i = 0; i < corners; i++) {
        const uint32_t j = i % 3 == 2 ? i - 2 : i + 1, a = mesh->triangles[i], b = mesh->triangles[j];
        edges[i] = a < b ? (HalfEdge){a, b, i, j} : (HalfEdge){b, a, j, i};
        fans[i] = i, pieces[i] = i - i % 3; // a piece is named by a triangle's first corner
    }
    qsort(edges, corners, sizeof *edges, compare_edges);
    for (uint32_t i = 0; i + 1 < corners; i += 2) {
        join(fans, edges[i].low_corner, edges[i + 1].low_corner);
        join(fans, edges[i].high_corner, edges[i + 1].high_corner);
        join(pieces, edges[i].low_corner, edges[i + 1].low_corner);
    }
    *components = count_roots(pieces, corners);
    const int vertices = count_roots(fans, corners);
    ffp_free(edges);
    ffp_free(fans);
    ffp_free(pieces);
    return *components - (vertices - mesh->n_triangles / 2) / 2;
}
