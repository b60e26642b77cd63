// Cameras, projectors and the light between them: the data for compensation and for the maps.
// For fixed Gaussians a camera's picture is linear in the patterns: with M the projectors that reach a pixel,
//     C = ambient + sum over M of response * lookup(light, position, footprint) + sum of level * scattered,
// which is the light model of docs/design/architecture.md with everything but the pattern in `response`. The
// light is the pattern of which a share is spread (FfpPanel.spread), the level its mean where it falls on the
// object.
#ifndef FFP_APPLY_PROCAMS_H
#define FFP_APPLY_PROCAMS_H

#include <stdbool.h>
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/render/render.h"

// One camera's picture and its target. All images have the camera's size.
typedef struct FfpCameraView {
    const FfpView *view;
    FfpImage depth;     // 1: camera z in world units, 0 where the opacity is below one half
    FfpImage facing;    // 1: cosine between the normal and the ray to the camera, in [0,1]
    FfpImage ambient;   // 3: linear radiance under dark projectors
    FfpImage scattered; // 3: linear radiance that a white pattern adds by other ways than its direct ray;
                        // empty: none does
    FfpImage target;    // 3: linear radiance requested; empty until it is given
    FfpImage weight;    // 1: in [0,1], the weight of a pixel: coverage times the target's alpha
} FfpCameraView;

// The surface that one projector lights. All images have the projector's size.
typedef struct FfpProjection {
    const FfpView *view; // the first view with this projector pose
    FfpImage feather;    // 1: in (0,1], the projector's share where several overlap; 1 for a single one
    FfpImage lit;        // 1: 1 where it lights a surface, 0 elsewhere
    FfpImage pattern;    // 3: linear, in [0,1]
} FfpProjection;

// The effect of one projector in one camera; the camera's size.
typedef struct FfpLink {
    FfpMapping mapping; // where each pixel lies in the pattern, and its footprint there
    FfpImage response;  // 3: radiance for a pattern of 1, 0 where no light comes
} FfpLink;

typedef struct FfpProCams {
    int n_camera_views, n_projections;
    FfpCameraView *camera_views;
    FfpProjection *projections;
    FfpLink *links; // [n_camera_views, n_projections]
    real black;     // the share of its white that a dark projector still gives (ffp_procams_black_level)
    real spread[3], spread_reach; // of the capture's panel
    real blur; // deviation in the patterns' pixels, of the light that they are solved for; 0 at first
} FfpProCams;

// Borrows the views. Projectors with the same pose and lens (ffp_same_device) are one projection. With
// `photographs`, a view that has pictures under black and white takes its ambient light and its own
// projector's response from them, which is what the camera really saw: the Gaussians then only determine
// where the light goes. Views are drawn in strips of ffp_strip_rows.
FfpProCams ffp_procams_new(const FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpView *const *views, int n_views, const FfpRenderSettings *settings,
                           bool photographs);
void ffp_procams_free(FfpProCams *procams);
FfpLink *ffp_procams_link(const FfpProCams *procams, int camera_view, int projection);

// Gives a camera its target: linear RGB of the camera's size; alpha (1 channel) may be NULL.
void ffp_procams_aim(FfpProCams *procams, int camera_view, const FfpImage *target, const FfpImage *alpha);
// Multiplies all targets.
void ffp_procams_scale(FfpProCams *procams, real gain);

// Projectors that are dark still give a share `black` of their white, in [0,1): that becomes ambient light,
// and the patterns have the rest. Before the targets are given.
void ffp_procams_black_level(FfpProCams *procams, real black);

// The least that targets ask for, which makes the dark even where several projectors overlap and beside it:
// the darkness of the place that most projectors reach (one that less than a hundredth of the lit pixels
// share does not count). The mean of what each projector's white would show alone, weighted by their
// feathers, times black times that number, on what the camera sees with the projectors off. Raises targets to
// it.
void ffp_procams_lift(FfpProCams *procams);

// Turns targets into light painted on the object: a target of 0 becomes what the camera sees under dark
// projectors, lifted as by ffp_procams_lift, 1 what it sees under the mean of what each projector's white
// would show alone, weighted by their feathers: so nothing is brighter where projectors overlap than beside.
// Without a black level all of these values can be reached.
void ffp_procams_paint(FfpProCams *procams);

// A projection's light under its pattern: blurred, and what of it is spread included. The caller's to free.
FfpImage ffp_procams_light(const FfpProCams *procams, int projection);
// Ambient light and what the patterns scatter, as the camera sees it without any direct light: what is too
// bright in it no pattern mends. The caller's to free.
FfpImage ffp_procams_floor(const FfpProCams *procams, int camera_view);
// The camera's picture under the projections' patterns: linear, unclamped.
FfpImage ffp_procams_picture(const FfpProCams *procams, int camera_view);

// The depth of a camera's pixels that a projector lights, 0 elsewhere: the camera's size, 1 channel.
FfpImage ffp_procams_lit_depth(const FfpProCams *procams, int camera_view, int projection);

// Where a camera's pixels lie in a projector, the other way round: [projector's size, 3] camera x, y and the
// depth from the projector; -1 -1 0 where the camera sees nothing that the projector lights. Cells between
// four neighbouring pixels are laid into the projector with a depth buffer, so that going there and back
// ends where it began; cells across a depth jump are left out.
FfpImage ffp_procams_inverse(const FfpProCams *procams, int camera_view, int projection);
// The same in parts: an inverse in which nothing is seen yet, and the cells of a strip's lit pixels. `camera`
// is the strip's (ffp_strip_of), and row 0 is row `top` of the picture; strips share a row with the next.
FfpImage ffp_inverse_new(const FfpCamera *projector);
void ffp_inverse_draw(FfpImage *inverse, const FfpImage *lit, const FfpCamera *camera,
                      const FfpCamera *projector, int top);

// Camera pixels that the projector lights, sent to it and back through an inverse (its depth-consistent
// pixels among the four around the position, mixed bilinearly): the distance from where they began, in camera
// pixels. Overwrites the lit depths.
typedef struct FfpRoundTrip {
    int pixels; // that came back
    int lost;   // lit, but with no pixel of the inverse at their depth: cells at outlines, and hidden parts
    double within_half;  // share of those that came back, within half a pixel
    double median, most; // pixels
} FfpRoundTrip;
FfpRoundTrip ffp_round_trip(const FfpCamera *camera, const FfpCamera *projector, FfpImage *lit,
                            const FfpImage *inverse);

#endif
