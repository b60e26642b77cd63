// A device with its lens.
#ifndef FFP_CAPTURE_OPTICS_H
#define FFP_CAPTURE_OPTICS_H

#include "core/base/error.h"
#include "core/base/lens.h"

// One device's optics. A ray (x, y, 1) in its frame meets pixel (cx + fx x', cy + fy y'), where x', y' are x,
// y moved by the lens (ffp_lens_distort).
typedef struct FfpOptics {
    int width, height;     // pixels at which it was calibrated; 0: the files do not say
    double fx, fy, cx, cy; // pixels, centres at integer + 0.5
    double lens[5];        // k1 k2 p1 p2 k3 of OpenCV's Brown-Conrady model; all 0: none
} FfpOptics;

// Refuses a lens that folds the picture over itself anywhere inside it (because its coefficients were fitted
// to the centre only, or are wrong).
bool ffp_optics_check(const FfpOptics *optics, const char *what, FfpError *err);

#endif
