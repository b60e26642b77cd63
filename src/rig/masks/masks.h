// Separates the object from its background: masks of a capture's views, as imports ask for them. The steps to
// them are this room's own (steps.h).
#ifndef FFP_RIG_MASKS_H
#define FFP_RIG_MASKS_H

#include "core/capture/capture.h"

// --- The stage: what camera and projector see where the object is taken away. ---

typedef struct FfpEmptyStage {
    FfpImage *images; // [n_patterns] as FfpView.images, without the object; .data NULL: not photographed
    FfpImage known; // 1 channel, above 0 where the stage is known, negative where all views show the object;
                    // .data NULL: known everywhere
} FfpEmptyStage;

// --- The object's share of each pixel, from what white adds to black (mask.c). ---

// 1 where the projector's light reaches something, otherwise 0, from linear pictures of one size: the
// sRGB-encoded luminance (Rec. 709) of white - black, smoothed by 1 2 1, is divided into the three classes
// between which the variance is greatest (Otsu 1979, 256 bins), and the darkest is background. Then holes are
// filled (1 in *holes), and pieces below a twentieth of the largest dropped. Fails if white adds nothing
// anywhere.
bool ffp_mask_otsu(FfpImage *mask, FfpImage *holes, const FfpImage *black, const FfpImage *white,
                   const char *where, FfpError *err);

// --- The object in the dark: where nothing but it sends light to the camera (dark.c). ---

// Masks (0 and 1) of views whose pictures are not masked yet: what is brighter, in the mean of all its
// pictures, than their background by five standard deviations; pieces below a twentieth of the largest are
// dropped. Shadows of the projector show in them by the room's weak light and by light from the object
// itself. False, and no masks, unless the background of every view is dark and even: by less than a thirtieth
// of the object's light.
bool ffp_dark_masks(FfpImage *masks, const FfpCapture *capture);

// Edges of coverage that ffp_dark_masks found, as soft as the camera's. Pictures stay as they
// are.
void ffp_dark_soften(const FfpCapture *capture, FfpView *view);

// --- All masks of an import in one picture, to be looked at (contact_sheet.c). ---

// A small copy of a linear photograph, at most 240 pixels wide.
FfpImage ffp_contact_thumb(const FfpImage *photograph);
// One view, encoded for a PNG: what is not the object is dark and blue, and a red line goes round it.
FfpImage ffp_contact_picture(const FfpImage *thumb, const FfpImage *coverage);
// One view in grey, tinted in encoded colours [h,w,3] of the photograph's size; black darkens.
FfpImage ffp_contact_tinted(const FfpImage *thumb, const FfpImage *tint);
// thumbs [n_views], in rows and in the views' order.
FfpImage ffp_contact_sheet(const FfpCapture *capture, const FfpImage *thumbs);

// --- All of it (complete.c, stage_doubts.c). ---

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
// pictures. Says what they were made from and how well they agree. Errors: a view shows hardly anything of
// the stage, or no view an object.
bool ffp_masks_complete(const FfpMasking *masking, FfpError *err);
// A warning each where the stage, or a view, was photographed from another place, and where the room's light
// changed in between; of views whose masks are made. Error: the stage's black and white are exchanged.
bool ffp_masks_check_stage(const FfpMasking *masking, FfpError *err);

#endif
