// From depth found on reduced pictures to depth at full size.
#ifndef FFP_MATCH_ENLARGE_H
#define FFP_MATCH_ENLARGE_H

#include "engine/match/observe.h"
#include "engine/match/reduce.h"

// Depth, normal and confidence of a view's pixels at full size.
typedef struct FfpEnlarged {
    real *depth;      // [h,w] camera z; 0 off the object
    real *normal;     // [h,w,3] world, unit, facing the camera
    real *confidence; // [h,w] as in FfpInitialisation
} FfpEnlarged;

// Fills the maps, which are zero, of the view from the reduced start. At a pixel the local planes of the 3 x
// 3 reduced pixels around it, of those on one surface, are blended by quadratic B-splines. The surface is
// that of the reduced pixel it lies in, or where other surfaces come near and the projector lights the pixel,
// the one under which it saw the patterns as they are. `observed`: of the view at full size; patterns:
// blurred for its pixels.
void ffp_enlarge(const FfpEnlarged *out, const FfpReduced *reduced, const FfpView *full, int view,
                 const FfpObservation *observed, const FfpBlurred *patterns);

#endif
