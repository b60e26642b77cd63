// Gaussians and devices that the render tests share.
#ifndef FFP_TESTS_RENDER_SCENES_H
#define FFP_TESTS_RENDER_SCENES_H

#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/render/render.h"

static inline real between(FfpRng *rng, double low, double high) {
    return (real)(low + (high - low) * (double)ffp_rng_uniform(rng));
}

// A device at `eye` that looks at `target`, z up.
static inline FfpCamera look_at(int width, int height, double focal, const real eye[3],
                                const real target[3]) {
    FfpCamera c = {width, height, (real)focal, (real)focal, (real)width / 2, (real)height / 2, {0}};
    const real up[3] = {0, 0, 1};
    real forward[3], right[3], down[3];
    for (int i = 0; i < 3; i++) forward[i] = target[i] - eye[i];
    ffp_normalise3(forward);
    ffp_cross3(forward, up, right);
    ffp_normalise3(right);
    ffp_cross3(forward, right, down);
    for (int i = 0; i < 3; i++) {
        c.pose[4 * i] = right[i], c.pose[4 * i + 1] = down[i], c.pose[4 * i + 2] = forward[i],
                   c.pose[4 * i + 3] = eye[i];
    }
    c.pose[15] = 1;
    return c;
}

// Splats of all shapes in a ball of the given radius around the origin. Quaternions are not of length 1.
static inline FfpGaussians random_gaussians(int64_t count, uint64_t seed, double radius, double scale_low,
                                            double scale_high, double opacity_low, double opacity_high) {
    FfpGaussians g = ffp_gaussians_new(count);
    FfpRng rng = ffp_rng(seed, 1);
    for (int64_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            g.centre[3 * i + k] = between(&rng, -radius, radius);
            g.scale[3 * i + k] = between(&rng, scale_low, scale_high);
            g.albedo[3 * i + k] = between(&rng, 0.1, 0.9);
            g.ambient[3 * i + k] = between(&rng, 0.0, 0.4);
        }
        for (int k = 0; k < 4; k++) g.rotation[4 * i + k] = (real)ffp_rng_normal(&rng);
        g.opacity[i] = between(&rng, opacity_low, opacity_high);
        g.roughness[i] = between(&rng, 0.2, 0.9);
    }
    return g;
}

// Light that is scattered, for sets that had none.
static inline void scatter_light(FfpGaussians *g, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 3);
    for (int64_t i = 0; i < 3 * g->count; i++) g->scattered[i] = between(&rng, 0.01, 0.3);
    g->scatters = true;
}

// The attribute arrays of a set or a G-buffer in a fixed order, so that tests can walk all of them alike.
typedef struct Field {
    const char *name;
    real *data;
    int64_t count;
} Field;

enum { FIELDS = 8 };

static inline void gaussian_fields(const FfpGaussians *g, Field out[FIELDS]) {
    const int64_t n = g->count;
    out[0] = (Field){"centre", g->centre, 3 * n}, out[1] = (Field){"scale", g->scale, 3 * n};
    out[2] = (Field){"rotation", g->rotation, 4 * n}, out[3] = (Field){"opacity", g->opacity, n};
    out[4] = (Field){"albedo", g->albedo, 3 * n}, out[5] = (Field){"roughness", g->roughness, n};
    out[6] = (Field){"ambient", g->ambient, 3 * n}, out[7] = (Field){"scattered", g->scattered, 3 * n};
}

static inline void gbuffer_fields(const FfpGbuffer *g, Field out[FIELDS]) {
    const int64_t n = (int64_t)g->width * g->height;
    out[0] = (Field){"opacity", g->opacity, n}, out[1] = (Field){"depth", g->depth, n};
    out[2] = (Field){"normal", g->normal, 3 * n}, out[3] = (Field){"albedo", g->albedo, 3 * n};
    out[4] = (Field){"roughness", g->roughness, n}, out[5] = (Field){"ambient", g->ambient, 3 * n};
    out[6] = (Field){"distortion", g->distortion, n};
    out[7] = (Field){"scattered", g->scattered, g->scattered ? 3 * n : 0};
}

// Random numbers in [-1, 1] everywhere: the weights of a loss that looks at all of a G-buffer.
static inline void randomise_gbuffer(FfpGbuffer *g, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 2);
    Field f[FIELDS];
    gbuffer_fields(g, f);
    for (int k = 0; k < FIELDS; k++)
        for (int64_t i = 0; i < f[k].count; i++) f[k].data[i] = between(&rng, -1, 1);
}

#endif
