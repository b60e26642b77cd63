#include "engine/match/labels.h"
#include <tgmath.h>
#include "core/base/arena.h"

#define WITHIN 10.0F // cost of another label within one colour,
#define ACROSS 0.05F // between two,
#define UNTOLD 0.25F // and in the dark
#define UNLIKE 0.03F // difference of encoded colours at which the cost has fallen by a factor of e
#define BRIGHT 0.1F  // encoded colours from which a picture tells surfaces apart
#define FAR_COST 1e9F
#define WAYS 4 // directions that one walk over the picture serves

typedef struct Walk {
    const FfpForeground *on;
    const real *colour;
    int labels;
    real *path;  // [count,WAYS,labels]
    real *least; // [count,WAYS]
} Walk;

static real cost_of_change(const real a[3], const real b[3]) {
    real off = 0, bright = 0;
    for (int c = 0; c < 3; c++) off += fabs(a[c] - b[c]) / 3, bright += (a[c] + b[c]) / 6;
    const real told = fmin(bright / BRIGHT, 1);
    return told * (ACROSS + (WITHIN - ACROSS) * exp(-off / UNLIKE)) + (1 - told) * UNTOLD;
}

// The slot of the pixel (dx, dy) before that of `slot`, or FFP_OFF.
static size_t slot_before(const FfpForeground *on, size_t slot, int dx, int dy) {
    const size_t width = (size_t)on->width;
    const int x = (int)(on->pixel[slot] % width) - dx, y = (int)(on->pixel[slot] / width) - dy;
    if (x < 0 || x >= on->width || y < 0 || y >= on->height) return FFP_OFF;
    return on->slot[(size_t)y * width + (size_t)x];
}

// Carries the path of one direction from slot `from` to `slot`. From off the object it starts again.
static void step(Walk *walk, const real *cost, size_t slot, size_t from, size_t way) {
    const size_t labels = (size_t)walk->labels, here = slot * WAYS + way, there = from * WAYS + way;
    const bool begins = from == FFP_OFF;
    const size_t *pixel = walk->on->pixel;
    real change = 0;
    if (!begins) change = cost_of_change(walk->colour + 3 * pixel[slot], walk->colour + 3 * pixel[from]);
    real *path = walk->path + here * labels, least = FAR_COST;
    for (size_t k = 0; k < labels; k++) {
        path[k] = cost[k];
        if (!begins) path[k] += fmin(walk->path[there * labels + k] - walk->least[there], change);
        least = fmin(least, path[k]);
    }
    walk->least[here] = least;
}

// Walks over the object's pixels, forwards for the paths that come from the left and from above, backwards
// (sign -1) for those against them.
static void walk_all(Walk *walk, real *total, const real *cost, int sign) {
    static const int ways[WAYS][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    const size_t labels = (size_t)walk->labels, count = walk->on->count;
    for (size_t n = 0; n < count; n++) {
        const size_t slot = sign > 0 ? n : count - 1 - n;
        for (size_t way = 0; way < WAYS; way++) {
            const size_t from = slot_before(walk->on, slot, sign * ways[way][0], sign * ways[way][1]);
            step(walk, cost + slot * labels, slot, from, way);
            for (size_t k = 0; k < labels; k++)
                total[slot * labels + k] += walk->path[(slot * WAYS + way) * labels + k];
        }
    }
}

void ffp_labels_total(real *total, const real *cost, const FfpForeground *foreground, int labels,
                      const real *colour) {
    const size_t paths = foreground->count * WAYS;
    Walk walk = {foreground, colour, labels, ffp_alloc(paths * (size_t)labels, sizeof(real)),
                 ffp_alloc(paths, sizeof(real))};
    for (size_t i = 0; i < foreground->count * (size_t)labels; i++) total[i] = 0;
    walk_all(&walk, total, cost, 1);
    walk_all(&walk, total, cost, -1);
    ffp_free(walk.path);
    ffp_free(walk.least);
}
