#include "engine/refine/coarse.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/refine/parameters.h"

#define OPACITY_LEAST 1e-3F // what a mean counts a Gaussian with at least: below 1/255, so not drawn
#define NEAR 4 // of the coarse splat's larger deviations: what lies farther away is of another surface

static int64_t block_of(const FfpOrigin *o, int64_t pixel, int side, int across, int down) {
    const int64_t x = pixel % o->width, row = pixel / o->width, view = row / o->height, y = row % o->height;
    return (view * down + y / side) * across + x / side;
}

static real larger_scale(const FfpGaussians *g, int64_t i) {
    return fmax(fmax(g->scale[3 * i], g->scale[3 * i + 1]), g->scale[3 * i + 2]);
}

static bool is_near(const real a[3], const real b[3], real reach) {
    const real d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return ffp_dot3(d, d) < reach * reach;
}

// For each block its most opaque Gaussian, or -1; counts the blocks that have one.
static int64_t find_leaders(const FfpGaussians *fine, const FfpOrigin *o, const FfpCoarse *c,
                            int64_t *leader) {
    const int64_t blocks = (int64_t)o->views * c->down * c->across;
    int64_t count = 0;
    for (int64_t b = 0; b < blocks; b++) leader[b] = -1;
    for (int64_t i = 0; i < fine->count; i++) {
        int64_t *l = &leader[block_of(o, o->pixel[i], c->side, c->across, c->down)];
        count += *l < 0;
        if (*l < 0 || fine->opacity[i] > fine->opacity[*l]) *l = i;
    }
    return count;
}

// Adds fine Gaussian i to the sums that become coarse Gaussian j.
static void gather(const FfpGaussians *fine, int64_t i, FfpGaussians *sums, int64_t j) {
    const real w = fmax(fine->opacity[i], OPACITY_LEAST);
    for (int k = 0; k < 3; k++) {
        sums->centre[3 * j + k] += w * fine->centre[3 * i + k];
        sums->scale[3 * j + k] += w * fine->scale[3 * i + k];
        sums->albedo[3 * j + k] += w * fine->albedo[3 * i + k];
        sums->ambient[3 * j + k] += w * fine->ambient[3 * i + k];
        sums->scattered[3 * j + k] += w * fine->scattered[3 * i + k];
    }
    sums->roughness[j] += w * fine->roughness[i];
    sums->opacity[j] += w;
}

static void settle(FfpGaussians *sums, int64_t j, int side) {
    const real per = 1 / sums->opacity[j];
    for (int k = 0; k < 3; k++) {
        sums->centre[3 * j + k] *= per;
        sums->scale[3 * j + k] *= per * (real)side;
        sums->albedo[3 * j + k] *= per;
        sums->ambient[3 * j + k] *= per;
        sums->scattered[3 * j + k] *= per;
    }
    sums->roughness[j] *= per;
    sums->opacity[j] /= (real)(side * side);
}

FfpCoarse ffp_coarse_new(const FfpGaussians *fine, const FfpOrigin *o, int side) {
    FfpCoarse c = {
        .side = side, .across = (o->width + side - 1) / side, .down = (o->height + side - 1) / side};
    const int64_t blocks = (int64_t)o->views * c.down * c.across;
    int64_t *leader = ffp_alloc((size_t)blocks, sizeof *leader), count = 0;
    c.of_block = ffp_alloc((size_t)blocks, sizeof *c.of_block);
    c.gaussians = ffp_gaussians_new(find_leaders(fine, o, &c, leader));
    ffp_gaussians_take_notes(&c.gaussians, fine);
    for (int64_t b = 0; b < blocks; b++) c.of_block[b] = leader[b] < 0 ? -1 : count++;
    for (int64_t i = 0; i < fine->count; i++) {
        const int64_t b = block_of(o, o->pixel[i], side, c.across, c.down), l = leader[b];
        const real reach = NEAR * (real)side * larger_scale(fine, l);
        if (i == l || is_near(fine->centre + 3 * i, fine->centre + 3 * l, reach))
            gather(fine, i, &c.gaussians, c.of_block[b]);
        if (i == l)
            memcpy(c.gaussians.rotation + 4 * c.of_block[b], fine->rotation + 4 * l, 4 * sizeof(real));
    }
    for (int64_t j = 0; j < count; j++) settle(&c.gaussians, j, side);
    ffp_free(leader);
    return c;
}

void ffp_coarse_free(FfpCoarse *coarse) {
    ffp_gaussians_free(&coarse->gaussians);
    ffp_free(coarse->of_block);
    coarse->of_block = NULL;
}

static real logit(real p) {
    const real inside = fmin(fmax(p, 1e-4F), 1 - 1e-4F);
    return log(inside / (1 - inside));
}

static real moved_by_logit(real p, real step) {
    return 1 / (1 + exp(-logit(p) - step));
}

static real moved_by_root(real s, real step) {
    const real root = fmax(sqrt(s) + step, (real)0);
    return root * root;
}

