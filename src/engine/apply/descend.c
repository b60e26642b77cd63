// Gradient descent on the patterns, through lookup and light.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/real.h"
#include "core/tensor/adam.h"
#include "engine/apply/encoded.h"
#include "engine/apply/solve.h"

#define RATE 0.03F // of the first step, in pattern values; falls to a tenth along a cosine
#define BETA1 0.9
#define BETA2 0.99

static double total_weight(const FfpProCams *procams) {
    double sum = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        const FfpImage *weight = &procams->camera_views[s].weight;
        for (int p = 0; p < weight->width * weight->height; p++) sum += (double)weight->data[p];
    }
    return sum > 0 ? sum : 1;
}

// The camera's part of the loss; `difference` becomes its gradient to the linear picture.
static double compare(const FfpCameraView *camera_view, const FfpImage *picture, double scale,
                      FfpImage *difference) {
    const int pixels = picture->width * picture->height;
    double sum = 0;
    for (int i = 0; i < 3 * pixels; i++) {
        real slope, unused;
        const real error =
            ffp_encode_on(picture->data[i], &slope) - ffp_encode_on(camera_view->target.data[i], &unused);
        const double weight = (double)camera_view->weight.data[i / 3] * scale;
        sum += weight * (double)error * (double)error;
        difference->data[i] = (real)(2 * weight) * error * slope;
    }
    return sum;
}

// From a camera's picture to a projection's pattern; spread and blur are their own adjoints, but at the
// pattern's edges.
static void take_back(const FfpProCams *procams, int s, int k, const FfpImage *difference,
                      FfpImage *gradient) {
    const FfpLink *link = ffp_procams_link(procams, s, k);
    const FfpImage *scattered = &procams->camera_views[s].scattered;

    FfpSummed adjoint = ffp_summed_zeros(gradient->width, gradient->height);
    FfpImage part = ffp_image_new(gradient->width, gradient->height, 3);
    real level[3] = {0, 0, 0};
    const size_t count = (size_t)gradient->width * (size_t)gradient->height * 3;
    for (int p = 0; p < difference->width * difference->height; p++) {
        const real *uv = link->mapping.uv + 2 * p, *extent = link->mapping.extent + 2 * p;
        real grad[3];
        for (int c = 0; c < 3 && scattered->data; c++)
            level[c] += difference->data[3 * p + c] * scattered->data[3 * p + c];
        for (int c = 0; c < 3; c++) grad[c] = difference->data[3 * p + c] * link->response.data[3 * p + c];
        if (grad[0] == 0 && grad[1] == 0 && grad[2] == 0) continue;
        ffp_lookup_backward_pattern(&adjoint, uv[0], uv[1], extent[0], extent[1], grad);
    }
    const real *lit = link->mapping.lit;
    if (scattered->data) ffp_lookup_backward_pattern(&adjoint, lit[0], lit[1], lit[2], lit[3], level);
    ffp_lookup_gather_pattern(&adjoint, &part);
    ffp_image_spread(&part, procams->spread, procams->spread_reach);
    ffp_image_blur(&part, procams->blur);
    for (size_t i = 0; i < count; i++) gradient->data[i] += part.data[i];
    ffp_image_free(&part);
    ffp_summed_free(&adjoint);
}

double ffp_procams_loss(const FfpProCams *procams, FfpImage *gradients) {
    const double scale = 1 / (3 * total_weight(procams));
    double loss = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpImage picture = ffp_procams_picture(procams, s);
        FfpImage difference = ffp_image_new(picture.width, picture.height, 3);
        loss += compare(&procams->camera_views[s], &picture, scale, &difference);
        for (int k = 0; gradients && k < procams->n_projections; k++)
            take_back(procams, s, k, &difference, &gradients[k]);
        ffp_image_free(&picture);
        ffp_image_free(&difference);
    }
    return loss;
}

typedef struct Adam {
    FfpImage *gradients; // [n_projections]
    real **mean, **square;
    size_t *count;
} Adam;

static Adam adam_new(const FfpProCams *procams) {
    const size_t n = (size_t)procams->n_projections;
    Adam adam = {ffp_alloc(n, sizeof *adam.gradients), ffp_alloc(n, sizeof *adam.mean),
                 ffp_alloc(n, sizeof *adam.square), ffp_alloc(n, sizeof *adam.count)};
    for (size_t k = 0; k < n; k++) {
        const FfpImage *pattern = &procams->projections[k].pattern;
        adam.count[k] = (size_t)pattern->width * (size_t)pattern->height * 3;
        adam.gradients[k] = ffp_image_new(pattern->width, pattern->height, 3);
        adam.mean[k] = ffp_alloc(adam.count[k], sizeof(real));
        adam.square[k] = ffp_alloc(adam.count[k], sizeof(real));
    }
    return adam;
}

static void adam_free(Adam *adam, int n_projections) {
    for (int k = 0; k < n_projections; k++) {
        ffp_image_free(&adam->gradients[k]);
        ffp_free(adam->mean[k]);
        ffp_free(adam->square[k]);
    }
    ffp_free(adam->gradients);
    ffp_free(adam->mean);
    ffp_free(adam->square);
    ffp_free(adam->count);
}

// One step of pattern k, within [0,1].
static void adam_step(const Adam *adam, int k, const FfpAdamStep *step, real *value) {
    const FfpAdamArray array = {.step = *step,
                                .count = (int64_t)adam->count[k],
                                .x = value,
                                .mean = adam->mean[k],
                                .square = adam->square[k],
                                .grad = adam->gradients[k].data};
    ffp_adam(&array, 1);
    for (size_t i = 0; i < adam->count[k]; i++) value[i] = fmin(fmax(value[i], (real)0), (real)1);
}

static real root_mean_square(const FfpImage *image) {
    const size_t n = (size_t)image->width * (size_t)image->height * 3;
    double sum = 0, count = 0;
    for (size_t i = 0; i < n; i++)
        if (image->data[i] != 0) {
            sum += (double)image->data[i] * (double)image->data[i];
            count++;
        }
    return count > 0 ? (real)sqrt(sum / count) : 1;
}

void ffp_procams_descend(FfpProCams *procams, int steps) {
    Adam adam = adam_new(procams);
    real *small = ffp_alloc((size_t)procams->n_projections, sizeof *small);
    for (int step = 1; step <= steps; step++) {
        ffp_cancel_point();
        for (int k = 0; k < procams->n_projections; k++)
            memset(adam.gradients[k].data, 0, adam.count[k] * sizeof(real));
        ffp_procams_loss(procams, adam.gradients);
        const real turn = (real)(step - 1) / (real)steps;
        const real rate = RATE * (0.55F + 0.45F * cos(FFP_PI * turn));
        for (int k = 0; k < procams->n_projections; k++) {
            // keeps places that hardly matter from moving as fast as the others
            if (step == 1) small[k] = root_mean_square(&adam.gradients[k]);
            const FfpAdamStep move = ffp_adam_step((double)rate, BETA1, BETA2, (double)small[k], step);
            adam_step(&adam, k, &move, procams->projections[k].pattern.data);
        }
    }
    ffp_free(small);
    adam_free(&adam, procams->n_projections);
}
