// Products of 64 x 64 tiles in shared memory, in fp32, by a block of 256 threads as 16 rows of 16. Each
// thread has 4 x 4 numbers of the product. A tile lies in lines of FFP_TILE_LD numbers, which spreads what
// threads read side by side over the banks.
//
// Which lines of the product a thread has: of rows those from 4 * ffp_tile_row() on; of columns either those
// from 4 * ffp_tile_column() on ("together") or every 16th from ffp_tile_column() on ("apart"). Loads are 16
// bytes wide wherever the operand's layout lets them.
#ifndef FFP_CUDA_TENSOR_TILE_H
#define FFP_CUDA_TENSOR_TILE_H

#include "engine/cuda/launch.h"

enum {
    FFP_TILE_SIDE = 64,
    FFP_TILE_LD = 68,
    FFP_TILE_SIZE = FFP_TILE_SIDE * FFP_TILE_LD,
    FFP_TILE_THREADS = 256
};

// How an operand lies in its tile.
typedef enum FfpTileRows {
    FFP_ROWS_K_INSIDE, // a[row][k]
    FFP_ROWS_K_OUTSIDE // a[k][row]
} FfpTileRows;
typedef enum FfpTileColumns {
    FFP_STRIDED_K_INSIDE,    // b[column][k]
    FFP_STRIDED_K_OUTSIDE,   // b[k][column]
    FFP_CONTIGUOUS_K_OUTSIDE // b[k][column]
} FfpTileColumns;

static __device__ inline int ffp_tile_row(void) {
    return (int)threadIdx.x / 16;
}
static __device__ inline int ffp_tile_column(void) {
    return (int)threadIdx.x % 16;
}

static __device__ inline void ffp_tile_four(float to[4], const float *from) {
    const float4 v = *(const float4 *)from;
    to[0] = v.x, to[1] = v.y, to[2] = v.z, to[3] = v.w;
}

// sum += A B over k = 0..63
template <FfpTileRows ROWS, FfpTileColumns COLUMNS>
static __device__ inline void ffp_tile_multiply(float sum[4][4], const float *a, const float *b) {
    const int row = 4 * ffp_tile_row(), column = ffp_tile_column();
#pragma unroll 2
    for (int k = 0; k < FFP_TILE_SIDE; k += 4) {
        float x[4][4], y[4][4]; // [k][line] where k is outside, otherwise [line][k]
#pragma unroll
        for (int i = 0; i < 4; i++) {
            ffp_tile_four(x[i], a + (ROWS == FFP_ROWS_K_INSIDE ? (row + i) * FFP_TILE_LD + k
                                                               : (k + i) * FFP_TILE_LD + row));
            if (COLUMNS == FFP_STRIDED_K_INSIDE)
                ffp_tile_four(y[i], b + (column + 16 * i) * FFP_TILE_LD + k);
            else if (COLUMNS == FFP_CONTIGUOUS_K_OUTSIDE)
                ffp_tile_four(y[i], b + (k + i) * FFP_TILE_LD + 4 * column);
            else
                for (int j = 0; j < 4; j++) y[i][j] = b[(k + i) * FFP_TILE_LD + column + 16 * j];
        }
#pragma unroll
        for (int d = 0; d < 4; d++)
#pragma unroll
            for (int i = 0; i < 4; i++)
#pragma unroll
                for (int j = 0; j < 4; j++)
                    sum[i][j] += (ROWS == FFP_ROWS_K_INSIDE ? x[i][d] : x[d][i]) *
                                 (COLUMNS == FFP_STRIDED_K_INSIDE ? y[j][d] : y[d][j]);
    }
}

// Fills a tile from rows x columns numbers of a matrix with row stride ld; zeros beyond them. `weight`, if
// not NULL, multiplies the rows.
static __device__ inline void ffp_tile_load(float *tile, const float *from, size_t ld, int rows, int columns,
                                            const float *weight) {
    const int column = (int)threadIdx.x % FFP_TILE_SIDE;
#pragma unroll 8
    for (int row = (int)threadIdx.x / FFP_TILE_SIDE; row < FFP_TILE_SIDE;
         row += FFP_TILE_THREADS / FFP_TILE_SIDE) {
        const float x = row < rows && column < columns ? from[(size_t)row * ld + column] : 0;
        tile[row * FFP_TILE_LD + column] = weight ? weight[row] * x : x;
    }
}

// Writes four numbers of a row, of which `count` exist.
static __device__ inline void ffp_tile_store_four(float *to, const float from[4], int count) {
    if (count >= 4 && (uintptr_t)to % 16 == 0) {
        *(float4 *)to = make_float4(from[0], from[1], from[2], from[3]);
        return;
    }
    for (int j = 0; j < 4; j++)
        if (j < count) to[j] = from[j];
}

// total[row] of the product's rows, from each thread's sums of its own four; good after the next barrier.
static __device__ inline void ffp_tile_row_sums(float *total, const float sum[4]) {
    for (int i = 0; i < 4; i++) {
        float x = sum[i];
        for (int other = 8; other > 0; other /= 2) x += __shfl_xor_sync(0xffffffffu, x, other);
        if (ffp_tile_column() == 0) total[4 * ffp_tile_row() + i] = x;
    }
}

// partial[warp][column] of the product's columns that are apart, [8][FFP_TILE_SIDE]; good after the next
// barrier.
static __device__ inline void ffp_tile_column_sums(float *partial, const float sum[4]) {
    for (int j = 0; j < 4; j++) {
        const float x = sum[j] + __shfl_xor_sync(0xffffffffu, sum[j], 16);
        if (threadIdx.x % 32 < 16)
            partial[(int)threadIdx.x / 32 * FFP_TILE_SIDE + ffp_tile_column() + 16 * j] = x;
    }
}

#endif
