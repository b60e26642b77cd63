// A small made-up capture for the field's tests: two views of coloured noise on a disc, a projector beside
// each; black, white and a chequered pattern.
#ifndef FFP_TESTS_FIELD_SCENE_H
#define FFP_TESTS_FIELD_SCENE_H

#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "lab/baselines/chunk.h"
#include "support.h"

enum { SCENE_SIDE = 24, SCENE_PATTERN = 40, SCENE_VIEWS = 2, SCENE_PATTERNS = 3 };

static inline FfpCamera scene_device(real x, real y, real z, int side, real focal) {
    FfpCamera device = {.width = side, .height = side, .fx = focal, .fy = focal};
    const real length = sqrt(x * x + y * y + z * z), forward[3] = {-x / length, -y / length, -z / length};
    real right[3] = {-forward[1], forward[0], 0}, down[3];
    ffp_normalise3(right);
    ffp_cross3(forward, right, down);
    device.cx = device.cy = (real)side / 2;
    for (int k = 0; k < 3; k++) {
        device.pose[4 * k] = right[k], device.pose[4 * k + 1] = down[k], device.pose[4 * k + 2] = forward[k];
        device.pose[4 * k + 3] = (real[3]){x, y, z}[k];
    }
    device.pose[15] = 1;
    return device;
}

static inline FfpImage scene_noise(int side, int channels, FfpRng *rng) {
    FfpImage image = ffp_image_new(side, side, channels);
    for (int i = 0; i < side * side * channels; i++) image.data[i] = ffp_rng_range(rng, 0.05F, 0.9F);
    return image;
}

static inline void scene_view(FfpView *view, int index, FfpRng *rng) {
    const real turn = (real)index * 1.3F;
    snprintf(view->id, sizeof view->id, "view_%d", index);
    view->camera = scene_device(3 * cos(turn), 3 * sin(turn), 0.4F, SCENE_SIDE, 34);
    view->projector = scene_device(2 * cos(turn + 0.4F), 2 * sin(turn + 0.4F), 1.1F, SCENE_PATTERN, 40);
    view->images = ffp_alloc(SCENE_PATTERNS, sizeof *view->images);
    for (int p = 0; p < SCENE_PATTERNS; p++) view->images[p] = scene_noise(SCENE_SIDE, 3, rng);
    view->coverage = ffp_image_new(SCENE_SIDE, SCENE_SIDE, 1);
    for (int i = 0; i < SCENE_SIDE * SCENE_SIDE; i++) {
        const real x = (real)(i % SCENE_SIDE) - 11.5F, y = (real)(i / SCENE_SIDE) - 11.5F;
        view->coverage.data[i] = x * x + y * y < 49 ? 1 : 0;
        for (int p = 0; p < SCENE_PATTERNS; p++)
            for (int k = 0; k < 3; k++) view->images[p].data[3 * i + k] *= view->coverage.data[i];
    }
}

static inline FfpCapture scene_capture(void) {
    FfpRng rng = ffp_rng(5, 0);
    FfpCapture capture = {.n_patterns = SCENE_PATTERNS,
                          .n_views = SCENE_VIEWS,
                          .white = 1,
                          .intensity = {8, 7, 6},
                          .intensity_known = true,
                          .radius = 1};
    capture.patterns = ffp_alloc(SCENE_PATTERNS, sizeof *capture.patterns);
    capture.views = ffp_alloc(SCENE_VIEWS, sizeof *capture.views);
    for (int p = 0; p < SCENE_PATTERNS; p++) {
        FfpImage *image = &capture.patterns[p].image;
        *image = ffp_image_new(SCENE_PATTERN, SCENE_PATTERN, 3);
        for (int i = 0; i < SCENE_PATTERN * SCENE_PATTERN * 3; i++)
            image->data[i] = p < 2 ? (real)p : ffp_rng_uniform(&rng);
    }
    for (int v = 0; v < SCENE_VIEWS; v++) scene_view(&capture.views[v], v, &rng);
    return capture;
}

#endif
