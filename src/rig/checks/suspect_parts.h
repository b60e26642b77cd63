// The parts of suspect.c, each of which fails where it can name a fault.
#ifndef FFP_RIG_SUSPECT_PARTS_H
#define FFP_RIG_SUSPECT_PARTS_H

#include "core/capture/capture.h"

// What happens to photographs.
typedef enum FfpRigMishap {
    FFP_RIG_TURNED_HALF,
    FFP_RIG_TURNED_LEFT,
    FFP_RIG_TURNED_RIGHT,
    FFP_RIG_MIRRORED,
    FFP_RIG_FLIPPED,
    FFP_RIG_MISHAPS
} FfpRigMishap;

// What brightness says: photographs exchanged or taken twice, a projector that stayed dark, an inverted mask,
// and in notes a lamp, an exposure or a room that costs quality. `active`: the structured light's pattern,
// -1: none.
bool ffp_rig_suspect_light(const FfpCapture *capture, int active, FfpError *err);
// Whether structured light explains the photographs; where it does not, what people do is tried: the
// projector or its file mirrored, calibrated at another size, another pattern of the capture, red and blue
// exchanged, and in one view another view's photograph.
bool ffp_rig_suspect_pattern(const FfpCapture *capture, int active, FfpError *err);

// A message, with the way: "left to right" or "upside down".
#define FFP_RIG_ALL_MIRRORED                                                                                 \
    "all photographs are mirrored %s: the camera's program shows them as in a mirror; switch that off, or "  \
    "mirror the files, and import again"

// The error of structured light (ffp_rig_guess, over all views) when all photographs are mirrored back; NAN:
// too few pixels are lit.
double ffp_rig_error_mirrored_back(const FfpCapture *capture, int active, FfpRigMishap mishap);

// A capture with views of its own, to be rearranged; everything they point to stays the capture's. Free
// `views` only.
FfpCapture ffp_rig_alias(const FfpCapture *capture);

// The picture with the mishap undone, as large as it is: a new image.
FfpImage ffp_rig_undone(const FfpImage *image, FfpRigMishap mishap);

#endif
