// Separates the object from its background: masks of a capture's views, and the steps to them. Whatever other
// rooms use of this one is here.
#ifndef FFP_RIG_MASKS_H
#define FFP_RIG_MASKS_H

#include <stdint.h>
#include "core/capture/capture.h"

// --- The stage: what camera and projector see where the object is taken away, and what of a view is like it.
// ---

typedef struct FfpEmptyStage {
    FfpImage *images; // [n_patterns] as FfpView.images, without the object; .data NULL: not photographed
    FfpImage known; // 1 channel, above 0 where the stage is known, negative where all views show the object;
                    // .data NULL: known everywhere
} FfpEmptyStage;

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

// --- The object's share of each pixel, from what white adds to black. ---

// 1 where the projector's light reaches something, otherwise 0, from linear pictures of one size: the
// sRGB-encoded luminance (Rec. 709) of white - black, smoothed by 1 2 1, is divided into the three classes
// between which the variance is greatest (Otsu 1979, 256 bins), and the darkest is background. Then holes are
// filled (1 in *holes), and pieces below a twentieth of the largest dropped. Fails if white adds nothing
// anywhere.
bool ffp_mask_otsu(FfpImage *mask, FfpImage *holes, const FfpImage *black, const FfpImage *white,
                   const char *where, FfpError *err);

// Fills enclosed background of less than a two-hundredth of the largest piece; returns how many pixels.
int64_t ffp_mask_fill_specks(FfpImage *mask);

// Fills background that does not reach the picture's edge.
void ffp_mask_fill_holes(FfpImage *mask);
// Drops pieces that have less than a twentieth of the largest's pixels; those that have fewer than `least`.
void ffp_mask_drop_pieces(FfpImage *mask);
void ffp_mask_drop_specks(FfpImage *mask, int64_t least);

// --- Masks that the light made, completed by what the views know of each other. ---

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

// --- The object in the dark: where nothing but it sends light to the camera. ---

// Masks (0 and 1) of views whose pictures are not masked yet: what is brighter, in the mean of all its
// pictures, than their background by five standard deviations; pieces below a twentieth of the largest are
// dropped. Shadows of the projector show in them by the room's weak light and by light from the object
// itself. False, and no masks, unless the background of every view is dark and even: by less than a thirtieth
// of the object's light.
bool ffp_dark_masks(FfpImage *masks, const FfpCapture *capture);

// True if pictures of the empty stage show nothing either.
bool ffp_dark_stage(const FfpCapture *capture, int view, const FfpEmptyStage *stage);

// Edges of coverage that ffp_dark_masks found, as soft as the camera's. Pictures stay as they
// are.
void ffp_dark_soften(const FfpCapture *capture, FfpView *view);

// --- Masks of all views from the stage behind the object. ---

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

// --- The stage behind an object that turns, from the views themselves: what stays the same is background.
// ---

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

// --- Edges of a mask as soft as the camera's. ---

// A mask of 0 and 1 gets shares of pixels along its outline, and what is not the object's there leaves the
// view's pictures. In each picture a pixel two steps or less from the outline shows a mean of the object
// inside and of the stage there, which is known and as bright here as it is outside; its share is that which
// explains all pictures best. Where both are alike, the mask stays as it is.
void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);
// The mask alone: pictures stay as they are.
void ffp_soften_mask(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);

// --- The camera's displacement from where the empty stage was photographed. ---

// The displacement (x, y) in pixels by which the stage's pictures look most like the view's; 0, 0 if none is
// clearly better than none. White minus black is compared, linear, 3 channels, all four of one size, by the
// mean of |a - b| / (a + b), bounded for each pixel so that the object counts little, at displacements in
// small pictures.
void ffp_stage_moved(int moved[2], const FfpImage *black, const FfpImage *white, const FfpImage *stage_black,
                     const FfpImage *stage_white);

// --- All masks of an import in one picture, to be looked at. ---

// A small copy of a linear photograph, at most 240 pixels wide.
FfpImage ffp_contact_thumb(const FfpImage *photograph);
// One view, encoded for a PNG: what is not the object is dark and blue, and a red line goes round it.
FfpImage ffp_contact_picture(const FfpImage *thumb, const FfpImage *coverage);
// thumbs [n_views], in rows and in the views' order.
FfpImage ffp_contact_sheet(const FfpCapture *capture, const FfpImage *thumbs);

// --- All of it. ---

// Views whose masks are made of light.
typedef struct FfpMasking {
    FfpCapture *capture;      // with pictures, and with coverage where there is no empty stage
    const bool *made;         // [n_views] masks that were made; the others are as they were given
    const FfpImage *holes;    // [n_views] what ffp_mask_otsu filled of them
    FfpEmptyStage *stages;    // [n_views] where it was photographed; NULL: was not
    const char *const *paths; // [n_views] photographs under white, for errors
    bool posed;               // poses are known
    bool turns;               // views are the stops of a turntable before one camera
    // Replaces a mask made in the dark by a finer one. False: it stays.
    bool (*refine)(void *context, int view);
    void *context;
} FfpMasking;

// Completes the masks that were made, as far as views, poses and the stage tell, and applies them to the
// pictures. Says what they were made from and how well they agree. Errors: as ffp_stage_masks.
bool ffp_masks_complete(const FfpMasking *masking, FfpError *err);
// A warning each where the stage, or a view, was photographed from another place, and where the room's light
// changed in between; of views whose masks are made. Error: the stage's black and white are exchanged.
bool ffp_masks_compare_stage(const FfpMasking *masking, FfpError *err);

#endif
