// Means over a pixel's neighbourhood.
#ifndef FFP_RIG_LOCAL_MEAN_H
#define FFP_RIG_LOCAL_MEAN_H

#include "core/image/image.h"

// Gaussian of `sigma` pixels (above 0), cut off at three of them, or at 64 pixels; edges repeated. Any number
// of channels.
FfpImage ffp_local_mean(const FfpImage *image, double sigma);
// The same over those pixels alone where `where` [height*width] is not 0. One more channel than the image
// has: the share of the Gaussian that they are; where it is 0, every channel is 0.
FfpImage ffp_local_mean_where(const FfpImage *image, const unsigned char *where, double sigma);

// Marks [height*width] (0 or 1) grow by `steps` pixels in each of the four directions, or shrink; what lies
// beyond the picture neither takes nor gives.
void ffp_marks_grow(unsigned char *marks, int width, int height, int steps);
void ffp_marks_shrink(unsigned char *marks, int width, int height, int steps);

#endif
