// Import of a whole scene: everything that a camera saw belongs to it.
#include "rig/import/import_steps.h"
#include "rig/masks/masks.h"

bool ffp_importing_check_scene(const FfpImporting *import, FfpError *err) {
    const FfpImport *settings = import->settings;
    if (!settings->scene) return true;
    if (settings->masks != FFP_MASKS_FROM_ALPHA || settings->n_empty > 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, settings->n_empty > 0 ? "empty" : "masks",
                        "a whole scene has no masks");
    return !settings->turntable.find_axis ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "turntable", "nothing turns in a whole scene");
}

void ffp_importing_cover_scene(FfpImporting *import, int stop) {
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    FfpView *view = &import->capture.views[stop];
    FfpImage whole = ffp_image_new(optics->width, optics->height, 1);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)whole.width * whole.height; i++) whole.data[i] = 1;
    view->coverage = ffp_optics_rectify(optics, &view->camera, &whole);
    ffp_image_free(&whole);
    for (int p = 0; p < import->shots.n_patterns; p++) ffp_mask_apply(&view->coverage, &view->images[p]);
}
