// The processor's abilities, and the choice among the compiled kernel levels.
#ifndef FFP_BASE_CPU_H
#define FFP_BASE_CPU_H

#include "core/base/error.h"
#include "ffprocams/api.h"

// The levels of the processors that this is compiled for, as X(NAME, name, ...), each containing those before
// it. FFP_EACH_LEVEL names those of products, FFP_EACH_BF16_LEVEL those among them that round operands to
// bf16, and FFP_EACH_LOOP_LEVEL those of loops in plain C, which gain nothing from bf16 and tiles.
#define FFP_PORTABLE_LEVEL(X, ...) X(PORTABLE, portable, __VA_ARGS__)
#if defined(__x86_64__)
// AVX2, FMA; AVX-512 F, BW, CD, DQ, VL; products of bf16 pairs (vdpbf16ps); bf16 tile products, granted by
// the operating system
#define FFP_EACH_LOOP_LEVEL(X, ...)                                                                          \
    FFP_PORTABLE_LEVEL(X, __VA_ARGS__) X(AVX2, avx2, __VA_ARGS__) X(AVX512, avx512, __VA_ARGS__)
#define FFP_EACH_BF16_LEVEL(X, ...) X(AVX512BF16, avx512bf16, __VA_ARGS__) X(AMX, amx, __VA_ARGS__)
#elif defined(__aarch64__)
// NEON; products of bf16 (bfmmla)
#define FFP_EACH_LOOP_LEVEL(X, ...) FFP_PORTABLE_LEVEL(X, __VA_ARGS__) X(NEON, neon, __VA_ARGS__)
#define FFP_EACH_BF16_LEVEL(X, ...) X(NEONBF16, neonbf16, __VA_ARGS__)
#elif defined(__wasm__) // a module with vectors runs as a whole or not at all: there is nothing to choose
#define FFP_EACH_LOOP_LEVEL(X, ...) X(SIMD128, simd128, __VA_ARGS__)
#define FFP_EACH_BF16_LEVEL(X, ...)
#else
#define FFP_EACH_LOOP_LEVEL FFP_PORTABLE_LEVEL
#define FFP_EACH_BF16_LEVEL(X, ...)
#endif
#define FFP_EACH_LEVEL(X, ...) FFP_EACH_LOOP_LEVEL(X, __VA_ARGS__) FFP_EACH_BF16_LEVEL(X, __VA_ARGS__)

#define FFP_CPU_ENTRY(NAME, name, ...) FFP_CPU_##NAME,
typedef enum FfpCpuLevel { FFP_EACH_LEVEL(FFP_CPU_ENTRY, ) FFP_CPU_LEVELS } FfpCpuLevel;

const char *ffp_cpu_name(FfpCpuLevel level); // portable, avx2, neon, ...
bool ffp_cpu_bf16(FfpCpuLevel level);        // true if products of this level take operands rounded to bf16
FfpCpuLevel ffp_cpu_best(void);              // the highest level that this processor and kernel can run

// The level in use: the quickest (the best, or avx512 where bf16 without tiles is slower), or the one that
// the environment variable FFPROCAMS_CPU names if it can run here (ffp_cpu_check tells). Decided at the first
// call.
FfpCpuLevel ffp_cpu_level(void);
// Checks that FFPROCAMS_CPU, if set, names a level that this processor can run.
FFP_API bool ffp_cpu_check(FfpError *err); // public too
// For tests and benchmarks: uses another level from now on; false when it cannot run here. Not while
// kernels run.
bool ffp_cpu_set_level(FfpCpuLevel level);

#endif
