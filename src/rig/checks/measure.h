// Measures of a capture: light, frusta, silhouettes, structured light. Nothing is judged here.
#ifndef FFP_RIG_CHECKS_MEASURE_H
#define FFP_RIG_CHECKS_MEASURE_H

#include "core/capture/capture.h"
#include "core/image/lookup.h"

// Light on the object, in linear values (light.c). Of a view, or the sums over all.
typedef struct FfpObjectLight {
    double object, lit;  // pixels: of the object; of these, to which white adds something in a channel,
    double brightened;   // to which it adds something in the mean,
    double clipped;      // at the limit under white,
    double reversed;     // darker under white than under black,
    double unreached;    // lit where no light of the projector can be
    double guessed;      // of the object, that no pattern tells
    double least;        // what white adds at least to a pixel that it lights, brightest channel
    double black, added; // sums over the object: under black, and what white adds
    float bright;        // under white, brightest channel: 95 % of the object's pixels are darker
} FfpObjectLight;
typedef struct FfpLights {
    FfpObjectLight *views, all; // [n_views]
    float bright, ambient; // of all lit pixels: brightest channel under white, 95 % are darker; median share
                           // of it under black
} FfpLights;
// `reach`: unreached is wanted, which takes longer.
FfpLights ffp_rig_lights(const FfpCapture *capture, bool reach);
void ffp_rig_lights_free(FfpLights *lights);
// How the patterns of its own view tell a pixel's depth.
typedef enum FfpTold {
    FFP_TOLD,         // by its Gray codes' position or, in a view without them, because it is lit
    FFP_TOLD_REFUSED, // not: lit, but its Gray codes give no position, as on mirrors
    FFP_TOLD_UNLIT,   // not: the projector does not reach it
    FFP_TOLD_KINDS
} FfpTold;
// `least` as in FfpObjectLight.
FfpTold ffp_rig_told(const FfpCapture *capture, const FfpView *view, size_t pixel, double least);
// Share of the lit pixels that are lit where no light of the projector can be.
double ffp_rig_unreached(const FfpCapture *capture);
// True if a view is darker under pattern a than under b in many of the object's pixels, and brighter in
// hardly any.
bool ffp_rig_is_darker(const FfpView *view, int a, int b);

// The least sharp view by its photograph under the pattern, and in *left its contrast between neighbouring
// pixels, as a share of the views' median (focus.c); -1: nothing can be said.
int ffp_rig_blurred(const FfpCapture *capture, int active, double *left);

// The parts of the object's sphere that the devices see (devices.c).
typedef struct FfpFrusta {
    double camera, projector; // share of the sphere's surface within the device's field, in the worst view
    bool ahead;               // true if its centre lies before all of them
} FfpFrusta;
FfpFrusta ffp_rig_frusta(const FfpCapture *capture);
// True if that is enough: more than FFP_RIG_CAMERA_LEAST and FFP_RIG_PROJECTOR_LEAST.
#define FFP_RIG_CAMERA_LEAST 0.9
#define FFP_RIG_PROJECTOR_LEAST 0.8
bool ffp_rig_frusta_hold(FfpFrusta frusta);
bool ffp_rig_falls_into(const FfpCamera *device, const real point[3]);      // within a pixel of its picture
bool ffp_rig_is_behind(const FfpCapture *capture, const FfpCamera *device); // the sphere's centre
// From the object's centre to a device: its distance, and its direction as a unit vector.
double ffp_rig_direction(const FfpCapture *capture, const FfpCamera *device, double out[3]);

// The rig's numbers once the object's sphere has radius 1, from the least to the most of all views.
typedef enum FfpRigNumber {
    FFP_RIG_CAMERA_DISTANCE,
    FFP_RIG_PROJECTOR_DISTANCE,
    FFP_RIG_CAMERA_HEIGHT, // degrees above the world's x-y plane, as the others
    FFP_RIG_BETWEEN,       // the two devices
    FFP_RIG_CAMERA_FIELD,  // of the narrower side, were the principal point in the middle
    FFP_RIG_PROJECTOR_FIELD,
    FFP_RIG_ROLL, // of the camera about its axis
    FFP_RIG_NUMBERS
} FfpRigNumber;
typedef struct FfpRange {
    double low, high;
} FfpRange;
void ffp_rig_ranges(const FfpCapture *capture, FfpRange ranges[FFP_RIG_NUMBERS]);
// The widest gap between neighbouring cameras' azimuths, degrees.
double ffp_rig_widest_gap(const FfpCapture *capture);
// The widest angle from a camera to the nearest that stands elsewhere, seen from the sphere's centre,
// degrees; 0: all stand in one place.
double ffp_rig_widest_step(const FfpCapture *capture);

// Silhouettes (silhouettes.c). Share of the object's pixels through which no point of its sphere lies in all
// views' silhouettes (a pixel's width is forgiven; what a view does not show contradicts nothing). 0 with
// poses and masks that fit.
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

// Of what chance explains: more, and the pattern explains nothing.
#define FFP_RIG_CHANCE_MAX 0.75
// How the pattern explains the active pictures of a capture (explain.c). Errors are root mean squares of
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
    double mirrored;     // turned round: least of left to right, upside down, both
    int odd;             // the view that is unlike the others; -1: none
    double odd_across;   // pattern pixels by which it fits better when moved; 0: its error is just larger
} FfpExplanation;
FfpExplanation ffp_rig_explain(const FfpCapture *capture, int pattern);

// A guess at what was photographed.
typedef struct FfpGuess {
    const FfpImage *photograph; // under the pattern, of the view's size
    const FfpSummed *pattern;   // that was shown
    int mirror;                 // bit 0: left to right, bit 1: upside down
    int third;                  // 1 to 4: moved by a third of the pattern to one of four sides; 0: not moved
    bool reversed;              // red and blue exchanged
    bool ideal;                 // not the photograph, but a flawless one of the lit pixels
} FfpGuess;
// The root mean square error of that in one view, of up to 80 of its pixels, without the worst of them; NAN
// if fewer than 16 are lit.
double ffp_rig_guess(const FfpCapture *capture, const FfpView *view, const FfpGuess *guess);
// The same over one view or, -1, over all that are lit; without a photograph theirs under `active`.
double ffp_error_of(const FfpCapture *capture, int active, int view, FfpGuess guess);
// The least of four places where the pattern certainly is not.
double ffp_chance_of(const FfpCapture *capture, int active, const FfpSummed *pattern, int view);

// True if the photographs under a pattern can tell right poses from wrong ones. Those of stripes cannot: each
// ray meets all of their colours, wherever the pattern is; unless correspondences say where to look.
bool ffp_rig_tells(const FfpCapture *capture, int pattern);
// The error up to which photographs under a pattern that cannot tell may show it.
#define FFP_RIG_SHOWN 0.12

#endif
