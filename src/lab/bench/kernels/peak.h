// Loops that do nothing but multiply and add, from registers: one CPU level's peaks.
#ifndef FFP_BENCH_KERNELS_PEAK_H
#define FFP_BENCH_KERNELS_PEAK_H

#include "core/base/level.h"

typedef struct FfpPeakKernels {
    double (*fma)(int rounds, float *sink);      // fp32 multiply-adds
    double (*products)(int rounds, float *sink); // what the level's products are made of
} FfpPeakKernels;                                // each returns the operations done by the calling thread

#define FFP_DECLARE_PEAKS(NAME, name, ...) extern const FfpPeakKernels ffp_##name##_peaks;
FFP_EACH_LEVEL(FFP_DECLARE_PEAKS, )

#endif
