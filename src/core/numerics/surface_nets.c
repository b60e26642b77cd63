#include "core/numerics/surface_nets.h"
#include "core/base/alloc.h"

typedef struct Strides {
    size_t of[3]; // from a point to the next along an axis
} Strides;

static Strides strides_of(const FfpNetGrid *g) {
    return (Strides){{1, (size_t)g->size[0], (size_t)g->size[0] * (size_t)g->size[1]}};
}

void ffp_net_repair(const int size[3], float *value, uint8_t *inside, float depth) {
    const FfpNetGrid grid = {{size[0], size[1], size[2]}, value, inside};
    const Strides stride = strides_of(&grid);
    for (bool changed = true; changed;) { // the inside only grows, so this ends
        changed = false;
        for (int z = 1; z < size[2] - 1; z++)
            for (int y = 1; y < size[1] - 1; y++)
                for (int x = 1; x < size[0] - 1; x++)
                    for (int a = 0; a < 3; a++) {
                        const size_t i = ffp_net_point(&grid, x, y, z), s = stride.of[a],
                                     t = stride.of[(a + 1) % 3];
                        if (inside[i] != inside[i + s + t] || inside[i + s] != inside[i + t] ||
                            inside[i] == inside[i + s])
                            continue;
                        const size_t fill = inside[i] ? i + s : i;
                        inside[fill] = 1;
                        value[fill] = -depth;
                        changed = true;
                    }
    }
}

int ffp_net_count_quads(const FfpNetGrid *g) {
    const Strides stride = strides_of(g);
    int quads = 0;
    for (int z = 0; z < g->size[2] - 1; z++)
        for (int y = 0; y < g->size[1] - 1; y++) {
            const uint8_t *row = g->inside + ffp_net_point(g, 0, y, z);
            int in_row = 0;
            for (int x = 0; x < g->size[0] - 1; x++)
                in_row += (row[x] ^ row[x + (int)stride.of[0]]) + (row[x] ^ row[x + (int)stride.of[1]]) +
                          (row[x] ^ row[x + (int)stride.of[2]]);
            quads += in_row;
        }
    return quads;
}

FfpNetCells ffp_net_cells(const FfpNetGrid *g) {
    const Strides stride = strides_of(g);
    FfpNetCells out = {0};
    int room = 0;
    out.number = ffp_alloc(stride.of[2] * (size_t)g->size[2], sizeof *out.number);
    for (int z = 0; z < g->size[2] - 1; z++)
        for (int y = 0; y < g->size[1] - 1; y++) {
            const uint8_t *r0 = g->inside + ffp_net_point(g, 0, y, z), *r1 = r0 + stride.of[1];
            const uint8_t *r2 = r0 + stride.of[2], *r3 = r2 + stride.of[1];
            for (int x = 0; x < g->size[0] - 1; x++) {
                const int in = r0[x] + r0[x + 1] + r1[x] + r1[x + 1] + r2[x] + r2[x + 1] + r3[x] + r3[x + 1];
                if (in == 0 || in == 8) continue;
                if (out.count == room) {
                    room = 2 * room + (1 << 14);
                    out.cells = ffp_grow(out.cells, (size_t)room, 3 * sizeof *out.cells);
                }
                int *cell = out.cells + 3 * (size_t)out.count;
                cell[0] = x, cell[1] = y, cell[2] = z;
                out.number[ffp_net_point(g, x, y, z)] = (uint32_t)out.count++;
            }
        }
    return out;
}

void ffp_net_cells_free(FfpNetCells *cells) {
    ffp_free(cells->cells);
    ffp_free(cells->number);
    *cells = (FfpNetCells){0};
}

void ffp_net_crossing(const FfpNetGrid *g, const int cell[3], float mean[3]) {
    const Strides stride = strides_of(g);
    const size_t first = ffp_net_point(g, cell[0], cell[1], cell[2]);
    int crossings = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (int e = 0; e < 12; e++) {
        const int axis = e / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
        int at[3] = {cell[0], cell[1], cell[2]};
        at[u] += e & 1;
        at[v] += e >> 1 & 1;
        const size_t a = first + (size_t)(e & 1) * stride.of[u] + (size_t)(e >> 1 & 1) * stride.of[v],
                     b = a + stride.of[axis];
        if (g->inside[a] == g->inside[b]) continue;
        for (int k = 0; k < 3; k++) mean[k] += (float)at[k];
        const float share = g->value[a] / (g->value[a] - g->value[b]);
        mean[axis] += share > 0 ? share < 1 ? share : 1 : 0;
        crossings++;
    }
    for (int k = 0; k < 3; k++) mean[k] /= (float)crossings;
}

void ffp_net_connect(const FfpNetGrid *g, const FfpNetCells *cells, FfpNetQuad *add, void *context) {
    const Strides stride = strides_of(g);
    const uint32_t *number = cells->number;
    for (int z = 1; z < g->size[2] - 1; z++)
        for (int y = 1; y < g->size[1] - 1; y++)
            for (int x = 1; x < g->size[0] - 1; x++) {
                const size_t i = ffp_net_point(g, x, y, z);
                for (int a = 0; a < 3; a++) {
                    if (g->inside[i] == g->inside[i + stride.of[a]]) continue;
                    const size_t u = stride.of[(a + 1) % 3], v = stride.of[(a + 2) % 3];
                    const uint32_t q[4] = {number[i - u - v], number[i - v], number[i], number[i - u]};
                    add(context, q, !g->inside[i]); // right-handed about an axis that leads outwards
                }
            }
}
