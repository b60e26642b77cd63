// The table of one CPU level.
#include "engine/match/kernels/kernels.h"

const FfpMatchKernels FFP_K(match) = {
    .fit_planes = FFP_K(fit_planes),
    .refine_pixel = FFP_K(refine_pixel),
    .semi_global = FFP_K(semi_global),
    .stereo_plane = FFP_K(stereo_plane),
};
