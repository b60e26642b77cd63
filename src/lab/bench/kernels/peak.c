#include "lab/bench/kernels/peak.h"

#if defined(__AVX512BF16__) || defined(__AMX_BF16__)
#include <immintrin.h>
#elif defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
#include <arm_neon.h>
#endif

// As many independent sums as hide the latency and still fit the registers.
#if defined(__AVX512F__)
enum { LANES = 16, SUMS = 20 };
#elif defined(__AVX2__)
enum { LANES = 8, SUMS = 12 };
#elif defined(__aarch64__)
enum { LANES = 4, SUMS = 24 };
#else
enum { LANES = 4, SUMS = 12 };
#endif
typedef float Lanes __attribute__((vector_size(LANES * sizeof(float))));

static double fma_loop(int rounds, float *sink) {
    Lanes sum[SUMS], factor, term;
    for (int l = 0; l < LANES; l++) {
        factor[l] = 0.999F + 1e-6F * (float)l;
        term[l] = 1e-3F * *sink;
    }
    for (int i = 0; i < SUMS; i++) sum[i] = term * (float)i;
    for (int round = 0; round < rounds; round++)
#pragma GCC unroll 32
        for (int i = 0; i < SUMS; i++) sum[i] = sum[i] * factor + term;
    for (int i = 1; i < SUMS; i++) sum[0] += sum[i];
    *sink = sum[0][0];
    return 2.0 * LANES * SUMS * rounds;
}

#if defined(__AMX_BF16__) && defined(__AMX_TILE__)
// Four tiles of sums, each 16 x 16 += (16 x 32) (32 x 16).
static double product_loop(int rounds, float *sink) {
    struct {
        unsigned char palette, start, reserved[14];
        unsigned short row_bytes[16];
        unsigned char rows[16];
    } config = {.palette = 1};
    for (int i = 0; i < 8; i++) {
        config.row_bytes[i] = 64;
        config.rows[i] = 16;
    }
    _tile_loadconfig(&config);
    _tile_zero(0);
    _tile_zero(1);
    _tile_zero(2);
    _tile_zero(3);
    _tile_zero(4);
    _tile_zero(5);
    _tile_zero(6);
    _tile_zero(7);
    for (int round = 0; round < rounds; round++) {
        _tile_dpbf16ps(0, 4, 6);
        _tile_dpbf16ps(1, 4, 7);
        _tile_dpbf16ps(2, 5, 6);
        _tile_dpbf16ps(3, 5, 7);
    }
    float out[256];
    _tile_stored(0, out, 64);
    _tile_release();
    *sink += out[0];
    return 4.0 * 2 * 16 * 16 * 32 * rounds;
}
#elif defined(__AVX512BF16__)
static double product_loop(int rounds, float *sink) {
    __m512 sum[SUMS];
    const __m512 start = _mm512_set1_ps(*sink);
    const __m512bh a = _mm512_cvtne2ps_pbh(start, start), b = _mm512_cvtne2ps_pbh(start, start);
    for (int i = 0; i < SUMS; i++) sum[i] = _mm512_set1_ps((float)i);
    for (int round = 0; round < rounds; round++)
#pragma GCC unroll 32
        for (int i = 0; i < SUMS; i++) sum[i] = _mm512_dpbf16_ps(sum[i], a, b);
    for (int i = 1; i < SUMS; i++) sum[0] = _mm512_add_ps(sum[0], sum[i]);
    *sink = _mm512_reduce_add_ps(sum[0]);
    return 4.0 * 16 * SUMS * rounds;
}
#elif defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
static double product_loop(int rounds, float *sink) {
    float32x4_t sum[SUMS];
    const bfloat16x8_t a = vcvtq_low_bf16_f32(vdupq_n_f32(*sink));
    for (int i = 0; i < SUMS; i++) sum[i] = vdupq_n_f32((float)i);
    for (int round = 0; round < rounds; round++)
#pragma GCC unroll 32
        for (int i = 0; i < SUMS; i++) sum[i] = vbfdotq_f32(sum[i], a, a);
    for (int i = 1; i < SUMS; i++) sum[0] = vaddq_f32(sum[0], sum[i]);
    *sink = vaddvq_f32(sum[0]);
    return 4.0 * LANES * SUMS * rounds;
}
#else
static double product_loop(int rounds, float *sink) {
    return fma_loop(rounds, sink);
}
#endif

const FfpPeakKernels FFP_K(peaks) = {fma_loop, product_loop};
