// A list of named images that a call gives out (FfpImages of the public header).
#ifndef FFP_API_IMAGES_H
#define FFP_API_IMAGES_H

#include "ffprocams.h"
#include "image/image.h"

FfpImages *ffp_images_new(void);
// Takes the image over. The name is "<what>" or "<what>_<view>" where view is not NULL.
void ffp_images_add(FfpImages *images, FfpImage image, const char *what, const char *view);

#endif
