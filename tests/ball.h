// A ball of splats and its photographs, drawn by the renderer itself on the CPU.
#ifndef FFP_TESTS_BALL_H
#define FFP_TESTS_BALL_H

#include <string.h>
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/render/pass.h"
#include "looking.h"

enum { BALL_BLACK, BALL_WHITE, BALL_STRIPES, BALL_PATTERNS };
static const int ball_patterns[] = {BALL_BLACK, BALL_WHITE, BALL_STRIPES};

// At `distance` from the origin, looking there; focal lengths of 1.3 heights.
static inline FfpCamera ball_device(real azimuth, real z, real distance, int width, int height) {
    const real eye[3] = {distance * (real)cos(azimuth), distance * (real)sin(azimuth), z};
    return looking_at_origin(eye, width, height, 1.3F * (real)height);
}

// Splats on a sphere of radius 0.6, flat along it, that just close it.
static inline FfpGaussians ball_of_splats(int64_t count) {
    FfpGaussians g = ffp_gaussians_new(count);
    const real wide = 1 / (real)sqrt((real)count);
    for (int64_t i = 0; i < count; i++) {
        const real z = 1 - 2 * ((real)i + 0.5F) / (real)count, r = (real)sqrt(1 - z * z);
        const double a = 2.39996322972865332 * (double)i;
        const real n[3] = {r * (real)cos(a), r * (real)sin(a), z};
        const real q[4] = {1 + n[2], -n[1], n[0], 0}; // the z axis onto n
        for (int k = 0; k < 3; k++) {
            g.centre[3 * i + k] = 0.6F * n[k];
            g.scale[3 * i + k] = k < 2 ? wide : 0.1F * wide;
            g.albedo[3 * i + k] = 0.5F + 0.3F * n[(k + 1) % 3];
            g.ambient[3 * i + k] = 0.1F + 0.05F * n[k];
        }
        for (int k = 0; k < 4; k++) g.rotation[4 * i + k] = q[k] / (real)sqrt(2 + 2 * n[2]);
        g.opacity[i] = 0.95F;
        g.roughness[i] = 0.6F;
    }
    return g;
}

// The ball with errors in everything.
static inline FfpGaussians ball_disturbed(int64_t count) {
    FfpGaussians g = ball_of_splats(count);
    FfpRng rng = ffp_rng(5, 1);
    for (int64_t i = 0; i < 3 * count; i++) {
        g.centre[i] += 0.1F * g.scale[i / 3 * 3] * (real)ffp_rng_normal(&rng);
        g.scale[i] *= (real)exp(0.2 * ffp_rng_normal(&rng));
        g.albedo[i] = fmin(fmax(g.albedo[i] + 0.1F * (real)ffp_rng_normal(&rng), 0.02F), 0.98F);
        g.ambient[i] = fmax(g.ambient[i] + 0.03F * (real)ffp_rng_normal(&rng), 0.01F);
    }
    return g;
}

static inline void ball_photograph(FfpView *view, const FfpGaussians *ball, const FfpCapture *capture) {
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    ffp_view_pass_draw(pass, ball, &view->camera, &view->projector);
    view->images = ffp_alloc(BALL_PATTERNS, sizeof *view->images);
    for (int p = 0; p < BALL_PATTERNS; p++) {
        FfpSummed light = ffp_summed_new(&capture->patterns[p].image);
        view->images[p] = ffp_view_pass_picture_new(pass);
        ffp_view_pass_shade(pass, capture->intensity, p == BALL_BLACK ? NULL : &light, &view->images[p]);
        ffp_image_to_linear(&view->images[p]);
        ffp_summed_free(&light);
    }
    view->coverage = ffp_image_new(view->camera.width, view->camera.height, 1);
    const FfpGbuffer *gbuffer = ffp_view_pass_gbuffer(pass);
    for (int i = 0; i < view->camera.width * view->camera.height; i++)
        view->coverage.data[i] = gbuffer->opacity[i] > 0.5F;
    ffp_view_pass_free(pass);
}

// From all around, on the CPU; released by ffp_capture_free.
static inline FfpCapture ball_capture(int64_t splats, int views, int width, int height, int side) {
    FfpCapture c = {.n_patterns = BALL_PATTERNS,
                    .n_views = views,
                    .patterns = ffp_alloc(BALL_PATTERNS, sizeof *c.patterns),
                    .views = ffp_alloc((size_t)views, sizeof *c.views),
                    .black = BALL_BLACK,
                    .white = BALL_WHITE,
                    .intensity = {4, 4, 4},
                    .radius = 1};
    memcpy(c.folder, "ball", 5);
    for (int p = 0; p < BALL_PATTERNS; p++) {
        FfpImage *image = &c.patterns[p].image;
        *image = ffp_image_new(side, side, 3);
        for (int i = 0; i < side * side * 3; i++)
            image->data[i] = p == BALL_WHITE ? 1 : p == BALL_STRIPES ? (real)(i / 3 / 4 % 2) : 0;
    }
    FfpGaussians ball = ball_of_splats(splats);
    for (int v = 0; v < views; v++) {
        const real azimuth = (real)v * 6.2831853F / (real)views;
        c.views[v].camera = ball_device(azimuth, 0.3F, 2.5F, width, height);
        c.views[v].projector = ball_device(azimuth + 0.2F, 1, 2, side, side);
        ball_photograph(&c.views[v], &ball, &c);
    }
    ffp_gaussians_free(&ball);
    return c;
}

#endif
