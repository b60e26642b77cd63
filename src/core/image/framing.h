// Pictures into frames of another shape.
#ifndef FFP_IMAGE_FRAMING_H
#define FFP_IMAGE_FRAMING_H

#include "core/image/image.h"
#include "ffprocams.h" // FfpFraming: a type, as in engine/pipeline

bool ffp_framing_check(FfpFraming framing, FfpError *err);
// A picture in a frame of width x height, centred; where it does not reach, all channels are 0. Shapes (width
// over height) that differ by at most 1 % are taken as the same, and then every way but FFP_FRAMING_PIXEL
// only changes the size (ffp_image_resize).
FfpImage ffp_image_framed(const FfpImage *image, int width, int height, FfpFraming framing);
// Checks by its header alone that a picture is worth reading for a frame of width x height: it has at most
// four times the frame's pixels, or FFP_FRAMED_PIXELS_MAX. A small file may unpack to
// a large picture: 16000 x 16000 pixels fit into 250 kB, and take 7 GB to read.
#define FFP_FRAMED_PIXELS_MAX (8192LL * 8192)
bool ffp_framed_check(const char *path, int width, int height, FfpError *err);
// Notes in the log what that does to a picture of this size: nothing is noted where nothing changes.
void ffp_framing_note(const char *name, const FfpImage *image, int width, int height, FfpFraming framing);

#endif
