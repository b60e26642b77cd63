// Import: which pixels are the object: from files, alpha channels or light.
#include <tgmath.h>
#include "core/base/log.h"
#include "rig/import/grow_masks.h"
#include "rig/import/import_steps.h"
#include "rig/import/mask.h"

static bool load_mask(FfpImporting *import, int stop, FfpError *err) {
    const char *path = import->shots.masks[stop];
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    FfpView *view = &import->capture.views[stop];
    FfpImage rgba = {0};
    if (!ffp_importing_check_size(path, optics, err) || !ffp_image_read(&rgba, path, FFP_COLOUR_ENCODED, err))
        return false;
    FfpImage mask = ffp_mask_of(&rgba);
    view->coverage = ffp_optics_rectify(optics, &view->camera, &mask);
    ffp_image_free(&mask);
    ffp_image_free(&rgba);
    return true;
}

// The mask as it was asked for: a file; otherwise the white picture's alpha channel, unless Otsu's was named;
// otherwise Otsu's. Pictures that are over black by an alpha channel of their own are left alone in the
// second case.
bool ffp_importing_cover(FfpImporting *import, int stop, const FfpImage *alphas, FfpError *err) {
    const FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    const bool by_alpha = !shots->masks && import->settings->sources.mask == FFP_MASKS_ALPHA &&
                          alphas[shots->white].data != NULL;
    if (shots->masks) {
        if (!load_mask(import, stop, err)) return false;
    } else if (by_alpha) {
        view->coverage = ffp_image_copy(&alphas[shots->white]);
    } else {
        const char *path = shots->pictures[stop * FFP_PATTERNS_MAX + shots->white];
        if (!ffp_mask_otsu(&view->coverage, &import->holes[stop], &view->images[shots->black],
                           &view->images[shots->white], path, err)) {
            return false;
        }
        import->made[stop] = true; // and applied when it is complete
    }
    for (int p = 0; p < shots->n_patterns && !import->made[stop]; p++) {
        if (!by_alpha || !alphas[p].data) ffp_mask_apply(&view->coverage, &view->images[p]);
    }
    return true;
}

#define VIEWS_GROWN 4 // from which on views know enough of each other

// The shadows in them, from what the other views show.
static void add_shadows(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    int64_t covered = 0, added;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *mask = &capture->views[v].coverage;
        for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++)
            covered += mask->data[i] >= 0.5F;
    }
    ffp_capture_estimate_bounds(capture);
    if (ffp_grow_masks(capture, import->made, import->holes, &added))
        ffp_note("  shadows that the other views show lit were added to them, and holes opened that they see "
                 "through: %+.1f %% of the object's pixels",
                 100 * (double)added / fmax(1, (double)covered));
    else
        ffp_note("  too much of the object is in shadow for the other views to complete them");
}

// Masks made of light, completed where there are views enough and their poses are known, and applied.
void ffp_importing_complete_masks(FfpImporting *import) {
    const FfpCapture *capture = &import->capture;
    int made = 0;
    for (int v = 0; v < capture->n_views; v++) made += import->made[v];
    if (made == 0) return;
    ffp_note(
        "%d masks were made from white minus black (Otsu): look at them, and give files of masks if they "
        "are wrong",
        made);
    if (import->settings->axis == FFP_AXIS_KNOWN && capture->n_views >= VIEWS_GROWN)
        add_shadows(import);
    else
        ffp_note("  what the projector does not reach is left out");
    for (int v = 0; v < capture->n_views; v++)
        for (int p = 0; p < capture->n_patterns && import->made[v]; p++)
            ffp_mask_apply(&capture->views[v].coverage, &capture->views[v].images[p]);
}
