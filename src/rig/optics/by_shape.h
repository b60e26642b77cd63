// Keys of an unknown calibration tool.
#ifndef FFP_RIG_BY_SHAPE_H
#define FFP_RIG_BY_SHAPE_H

#include "core/capture/node.h"

typedef enum FfpKeyShape {
    FFP_SHAPE_MATRIX, // 3 x 3, fx 0 cx, 0 fy cy, 0 0 1
    FFP_SHAPE_LENS,   // a row or column of 4, 5, 8, 12 or 14 numbers
    FFP_SHAPE_SIZE,   // two whole numbers of pixels
    FFP_SHAPES,
    FFP_SHAPE_ROTATION = FFP_SHAPES,
    FFP_SHAPE_TRANSLATION,
    FFP_SHAPE_NONE
} FfpKeyShape;

// The keys of `root` (not copied) by what they hold; NULL: it has none.
typedef struct FfpShapedKeys {
    const char *device[2][FFP_SHAPES]; // of the camera, of the projector
    const char *rotation, *translation;
} FfpShapedKeys;

// False: camera and projector do not both have a camera matrix, or a place has two keys.
bool ffp_keys_by_shape(const FfpNode *root, FfpShapedKeys *keys);

#endif
