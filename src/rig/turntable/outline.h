// Silhouettes as planes that touch the object. A plane through two camera centres that touches the object
// touches both silhouettes (epipolar tangency; Cipolla and Giblin 2000, "Visual Motion of Curves and
// Surfaces"). That holds for the right axis at any distance: pictures of one camera tell no unit of length.
#ifndef FFP_RIG_OUTLINE_H
#define FFP_RIG_OUTLINE_H

#include "core/capture/capture.h"
#include "rig/turntable/axis.h"

typedef struct FfpOutline { // of the silhouette's convex hull
    int count;
    double (*rays)[3];  // unit vectors in camera coordinates
    bool *cut;          // where the picture's edge cuts the silhouette
    double centroid[3]; // the silhouette's, as a unit vector
} FfpOutline;

// Where the coverage crosses one half, between the centres of pixels; count is 0 for an empty mask.
FfpOutline ffp_outline_new(const FfpImage *coverage, const FfpCamera *camera);
void ffp_outline_free(FfpOutline *outline);

typedef struct FfpOutlines {
    int n;                // stops
    FfpOutline *outlines; // [n]
    const double *angles; // [n], radians
    double focal;         // pixels
    int n_pairs;
    int (*pairs)[2]; // stops that are compared
} FfpOutlines;

// Pairs are all, or an even choice of some hundreds of them.
FfpOutlines ffp_outlines_new(const FfpCapture *capture, const double *angles);
void ffp_outlines_free(FfpOutlines *outlines);

// Nearest stop on one side (1 or -1) of a view, at least `apart` radians from it; -1: none.
int ffp_next_stop(const FfpOutlines *outlines, int view, int side, double apart);

// Two residuals a pair of the outlines, in pixels: how far the tangent plane of one silhouette passes by the
// other. None where the line between the cameras meets the object, or the picture cuts the silhouette there.
void ffp_outline_residuals(const void *context, const FfpAxis *axis, double *residuals);

// The object's middle and radius when it stands at angle 0, from the centroids' and outlines' rays.
void ffp_outline_sphere(const FfpOutlines *outlines, const FfpAxis *axis, double centre[3], double *radius);

#endif
