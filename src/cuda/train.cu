// The optimiser and training's own loss terms on the GPU.
#include "cuda/loss_sums.h"
extern "C" {
#include "cuda/cuda.h"
#include "train/table.h"
}

static __global__ void squares(size_t threads, FfpPartials sums, const float *x, int64_t count) {
    double sum = 0;
    for (int64_t i = (int64_t)ffp_thread(); i < count; i += (int64_t)threads) sum += (double)x[i] * x[i];
    ffp_put_partial(sums, 0, sum);
}

static double squared_norm(const float *x, int64_t count) {
    enum { BLOCKS = 512 };
    const FfpPartials sums = ffp_launch_sums(1, (size_t)BLOCKS * FFP_SUM_THREADS, squares, x, count);
    double sum;
    ffp_cuda_loss_totals(&sum, &sums, true);
    return sum;
}

static __global__ void adam_each(size_t count, FfpAdamRates rates, float *w, float *m, float *v, float *ema,
                                 const float *grad) {
    const size_t i = ffp_thread();
    if (i < count) ffp_adam_move(&rates, w + i, m + i, v + i, ema + i, grad[i]);
}

static void adam(const FfpAdamRates *rates, float *w, float *m, float *v, float *ema, const float *grad,
                 int64_t count) {
    ffp_launch_each((size_t)count, adam_each, *rates, w, m, v, ema, grad);
}

// One thread a number: |sum - opacity truth| of foreground pixels, and how many numbers these have.
static __global__ void truth_differences(size_t numbers, FfpPartials sums, const float *sum,
                                         const float *opacity, const float *truth, const float *coverage,
                                         int channels) {
    const size_t i = ffp_thread(), p = i / channels;
    const bool known = i < numbers && coverage[p] > 0.5F;
    ffp_put_partial(sums, 0, known ? fabsf(sum[i] - opacity[p] * truth[i]) : 0);
    ffp_put_partial(sums, 1, known);
}

static __global__ void truth_gradient(size_t numbers, const float *sum, const float *opacity,
                                      const float *truth, const float *coverage, int channels, float weight,
                                      const double *known, float *grad) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const size_t p = i / channels;
    if (coverage[p] <= 0.5F) return;
    const float difference = sum[i] - opacity[p] * truth[i], step = weight / (float)*known;
    grad[i] += difference > 0 ? step : difference < 0 ? -step : 0;
}

static double truth_loss(const float *sum, const float *opacity, const float *truth, const float *coverage,
                         int pixels, int channels, float weight, float *grad) {
    const size_t numbers = (size_t)pixels * channels;
    const FfpPartials sums =
        ffp_launch_sums(2, numbers, truth_differences, sum, opacity, truth, coverage, channels);
    ffp_cuda_loss_add(&sums);
    ffp_launch_each(numbers, truth_gradient, sum, opacity, truth, coverage, channels, weight, sums.total + 1,
                    grad);
    return ffp_cuda_mean(&sums, false, weight, 0);
}

static __global__ void distances(size_t count, FfpPartials sums, const float *t, const float *truth) {
    const size_t i = ffp_thread();
    const bool known = i < count && truth[i] > 0;
    ffp_put_partial(sums, 0, known ? fabsf(t[i] - truth[i]) : 0);
    ffp_put_partial(sums, 1, known);
}

static __global__ void distance_gradient(size_t count, const float *t, const float *truth, float weight,
                                         const double *known, float *grad) {
    const size_t i = ffp_thread();
    if (i >= count) return;
    const float step = *known > 0 ? weight / (float)*known : 0;
    grad[i] = truth[i] <= 0 ? 0 : t[i] > truth[i] ? step : -step;
}

static double distance_loss(const float *t, const float *truth, int64_t count, float weight, float *grad) {
    const FfpPartials sums = ffp_launch_sums(2, (size_t)count, distances, t, truth);
    ffp_cuda_loss_add(&sums);
    ffp_launch_each((size_t)count, distance_gradient, t, truth, weight, sums.total + 1, grad);
    return ffp_cuda_mean(&sums, false, weight, 0);
}

extern "C" const struct FfpTrainTable ffp_cuda_train = {
    .squared_norm = squared_norm,
    .adam = adam,
    .truth_loss = truth_loss,
    .distance_loss = distance_loss,
};
