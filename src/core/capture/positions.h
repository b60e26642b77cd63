// Positions in the projector as a picture of 16 bits, which every program reads.
#ifndef FFP_CAPTURE_POSITIONS_H
#define FFP_CAPTURE_POSITIONS_H

#include "core/image/image.h"

// The map [h,w,3] of a view's correspondence (capture.h), in a projector of width x height pixels, as values
// in [0,1] for a PNG: each position runs from a quarter of the side before the first pixel to a quarter after
// the last, and the confidence is as it is. Positions further outside become unknown, 0 0 0.
FfpImage ffp_positions_encoded(const FfpImage *map, int width, int height);
// The way back, from the picture as ffp_image_read has it [h,w,4]. Exact to 1.5 / 131070 of a side.
FfpImage ffp_positions_decoded(const FfpImage *picture, int width, int height);

#endif
