// A grid of cells over the sphere's box, searched in growing shells. Points outside count to the nearest
// cell: moving into a box never lengthens a distance, so a shell's bound stays good.
#include "engine/refine/neighbours.h"
#include <stdbool.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/vec.h"

#define SIDE 1.25F // half the box

typedef struct Grid {
    const real *points;
    int64_t count;
    int cells;      // a side
    real width;     // of a cell
    int64_t *first; // [cells^3 + 1] into `order`
    int64_t *order; // point indices, cell by cell, ascending in each
} Grid;

typedef struct Nearest {
    int k, found;
    int64_t index[FFP_NEIGHBOURS_MAX];
    real squared[FFP_NEIGHBOURS_MAX];
} Nearest;

static int cell_of(const Grid *grid, real x) {
    const real at = fmin(fmax((x + SIDE) / grid->width, 0), (real)(grid->cells - 1));
    return (int)at;
}

static int64_t cell_index(const Grid *grid, const real *p) {
    const int64_t x = cell_of(grid, p[0]), y = cell_of(grid, p[1]), z = cell_of(grid, p[2]);
    return (z * grid->cells + y) * grid->cells + x;
}

static Grid grid_new(const real *points, int64_t count) {
    Grid grid = {.points = points, .count = count};
    grid.cells = (int)fmin(fmax(sqrt((real)count) / 2, 1), 128);
    grid.width = 2 * SIDE / (real)grid.cells;
    const int64_t total = (int64_t)grid.cells * grid.cells * grid.cells;
    grid.first = ffp_alloc((size_t)total + 1, sizeof *grid.first);
    grid.order = ffp_alloc((size_t)count + 1, sizeof *grid.order);
    int64_t *next = ffp_alloc((size_t)total, sizeof *next);
    for (int64_t i = 0; i < count; i++) grid.first[cell_index(&grid, points + 3 * i) + 1]++;
    for (int64_t c = 0; c < total; c++) {
        grid.first[c + 1] += grid.first[c];
        next[c] = grid.first[c];
    }
    for (int64_t i = 0; i < count; i++) grid.order[next[cell_index(&grid, points + 3 * i)]++] = i;
    ffp_free(next);
    return grid;
}

static void consider(Nearest *best, int64_t index, real squared) {
    if (best->found == best->k && !(squared < best->squared[best->k - 1])) return;
    int at = best->found < best->k ? best->found++ : best->k - 1;
    for (; at > 0 && best->squared[at - 1] > squared; at--) {
        best->squared[at] = best->squared[at - 1];
        best->index[at] = best->index[at - 1];
    }
    best->squared[at] = squared;
    best->index[at] = index;
}

static void search_cell(const Grid *grid, int64_t cell, int64_t self, Nearest *best) {
    const real *p = grid->points + 3 * self;
    for (int64_t j = grid->first[cell]; j < grid->first[cell + 1]; j++) {
        const int64_t other = grid->order[j];
        const real *q = grid->points + 3 * other;
        const real d[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
        if (other != self) consider(best, other, ffp_dot3(d, d));
    }
}

// The cells whose largest step from (x, y, z) is r.
static void search_shell(const Grid *grid, const int at[3], int r, int64_t self, Nearest *best) {
    const int n = grid->cells;
    for (int z = at[2] - r; z <= at[2] + r; z++) {
        if (z < 0 || z >= n) continue;
        for (int y = at[1] - r; y <= at[1] + r; y++) {
            if (y < 0 || y >= n) continue;
            const bool face = abs(z - at[2]) == r || abs(y - at[1]) == r;
            for (int x = at[0] - r; x <= at[0] + r; x += face ? 1 : 2 * r)
                if (x >= 0 && x < n) search_cell(grid, ((int64_t)z * n + y) * n + x, self, best);
        }
    }
}

void ffp_neighbours(const real *points, int64_t count, int k, int64_t *neighbour, real *squared) {
    Grid grid = grid_new(points, count);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        Nearest best = {.k = k};
        const real *p = points + 3 * i;
        const int at[3] = {cell_of(&grid, p[0]), cell_of(&grid, p[1]), cell_of(&grid, p[2])};
        for (int r = 0; r < grid.cells; r++) {
            search_shell(&grid, at, r, i, &best);
            const real reach = (real)r * grid.width;
            if (best.found == k && best.squared[k - 1] <= reach * reach) break;
        }
        for (int j = 0; j < k; j++) {
            neighbour[i * k + j] = j < best.found ? best.index[j] : -1;
            if (squared) squared[i * k + j] = j < best.found ? best.squared[j] : (real)INFINITY;
        }
    }
    ffp_free(grid.first);
    ffp_free(grid.order);
}
