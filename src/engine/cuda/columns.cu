#include "engine/cuda/columns.h"
#include "engine/cuda/launch.h"
#include "engine/cuda/memory.h"

enum { WIDTH = 32, HEIGHT = 8 }; // of a block of threads: columns, and rows that are summed side by side

float *ffp_cuda_column_partials(size_t count) {
    static void *block;
    static size_t capacity;
    ffp_cuda_grow(&block, &capacity, count * sizeof(float));
    return (float *)block;
}

// One block for WIDTH columns and the rows from `first` to `end`: its sum comes out in the threads of the
// block's first row.
static __device__ float sum_rows(const float *x, int first, int end, int column, int dim) {
    __shared__ float sums[HEIGHT][WIDTH];
    float sum = 0;
    if (column < dim)
        for (int row = first + (int)threadIdx.y; row < end; row += HEIGHT)
            sum += x[(size_t)row * dim + column];
    sums[threadIdx.y][threadIdx.x] = sum;
    __syncthreads();
    for (int i = 1; i < HEIGHT; i++) sum += sums[i][threadIdx.x];
    return sum;
}

static __global__ void sum_of_block(float *partial, const float *x, int rows, int dim, int rows_a_block) {
    const int column = (int)(blockIdx.x * WIDTH + threadIdx.x), first = (int)blockIdx.y * rows_a_block;
    const int end = min(first + rows_a_block, rows);
    const float sum = sum_rows(x, first, end, column, dim);
    if (threadIdx.y == 0 && column < dim) partial[(size_t)blockIdx.y * dim + column] = sum;
}

static __global__ void sum_of_partials(float *sum1, int dim1, float *sum2, const float *partial, int count,
                                       int dim) {
    const int column = (int)(blockIdx.x * WIDTH + threadIdx.x);
    const float sum = sum_rows(partial, 0, count, column, dim);
    if (threadIdx.y != 0 || column >= dim) return;
    if (column < dim1)
        sum1[column] += sum;
    else
        sum2[column - dim1] += sum;
}

void ffp_cuda_add_columns(const float *partial, int count, float *sum1, int dim1, float *sum2, int dim2) {
    const int dim = dim1 + dim2;
    ffp_launch_blocks(sum_of_partials, dim3(ffp_blocks((size_t)dim, WIDTH)), dim3(WIDTH, HEIGHT), 0, sum1,
                      dim1, sum2, partial, count, dim);
}

void ffp_cuda_add_column_sums(float *sum, const float *x, int rows, int dim) {
    enum { LEAST = 4 * HEIGHT, BLOCKS = 128 };
    const int rows_a_block = max((int)LEAST, (rows + BLOCKS - 1) / BLOCKS);
    const int blocks = (int)ffp_blocks((size_t)rows, (unsigned)rows_a_block);
    float *partial = ffp_cuda_column_partials((size_t)blocks * dim);
    ffp_launch_blocks(sum_of_block, dim3(ffp_blocks((size_t)dim, WIDTH), (unsigned)blocks),
                      dim3(WIDTH, HEIGHT), 0, partial, x, rows, dim, rows_a_block);
    ffp_cuda_add_columns(partial, blocks, sum, dim, NULL, 0);
}
