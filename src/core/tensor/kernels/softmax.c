#include "core/tensor/kernels/softmax.h"
#include <string.h>
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/narrow.h"

#if defined(FFP_BF16) && defined(__AVX512BF16__)
#include <immintrin.h>

// ffp_exp2_short of 16 numbers.
static inline __m512 exp2_lanes(__m512 x) {
    const __m512 magic = _mm512_set1_ps(12582912.0F);
    x = _mm512_max_ps(_mm512_set1_ps(-125.0F), x);
    const __m512 shifted = _mm512_add_ps(x, magic), r = _mm512_sub_ps(x, _mm512_sub_ps(shifted, magic));
    __m512 p = _mm512_fmadd_ps(_mm512_set1_ps(0.0551716691F), r, _mm512_set1_ps(0.242611122F));
    p = _mm512_fmadd_ps(p, r, _mm512_set1_ps(0.693260985F));
    p = _mm512_fmadd_ps(p, r, _mm512_set1_ps(0.999928074F));
    return (__m512)_mm512_add_epi32((__m512i)p, _mm512_slli_epi32((__m512i)shifted, 23));
}

static inline __mmask16 first_lanes(int count) {
    return (__mmask16)(count >= 16 ? 0xFFFF : count <= 0 ? 0 : (1 << count) - 1);
}

static inline __m512 weigh_lanes(const real *scores, __m512 top, __mmask16 lanes) {
    return _mm512_maskz_mov_ps(lanes, exp2_lanes(_mm512_sub_ps(_mm512_maskz_loadu_ps(lanes, scores), top)));
}

real FFP_K(softmax_row)(FfpPacked *weights, const real *scores, real top, int count) {
    const __m512 tops = _mm512_set1_ps(top);
    __m512 low_sum = _mm512_setzero_ps(), high_sum = _mm512_setzero_ps();
    for (int j = 0; j < count; j += FFP_PACK_DEPTH) {
        const __m512 low = weigh_lanes(scores + j, tops, first_lanes(count - j));
        const __m512 high = weigh_lanes(scores + j + 16, tops, first_lanes(count - j - 16));
        low_sum = _mm512_add_ps(low_sum, low);
        high_sum = _mm512_add_ps(high_sum, high);
        _mm512_storeu_si512(weights + j, (__m512i)_mm512_cvtne2ps_pbh(high, low));
    }
    return _mm512_reduce_add_ps(_mm512_add_ps(low_sum, high_sum));
}

// Two rows' 16 numbers, side by side, to where each row lies.
static inline void store_rows(FfpPacked *even, FfpPacked *odd, __m512i pair) {
    _mm256_storeu_si256((__m256i *)even, _mm512_castsi512_si256(pair));
    _mm256_storeu_si256((__m256i *)odd, _mm512_extracti64x4_epi64(pair, 1));
}

// Rows i and i + 1, of which `rows` exist.
static void gradient_rows(const FfpSoftmaxBlock *block, int i, int rows) {
    const __m512i interleave = _mm512_set_epi16(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8,
                                                23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
    const size_t depth = ffp_packed_depth(block->queries);
    const real *scores = block->scores + (size_t)i * block->stride;
    const real *dscores = block->dscores + (size_t)i * block->stride;
    FfpPacked *weights = block->weights + (size_t)i * depth, *dweights = block->dweights + (size_t)i * depth;
    for (int j = 0; j < (int)depth; j += FFP_PACK_LINES) {
        const __mmask16 even = first_lanes(block->queries - j), odd = rows > 1 ? even : 0;
        const __m512 base = _mm512_maskz_loadu_ps(even, block->base + j);
        const __m512 delta = _mm512_maskz_loadu_ps(even, block->delta + j);
        const __m512 p = weigh_lanes(scores + j, base, even);
        const __m512 q = weigh_lanes(scores + block->stride + j, base, odd);
        const __m512 dp = _mm512_maskz_loadu_ps(even, dscores + j);
        const __m512 dq = _mm512_maskz_loadu_ps(odd, dscores + block->stride + j);
        const __m512i ds = (__m512i)_mm512_cvtne2ps_pbh(_mm512_mul_ps(q, _mm512_sub_ps(dq, delta)),
                                                        _mm512_mul_ps(p, _mm512_sub_ps(dp, delta)));
        store_rows(weights + j, weights + depth + j, (__m512i)_mm512_cvtne2ps_pbh(q, p));
        store_rows(dweights + j, dweights + depth + j, ds);
        if (j < block->queries)
            _mm512_storeu_si512(block->columns + (size_t)j * block->columns_depth +
                                    (size_t)i * FFP_PACK_LINES,
                                _mm512_permutexvar_epi16(interleave, ds));
    }
}

void FFP_K(softmax_gradients)(const FfpSoftmaxBlock *block) {
    const int end = (block->keys + 1) / 2 * 2;
    for (int i = 0; i < block->keys; i += 2) gradient_rows(block, i, block->keys - i);
    for (int j = 0; j < block->queries; j += FFP_PACK_LINES)
        memset(block->columns + (size_t)j * block->columns_depth + (size_t)end * FFP_PACK_LINES, 0,
               (ffp_packed_depth(block->keys) - (size_t)end) * FFP_PACK_LINES * sizeof(FfpPacked));
}

#else

real FFP_K(softmax_row)(FfpPacked *weights, const real *scores, real top, int count) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int j = 0; j < count; j++) {
        const real weight = ffp_exp2_packed(scores[j] - top);
        weights[j] = ffp_narrow(weight);
        sum += weight;
    }
    for (size_t j = (size_t)count; j < ffp_packed_depth(count); j++) weights[j] = 0;
    return sum;
}

// Rows i and on of dS^T, one group of k, into the columns. Rows from `keys` on are zero.
static void spread_rows(const FfpSoftmaxBlock *block, int i) {
    const size_t depth = ffp_packed_depth(block->queries);
    const FfpPacked *rows = block->dweights + (size_t)i * depth;
    for (int column = 0; column < block->queries; column += FFP_PACK_LINES) {
        FfpPacked *out = block->columns + (size_t)column * block->columns_depth + (size_t)i * FFP_PACK_LINES;
        for (int j = 0; j < FFP_PACK_LINES; j++)
            for (int g = 0; g < FFP_PACK_GROUP; g++)
                out[j * FFP_PACK_GROUP + g] =
                    i + g < block->keys ? rows[(size_t)g * depth + (size_t)(column + j)] : 0;
    }
}

void FFP_K(softmax_gradients)(const FfpSoftmaxBlock *block) {
    const size_t depth = ffp_packed_depth(block->queries);
    for (int i = 0; i < block->keys; i++) {
        const real *scores = block->scores + (size_t)i * block->stride;
        const real *dscores = block->dscores + (size_t)i * block->stride;
        FfpPacked *weights = block->weights + (size_t)i * depth;
        FfpPacked *dweights = block->dweights + (size_t)i * depth;
#pragma omp simd
        for (int j = 0; j < block->queries; j++) {
            const real weight = ffp_exp2_packed(scores[j] - block->base[j]);
            weights[j] = ffp_narrow(weight);
            dweights[j] = ffp_narrow(weight * (dscores[j] - block->delta[j]));
        }
        for (size_t j = (size_t)block->queries; j < depth; j++) weights[j] = dweights[j] = 0;
    }
    for (int i = 0; i < (int)ffp_packed_depth(block->keys); i += FFP_PACK_GROUP) spread_rows(block, i);
}

#endif
