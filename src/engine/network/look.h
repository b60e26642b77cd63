// Looking again: the input views are drawn with the splats as they are, and each splat is corrected by the
// errors at its place (as in ReSplat, Xu et al. 2025, and G3R, Chen et al. 2024). No gradient passes through
// what was drawn.
#ifndef FFP_NETWORK_LOOK_H
#define FFP_NETWORK_LOOK_H

#include "engine/network/look_formula.h"
#include "engine/network/network.h"
#include "engine/render/pass.h"

// The photographs to compare with, in the memory of the device that the thread works on.
typedef struct FfpLookPhotographs {
    int views, width, height;
    FfpCamera *projector, *camera; // [views] the host's
    FfpCamera *camera_there;       // [views] the device's, or the host's
    int32_t *frame;                // [views,2]
    real *colour;                  // [views,height,width,FFP_LOOK_COLOURS] sRGB-encoded
    real *coverage;                // [views,height,width]
    FfpSummed pattern[2];          // white, active
    real intensity[3];
} FfpLookPhotographs;

// Of the first `views` views under black, white and the active pattern; made on the CPU.
FfpLookPhotographs *ffp_look_photographs_new(const FfpCapture *capture, int views, int active);
FfpLookPhotographs *ffp_look_photographs_uploaded(const FfpLookPhotographs *here); // to the device in use
// By who works on the device they are on; NULL is allowed.
void ffp_look_photographs_free(FfpLookPhotographs *photographs);

// numbers [views,height,width,FFP_LOOK_NUMBERS]: every view is drawn once, under black, white and the
// pattern.
void ffp_look(real *numbers, FfpViewPass *pass, const FfpGaussians *gaussians,
              const FfpLookPhotographs *photographs);

FfpLookMaps ffp_look_maps(const FfpLookPhotographs *photographs, const real *numbers);

// The Gaussians, and the maps in which their errors are looked up.
typedef struct FfpLookInputs {
    FfpLookMaps maps;
    const int64_t *pixel; // [Gaussians] (view * height + y) * width + x
    const real *centre;   // [Gaussians,3]
    const real *raw;      // [Gaussians,numbers]
    int numbers;
} FfpLookInputs;
// out [count, FFP_LOOK_SEEN + numbers] of the Gaussians from `first` on.
void ffp_look_gather(real *out, const FfpLookInputs *looked, int64_t first, int count);

#endif
