// Plane sweep over the photographs of a whole scene: what no projector reaches has its depth from the
// cameras' own parallax. Under a projector that stands, its light is texture like any other.
#ifndef FFP_MATCH_STEREO_H
#define FFP_MATCH_STEREO_H

#include "engine/match/foreground.h"
#include "engine/match/sweep.h"

// A pixel's encoded colours: black, the first pattern, and the mean of white; one number is spare.
enum { FFP_STEREO_CHANNELS = 8 };
typedef real FfpStereoCell __attribute__((vector_size(FFP_STEREO_CHANNELS * sizeof(real))));

typedef struct FfpStereo {
    const FfpCapture *capture;
    FfpStereoCell *cells; // [views,h,w]
} FfpStereo;

// A plane of the sweep, as a neighbour sees it.
typedef struct FfpStereoPlane {
    FfpStereoCell weight;              // of the channels; their sum is 1
    size_t count;                      // the view's pixels that are compared,
    const size_t *pixel;               // [count] y * width + x, both pictures' width
    const real *line[6];               // [count] each: u, v and w of FfpLine, at the inverse depth `at`
    const FfpStereoCell *own, *theirs; // [h,w]
    real at, right, bottom; // right, bottom: of the neighbour's pixels; positions from there on are outside
    int width;
} FfpStereoPlane;
// single [h,w] at the pixels: their cost, the weighted difference in [0,1]; -1 where the neighbour does not
// see the point.
void ffp_stereo_plane(real *single, const FfpStereoPlane *plane);

// The view's pictures as they are compared; `pattern` is an index into the capture's.
FfpStereo ffp_stereo_new(const FfpCapture *capture, int pattern);
void ffp_stereo_free(FfpStereo *stereo);

// cost [foreground, count] of a view's pixels: added, `share` times the difference, in [0,1], between what
// the view and its neighbours show around the point, of the two most alike of up to four neighbours, since
// something may hide it from the others. Views that another projector lights are compared under black alone.
void ffp_stereo_costs(real *cost, const FfpStereo *stereo, int view, const FfpForeground *foreground,
                      const FfpPlanes *planes, real share);

#endif
