// Checks whether a capture can be reconstructed well: a page for the person who made it.
#ifndef FFP_RIG_CHECKS_H
#define FFP_RIG_CHECKS_H

#include <stdio.h>
#include "core/capture/capture.h"
#include "core/image/lookup.h"

// Where the projector's frustum lies, exposure and clipping, ambient light, how far the rig is from what the
// shipped model was trained on, and how well looking up the pattern explains the pictures. A line each, "ok"
// or "LOOK", and what to do below the latter. Returns the number of the latter. `taken` has the size of the
// photographs, of which the capture may hold reduced ones.
int ffp_rig_checks(const FfpCapture *capture, const FfpCamera *taken, FILE *out);

// What the devices see of the object's sphere.
typedef struct FfpFrusta {
    double camera, projector; // share of the sphere's surface within the device's field, in the worst view
    bool ahead;               // whether its centre lies before all of them
} FfpFrusta;
FfpFrusta ffp_rig_frusta(const FfpCapture *capture);
// Whether that is enough: more than 90 % for the camera, 80 % for the projector.
bool ffp_rig_frusta_hold(FfpFrusta frusta);

// The share from which on the views are said to contradict each other.
#define FFP_RIG_MISFIT_MAX 0.03
// Share of the object's pixels through which no point of its sphere lies in all views' silhouettes (a pixel's
// width is forgiven; what a view does not show contradicts nothing). 0 with poses and masks that fit.
double ffp_rig_silhouette_misfit(const FfpCapture *capture);
// The same, or INFINITY as soon as it is known not to be below `enough`, which takes less time.
double ffp_rig_misfit_below(const FfpCapture *capture, double enough);
// Fewer views than these cannot outvote one, and what leaves so much of the misfit explains it.
#define FFP_RIG_VIEWS_TO_ACCUSE 4
#define FFP_RIG_EXPLAINED 0.25
// The same view by view. A misfit below 1 % accuses nobody: `blame` is 0 then.
typedef struct FfpSilhouettes {
    double misfit;  // of all views
    double without; // of the others, without the odd view
    int odd;        // the view without which the others agree; -1: there is none
    double *own;    // [n_views] share of each view's pixels
    double *blame;  // [n_views] share of all pixels that have no point: its own, and those that it alone
                    // denies one
} FfpSilhouettes;
FfpSilhouettes ffp_rig_silhouettes(const FfpCapture *capture);
void ffp_rig_silhouettes_free(FfpSilhouettes *silhouettes);

// How the pattern explains the active pictures of a capture. Errors are root mean squares of
// (C - B) / (W - B) - pattern, per channel in linear values, with each pixel's best depth in the object's
// sphere, or in views with correspondences the depth that these give; they are small when poses, lenses,
// sizes and pattern file are right, and near `chance` when they are not.
typedef struct FfpExplanation {
    int pixels;    // looked at; 0: no lit pixels, and nothing below holds
    double error;  // as the capture is
    double chance; // with the pattern moved by a third, wrapped round its edges: least of four directions;
                   // in views with correspondences the error of a constant
    double best;   // least error with the pattern moved a little across the epipolar lines, and
    double across; // by how many of its pixels along
    double direction[2]; // in the first view
    double mirrored[3];  // turned round left to right, upside down, both
    int odd;             // the view that is unlike the others; -1: none
    double odd_across;   // pattern pixels by which it fits better when moved; 0: its error is just larger
} FfpExplanation;
FfpExplanation ffp_rig_explain(const FfpCapture *capture, int pattern);

// What might have been photographed.
typedef struct FfpGuess {
    const FfpImage *photograph; // under the pattern, of the view's size
    const FfpSummed *pattern;   // that was shown
    int mirror;                 // bit 0: left to right, bit 1: upside down
    int third;                  // 1 to 4: moved by a third of the pattern to one of four sides; 0: not moved
    bool reversed;              // red and blue exchanged
    bool ideal;                 // not the photograph, but a flawless one of the lit pixels
} FfpGuess;
// The root mean square error of that in one view, of up to 80 of its pixels; NAN if fewer than 16 are lit.
double ffp_rig_guess(const FfpCapture *capture, const FfpView *view, const FfpGuess *guess);

// Whether the photographs under a pattern can tell right poses from wrong ones. Those of stripes cannot: each
// ray meets all of their colours, wherever the pattern is; unless correspondences say where to look.
bool ffp_rig_tells(const FfpCapture *capture, int pattern);
// The error up to which photographs under a pattern that cannot tell may show it.
#define FFP_RIG_SHOWN 0.12

#endif
