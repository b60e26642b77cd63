// Common parts of attention's two passes. Scores live in registers alone (Dao et al. 2022): a block has a
// tile of rows of one operand, its warps 16 each, and walks along the other operand's tiles in shared memory.
// Scores are to base 2: q carries log2(e) / sqrt(head_dim), so that the softmax weight is 2^score.
#ifndef FFP_CUDA_ATTENTION_H
#define FFP_CUDA_ATTENTION_H

#include "engine/cuda/bf16.h"
#include "engine/cuda/launch.h"
#include "engine/cuda/tensor_core.h"
extern "C" {
#include "engine/cuda/tensor.h"
}

#define FFP_ATTENTION_LN_2 0.69314718055994530942f
#define FFP_ATTENTION_LOG2_E 1.44269504088896340736f
enum {
    FFP_ATTENTION_DIM_MAX = 128, // of a head
    FFP_ATTENTION_EACH = FFP_ATTENTION_DIM_MAX / FFP_WARP,
    FFP_ATTENTION_TILE = 64, // rows
    FFP_ATTENTION_THREADS = FFP_ATTENTION_TILE / 16 * FFP_WARP
};

typedef struct FfpAttentionPlan {
    int rows, heads, dim, width; // width = heads * dim
    int pad;                     // dim, filled up to 64 or 128
    uint16_t *q, *k, *v, *dout;  // [heads, T, pad] bf16: q, k normalised
    float *delta;                // [heads, T]: dout . out
    float *dq, *dk;              // [heads, T, pad]
} FfpAttentionPlan;

// Ends the program with a message when a head is wider than FFP_ATTENTION_DIM_MAX.
FfpAttentionPlan ffp_cuda_attention_plan(const FfpAttentionShape *shape, float *scratch);

// q, k (normalised, with gains), v as bf16; if dout is not NULL, that and delta, too.
void ffp_cuda_attention_prepare(const FfpAttentionPlan *plan, const FfpAttentionInput *in, const float *dout,
                                const float *out);

// A block for each tile of each head.
static inline dim3 ffp_attention_grid(const FfpAttentionPlan *plan) {
    return dim3(ffp_blocks((size_t)plan->rows, FFP_ATTENTION_TILE), (unsigned)plan->heads);
}

// A tile in shared memory; lines are 16 bytes longer than rows, which spreads them over the banks.
template <int PAD> struct alignas(16) FfpAttentionTile { uint16_t row[FFP_ATTENTION_TILE][PAD + 8]; };

// Fills a tile with rows from `first` on of [rows, PAD]; zeros beyond them.
template <int PAD>
static __device__ inline void ffp_attention_fill(FfpAttentionTile<PAD> *tile, const uint16_t *from, int first,
                                                 int rows) {
    const int columns = PAD / 8;
    for (int i = (int)threadIdx.x; i < FFP_ATTENTION_TILE * columns; i += FFP_ATTENTION_THREADS) {
        const int row = i / columns, column = i % columns * 8;
        const uint16_t *place = from + (size_t)(first + row) * PAD + column;
        *(uint4 *)&tile->row[row][column] = first + row < rows ? *(const uint4 *)place : uint4{0, 0, 0, 0};
    }
}

// The warp's first row in its block's tile, of all rows.
static __device__ inline int ffp_attention_first(void) {
    return (int)blockIdx.x * FFP_ATTENTION_TILE + (int)threadIdx.x / FFP_WARP * 16;
}
// The number in all rows of a lane's half h of its sums, and in a tile of number c of its n-th sums.
static __device__ inline int ffp_attention_row(int h) {
    return ffp_attention_first() + ffp_lane() / 4 + 8 * h;
}
static __device__ inline int ffp_attention_column(int n, int c) {
    return 8 * n + 2 * (ffp_lane() % 4) + c % 2;
}

// The warp's own rows as operands; zeros beyond `rows`.
template <int PAD>
static __device__ inline void ffp_attention_own(uint32_t own[PAD / 16][4], const uint16_t *from, int rows) {
#pragma unroll
    for (int k = 0; k < PAD / 16; k++)
#pragma unroll
        for (int i = 0; i < 4; i++) {
            const int row = ffp_attention_row(i % 2), column = 16 * k + 8 * (i / 2) + 2 * (ffp_lane() % 4);
            own[k][i] = row < rows ? ffp_core_pair(from + (size_t)row * PAD + column) : 0;
        }
}

// scores [16, tile] = own tile^T
template <int PAD>
static __device__ inline void ffp_attention_scores(float scores[FFP_ATTENTION_TILE / 8][4],
                                                   const uint32_t own[PAD / 16][4],
                                                   const FfpAttentionTile<PAD> *tile) {
    const int lane = ffp_lane(), row = lane / 16 * 8 + lane % 8, column = lane / 8 % 2 * 8;
#pragma unroll
    for (int n = 0; n < FFP_ATTENTION_TILE / 8; n += 2) {
#pragma unroll
        for (int i = 0; i < 4; i++) scores[n][i] = scores[n + 1][i] = 0;
#pragma unroll
        for (int k = 0; k < PAD / 16; k++) {
            uint32_t other[4];
            ffp_core_load<false>(other, &tile->row[8 * n + row][16 * k + column]);
            ffp_core_multiply(scores[n], own[k], other);
            ffp_core_multiply(scores[n + 1], own[k], other + 2);
        }
    }
}

// sums [16, PAD] += weights [16, tile], rounded to bf16, times the tile
template <int PAD>
static __device__ inline void ffp_attention_add(float sums[PAD / 8][4],
                                                const float weights[FFP_ATTENTION_TILE / 8][4],
                                                const FfpAttentionTile<PAD> *tile) {
    const int lane = ffp_lane(), row = lane % 16, column = lane / 16 * 8;
#pragma unroll
    for (int k = 0; k < FFP_ATTENTION_TILE / 16; k++) {
        const float *left = weights[2 * k], *right = weights[2 * k + 1];
        const uint32_t own[4] = {ffp_bf16_pair(left[0], left[1]), ffp_bf16_pair(left[2], left[3]),
                                 ffp_bf16_pair(right[0], right[1]), ffp_bf16_pair(right[2], right[3])};
#pragma unroll
        for (int n = 0; n < PAD / 8; n += 2) {
            uint32_t other[4];
            ffp_core_load<true>(other, &tile->row[16 * k + row][8 * n + column]);
            ffp_core_multiply(sums[n], own, other);
            ffp_core_multiply(sums[n + 1], own, other + 2);
        }
    }
}

// Writes the warp's sums, each row times its scale, to rows of `to` that begin `ld` apart.
template <int PAD>
static __device__ inline void ffp_attention_write(float *to, size_t ld, const float sums[PAD / 8][4],
                                                  const float scale[2], const FfpAttentionPlan *plan) {
#pragma unroll
    for (int n = 0; n < PAD / 8; n++)
#pragma unroll
        for (int i = 0; i < 4; i++) {
            const int row = ffp_attention_row(i / 2), column = ffp_attention_column(n, i);
            if (row < plan->rows && column < plan->dim)
                to[(size_t)row * ld + column] = sums[n][i] * scale[i / 2];
        }
}

#endif
