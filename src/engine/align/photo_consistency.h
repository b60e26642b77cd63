// How well a capture's pictures agree with each other under its poses.
#ifndef FFP_ALIGN_PHOTO_CONSISTENCY_H
#define FFP_ALIGN_PHOTO_CONSISTENCY_H

#include "core/capture/capture.h"

typedef struct FfpPhotoConsistency FfpPhotoConsistency;
FfpPhotoConsistency *ffp_photo_consistency_new(const FfpCapture *capture,
                                               int active); // capture normalised; it must outlive the looker
void ffp_photo_consistency_free(FfpPhotoConsistency *looker);

// Matches all views with their present poses, builds the classical splats, and draws all of them from every
// camera: compares the pattern's colour that should be seen at the surface drawn with the colour that was
// seen. If the poses are right, the surfaces of all views coincide. Returns the mean of the absolute
// differences of the pattern's linear values, each weighted by the light that the projector adds there (0 to
// 1), over the object's pixels. Errors: those of ffp_initialisation_new.
bool ffp_photo_consistency(FfpPhotoConsistency *looker, double *disagreement, FfpError *err);

#endif
