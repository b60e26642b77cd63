// Patterns that make cameras see their targets, and how near they come.
#ifndef FFP_APPLY_SOLVE_H
#define FFP_APPLY_SOLVE_H

#include "engine/apply/stage.h"

// What light allows, over the pixels that matter (weight above one half). Shares of them in [0,1]. A pixel is
// unlit when white light on all projections changes no channel by two steps of 255; of the others, too dark
// (bright) means that a channel of the target lies more than one such step below (above) what can be reached.
typedef struct FfpGamut {
    int pixels;
    double unlit, too_dark, too_bright;
} FfpGamut;
FfpGamut ffp_stage_gamut(const FfpStage *stage);

// The factor of the linear targets that brings them nearest to what light allows: the brightest of those from
// 2^-6 to 2^6 whose encoded distance from it, root mean square over the lit pixels, is the least but for a
// step of 255. 1 when nothing is lit or the targets are black.
real ffp_stage_brightest(const FfpStage *stage);

// The mean over the cameras of the PSNR in dB between encoded picture and target, over the lit pixels that
// matter; NAN when there are none.
double ffp_stage_psnr(const FfpStage *stage);

// Pixels of a camera that matter and that some projection lights: 1, else 0.
FfpImage ffp_stage_lit(const FfpStage *stage, int camera_view);

// Patterns in closed form. A camera pixel wants the level (target - ambient) / sum of feather * response; a
// projector pixel shows its feather times the mean level of the camera positions that look at it (by the
// inverse correspondence, weighted by weight and cosine), clipped to [0,1]. Places that no camera asks about
// stay dark, but for a margin of a footprint around those that are.
void ffp_stage_closed_form(FfpStage *stage);

// Improves the patterns by `steps` steps of Adam (Kingma and Ba 2015) on the weighted squared difference of
// encoded pictures and targets, each step clipped to [0,1]. Repeats bit for bit.
void ffp_stage_descend(FfpStage *stage, int steps);

// The loss that is descended, and its gradients [n_projections] (projector's size, 3; added to), which may be
// NULL.
double ffp_stage_loss(const FfpStage *stage, FfpImage *gradients);

// Patterns as they go through an 8-bit sRGB file.
void ffp_stage_quantise(FfpStage *stage);

#endif
