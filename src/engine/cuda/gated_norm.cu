// Mamba2's gated RMSNorm: y = rmsnorm(u) gain, u = x silu(z). A warp for each row.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}
#include "engine/cuda/columns.h"
#include "engine/cuda/warp.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP, ROWS_LEAST = 16, BLOCKS_MOST = 512 };
#define EPSILON 1e-5f

static __device__ inline float gate(float x, float z) {
    return x * z * ffp_logistic(z);
}

static __global__ void gated_forward(float *y, float *rstd, const float *x, const float *z, int ldz,
                                     const float *gain, int rows, int dim) {
    const int t = (int)(blockIdx.x * WARPS + threadIdx.x / FFP_WARP);
    if (t >= rows) return;
    x += (size_t)t * dim, y += (size_t)t * dim, z += (size_t)t * ldz;
    float sum = 0;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) {
        const float u = gate(x[i], z[i]);
        y[i] = u; // read again by the same lane
        sum += u * u;
    }
    const float scale = 1 / sqrtf(ffp_warp_sum(sum) / (float)dim + EPSILON);
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) y[i] *= scale * gain[i];
    if (ffp_lane() == 0) rstd[t] = scale;
}

// du = rstd (g - u mean(g u) rstd^2) with g = dy gain, then through the gate.
static __device__ void row_backward(float *dx, float *dz, const float *dy, const float *x, const float *z,
                                    float scale, const float *gain, int dim) {
    float sum = 0;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) sum += dy[i] * gain[i] * gate(x[i], z[i]);
    const float along = ffp_warp_sum(sum) * scale * scale / (float)dim;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) {
        const float open = ffp_logistic(z[i]), silu = z[i] * open; // silu' = open (1 + z (1 - open))
        const float du = scale * (dy[i] * gain[i] - x[i] * silu * along);
        dx[i] = du * silu;
        dz[i] += du * x[i] * open * (1 + z[i] * (1 - open));
    }
}

// As norm.cu's.
static __global__ void gated_backward(float *dx, float *dz, int lddz, float *partial, const float *dy,
                                      const float *x, const float *z, int ldz, const float *rstd,
                                      const float *gain, int rows, int dim, int rows_a_block) {
    const int first = (int)blockIdx.x * rows_a_block, end = min(first + rows_a_block, rows);
    for (int t = first + (int)threadIdx.x / FFP_WARP; t < end; t += WARPS) {
        const size_t row = (size_t)t * dim;
        row_backward(dx + row, dz + (size_t)t * lddz, dy + row, x + row, z + (size_t)t * ldz, rstd[t], gain,
                     dim);
    }
    for (int i = (int)threadIdx.x; i < dim; i += THREADS) {
        float sum = 0;
        for (int t = first; t < end; t++)
            sum += dy[(size_t)t * dim + i] * gate(x[(size_t)t * dim + i], z[(size_t)t * ldz + i]) * rstd[t];
        partial[(size_t)blockIdx.x * dim + i] = sum;
    }
}

void ffp_cuda_gated_norm_forward(float *y, float *rstd, const float *x, const float *z, int ldz,
                                 const float *gain, int rows, int dim) {
    ffp_launch_blocks(gated_forward, dim3(ffp_blocks((size_t)rows, WARPS)), dim3(THREADS), 0, y, rstd, x, z,
                      ldz, gain, rows, dim);
}

void ffp_cuda_gated_norm_backward(float *dx, float *dz, int lddz, float *dgain, const float *dy,
                                  const float *x, const float *z, int ldz, const float *rstd,
                                  const float *gain, int rows, int dim) {
    const int rows_a_block = max((int)ROWS_LEAST, (rows + BLOCKS_MOST - 1) / BLOCKS_MOST);
    const int blocks = (int)ffp_blocks((size_t)rows, (unsigned)rows_a_block);
    float *partial = ffp_cuda_column_partials((size_t)blocks * dim);
    ffp_launch_blocks(gated_backward, dim3((unsigned)blocks), dim3(THREADS), 0, dx, dz, lddz, partial, dy, x,
                      z, ldz, rstd, gain, rows, dim, rows_a_block);
    ffp_cuda_add_columns(partial, blocks, dgain, dim, NULL, 0);
}
