// Patterns that make cameras see their targets, and how close the result is.
#ifndef FFP_APPLY_SOLVE_H
#define FFP_APPLY_SOLVE_H

#include "engine/apply/procams.h"

// Targets within reach of the light, as shares in [0,1] of the constrained pixels (weight above one half). A
// pixel is unlit if white light on all projections changes no channel by two steps of 255; of the others, too
// dark (bright) means that a channel of the target is more than one such step below (above) the reachable
// range, which begins where the patterns so far scatter no less light.
typedef struct FfpGamut {
    int pixels;
    double unlit, too_dark, too_bright;
} FfpGamut;
FfpGamut ffp_procams_gamut(const FfpProCams *procams);

// The factor on the linear targets that brings them closest to what light can reach: the largest one from
// 2^-6 to 2^6 whose encoded distance from it, root mean square over the lit pixels, is within a step of 255
// of the least. 1 if nothing is lit or the targets are black.
real ffp_procams_brightest(const FfpProCams *procams);

// The mean over the cameras of the PSNR in dB between encoded picture and target, over the lit constrained
// pixels; NAN if there are none.
double ffp_procams_psnr(const FfpProCams *procams);

// 1 at a camera's constrained pixels that some projection lights, 0 elsewhere.
FfpImage ffp_procams_lit(const FfpProCams *procams, int camera_view);

// Patterns in closed form. A camera pixel requests the level (target - floor) / sum of feather * response;
// its floor is its ambient light and the light that the patterns so far scatter. A projector pixel shows its
// feather times the mean level of the camera positions that see it (by the inverse correspondence, weighted
// by weight and cosine), clipped to [0,1]. Where patterns scatter, spread or blur light, two more rounds
// subtract what those of the round before do. Of positions that no camera constrains, a margin of so many
// footprints around the others goes on with their levels, and so does the rest of what is lit, fading
// (unseen.h).
void ffp_procams_closed_form(FfpProCams *procams, int margin);

// The mean footprint of a lit camera pixel in a projector, in its pixels, rounded up; 1 if nothing is lit.
int ffp_procams_footprint(const FfpProCams *procams, int projection);

// Improves the patterns by `steps` steps of Adam (Kingma and Ba 2015) on the weighted squared difference of
// encoded pictures and targets, each step clipped to [0,1]. The result is reproducible to the bit.
void ffp_procams_descend(FfpProCams *procams, int steps);

// The loss that is descended, and its gradients [n_projections] (projector's size, 3; added to), which may be
// NULL.
double ffp_procams_loss(const FfpProCams *procams, FfpImage *gradients);

// Rounds the patterns as an 8-bit sRGB file does.
void ffp_procams_quantise(FfpProCams *procams);

#endif
