// Knowledge about points that no light of a projector tells, shared by the searches for them.
#ifndef FFP_MATCH_UNLIT_WORK_H
#define FFP_MATCH_UNLIT_WORK_H

#include "engine/match/consistency.h"
#include "engine/match/line.h"
#include "engine/match/projector_rays.h"

typedef struct FfpUnlit {
    const FfpDepths *depths;
    FfpSupportViews support_views;
    FfpProjectorRays *projector_rays; // [views]
    real *encoded;                    // [views,h,w,3]: the object's own colour under black
} FfpUnlit;

FfpUnlit ffp_unlit_new(const FfpDepths *depths);
void ffp_unlit_free(FfpUnlit *scene);

// A pixel's ray as cameras and projectors see it.
typedef struct FfpUnlitRay {
    int view;
    const real *colour;          // encoded
    FfpLine *camera, *projector; // [views]
} FfpUnlitRay;

// lines [2 views]: memory for the ray.
FfpUnlitRay ffp_unlit_ray(const FfpUnlit *scene, int view, size_t pixel, FfpLine *lines);
#define FFP_UNLIT_UNKNOWN 0.5F // cost of a point that no other view can tell about
// Cost of the ray's point at camera depth z, [0,1].
real ffp_unlit_cost(const FfpUnlit *scene, const FfpUnlitRay *ray, real z);

#endif
