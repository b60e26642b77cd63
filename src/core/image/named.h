// A list of named images that a call returns.
#ifndef FFP_IMAGE_NAMED_H
#define FFP_IMAGE_NAMED_H

#include "core/image/image.h"

typedef struct FfpImageEntry {
    char name[128];
    FfpImage image;
    struct FfpImageEntry *next;
} FfpImageEntry;

typedef struct FfpImages {
    int count;
    FfpImageEntry *first, *last;
} FfpImages;

FfpImages *ffp_images_new(void);
void ffp_images_free(FfpImages *images); // NULL is allowed
// Takes ownership of the image. The name is "<what>" or "<what>_<view>" where view is not NULL.
void ffp_images_add(FfpImages *images, FfpImage image, const char *what, const char *view);

#endif
