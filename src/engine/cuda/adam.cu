// The optimiser on the GPU: Adam a thread a number, and the sum of squares.
#include "engine/cuda/loss_sums.h"
extern "C" {
#include "engine/cuda/tensor.h"
}

static __global__ void squares(size_t threads, FfpPartials sums, const float *x, int64_t count) {
    double sum = 0;
    for (int64_t i = (int64_t)ffp_thread(); i < count; i += (int64_t)threads) sum += (double)x[i] * x[i];
    ffp_store_partial(sums, 0, sum);
}

double ffp_cuda_squared_norm(const float *x, int64_t count) {
    enum { BLOCKS = 512 };
    const FfpPartials sums = ffp_launch_sums(1, (size_t)BLOCKS * FFP_SUM_THREADS, squares, x, count);
    double sum;
    ffp_cuda_loss_totals(&sum, &sums, true);
    return sum;
}

static __global__ void adam_each(size_t count, FfpAdamArray a) {
    const size_t i = ffp_thread();
    if (i >= count) return;
    ffp_adam_move(&a.step, a.grad[i], a.x + i, a.mean + i, a.square + i);
    if (a.start) a.x[i] = ffp_adam_pulled(&a.step, a.x[i], a.start[i]);
    if (a.average) a.average[i] = ffp_adam_average(&a.step, a.average[i], a.x[i]);
}

void ffp_cuda_adam(const FfpAdamArray *arrays, int n) {
    for (int k = 0; k < n; k++) ffp_launch_each((size_t)arrays[k].count, adam_each, arrays[k]);
}
