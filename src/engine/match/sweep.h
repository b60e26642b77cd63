// The coarse search: costs of depth hypotheses for every pixel of a view, and the smooth surface of least
// cost.
#ifndef FFP_MATCH_SWEEP_H
#define FFP_MATCH_SWEEP_H

#include "engine/match/foreground.h"
#include "engine/match/line.h"
#include "engine/match/match.h"
#include "engine/match/observe.h"

// Hypotheses: planes of equal camera depth, evenly spaced over the object's sphere; of a whole scene, evenly
// spaced in inverse depth between the view's far and near end, so that all are as far apart in pictures.
typedef struct FfpPlanes {
    int count;
    bool inverse;     // of inverse camera depth,
    real first, step; // otherwise of camera depth
} FfpPlanes;
static inline real ffp_plane_depth(const FfpPlanes *planes, real k) {
    const real at = planes->first + k * planes->step;
    return planes->inverse ? 1 / at : at;
}
// The number, with its fraction, of the plane at a depth.
static inline real ffp_plane_at(const FfpPlanes *planes, real depth) {
    return ((planes->inverse ? 1 / depth : depth) - planes->first) / planes->step;
}
// A pixel's ray in the planes' own unit, for ffp_line_positions.
static inline FfpLine ffp_plane_line(const FfpPlanes *planes, FfpLine line) {
    if (!planes->inverse) return line;
    return (FfpLine){{line.u[1], line.u[0]}, {line.v[1], line.v[0]}, {line.w[1], line.w[0]}};
}
FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings);

// inside [foreground, count]: 1 where a hypothesis lies within the silhouettes of all other views, widened by
// a pixel; what is outside a picture is not known to be empty.
void ffp_hull(unsigned char *inside, const FfpCapture *capture, int view, const FfpForeground *foreground,
              const FfpPlanes *planes);
// A view's silhouette for it: 1 where any coverage is within a pixel, and around the frame's edge, [h,w] of
// the frame, and one more 1 for what is outside it.
unsigned char *ffp_hull_widened(const FfpView *view);
// The camera depths between which each pixel's ray is within the hull, [h,w,2]; the whole sphere where it
// never is, or off the object.
void ffp_hull_range(real *range, const unsigned char *inside, const FfpForeground *foreground,
                    const FfpPlanes *planes);
// The same for a single view.
void ffp_hull_ranges(real *range, const FfpCapture *capture, int view);

// cost [foreground, count] of a view's pixels: squared difference between the observed ratio and the pattern
// where the hypothesis puts it, summed over channels with their weights and over the view's patterns, which
// count alike because noise is one for all photographs; hypotheses outside the hull cost as much as a wrong
// colour.
void ffp_sweep(real *cost, const FfpView *view, const FfpForeground *foreground,
               const FfpObservation *observed, const FfpBlurred *patterns, const FfpPlanes *planes,
               const unsigned char *inside);

// Cost of any step between neighbouring pixels a and b of a picture [h,w,3].
typedef real FfpBorder(const real *picture, size_t a, size_t b);

// Costs of steps between the planes of neighbours: of one plane `small`, of more `large`, unless there is
// `border`.
typedef struct FfpSteps {
    real small, large;
    FfpBorder *border;
    const real *picture;
} FfpSteps;

// Semi-global aggregation (Hirschmueller 2008) over eight directions within the foreground: added to
// total [foreground, count].
void ffp_semi_global(real *total, const real *cost, const FfpForeground *foreground, int count,
                     const FfpSteps *steps);

#endif