// Hamilton's product a b, with b's inverse where it is asked for; all of length 1.
static void multiply(const real a[4], const real b[4], bool inverse, real out[4]) {
    const real s = inverse ? -1 : 1, w = b[0], x = s * b[1], y = s * b[2], z = s * b[3];
    out[0] = a[0] * w - a[1] * x - a[2] * y - a[3] * z;
    out[1] = a[0] * x + a[1] * w + a[2] * z - a[3] * y;
    out[2] = a[0] * y - a[1] * z + a[2] * w + a[3] * x;
    out[3] = a[0] * z + a[1] * y - a[2] * x + a[3] * w;
}

// The changes: differences of places, of logarithms of sizes, of logits and of roots, and turns, in
// Gaussians' shape.
static FfpGaussians changes(const FfpGaussians *after, const FfpGaussians *before) {
    FfpGaussians d = ffp_gaussians_new(after->count);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < after->count; i++) {
        for (int64_t k = 3 * i; k < 3 * i + 3; k++) {
            d.centre[k] = after->centre[k] - before->centre[k];
            d.scale[k] = log(after->scale[k] / before->scale[k]);
            d.albedo[k] = logit(after->albedo[k]) - logit(before->albedo[k]);
            d.ambient[k] = logit(after->ambient[k]) - logit(before->ambient[k]);
            d.scattered[k] = sqrt(after->scattered[k]) - sqrt(before->scattered[k]);
        }
        real *turn = d.rotation + 4 * i;
        multiply(after->rotation + 4 * i, before->rotation + 4 * i, true, turn);
        for (int k = 0; turn[0] < 0 && k < 4; k++) turn[k] = -turn[k];
        d.opacity[i] = logit(after->opacity[i]) - logit(before->opacity[i]);
        d.roughness[i] = logit(after->roughness[i]) - logit(before->roughness[i]);
    }
    return d;
}

// Up to four blocks around a pixel, with their bilinear shares.
typedef struct Around {
    int count;
    int64_t coarse[4];
    real share[4];
} Around;

static Around look_around(const FfpCoarse *c, const FfpGaussians *before, const FfpOrigin *o, int64_t pixel,
                          const real centre[3]) {
    const int64_t column = pixel % o->width, row = pixel / o->width, view = row / o->height;
    const real x = ((real)column + 0.5F) / (real)c->side - 0.5F;
    const real y = ((real)(row % o->height) + 0.5F) / (real)c->side - 0.5F;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    Around a = {0};
    real total = 0;
    for (int k = 0; k < 4; k++) {
        const int bx = x0 + (k & 1), by = y0 + (k >> 1);
        if (bx < 0 || by < 0 || bx >= c->across || by >= c->down) continue;
        const int64_t j = c->of_block[(view * c->down + by) * c->across + bx];
        if (j < 0 || !is_near(centre, before->centre + 3 * j, NEAR * larger_scale(before, j))) continue;
        a.coarse[a.count] = j;
        a.share[a.count] = (1 - fabs(x - (real)bx)) * (1 - fabs(y - (real)by));
        total += a.share[a.count++];
    }
    for (int k = 0; k < a.count; k++) a.share[k] /= total;
    return a;
}

static void change(FfpGaussians *g, int64_t i, const FfpGaussians *d, const Around *a) {
    real step[FFP_ATTRIBUTES][4] = {{0}}, turned[4], length = 0;
    for (int n = 0; n < a->count; n++)
        for (int t = 0; t < FFP_ATTRIBUTES; t++) {
            const FfpAttribute from = ffp_attribute(d, t);
            for (int k = 0; k < from.width; k++)
                step[t][k] += a->share[n] * from.data[from.width * a->coarse[n] + k];
        }
    for (int k = 0; k < 3; k++) {
        g->centre[3 * i + k] += step[FFP_CENTRE][k];
        g->scale[3 * i + k] *= exp(step[FFP_SCALE][k]);
        g->albedo[3 * i + k] = moved_by_logit(g->albedo[3 * i + k], step[FFP_ALBEDO][k]);
        g->ambient[3 * i + k] = moved_by_logit(g->ambient[3 * i + k], step[FFP_AMBIENT][k]);
        g->scattered[3 * i + k] = moved_by_root(g->scattered[3 * i + k], step[FFP_SCATTERED][k]);
    }
    g->opacity[i] = moved_by_logit(g->opacity[i], step[FFP_OPACITY][0]);
    g->roughness[i] = moved_by_logit(g->roughness[i], step[FFP_ROUGHNESS][0]);
    multiply(step[FFP_ROTATION], g->rotation + 4 * i, false, turned);
    for (int k = 0; k < 4; k++) length += turned[k] * turned[k];
    for (int k = 0; k < 4; k++) g->rotation[4 * i + k] = turned[k] / sqrt(length);
}

void ffp_coarse_carry(const FfpCoarse *coarse, const FfpGaussians *before, const FfpOrigin *origin,
                      FfpGaussians *fine) {
    FfpGaussians d = changes(&coarse->gaussians, before);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < fine->count; i++) {
        const Around around = look_around(coarse, before, origin, origin->pixel[i], fine->centre + 3 * i);
        if (around.count > 0) change(fine, i, &d, &around);
    }
    ffp_gaussians_free(&d);
}
