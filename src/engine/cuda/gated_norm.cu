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

static __global__ void gated_forward(float *y, float *rstd, FfpGatedNorm in) {
    const int t = (int)(blockIdx.x * WARPS + threadIdx.x / FFP_WARP), dim = in.dim;
    if (t >= in.rows) return;
    const float *x = in.x + (size_t)t * dim, *z = in.z + (size_t)t * in.ldz;
    y += (size_t)t * dim;
    float sum = 0;
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) {
        const float u = gate(x[i], z[i]);
        y[i] = u; // read again by the same lane
        sum += u * u;
    }
    const float scale = 1 / sqrtf(ffp_warp_sum(sum) / (float)dim + EPSILON);
    for (int i = ffp_lane(); i < dim; i += FFP_WARP) y[i] *= scale * in.gain[i];
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
static __global__ void gated_backward(FfpGatedNormGradient grad, float *partial, FfpGatedNorm in,
                                      const float *dy, const float *rstd, int rows_a_block) {
    const int first = (int)blockIdx.x * rows_a_block, end = min(first + rows_a_block, in.rows), dim = in.dim;
    for (int t = first + (int)threadIdx.x / FFP_WARP; t < end; t += WARPS) {
        const size_t row = (size_t)t * dim;
        row_backward(grad.x + row, grad.z + (size_t)t * grad.ldz, dy + row, in.x + row,
                     in.z + (size_t)t * in.ldz, rstd[t], in.gain, dim);
    }
    for (int i = (int)threadIdx.x; i < dim; i += THREADS) {
        float sum = 0;
        for (int t = first; t < end; t++)
            sum += dy[(size_t)t * dim + i] * gate(in.x[(size_t)t * dim + i], in.z[(size_t)t * in.ldz + i]) *
                   rstd[t];
        partial[(size_t)blockIdx.x * dim + i] = sum;
    }
}

void ffp_cuda_gated_norm_forward(float *y, float *rstd, const FfpGatedNorm *in) {
    ffp_launch_blocks(gated_forward, dim3(ffp_blocks((size_t)in->rows, WARPS)), dim3(THREADS), 0, y, rstd,
                      *in);
}

void ffp_cuda_gated_norm_backward(const FfpGatedNormGradient *grad, const FfpGatedNorm *in, const float *dy,
                                  const float *rstd) {
    const int rows_a_block = max((int)ROWS_LEAST, (in->rows + BLOCKS_MOST - 1) / BLOCKS_MOST);
    const int blocks = (int)ffp_blocks((size_t)in->rows, (unsigned)rows_a_block);
    float *partial = ffp_cuda_column_partials((size_t)blocks * in->dim);
    ffp_launch_blocks(gated_backward, dim3((unsigned)blocks), dim3(THREADS), 0, *grad, partial, *in, dy, rstd,
                      rows_a_block);
    ffp_cuda_add_columns(partial, blocks, grad->gain, in->dim, NULL, 0);
}
