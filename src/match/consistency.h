// What the other views say about a point that one view believes in.
#ifndef FFP_MATCH_CONSISTENCY_H
#define FFP_MATCH_CONSISTENCY_H

#include "capture/capture.h"

// Depth maps of all views, [views, h, w] each: camera z (0: none), and how far it is trusted.
typedef struct FfpDepths {
    const FfpCapture *capture;
    int width, height;
    real *depth, *trust;
} FfpDepths;

// What a view knows around a point between four pixels' centres, of those that have trusted depth: their
// least and greatest depth and greatest trust. All 0 where there is none.
typedef struct FfpHeard {
    real low, high, trust;
} FfpHeard;

typedef struct FfpWitnesses {
    const FfpDepths *depths;
    FfpHeard *heard; // [views,h,w], at the upper left of the four pixels
} FfpWitnesses;

FfpWitnesses ffp_witnesses_new(const FfpDepths *depths);
void ffp_witnesses_free(FfpWitnesses *witnesses);

// Adds the trust of what was heard to those who see past a point of depth z, or to those who have a surface
// there, give or take `slack`; behind the surface it says nothing.
void ffp_hear(real *past, real *agree, const FfpHeard *heard, real z, real slack);

// What is known around position (x, y) of the view's picture; all 0 outside it.
FfpHeard ffp_heard_at(const FfpWitnesses *witnesses, int view, real x, real y);

typedef struct FfpWitness {
    real coverage; // least share that the silhouette of any other view leaves of the point
    int views;     // other views with the point in their picture
    int agree,
        past; // of these: own surface at the point; own surface well behind it, so the point is in the way
    real trust_agree, trust_past; // sums of their trust
} FfpWitness;

// Asks the views other than `view` about the point at camera depth z of position (x, y) in the picture of
// `camera`, which stands where the view's does.
FfpWitness ffp_consult(const FfpWitnesses *witnesses, int view, const FfpCamera *camera, real x, real y,
                       real z);

// Takes the trust from depths that more trusted views see past than agree with.
void ffp_reject_inconsistent(FfpDepths *depths);

// Moves the near end of the range [views,h,w,2] of pixels without trusted depth to where no view's trusted
// surface lies behind it any more: what is seen through is empty.
void ffp_free_space(real *range, const FfpDepths *depths);

#endif
