// LayerNorm and RMSNorm: a warp for each row.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}
#include "engine/cuda/columns.h"
#include "engine/cuda/warp.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP, ROWS_LEAST = 16, BLOCKS_MOST = 512 };
#define EPSILON 1e-5f

// sum of (x - centre)^2
static __device__ inline float sum_of_squares(const float *x, float centre, int dim) {
    float sum = 0;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) sum += (x[i] - centre) * (x[i] - centre);
    return ffp_warp_sum(sum);
}

// `mean` NULL: RMSNorm.
static __global__ void norm_forward(float *y, float *mean, float *rstd, const float *x, const float *gain,
                                    int rows, int dim) {
    const int t = (int)(blockIdx.x * WARPS + threadIdx.x / FFP_WARP);
    if (t >= rows) return;
    x += (size_t)t * dim;
    y += (size_t)t * dim;
    float centre = 0;
    if (mean) {
        for (int i = ffp_lane(); i < dim; i += FFP_WARP) centre += x[i];
        centre = ffp_warp_sum(centre) / (float)dim;
    }
    const float scale = 1 / sqrtf(sum_of_squares(x, centre, dim) / (float)dim + EPSILON);
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) y[i] = (x[i] - centre) * scale * gain[i];
    if (ffp_lane() != 0) return;
    if (mean) mean[t] = centre;
    rstd[t] = scale;
}

// With n = (x - mean) rstd and g = dy gain: dx = rstd (g - mean(g) - n mean(g n)), RMSNorm's without mean(g).
static __device__ void row_backward(float *dx, const float *dy, const float *x, float centre, float scale,
                                    const float *gain, int dim, bool has_mean) {
    float sum = 0, sum_n = 0;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) {
        const float g = dy[i] * gain[i];
        sum += g;
        sum_n += g * (x[i] - centre);
    }
    const float along_one = has_mean ? ffp_warp_sum(sum) / (float)dim : 0;
    const float along_n = ffp_warp_sum(sum_n) * scale * scale / (float)dim;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP)
        dx[i] = scale * (dy[i] * gain[i] - along_one - (x[i] - centre) * along_n);
}

// The forward pass's numbers for the backward one.
typedef struct Norm {
    const float *x;           // [rows, dim]
    const float *mean, *rstd; // [rows]; mean NULL: RMSNorm
    const float *gain;        // [dim]
    int rows, dim;
} Norm;

// A block has some rows: its warps their dx, then its threads the columns' share of dgain, sum of dy n, while
// the rows are in the cache.
static __global__ void norm_backward(float *dx, float *partial, const float *dy, Norm norm,
                                     int rows_a_block) {
    const int first = (int)blockIdx.x * rows_a_block, end = min(first + rows_a_block, norm.rows),
              dim = norm.dim;
    const float *x = norm.x, *mean = norm.mean, *rstd = norm.rstd;
    for (int t = first + (int)threadIdx.x / FFP_WARP; t < end; t += WARPS) {
        const size_t row = (size_t)t * dim;
        row_backward(dx + row, dy + row, x + row, mean ? mean[t] : 0, rstd[t], norm.gain, dim, mean != NULL);
    }
    for (int i = (int)threadIdx.x; i < dim; i += THREADS) {
        float sum = 0;
        for (int t = first; t < end; t++)
            sum += dy[(size_t)t * dim + i] * (x[(size_t)t * dim + i] - (mean ? mean[t] : 0)) * rstd[t];
        partial[(size_t)blockIdx.x * dim + i] = sum;
    }
}

static void run_forward(float *y, float *mean, float *rstd, const float *x, const float *gain, int rows,
                        int dim) {
    ffp_launch_blocks(norm_forward, dim3(ffp_blocks((size_t)rows, WARPS)), dim3(THREADS), 0, y, mean, rstd, x,
                      gain, rows, dim);
}

static void run_backward(float *dx, float *dgain, const float *dy, const Norm *norm) {
    const int rows_a_block = max((int)ROWS_LEAST, (norm->rows + BLOCKS_MOST - 1) / BLOCKS_MOST);
    const int blocks = (int)ffp_blocks((size_t)norm->rows, (unsigned)rows_a_block);
    float *partial = ffp_cuda_column_partials((size_t)blocks * norm->dim);
    ffp_launch_blocks(norm_backward, dim3((unsigned)blocks), dim3(THREADS), 0, dx, partial, dy, *norm,
                      rows_a_block);
    ffp_cuda_add_columns(partial, blocks, dgain, norm->dim, NULL, 0);
}

void ffp_cuda_layernorm_forward(float *y, float *mean, float *rstd, const float *x, const float *gain,
                                int rows, int dim) {
    run_forward(y, mean, rstd, x, gain, rows, dim);
}

void ffp_cuda_layernorm_backward(float *dx, float *dgain, const float *dy, const float *x, const float *mean,
                                 const float *rstd, const float *gain, int rows, int dim) {
    const Norm norm = {x, mean, rstd, gain, rows, dim};
    run_backward(dx, dgain, dy, &norm);
}

void ffp_cuda_rmsnorm_forward(float *y, float *rstd, const float *x, const float *gain, int rows, int dim) {
    run_forward(y, NULL, rstd, x, gain, rows, dim);
}

void ffp_cuda_rmsnorm_backward(float *dx, float *dgain, const float *dy, const float *x, const float *rstd,
                               const float *gain, int rows, int dim) {
    const Norm norm = {x, NULL, rstd, gain, rows, dim};
    run_backward(dx, dgain, dy, &norm);
}
