// The optimiser and training's own loss terms on the GPU.
#include "cuda/launch.h"
extern "C" {
#include "cuda/cuda.h"
#include "train/table.h"
}
#include "cuda/memory.h"

enum { THREADS = 256, PARTS = 256 };

// The block's sum of x, the same in every thread of it; THREADS threads.
static __device__ double block_sum(double x) {
    __shared__ double parts[THREADS];
    __syncthreads();
    parts[threadIdx.x] = x;
    for (int half = THREADS / 2; half > 0; half /= 2) {
        __syncthreads();
        if ((int)threadIdx.x < half) parts[threadIdx.x] += parts[threadIdx.x + half];
    }
    __syncthreads();
    return parts[0];
}

// Partial sums [PARTS, 2] and what they come to, kept from call to call.
static double *sums_memory(void) {
    static double *memory;
    if (!memory) memory = (double *)ffp_cuda_alloc((2 * PARTS + 2) * sizeof *memory);
    return memory;
}

// parts [PARTS, 2] to out [2].
static __global__ void add_parts(const double *parts, double *out) {
    for (int k = 0; k < 2; k++) {
        const double sum = block_sum(parts[2 * threadIdx.x + k]);
        if (threadIdx.x == 0) out[k] = sum;
    }
}

static __global__ void square_parts(const float *x, int64_t count, double *parts) {
    double sum = 0;
    for (int64_t i = (int64_t)ffp_thread(); i < count; i += (int64_t)PARTS * THREADS)
        sum += (double)x[i] * x[i];
    sum = block_sum(sum);
    if (threadIdx.x == 0) parts[2 * blockIdx.x] = sum, parts[2 * blockIdx.x + 1] = 0;
}

static double squared_norm(const float *x, int64_t count) {
    double *parts = sums_memory(), *out = parts + 2 * PARTS, sum;
    ffp_launch_blocks(square_parts, dim3(PARTS), dim3(THREADS), 0, x, count, parts);
    ffp_launch_blocks(add_parts, dim3(1), dim3(PARTS), 0, parts, out);
    ffp_cuda_download(&sum, out, sizeof sum);
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

// Of each part: sum of |sum - opacity truth|, and the number of foreground pixels.
static __global__ void truth_parts(const float *sum, const float *opacity, const float *truth,
                                   const float *coverage, int pixels, int channels, double *parts) {
    double total = 0, known = 0;
    for (int p = (int)ffp_thread(); p < pixels; p += PARTS * THREADS) {
        if (coverage[p] <= 0.5F) continue;
        known++;
        for (int k = 0; k < channels; k++)
            total += fabsf(sum[p * channels + k] - opacity[p] * truth[p * channels + k]);
    }
    total = block_sum(total);
    known = block_sum(known);
    if (threadIdx.x == 0) parts[2 * blockIdx.x] = total, parts[2 * blockIdx.x + 1] = known;
}

static __global__ void truth_gradient(size_t numbers, const float *sum, const float *opacity,
                                      const float *truth, const float *coverage, int channels, float weight,
                                      const double *sums, float *grad) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const size_t p = i / channels;
    if (coverage[p] <= 0.5F) return;
    const float difference = sum[i] - opacity[p] * truth[i], step = weight / ((float)sums[1] * channels);
    grad[i] += difference > 0 ? step : difference < 0 ? -step : 0;
}

// sum / (known * per), times weight.
static double weighted_mean(const double *out, int per, float weight) {
    double sums[2];
    ffp_cuda_download(sums, out, sizeof sums);
    return sums[1] > 0 ? sums[0] * weight / (sums[1] * per) : 0;
}

static double truth_loss(const float *sum, const float *opacity, const float *truth, const float *coverage,
                         int pixels, int channels, float weight, float *grad) {
    double *parts = sums_memory(), *out = parts + 2 * PARTS;
    ffp_launch_blocks(truth_parts, dim3(PARTS), dim3(THREADS), 0, sum, opacity, truth, coverage, pixels,
                      channels, parts);
    ffp_launch_blocks(add_parts, dim3(1), dim3(PARTS), 0, parts, out);
    ffp_launch_each((size_t)pixels * channels, truth_gradient, sum, opacity, truth, coverage, channels,
                    weight, out, grad);
    return weighted_mean(out, channels, weight);
}

static __global__ void distance_parts(const float *t, const float *truth, int64_t count, double *parts) {
    double total = 0, known = 0;
    for (int64_t i = (int64_t)ffp_thread(); i < count; i += (int64_t)PARTS * THREADS) {
        if (truth[i] <= 0) continue;
        total += fabsf(t[i] - truth[i]);
        known++;
    }
    total = block_sum(total);
    known = block_sum(known);
    if (threadIdx.x == 0) parts[2 * blockIdx.x] = total, parts[2 * blockIdx.x + 1] = known;
}

static __global__ void distance_gradient(size_t count, const float *t, const float *truth, float weight,
                                         const double *sums, float *grad) {
    const size_t i = ffp_thread();
    if (i >= count) return;
    const float step = sums[1] > 0 ? weight / (float)sums[1] : 0;
    grad[i] = truth[i] <= 0 ? 0 : t[i] > truth[i] ? step : -step;
}

static double distance_loss(const float *t, const float *truth, int64_t count, float weight, float *grad) {
    double *parts = sums_memory(), *out = parts + 2 * PARTS;
    ffp_launch_blocks(distance_parts, dim3(PARTS), dim3(THREADS), 0, t, truth, count, parts);
    ffp_launch_blocks(add_parts, dim3(1), dim3(PARTS), 0, parts, out);
    ffp_launch_each((size_t)count, distance_gradient, t, truth, weight, out, grad);
    return weighted_mean(out, 1, weight);
}

extern "C" const struct FfpTrainTable ffp_cuda_train = {
    .squared_norm = squared_norm,
    .adam = adam,
    .truth_loss = truth_loss,
    .distance_loss = distance_loss,
};
