#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/kernels/kernels.h"

#define FAR_COST 1e6F
#define WAYS 4 // directions that one walk over the picture serves

// One pixel of one path: L(k) = C(k) + min(L'(k), L'(k -+ 1) + small, min L' + large) - min L'. The paths'
// rows have a cell of FAR_COST before and behind. Returns min L.
static real path_step(real *restrict path, const real *restrict before, real least_before,
                      const real *restrict cost, int count, real small, real large) {
    real least = FAR_COST;
    const real jump = least_before + large;
#pragma omp simd reduction(min : least)
    for (int k = 0; k < count; k++) { // comparisons, not fmin: they are one vector instruction
        const real beside = (before[k] < before[k + 2] ? before[k] : before[k + 2]) + small;
        const real near = before[k + 1] < beside ? before[k + 1] : beside, best = near < jump ? near : jump;
        const real value = cost[k] + best - least_before;
        path[k + 1] = value;
        least = value < least ? value : least;
    }
    return least;
}

// The paths of four directions at the pixels of the row before and of this one.
typedef struct Paths {
    const FfpForeground *foreground;
    int count;
    const FfpSteps *steps;
    size_t stride;  // of a path: count + 2
    real *rows[2];  // [width, WAYS, stride]
    real *least[2]; // [width, WAYS]
    real *fresh;    // [stride] a path that starts again: zero, so that L = C
} Paths;

static Paths paths_new(const FfpForeground *foreground, int count, const FfpSteps *steps) {
    Paths out = {foreground, count, steps, (size_t)count + 2, {NULL, NULL}, {NULL, NULL}, NULL};
    const size_t width = (size_t)foreground->width, cells = width * WAYS * out.stride;
    for (int r = 0; r < 2; r++) {
        out.rows[r] = ffp_alloc(cells, sizeof(real));
        out.least[r] = ffp_alloc(width * WAYS, sizeof(real));
        for (size_t i = 0; i < cells; i += out.stride)
            out.rows[r][i] = out.rows[r][i + out.stride - 1] = FAR_COST;
    }
    out.fresh = ffp_alloc(out.stride, sizeof(real));
    out.fresh[0] = out.fresh[out.stride - 1] = FAR_COST;
    return out;
}

static void paths_free(Paths *paths) {
    for (int r = 0; r < 2; r++) {
        ffp_free(paths->rows[r]);
        ffp_free(paths->least[r]);
    }
    ffp_free(paths->fresh);
}

// Steps the path of direction `way` (dx, dy) to pixel (x, y). A path that comes from off the object starts
// again.
static const real *step_to(Paths *paths, const real *cost, int x, int y, int way, int dx, int dy) {
    const FfpForeground *on = paths->foreground;
    const int px = x - dx, py = y - dy, now = y & 1;
    const size_t here = (size_t)x * WAYS + (size_t)way;
    const real *before = paths->fresh;
    const FfpSteps *steps = paths->steps;
    real small = steps->small, large = steps->large, least = 0;
    real *path = paths->rows[now] + here * paths->stride;
    const size_t width = (size_t)on->width, from = (size_t)py * width + (size_t)px;
    if (px >= 0 && px < on->width && py >= 0 && py < on->height && on->slot[from] != FFP_OFF) {
        const size_t there = (size_t)px * WAYS + (size_t)way;
        if (steps->border) small = large = steps->border(steps->picture, (size_t)y * width + (size_t)x, from);
        before = paths->rows[py & 1] + there * paths->stride;
        least = paths->least[py & 1][there];
    }
    paths->least[now][here] = path_step(path, before, least, cost, paths->count, small, large);
    return path + 1;
}

// Adds the four paths at a pixel to its total.
static void add_paths(real *restrict total, const real *const path[WAYS], int count) {
    const real *restrict a = path[0], *restrict b = path[1], *restrict c = path[2], *restrict d = path[3];
    for (int k = 0; k < count; k++) total[k] += (a[k] + b[k]) + (c[k] + d[k]);
}

// Walks over the object's pixels, forwards for the paths that come from the left and from above, backwards
// (sign -1) for those against them.
static void walk(Paths *paths, real *total, const real *cost, int sign) {
    static const int ways[WAYS][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    const FfpForeground *on = paths->foreground;
    for (size_t n = 0; n < on->count; n++) {
        const size_t slot = sign > 0 ? n : on->count - 1 - n, first = slot * (size_t)paths->count;
        const int x = (int)(on->pixel[slot] % (size_t)on->width),
                  y = (int)(on->pixel[slot] / (size_t)on->width);
        const real *path[WAYS];
        for (int w = 0; w < WAYS; w++)
            path[w] = step_to(paths, cost + first, x, y, w, sign * ways[w][0], sign * ways[w][1]);
        add_paths(total + first, path, paths->count);
    }
}

void FFP_K(semi_global)(real *total, const real *cost, const FfpForeground *foreground, int count,
                        const FfpSteps *steps) {
    Paths paths = paths_new(foreground, count, steps);
    walk(&paths, total, cost, 1);
    walk(&paths, total, cost, -1);
    paths_free(&paths);
}
