// The steps between a capture's photographs and its masks, for this room's own files, in the order in which
// they are taken.
#ifndef FFP_RIG_MASKS_STEPS_H
#define FFP_RIG_MASKS_STEPS_H

#include <stdint.h>
#include "rig/masks/masks.h"

// --- The camera's displacement from where the empty stage was photographed (stage_moved.c). ---

// The displacement (x, y) in pixels by which the stage's pictures look most like the view's; 0, 0 if none is
// clearly better than none. White minus black is compared, linear, 3 channels, all four of one size, by the
// mean of |a - b| / (a + b), bounded for each pixel so that the object counts little, at displacements in
// small pictures.
void ffp_stage_moved(int moved[2], const FfpImage *black, const FfpImage *white, const FfpImage *stage_black,
                     const FfpImage *stage_white);

// --- The stage behind an object that turns, from the views themselves: what stays the same is background
// (stage_common.c). ---

typedef struct FfpCommon {
    double known; // share of the pixels whose stage was found
    double lit;   // and share of these pixels that white lights
} FfpCommon;

// For views of one camera that stood still, whose pictures are not masked: per pixel the look that most views
// share under all patterns, three and a third of them at least, as the mean over these. A look that is as
// common, or nearly, and twice as bright is taken before a darker one, which then is a shadow. *stage (to be
// freed by ffp_common_stage_free) knows only such pixels. False when there are fewer than five views.
bool ffp_common_stage(FfpEmptyStage *stage, FfpCommon *found, const FfpCapture *capture);
// Finds *stage again, once there are masks made with it (coverage, 0 and 1), if part of what was taken for
// the stage stands above the platter (ffp_place_above), enough of the mean mask: there the object looks
// the same from all sides. Such pixels then count as the object. False, and nothing is done, if there is
// less.
bool ffp_common_stage_again(FfpEmptyStage *stage, const FfpCapture *capture);
void ffp_common_stage_free(FfpEmptyStage *stage, int n_patterns);

// --- What of a view is like the stage (stage_pixels.c). ---

// The kind of a view's pixel, as far as the stage alone shows it.
typedef enum FfpPixelKind {
    FFP_PIXEL_UNKNOWN,   // in shadow, or neither like the stage nor clearly another thing
    FFP_PIXEL_STAGE,     // lit, and as the stage is under every pattern
    FFP_PIXEL_DIM_STAGE, // like the stage, but too dimly lit to be sure
    FFP_PIXEL_OBJECT,    // lit, and unlike the stage
    FFP_PIXEL_LIT,       // lit where the stage is not known
} FfpPixelKind;

typedef struct FfpCompared {
    unsigned char *kinds; // [height*width] FfpPixelKind, owned
    double noise;         // linear: what two smoothed pictures of one thing differ by
    double gain;          // of the view over the stage, from what is lit
    double stage;         // share of the pixels that the camera saw which are stage, dim or not
} FfpCompared;

// Compares a view's photographs, which are not masked yet, with the stage's, both smoothed. With the light d
// that each pattern adds to black in the view and d0 on the stage, a pixel is stage where one factor near 1
// explains all patterns and channels, d = a d0; a shadow and what it leaves half lit have smaller factors and
// are unknown. Errors allowed are those of the noise, of a share of the light, and of a pixel's neighbours,
// since lens and pixel blur edges (limits.h). `where` names the view's pictures in errors: of the stage
// hardly anything is seen.
bool ffp_stage_compare(FfpCompared *compared, const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                       const char *where, FfpError *err);

// True if pictures of the empty stage show nothing either (dark.c).
bool ffp_dark_stage(const FfpCapture *capture, int view, const FfpEmptyStage *stage);

// --- Masks of all views from the stage behind the object (stage_masks.c). ---

typedef struct FfpStageMasks {
    double stage, object, decided; // mean shares of the pictures: stage, object for sure, and object by the
                                   // hull or in it
    double shade;                  // and stage in the object's shadow that the hull allowed the object
    double gain_least, gain_most;  // of a view over the stage
    double noise[FFP_VIEWS_MAX];   // in each view, for ffp_soften_edges
} FfpStageMasks;

// Fills in the coverage of all views with 0 and 1; their pictures are not masked yet. stages [n_views];
// `paths` [n_views] names the views' pictures for errors. Where poses are known (`posed`) and three views or
// more, what is neither stage nor object for sure is object where the rays run through a hull that the stage
// carves. Errors: a view shows hardly anything of the stage, or no view an object.
bool ffp_stage_masks(FfpStageMasks *report, FfpCapture *capture, const FfpEmptyStage *const *stages,
                     bool posed, const char *const *paths, FfpError *err);

// --- Pieces of a mask (mask.c). ---

// Fills enclosed background of less than a two-hundredth of the largest piece; returns how many pixels.
int64_t ffp_mask_fill_specks(FfpImage *mask);

// Fills background that does not reach the picture's edge.
void ffp_mask_fill_holes(FfpImage *mask);
// Drops pieces that have less than a twentieth of the largest's pixels; those that have fewer than `least`.
void ffp_mask_drop_pieces(FfpImage *mask);
void ffp_mask_drop_specks(FfpImage *mask, int64_t least);

// --- Masks that the light made, completed by what the views know of each other (grow_masks.c). ---

// A mask made of the projector's light lacks the parts that it does not reach. A dark pixel of a view
// (`made`) becomes object where a part of its ray
// - lies in the shadow of the object, as far as it is known, or outside the projector's field, and
// - is possible to all other views: each shows light there, or has a shadow there too, and nearly all show
//   light.
// Holes that were filled (holes[v], as ffp_mask_otsu has them) stay filled where a part of the ray is what
// all other views show as object, and are opened elsewhere. The shadows are those of the visual hull
// (Laurentini 1994), which grows with them. Poses are known, bounds set. Returns how many pixels were added,
// less those opened.
bool ffp_grow_masks(FfpCapture *capture, const bool *made, const FfpImage *holes, int64_t *added);

// --- Edges of a mask as soft as the camera's (soft_edges.c). ---

// A mask of 0 and 1 gets shares of pixels along its outline, and what is not the object's there leaves the
// view's pictures. In each picture a pixel two steps or less from the outline shows a mean of the object
// inside and of the stage there, which is known and as bright here as it is outside; its share is that which
// explains all pictures best. Where both are alike, the mask stays as it is.
void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);
// The mask alone: pictures stay as they are.
void ffp_soften_mask(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);

#endif
