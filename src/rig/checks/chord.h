// The part of a pixel's ray that lies within the object's sphere, or in a whole scene within one a quarter
// wider.
#ifndef FFP_RIG_CHORD_H
#define FFP_RIG_CHORD_H

#include "core/capture/capture.h"

typedef struct FfpChord {
    real origin[3], direction[3]; // unit
    real near, far;               // distances along it, world units
} FfpChord;

// Of the ray through the centre of pixel `index`, counted row by row; false when it misses that sphere
// or the camera is inside it.
bool ffp_chord(const FfpCapture *capture, const FfpCamera *camera, size_t index, FfpChord *chord);
// The middle of part k of n equal ones.
void ffp_chord_point(const FfpChord *chord, int k, int n, real point[3]);

#endif
