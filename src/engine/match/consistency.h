// Support of the other views for a point that one view has found.
#ifndef FFP_MATCH_CONSISTENCY_H
#define FFP_MATCH_CONSISTENCY_H

#include <stdbool.h>
#include "core/capture/capture.h"
#include "engine/match/thresholds.h"

// Depth maps of all views, [views, h, w] each: camera z (0: none), and its confidence ("trust").
typedef struct FfpDepths {
    const FfpCapture *capture;
    int width, height;
    real *depth, *trust;
} FfpDepths;

// The trusted depths of a view at the four pixels around a point: their least and greatest depth and greatest
// trust. All 0 if there are none.
typedef struct FfpDepthBounds {
    real low, high, trust;
} FfpDepthBounds;

#define FFP_ASKED 17 // views, the one that asks included

// The views that are asked about points of a view, in ascending order. The view itself is one of them.
typedef struct FfpAsked {
    int count, view[FFP_ASKED];
} FfpAsked;

// All views, or, of more than FFP_ASKED, the view itself and others from the nearest to the farthest, evenly
// by how many are nearer: the work for a view then does not grow with their number.
FfpAsked ffp_asked(const FfpCapture *capture, int view);

typedef struct FfpSupportViews {
    const FfpDepths *depths;
    FfpAsked *asked;        // [views]
    FfpDepthBounds *bounds; // [views,h,w], at the upper left of the four pixels
} FfpSupportViews;

FfpSupportViews ffp_support_views_new(const FfpDepths *depths);
void ffp_support_views_free(FfpSupportViews *support_views);

typedef struct FfpSupport {
    real coverage; // least share that the silhouette of any other view leaves of the point
    int views;     // other views with the point in their picture
    int agree,
        past; // of these: own surface at the point; own surface well behind it, so the point is in the way
    real trust_agree, trust_past; // sums of their trust
} FfpSupport;

// Counts a cell of another view among those that see past a point of depth z, or among those that have a
// surface there within `slack`; a point behind the surface is not counted.
static inline void ffp_support_count(FfpSupport *out, const FfpDepthBounds *bounds, real z, real slack) {
    if (bounds->high <= 0) return;
    if (z < bounds->low - slack) {
        out->past++;
        out->trust_past += bounds->trust;
    } else if (z <= bounds->high + slack) {
        out->agree++;
        out->trust_agree += bounds->trust;
    }
}

// True if enough views see past the point for it to be free space.
static inline bool ffp_support_is_free_space(const FfpSupport *support) {
    return support->trust_past > FFP_FREE_TRUST + support->trust_agree;
}

// Bounds of the depth around position (x, y) of the view's picture; all 0 outside it.
FfpDepthBounds ffp_depth_bounds_at(const FfpSupportViews *support_views, int view, real x, real y);

// Asks the views other than `view` about the point at camera depth z of position (x, y) in the picture of
// `camera`, which stands where the view's does.
FfpSupport ffp_support_at(const FfpSupportViews *support_views, int view, const FfpCamera *camera, real x,
                          real y, real z);

// Sets the trust of depths to 0 if more trust sees past them than agrees with them.
void ffp_reject_inconsistent(FfpDepths *depths);

// Sets the trust of depths that no pattern told (lit [views,h,w] below FFP_LIT_MIN) to 0 unless as many other
// views agree.
void ffp_require_support(FfpDepths *depths, const real *lit, int least);

// Moves the near end of the range [views,h,w,2] of pixels without trusted depth beyond the free space in
// front of other views' trusted surfaces.
void ffp_free_space(real *range, const FfpDepths *depths);

#endif
