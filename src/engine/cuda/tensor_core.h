// A warp's tensor cores: products of bf16 tiles with fp32 sums. Of a tile of sums [16, 8] a lane has the
// numbers (r, c), (r, c + 1), (r + 8, c), (r + 8, c + 1) with r = lane / 4 and c = 2 (lane % 4); operands lie
// in the lanes as the mma instruction wants them.
#ifndef FFP_CUDA_TENSOR_CORE_H
#define FFP_CUDA_TENSOR_CORE_H

#include "engine/cuda/launch.h"
#include "engine/cuda/warp.h"

// Two columns of a row from there on, as an operand's register.
static __device__ inline uint32_t ffp_core_pair(const uint16_t *from) {
    return *(const uint32_t *)from;
}

#ifndef __CUDACC__
static inline float ffp_emulated_half(uint64_t pairs, int half) {
    return __uint_as_float((unsigned)(pairs >> 16 * half) << 16);
}
#endif

// sum += A B^T of A [16, 16] and B [8, 16].
static __device__ inline void ffp_core_multiply(float sum[4], const uint32_t a[4], const uint32_t b[2]) {
#ifdef __CUDACC__
    asm volatile("mma.sync.aligned.m16n8k16.row.col.f32.bf16.bf16.f32 {%0,%1,%2,%3}, {%4,%5,%6,%7}, {%8,%9}, "
                 "{%0,%1,%2,%3};"
                 : "+f"(sum[0]), "+f"(sum[1]), "+f"(sum[2]), "+f"(sum[3])
                 : "r"(a[0]), "r"(a[1]), "r"(a[2]), "r"(a[3]), "r"(b[0]), "r"(b[1]));
#else
    const uint64_t mine[4] = {a[0] | (uint64_t)a[2] << 32, a[1] | (uint64_t)a[3] << 32,
                              b[0] | (uint64_t)b[1] << 32, 0};
    const uint64_t(*all)[4] = ffp_emulated_show(mine);
    const int row = ffp_lane() / 4, column = 2 * (ffp_lane() % 4);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 16; k++) { // a register's four numbers: two from k on, two from k + 8 on
            const int owner = k % 8 / 2, half = k / 8 * 2 + k % 2;
            sum[i] += ffp_emulated_half(all[4 * row + owner][i / 2], half) *
                      ffp_emulated_half(all[4 * (column + i % 2) + owner][2], half);
        }
#endif
}

// Registers of four tiles [8, 8] in shared memory, as operands: lane 8 i + r gives the place of row r of tile
// i, 16 bytes at a multiple of 16. TRANSPOSED: of their transposes.
template <bool TRANSPOSED> static __device__ inline void ffp_core_load(uint32_t to[4], const uint16_t *row) {
#ifdef __CUDACC__
    const unsigned place = (unsigned)__cvta_generic_to_shared(row);
    if (TRANSPOSED)
        asm volatile("ldmatrix.sync.aligned.m8n8.x4.trans.shared.b16 {%0,%1,%2,%3}, [%4];"
                     : "=r"(to[0]), "=r"(to[1]), "=r"(to[2]), "=r"(to[3])
                     : "r"(place)
                     : "memory");
    else
        asm volatile("ldmatrix.sync.aligned.m8n8.x4.shared.b16 {%0,%1,%2,%3}, [%4];"
                     : "=r"(to[0]), "=r"(to[1]), "=r"(to[2]), "=r"(to[3])
                     : "r"(place)
                     : "memory");
#else
    const uint64_t mine[4] = {(uint64_t)(uintptr_t)row, 0, 0, 0};
    const uint64_t(*all)[4] = ffp_emulated_show(mine);
    const int line = ffp_lane() / 4, pair = 2 * (ffp_lane() % 4);
    for (int i = 0; i < 4; i++) {
        const uint16_t *rows[8];
        for (int r = 0; r < 8; r++) rows[r] = (const uint16_t *)(uintptr_t)all[8 * i + r][0];
        to[i] = TRANSPOSED ? rows[pair][line] | (uint32_t)rows[pair + 1][line] << 16
                           : ffp_core_pair(rows[line] + pair);
    }
#endif
}

#endif
