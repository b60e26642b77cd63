// The corners of all attitudes as OpenCV takes them.
#ifndef FFP_CHESSBOARD_VIEWS_H
#define FFP_CHESSBOARD_VIEWS_H

#include "rig/chessboard/fit.h"
#include "rig/chessboard/opencv.h"

typedef struct FfpViews {
    FfpCvViews cv;
    int *counts;
    double *board, *points[2];
    int *attitude; // [cv.n] which
} FfpViews;

// Room for all attitudes of the fit.
FfpViews ffp_views_new(const FfpRigFit *fit);
void ffp_views_free(FfpViews *views);
// Corners that every one of the devices (1 camera, 2 projector, 3 both) has, of attitudes without a problem.
void ffp_views_fill(const FfpRigFit *fit, unsigned devices, FfpViews *views);
bool ffp_corner_used(const FfpAttitude *attitude, int corner, unsigned devices);

#endif
