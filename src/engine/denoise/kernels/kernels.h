// The loops of the noise filter that exist once for each CPU level (core/base/level.h).
#ifndef FFP_DENOISE_KERNELS_KERNELS_H
#define FFP_DENOISE_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "core/base/real.h"
#include "engine/denoise/stack.h"

enum { FFP_WINDOW_RADIUS = 3 }; // of a window, in pixels

typedef struct FfpWindow {
    real weight; // 0: unused
    real mean[FFP_VALUES], kept[FFP_VALUES * FFP_VALUES];
} FfpWindow;

typedef struct FfpFilter {
    int width, height, stride, across, down; // of the picture; pixels between windows, and their number
    int first, rows;                         // window rows that are kept
    double variance;                         // of the noise
    const real *stack, *coverage;
    FfpWindow *windows; // [rows,across], centred at multiples of the stride
} FfpFilter;

// Row or column of the first window that holds a pixel.
static inline int ffp_first_window(const FfpFilter *f, int pixel) {
    return pixel < FFP_WINDOW_RADIUS ? 0 : (pixel - FFP_WINDOW_RADIUS + f->stride - 1) / f->stride;
}

// The values of a pixel: the mean over all windows that hold it; where none does, the pixel as it is.
typedef void FfpSmooth(const FfpFilter *f, int x, int y, real values[FFP_VALUES]);

typedef struct FfpDenoiseKernels {
    FfpSmooth *smooth;
} FfpDenoiseKernels;

FFP_LOOP_TABLES(FfpDenoiseKernels, denoise)

#ifdef FFP_LEVEL
FfpSmooth FFP_K(smooth);
#endif

#endif
