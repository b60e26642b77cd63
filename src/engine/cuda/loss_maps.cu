// Terms on G-buffers that take every pixel by itself.
#include "engine/cuda/loss_room.h"
#include "engine/cuda/loss_sums.h"
extern "C" {
#include "engine/loss/terms.h"
}

static __global__ void mask_pixels(size_t count, FfpPartials sums, const float *opacity, const float *mask,
                                   float scale, float *grad) {
    const size_t i = ffp_thread();
    double entropy = 0;
    if (i < count) {
        entropy = -ffp_mask_term(opacity[i], mask[i]);
        if (grad) grad[i] += ffp_mask_slope(opacity[i], mask[i], scale);
    }
    ffp_store_partial(sums, 0, entropy);
}

real ffp_cuda_mask(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity) {
    const FfpPartials sums =
        ffp_launch_sums(1, (size_t)pixels, mask_pixels, opacity, mask, weight / (real)pixels, grad_opacity);
    return (real)ffp_cuda_mean(&sums, true, weight, pixels);
}

static __global__ void depth_pixels(size_t count, FfpPartials sums, const float *depth_sum,
                                    const float *opacity, const float *truth) {
    const size_t i = ffp_thread();
    const bool used = i < count && ffp_depth_counts(opacity[i], truth[i]);
    ffp_store_partial(sums, 0, used ? ffp_depth_term(depth_sum[i], opacity[i], truth[i]) : 0);
    ffp_store_partial(sums, 1, used);
}

// totals[1]: how many pixels count.
static __global__ void depth_slopes(size_t count, const double *totals, const float *depth_sum,
                                    const float *opacity, const float *truth, float weight,
                                    float *grad_depth_sum, float *grad_opacity) {
    const size_t i = ffp_thread();
    if (i >= count || !ffp_depth_counts(opacity[i], truth[i])) return;
    float by_opacity;
    const float slope =
        ffp_depth_slope(depth_sum[i], opacity[i], truth[i], 2 * weight / (float)totals[1], &by_opacity);
    if (grad_depth_sum) grad_depth_sum[i] += slope;
    if (grad_opacity) grad_opacity[i] -= by_opacity;
}

real ffp_cuda_depth(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                    real *grad_depth_sum, real *grad_opacity) {
    const FfpPartials sums = ffp_launch_sums(2, (size_t)pixels, depth_pixels, depth_sum, opacity, truth);
    ffp_cuda_loss_add(&sums);
    if (grad_depth_sum || grad_opacity)
        ffp_launch_each((size_t)pixels, depth_slopes, sums.total, depth_sum, opacity, truth, weight,
                        grad_depth_sum, grad_opacity);
    return (real)ffp_cuda_mean(&sums, false, weight, 0);
}

static __global__ void distortion_pixels(size_t count, FfpPartials sums, const float *distortion, float step,
                                         float *grad) {
    const size_t i = ffp_thread();
    if (grad && i < count) grad[i] += step;
    ffp_store_partial(sums, 0, i < count ? distortion[i] : 0);
}

real ffp_cuda_distortion(const real *distortion, int pixels, real weight, real *grad_distortion) {
    const FfpPartials sums = ffp_launch_sums(1, (size_t)pixels, distortion_pixels, distortion,
                                             weight / (real)pixels, grad_distortion);
    return (real)ffp_cuda_mean(&sums, true, weight, pixels);
}

// One thread a number: |sum - opacity truth| of foreground pixels, and how many numbers these have.
static __global__ void truth_differences(size_t numbers, FfpPartials sums, const float *sum,
                                         const float *opacity, const float *truth, const float *coverage,
                                         int channels) {
    const size_t i = ffp_thread(), p = i / channels;
    const bool known = i < numbers && coverage[p] > 0.5F;
    ffp_store_partial(sums, 0, known ? fabsf(sum[i] - opacity[p] * truth[i]) : 0);
    ffp_store_partial(sums, 1, known);
}

static __global__ void truth_gradient(size_t numbers, const float *sum, const float *opacity,
                                      const float *truth, const float *coverage, int channels, float weight,
                                      const double *known, float *grad) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const size_t p = i / channels;
    if (coverage[p] <= 0.5F) return;
    grad[i] += ffp_signed(weight / (float)*known, sum[i] - opacity[p] * truth[i]);
}

double ffp_cuda_truth(const real *sum, const real *opacity, const FfpImage *truth, const FfpImage *coverage,
                      real weight, real *grad) {
    const int channels = truth->channels;
    const size_t numbers = (size_t)truth->width * truth->height * channels;
    const FfpPartials sums =
        ffp_launch_sums(2, numbers, truth_differences, sum, opacity, truth->data, coverage->data, channels);
    ffp_cuda_loss_add(&sums);
    ffp_launch_each(numbers, truth_gradient, sum, opacity, truth->data, coverage->data, channels, weight,
                    sums.total + 1, grad);
    return ffp_cuda_mean(&sums, false, weight, 0);
}

static __global__ void distances(size_t count, FfpPartials sums, const float *t, const float *truth) {
    const size_t i = ffp_thread();
    const bool known = i < count && truth[i] > 0;
    ffp_store_partial(sums, 0, known ? fabsf(t[i] - truth[i]) : 0);
    ffp_store_partial(sums, 1, known);
}

static __global__ void distance_gradient(size_t count, const float *t, const float *truth, float weight,
                                         const double *known, float *grad) {
    const size_t i = ffp_thread();
    if (i >= count) return;
    const float step = *known > 0 ? weight / (float)*known : 0;
    grad[i] = truth[i] <= 0 ? 0 : t[i] > truth[i] ? step : -step;
}

double ffp_cuda_distance(const real *t, const real *truth, int64_t count, real weight, real *grad) {
    const FfpPartials sums = ffp_launch_sums(2, (size_t)count, distances, t, truth);
    ffp_cuda_loss_add(&sums);
    ffp_launch_each((size_t)count, distance_gradient, t, truth, weight, sums.total + 1, grad);
    return ffp_cuda_mean(&sums, false, weight, 0);
}
