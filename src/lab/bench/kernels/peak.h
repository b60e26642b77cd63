// Loops that do nothing but multiply and add, from registers: one CPU level's peaks.
#ifndef FFP_BENCH_KERNELS_PEAK_H
#define FFP_BENCH_KERNELS_PEAK_H

#include "core/base/level.h"

typedef struct FfpPeakKernels {
    double (*fma)(int rounds, float *sink);      // fp32 multiply-adds
    double (*products)(int rounds, float *sink); // what the level's products are made of
} FfpPeakKernels;                                // each returns the operations done by the calling thread

extern const FfpPeakKernels ffp_portable_peaks, ffp_avx2_peaks, ffp_avx512_peaks, ffp_avx512bf16_peaks,
    ffp_amx_peaks;

#endif
