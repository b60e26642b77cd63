// This room's functions on a device (core/base/device.h).
#ifndef FFP_IMAGE_TABLE_H
#define FFP_IMAGE_TABLE_H

#include "core/image/image.h"

// See image.h; the data of the images are the device's.
struct FfpImageTable {
    void (*to_srgb)(FfpImage *image);
    void (*to_linear)(FfpImage *image);
};

#endif
