// What the processor can do, and which of the compiled kernel levels is used.
#ifndef FFP_BASE_CPU_H
#define FFP_BASE_CPU_H

#include "core/base/error.h"
#include "ffprocams/api.h"

// Each level contains those before it. On processors other than x86-64 only the first exists.
typedef enum FfpCpuLevel {
    FFP_CPU_PORTABLE,
    FFP_CPU_AVX2,       // AVX2, FMA
    FFP_CPU_AVX512,     // AVX-512 F, BW, CD, DQ, VL
    FFP_CPU_AVX512BF16, // and products of bf16 pairs (vdpbf16ps)
    FFP_CPU_AMX,        // and bf16 tile products, granted by the operating system
    FFP_CPU_LEVELS
} FfpCpuLevel;

const char *ffp_cpu_name(FfpCpuLevel level); // portable, avx2, avx512, avx512bf16, amx
FfpCpuLevel ffp_cpu_best(void);              // the highest level that this processor and kernel can run

// The level in use: the best, or the one that the environment variable FFPROCAMS_CPU names if it can run here
// (ffp_cpu_check tells). Decided at the first call.
FfpCpuLevel ffp_cpu_level(void);
// Whether FFPROCAMS_CPU names a level that this processor can run, or nothing.
FFP_API bool ffp_cpu_check(FfpError *err); // public too
// For tests and benchmarks: uses another level from now on; false when it cannot run here. Not while
// kernels run.
bool ffp_cpu_set_level(FfpCpuLevel level);

#endif
