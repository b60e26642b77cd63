// Summed areas of a pattern (core/image/lookup.h), in double: sums along the rows, a warp a row, then down
// the columns, a thread a number.
#include "engine/cuda/launch.h"
#include "engine/cuda/refine.h"
extern "C" {
#include "core/base/device.h"
}

enum { ROWS = 4 }; // of a block

// This lane's value and those of all lanes before it.
static __device__ double scan(double x, unsigned lane) {
    for (int by = 1; by < FFP_WARP; by *= 2) {
        const double before = __shfl_up_sync(0xffffffffu, x, by);
        if (lane >= (unsigned)by) x += before;
    }
    return x;
}

// image [height,width,3] to sum [height+1,width+1,FFP_SUMMED_CHANNELS], of which three are written; the first
// row and column stay.
static __global__ void row_kernel(const real *image, int width, int height, double *sum) {
    const unsigned lane = threadIdx.x;
    const int y = (int)(blockIdx.x * ROWS + threadIdx.y);
    if (y >= height) return;
    const real *from = image + (size_t)y * (size_t)width * 3;
    double *to = sum + ((size_t)(y + 1) * ((size_t)width + 1) + 1) * FFP_SUMMED_CHANNELS,
           before[3] = {0, 0, 0};
    for (int first = 0; first < width; first += FFP_WARP) {
        const int x = first + (int)lane;
        for (int c = 0; c < 3; c++) {
            const double run = before[c] + scan(x < width ? (double)from[3 * x + c] : 0, lane);
            if (x < width) to[FFP_SUMMED_CHANNELS * x + c] = run;
            before[c] = __shfl_sync(0xffffffffu, run, FFP_WARP - 1);
        }
    }
}

static __global__ void column_kernel(size_t stride, int height, double *sum) {
    const size_t i = ffp_thread();
    if (i >= stride) return;
    double run = 0;
#pragma unroll 8
    for (int y = 1; y <= height; y++) {
        run += sum[(size_t)y * stride + i];
        sum[(size_t)y * stride + i] = run;
    }
}

FfpSummed ffp_cuda_summed_new(const FfpImage *rgb) {
    const size_t stride = ((size_t)rgb->width + 1) * FFP_SUMMED_CHANNELS;
    FfpSummed summed = {};
    summed.width = rgb->width;
    summed.height = rgb->height;
    summed.sum = (double *)ffp_memory_new(stride * ((size_t)rgb->height + 1), sizeof(double));
    ffp_launch_blocks(row_kernel, dim3(ffp_blocks((size_t)rgb->height, ROWS)), dim3(FFP_WARP, ROWS), 0,
                      (const real *)rgb->data, rgb->width, rgb->height, summed.sum);
    ffp_launch(column_kernel, dim3(ffp_blocks(stride, 64)), dim3(64), stride, rgb->height, summed.sum);
    return summed;
}
