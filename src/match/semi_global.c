#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/arena.h"
#include "match/sweep.h"

#define FAR_COST 1e6F

// One pixel of one path: L(k) = C(k) + min(L'(k), L'(k -+ 1) + small, min L' + large) - min L', added to
// total. The paths' rows have a cell of FAR_COST before and behind. Returns min L.
static real path_step(real *restrict path, const real *restrict before, real least_before,
                      const real *restrict cost, real *restrict total, int count, real small, real large) {
    real least = FAR_COST;
    for (int k = 0; k < count; k++) { // comparisons, not fmin: they are one vector instruction
        const real beside = (before[k] < before[k + 2] ? before[k] : before[k + 2]) + small,
                   jump = least_before + large;
        const real near = before[k + 1] < beside ? before[k + 1] : beside, best = near < jump ? near : jump;
        const real value = cost[k] + best - least_before;
        path[k + 1] = value;
        total[k] += value;
        least = value < least ? value : least;
    }
    return least;
}

typedef struct Paths {
    real *rows[2]; // [width, count + 2] of the row before and of this one
    real *least[2];
} Paths;

// All paths of one direction (dx, dy). Pixels are visited so that the one before on the path is done; a path
// that comes from off the mask starts anew.
static void scan(Paths *paths, real *total, const real *cost, const real *mask, int width, int height,
                 int count, int dx, int dy, real small, real large) {
    const size_t stride = (size_t)count + 2;
    const bool up = dy < 0, left = dx < 0;
    for (int j = 0; j < height; j++) {
        const int y = up ? height - 1 - j : j, now = j & 1;
        for (int i = 0; i < width; i++) {
            const int x = left ? width - 1 - i : i, px = x - dx, py = y - dy;
            const size_t pixel = (size_t)y * (size_t)width + (size_t)x;
            if (mask[pixel] <= 0) continue;
            real *path = paths->rows[now] + stride * (size_t)x;
            const real *from = cost + pixel * (size_t)count;
            real *to = total + pixel * (size_t)count;
            const bool inside = px >= 0 && px < width && py >= 0 && py < height;
            if (inside && mask[(size_t)py * (size_t)width + (size_t)px] > 0) {
                const int source = dy == 0 ? now : 1 - now;
                paths->least[now][x] = path_step(path, paths->rows[source] + stride * (size_t)px,
                                                 paths->least[source][px], from, to, count, small, large);
            } else {
                real least = FAR_COST;
                for (int k = 0; k < count; k++)
                    path[k + 1] = from[k], to[k] += from[k], least = fmin(least, from[k]);
                paths->least[now][x] = least;
            }
        }
    }
}

void ffp_semi_global(real *total, const real *cost, const real *mask, int width, int height, int count,
                     real small, real large) {
    static const int directions[8][2] = {{1, 0}, {-1, 0}, {0, 1},  {0, -1},
                                         {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    Paths paths;
    for (int r = 0; r < 2; r++) {
        const size_t cells = (size_t)width * ((size_t)count + 2);
        paths.rows[r] = ffp_alloc(cells, sizeof(real));
        paths.least[r] = ffp_alloc((size_t)width, sizeof(real));
        for (size_t i = 0; i < cells; i++) paths.rows[r][i] = FAR_COST;
    }
    for (int d = 0; d < 8; d++)
        scan(&paths, total, cost, mask, width, height, count, directions[d][0], directions[d][1], small,
             large);
    for (int r = 0; r < 2; r++) free(paths.rows[r]), free(paths.least[r]);
}
