// The vectors that the CPU level being compiled works with, and what gcc's and clang's vector extension has
// no operators for: in kernels' folders only, since they alone are compiled for more than one level.
#ifndef FFP_BASE_VECTOR_H
#define FFP_BASE_VECTOR_H

#include <math.h>
#include <stdint.h>
#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#if defined(__AVX512F__)
enum { FFP_VECTOR_BYTES = 64 };
#elif defined(__AVX2__)
enum { FFP_VECTOR_BYTES = 32 };
#else
enum { FFP_VECTOR_BYTES = 16 };
#endif

typedef float FfpFloats __attribute__((vector_size(FFP_VECTOR_BYTES)));
typedef int32_t FfpFloatsWhere __attribute__((vector_size(FFP_VECTOR_BYTES))); // lanes of all or no bits

// ffp_floats_min: a < b ? a : b, ffp_floats_max: a > b ? a : b; where one is not a number, b.
// ffp_floats_sqrt: of every lane. ffp_floats_bits: bit l is set where lane l is so.
#if defined(__AVX512F__)
static inline FfpFloats ffp_floats_min(FfpFloats a, FfpFloats b) {
    return (FfpFloats)_mm512_min_ps((__m512)a, (__m512)b);
}
static inline FfpFloats ffp_floats_max(FfpFloats a, FfpFloats b) {
    return (FfpFloats)_mm512_max_ps((__m512)a, (__m512)b);
}
static inline FfpFloats ffp_floats_sqrt(FfpFloats v) {
    return (FfpFloats)_mm512_sqrt_ps((__m512)v);
}
static inline unsigned ffp_floats_bits(FfpFloatsWhere so) {
    return _mm512_movepi32_mask((__m512i)so);
}
#elif defined(__AVX2__)
static inline FfpFloats ffp_floats_min(FfpFloats a, FfpFloats b) {
    return (FfpFloats)_mm256_min_ps((__m256)a, (__m256)b);
}
static inline FfpFloats ffp_floats_max(FfpFloats a, FfpFloats b) {
    return (FfpFloats)_mm256_max_ps((__m256)a, (__m256)b);
}
static inline FfpFloats ffp_floats_sqrt(FfpFloats v) {
    return (FfpFloats)_mm256_sqrt_ps((__m256)v);
}
static inline unsigned ffp_floats_bits(FfpFloatsWhere so) {
    return (unsigned)_mm256_movemask_ps((__m256)so);
}
#elif defined(__ARM_NEON)
static inline FfpFloats ffp_floats_min(FfpFloats a, FfpFloats b) {
    return vbslq_f32(vcltq_f32(a, b), a, b);
}
static inline FfpFloats ffp_floats_max(FfpFloats a, FfpFloats b) {
    return vbslq_f32(vcgtq_f32(a, b), a, b);
}
static inline FfpFloats ffp_floats_sqrt(FfpFloats v) {
    return vsqrtq_f32(v);
}
static inline unsigned ffp_floats_bits(FfpFloatsWhere so) {
    const uint32x4_t bit = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32((uint32x4_t)so, bit));
}
#elif defined(__wasm_simd128__)
static inline FfpFloats ffp_floats_min(FfpFloats a, FfpFloats b) {
    return (FfpFloats)wasm_f32x4_pmin((v128_t)b, (v128_t)a); // b, unless a < b
}
static inline FfpFloats ffp_floats_max(FfpFloats a, FfpFloats b) {
    return (FfpFloats)wasm_f32x4_pmax((v128_t)b, (v128_t)a);
}
static inline FfpFloats ffp_floats_sqrt(FfpFloats v) {
    return (FfpFloats)wasm_f32x4_sqrt((v128_t)v);
}
static inline unsigned ffp_floats_bits(FfpFloatsWhere so) {
    return (unsigned)wasm_i32x4_bitmask((v128_t)so);
}
#else
static inline FfpFloats ffp_floats_min(FfpFloats a, FfpFloats b) {
    const FfpFloatsWhere so = a < b;
    return (FfpFloats)(((FfpFloatsWhere)a & so) | ((FfpFloatsWhere)b & ~so));
}
static inline FfpFloats ffp_floats_max(FfpFloats a, FfpFloats b) {
    const FfpFloatsWhere so = a > b;
    return (FfpFloats)(((FfpFloatsWhere)a & so) | ((FfpFloatsWhere)b & ~so));
}
static inline FfpFloats ffp_floats_sqrt(FfpFloats v) {
    for (int l = 0; l < FFP_VECTOR_BYTES / 4; l++) v[l] = sqrtf(v[l]);
    return v;
}
static inline unsigned ffp_floats_bits(FfpFloatsWhere so) {
    unsigned bits = 0;
    for (int l = 0; l < FFP_VECTOR_BYTES / 4; l++) bits |= (unsigned)(so[l] & 1) << l;
    return bits;
}
#endif

#endif
