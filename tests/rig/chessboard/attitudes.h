// Corners of a chessboard as a known camera and projector see them, without pictures.
#ifndef FFP_TESTS_ATTITUDES_H
#define FFP_TESTS_ATTITUDES_H

#include <math.h>
#include "core/base/alloc.h"
#include "core/base/lens.h"
#include "core/base/rigid.h"
#include "core/base/rng.h"
#include "rig/chessboard/chessboard.h"
#include "support.h"

enum { CAMERA_W = 480, CAMERA_H = 360, PANEL_W = 250, PANEL_H = 190 };
static const FfpBoard chessboard = {7, 5, 30};
static const FfpCvDevice true_devices[2] = {{.width = CAMERA_W,
                                             .height = CAMERA_H,
                                             .matrix = {620, 0, 247, 0, 615, 174, 0, 0, 1},
                                             .lens = {-0.18, 0.11, 0.0011, -0.0007, 0}},
                                            {.width = PANEL_W,
                                             .height = PANEL_H,
                                             .matrix = {310, 0, 121, 0, 312, 141, 0, 0, 1},
                                             .lens = {-0.06, 0.04}}};
static const double true_turn[3] = {0.06, -0.32, 0.02}, true_shift[3] = {170, 15, 20}; // X_p = R X_c + T

static inline void put_pixel(const FfpCvDevice *device, const double x[3], double noise, FfpRng *rng,
                             double out[2]) {
    double u, v;
    ffp_lens_distort(device->lens, x[0] / x[2], x[1] / x[2], &u, &v);
    out[0] = device->matrix[0] * u + device->matrix[2] + noise * (double)ffp_rng_normal(rng);
    out[1] = device->matrix[4] * v + device->matrix[5] + noise * (double)ffp_rng_normal(rng);
}

// A board in a random pose, its corners strayed by `noise` pixels.
static inline FfpAttitude new_attitude(const char *name, double noise, FfpRng *rng) {
    const int n = chessboard.columns * chessboard.rows;
    FfpAttitude a = {.name = name, .n = n, .scale = 1};
    a.camera = ffp_alloc((size_t)n, 2 * sizeof(double)),
    a.projector = ffp_alloc((size_t)n, 2 * sizeof(double));
    a.camera_off = ffp_alloc((size_t)n, 2 * sizeof(double));
    a.projector_off = ffp_alloc((size_t)n, 2 * sizeof(double));
    a.camera_state = ffp_alloc((size_t)n, 1), a.projector_state = ffp_alloc((size_t)n, 1);
    double turn[9], between[9];
    const double v[3] = {ffp_rng_range(rng, -0.6F, 0.6F), ffp_rng_range(rng, -0.6F, 0.6F),
                         ffp_rng_range(rng, -0.4F, 0.4F)},
                 middle[3] = {ffp_rng_range(rng, -30, 30), ffp_rng_range(rng, -25, 25),
                              ffp_rng_range(rng, 560, 640)};
    ffp_rotation_from_vector(v, turn), ffp_rotation_from_vector(true_turn, between);
    for (int i = 0; i < n; i++) {
        const double point[3] = {
            (ffp_corner_column(&chessboard, i) - 0.5 * (chessboard.columns - 1)) * chessboard.square,
            (ffp_corner_row(&chessboard, i) - 0.5 * (chessboard.rows - 1)) * chessboard.square, 0};
        double x[3], p[3];
        for (int k = 0; k < 3; k++) x[k] = ffp_dot(turn + 3 * k, point) + middle[k];
        for (int k = 0; k < 3; k++) p[k] = ffp_dot(between + 3 * k, x) + true_shift[k];
        put_pixel(&true_devices[0], x, noise, rng, a.camera + 2 * (size_t)i);
        put_pixel(&true_devices[1], p, noise, rng, a.projector + 2 * (size_t)i);
    }
    return a;
}

static inline FfpRigFit new_rig_fit(int n) {
    FfpRigFit fit = {.board = chessboard, .n = n, .attitudes = ffp_alloc((size_t)n, sizeof(FfpAttitude))};
    for (int d = 0; d < 2; d++)
        fit.devices[d].width = true_devices[d].width, fit.devices[d].height = true_devices[d].height;
    return fit;
}

#endif
