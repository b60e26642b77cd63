// Noise in a view's photographs: how much there is, and the photographs without it. Under black, white and a
// pattern the same surface is seen three times; what its nine colour values have in common is the object.
#ifndef FFP_DENOISE_DENOISE_H
#define FFP_DENOISE_DENOISE_H

#include "core/capture/capture.h"

enum { FFP_PHOTOGRAPHS = 3 }; // of a view: black, white, active

// Standard deviation of the noise, linear, of a value between 0 and 1; the same is taken for all values.
// 0 where the views show too little of the object to tell, or where it is below 0.0005: rounding to 8 bits
// makes twice as much.
//
// A Laplacian takes smooth shading away and leaves noise and texture (Immerkaer 1996). Texture is one for all
// photographs of a view, noise is not: of the nine values' covariance the smallest eigenvalue is the noise's
// variance. Values near black count little, since noise cannot go below zero there.
double ffp_noise_estimate(const FfpCapture *capture, const int photographs[FFP_PHOTOGRAPHS]);

// Gives every view a new list of pictures, in which the photographs have the noise of the given deviation
// taken away; all others are those of the old list, and what the object does not cover stays. A view that
// lacks one of the first three photographs keeps its list; a further one that it lacks stays missing. Returns
// the lists, [n_views,n_patterns], for ffp_denoise_free; the old lists are neither changed nor released.
//
// In every window the nine values' mean and covariance are measured, and each pixel keeps of its difference
// from the mean what a Wiener filter leaves of it along the covariance's axes; a pixel's result is the mean
// over the windows that hold it, those that smooth more counting more. At the outline a colour is the
// object's, mixed into black by the coverage.
//
// Of n >= 3 photographs, black and white first, each further one is looked at together with these two.
FfpImage *ffp_denoise(FfpCapture *capture, const int *photographs, int n, double noise);
void ffp_denoise_free(FfpImage *lists, const FfpCapture *capture, const int *photographs, int n);

#endif
