// Where values on a grid cross zero, as quads: a vertex in every cell that the surface crosses, a quad for
// every edge between two points that it crosses (surface nets: Gibson 1998).
#ifndef FFP_NUMERICS_SURFACE_NETS_H
#define FFP_NUMERICS_SURFACE_NETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The outermost points are all outside.
typedef struct FfpNetGrid {
    int size[3];           // points along x, y, z
    const float *value;    // [z,y,x], of different signs inside and outside
    const uint8_t *inside; // [z,y,x] 0 or 1
} FfpNetGrid;

static inline size_t ffp_net_point(const FfpNetGrid *g, int x, int y, int z) {
    return ((size_t)z * (size_t)g->size[1] + (size_t)y) * (size_t)g->size[0] + (size_t)x;
}

// A face of a cell whose corners are inside and outside in turn would give an edge with four quads. One
// corner outside becomes inside, with the value -`depth`, until there is no such face.
void ffp_net_repair(const int size[3], float *value, uint8_t *inside, float depth);

int ffp_net_count_quads(const FfpNetGrid *grid);

// The cells that the surface crosses, by their lowest points, and the number of each: that of its vertex.
typedef struct FfpNetCells {
    int count;
    int *cells;       // [count,3] in the grid's order
    uint32_t *number; // [z,y,x] of those cells
} FfpNetCells;
FfpNetCells ffp_net_cells(const FfpNetGrid *grid);
void ffp_net_cells_free(FfpNetCells *cells);

// The mean of the crossings of such a cell's edges, in steps from the grid's first point.
void ffp_net_crossing(const FfpNetGrid *grid, const int cell[3], float mean[3]);

// Calls `add` for every quad in the grid's order: counter-clockwise seen from outside, or clockwise where
// `flipped`.
typedef void FfpNetQuad(void *context, const uint32_t vertices[4], bool flipped);
void ffp_net_connect(const FfpNetGrid *grid, const FfpNetCells *cells, FfpNetQuad *add, void *context);

#endif
