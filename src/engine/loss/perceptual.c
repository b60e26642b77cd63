// Perceptual distances over the networks of perceptual_net.c: LPIPS v0.1 and the mean squared feature
// distance.
#include <assert.h>
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "engine/loss/loss.h"
#include "engine/loss/perceptual_net.h"
#include "engine/loss/table.h"
#include "engine/loss/terms.h"

enum { BLOCK = 64 }; // pixels a thread takes at a time; sums are kept per block and added in order

// Two images' features at a tap, and where the gradient of the first goes (or NULL). Planes are `pixels`
// apart.
typedef struct Pair {
    const real *a, *b;
    real *grad;
    int channels;
    ptrdiff_t pixels;
} Pair;

// 1 / (|x| + 1e-10) per pixel of a block, |x| over the channels.
static void inverse_norms(real inverse[BLOCK], const real *x, const Pair *pair, int count) {
    for (int i = 0; i < count; i++) inverse[i] = 0;
    for (int c = 0; c < pair->channels; c++)
        for (int i = 0; i < count; i++) inverse[i] += x[c * pair->pixels + i] * x[c * pair->pixels + i];
    for (int i = 0; i < count; i++) inverse[i] = 1 / (sqrt(inverse[i]) + 1e-10F);
}

// One block's share of sum_pixels sum_c head_c (u_c - v_c)^2, u = a/|a|, v = b/|b|; scale times its gradient
// goes through the normalisation: da = (g - u (g.u)) / |a| with g = 2 head (u - v).
static double lpips_block(const Pair *pair, const real *head, real scale, ptrdiff_t first, int count) {
    real inverse_a[BLOCK], inverse_b[BLOCK], value[BLOCK] = {0}, along[BLOCK] = {0};
    const real *a = pair->a + first, *b = pair->b + first;
    inverse_norms(inverse_a, a, pair, count);
    inverse_norms(inverse_b, b, pair, count);
    for (int c = 0; c < pair->channels; c++) {
        const real *ac = a + c * pair->pixels, *bc = b + c * pair->pixels;
        for (int i = 0; i < count; i++) {
            const real u = ac[i] * inverse_a[i], difference = u - bc[i] * inverse_b[i];
            value[i] += head[c] * difference * difference;
            along[i] += 2 * head[c] * difference * u;
        }
    }
    for (int c = 0; pair->grad && c < pair->channels; c++) {
        const real *ac = a + c * pair->pixels, *bc = b + c * pair->pixels;
        real *g = pair->grad + first + c * pair->pixels;
        for (int i = 0; i < count; i++) {
            const real u = ac[i] * inverse_a[i], difference = u - bc[i] * inverse_b[i];
            g[i] += scale * ffp_lpips_slope(ac[i], u, difference, head[c], along[i], inverse_a[i]);
        }
    }
    double sum = 0;
    for (int i = 0; i < count; i++) sum += value[i];
    return sum;
}

// One block's share of the summed squared difference.
static double square_block(const Pair *pair, real scale, ptrdiff_t first, int count) {
    real value[BLOCK] = {0};
    for (int c = 0; c < pair->channels; c++) {
        const real *a = pair->a + first + c * pair->pixels, *b = pair->b + first + c * pair->pixels;
        for (int i = 0; i < count; i++) value[i] += (a[i] - b[i]) * (a[i] - b[i]);
        real *g = pair->grad ? pair->grad + first + c * pair->pixels : NULL;
        for (int i = 0; g && i < count; i++) g[i] += scale * 2 * (a[i] - b[i]);
    }
    double sum = 0;
    for (int i = 0; i < count; i++) sum += value[i];
    return sum;
}

// The distance at one tap; weight * gradient is added to the tap's gradient.
static double tap_distance(const FfpTap *tap, const FfpPerceptual *net, const FfpFeatures *features,
                           real weight) {
    const int slot = tap->slot;
    const Pair pair = {.a = features->value[slot],
                       .b = features->value[slot] + features->size[slot],
                       .grad = features->grad[slot],
                       .channels = net->channels[slot],
                       .pixels = (ptrdiff_t)features->width[slot] * features->height[slot]};
    // LPIPS averages over pixels and sums channels, the feature distance averages over both.
    const double inverse = 1 / (tap->head ? (double)pair.pixels : (double)features->size[slot]);
    const real scale = weight * (real)inverse;
    const ptrdiff_t blocks = (pair.pixels + BLOCK - 1) / BLOCK;
    double *sums = ffp_alloc(blocks, sizeof *sums), total = 0;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t k = 0; k < blocks; k++) {
        const ptrdiff_t first = k * BLOCK, left = pair.pixels - first;
        const int count = left < BLOCK ? (int)left : BLOCK;
        sums[k] = tap->head ? lpips_block(&pair, tap->head, scale, first, count)
                            : square_block(&pair, scale, first, count);
    }
    for (ptrdiff_t k = 0; k < blocks; k++) total += sums[k];
    ffp_free(sums);
    return total * inverse;
}

// The network's weights on the device in use, uploaded when it is asked for the first time.
static const void *weights_on_device(const FfpPerceptual *net) {
    FfpPerceptualCopy *copy = net->copy;
    if (copy->weights && copy->device == ffp_device()) return copy->weights;
    ffp_disown(copy->weights);
    if (copy->weights) copy->device->loss->perceptual_release(copy->weights);
    copy->device = ffp_device();
    copy->weights = NULL;
    copy->weights = copy->device->loss->perceptual_upload(net);
    ffp_own(copy->weights, copy->device->loss->perceptual_release);
    return copy->weights;
}

real ffp_perceptual_loss(const FfpPerceptual *net, const FfpImage *prediction, const FfpImage *target,
                         real weight, FfpImage *grad) {
    assert(prediction->width == target->width && prediction->height == target->height);
    assert(prediction->channels >= 3 && target->channels >= 3);
    FfpFeatures features;
    if (!ffp_features_plan(&features, net, prediction->width, prediction->height)) return 0;
    if (ffp_device())
        return ffp_device()->loss->perceptual(net, weights_on_device(net), prediction, target, weight, grad);
    ffp_features_forward(&features, net, prediction, target);
    if (grad) ffp_features_new_gradient(&features, net);
    double sum = 0;
    for (int i = 0; i < net->tap_count; i++) sum += tap_distance(&net->taps[i], net, &features, weight);
    if (grad) ffp_features_backward(&features, net, grad);
    ffp_features_free(&features);
    return weight * (real)sum;
}

bool ffp_perceptual_is_lpips(const FfpPerceptual *net) {
    return net->kind != FFP_PERCEPTUAL_VGG16;
}

int ffp_perceptual_least_side(const FfpPerceptual *net) {
    FfpFeatures features;
    int side = 1;
    while (!ffp_features_plan(&features, net, side, side)) side++;
    return side;
}
