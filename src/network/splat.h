// The heads' formulas: from a pixel's raw numbers to its Gaussian, around what is known of the pixel. Both
// forms forward and backward; no parameters live here.
#ifndef FFP_NETWORK_SPLAT_H
#define FFP_NETWORK_SPLAT_H

#include <stdbool.h>
#include "base/real.h"
#include "match/match.h"

enum { FFP_PLAIN_NUMBERS = 16, FFP_RESIDUAL_NUMBERS = 18 };

// What the formulas start from.
typedef struct FfpPixelBase {
    real direction[3], nearest; // the unit ray and -o.d, the distance to its point nearest to the origin
    real footprint; // world width of a pixel: at the nearest point (plain), at the start's point (residual)
    // Residual form only:
    real t, t_logit; // the start's distance, and where t_net's sigmoid stands for it
    real opacity_logit, frame[4], albedo_logit[3], ambient_logit[3];
} FfpPixelBase;

typedef struct FfpSplat { // one Gaussian, or the gradient with respect to it
    real t, scale[3], rotation[4], opacity, albedo[3], roughness, ambient[3];
} FfpSplat;

// Fills the residual form's fields from pixel `pixel` of the start; direction and nearest must be set.
void ffp_residual_base(FfpPixelBase *base, const FfpStart *start, int64_t pixel);

// raw [16]: t, scale 3, quaternion 4, opacity, albedo 3, roughness, ambient 3
void ffp_plain_splat(FfpSplat *out, const FfpPixelBase *base, const real *raw);
void ffp_plain_splat_backward(real *draw, const FfpSplat *grad, const FfpPixelBase *base, const real *raw);

// raw [18]: correction, gate, t_net, then as above from the scale on. All zero: the classical start.
void ffp_residual_splat(FfpSplat *out, const FfpPixelBase *base, const real *raw);
void ffp_residual_splat_backward(real *draw, const FfpSplat *grad, const FfpPixelBase *base, const real *raw);

#endif
