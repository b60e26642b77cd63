// The projector's light for every pattern, laid out so that one lookup serves them all.
#ifndef FFP_SYNTH_LIGHT_H
#define FFP_SYNTH_LIGHT_H

#include "core/image/image.h"

enum { FFP_COARSE = 8, FFP_SOFT = 4 };

typedef struct FfpLight {
    int width, height, coarse_width, coarse_height;
    int n_patterns, lanes; // lanes: a multiple of 8
    int *lane;             // [n_patterns] which one is a pattern's; -1: it is black
    const FfpImage **sharp;
    FfpImage *soft; // [FFP_SOFT, n_patterns] those of several colours through Gaussians; NULL: none
    bool *even;     // [n_patterns] the first pixel's colour everywhere
    float *coarse;  // [coarse_height, coarse_width, 3, lanes] box means of FFP_COARSE^2 pixels
} FfpLight;

// The patterns, [height, width, 3] linear and all of one size, must live as long as the light.
FfpLight ffp_light_new(const FfpImage *const *patterns, int n_patterns);
// Makes the soft pictures, of deviations 1, 2, 4 and 8 pixels.
void ffp_light_soften(FfpLight *light);
void ffp_light_free(FfpLight *light);

// A bilinear lookup: the first of four pixels, the way to the others in pixels, and their weights.
typedef struct FfpTexel {
    size_t at, right, down;
    float weight[4];
} FfpTexel;

// The lookup at (u, v) in an image of pixels whose centres lie at one half; clamped to the outermost centres.
// False outside the rectangle.
bool ffp_light_texel(int width, int height, float u, float v, FfpTexel *out);
// sum[3, lanes] += colour * the patterns' values at the lookup.
void ffp_light_add(const FfpLight *light, const FfpTexel *texel, const float colour[3], float *sum);
// The same through a Gaussian of `deviation` pixels, 8 at most: of the soft pictures on both sides of it, so
// much of each that the variance is right. They must have been made.
void ffp_light_add_soft(const FfpLight *light, const FfpTexel *texel, float deviation, const float colour[3],
                        float *sum);
// The same of the coarse patterns, for light that has bounced.
void ffp_light_add_coarse(const FfpLight *light, const FfpTexel *texel, const float colour[3], float *sum);

#endif
