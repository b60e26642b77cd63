// The functions of scenes that exist once for each CPU level (core/base/level.h): those of noise.h.
#ifndef FFP_SHAPES_KERNELS_KERNELS_H
#define FFP_SHAPES_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "world/shapes/noise.h"

typedef float FfpNoise(const float p[3], uint32_t seed);
typedef float FfpOctaves(const float p[3], uint32_t seed, int octaves);
typedef FfpCells FfpCellular(const float p[3], uint32_t seed);

typedef struct FfpShapesKernels {
    FfpNoise *noise;
    FfpOctaves *fbm, *ridges;
    FfpCellular *cells;
} FfpShapesKernels;

FFP_LOOP_TABLES(FfpShapesKernels, shapes)

#ifdef FFP_LEVEL
FfpNoise FFP_K(noise);
FfpOctaves FFP_K(fbm), FFP_K(ridges);
FfpCellular FFP_K(cells);
#endif

#endif
