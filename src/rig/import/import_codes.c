// Import: photographs of Gray codes as positions in the projector's picture.
#include <string.h>
#include "core/base/log.h"
#include "rig/import/codes.h"
#include "rig/import/import_steps.h"

#define FINE_SUM_MIN 0.75 // of white
#define CLIPPED_MAX 0.2   // of the light pixels, under white
#define CODES_OFF_MAX 3.0 // pixels: median by which the codes may contradict the calibration

static bool decode_view(FfpImporting *import, int stop, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const FfpOptics *camera = &import->calibration.stops[stop].camera, *panel = &import->coded;
    FfpView *view = &import->capture.views[stop];
    const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    const FfpGrayPhotographs from = {.width = panel->width,
                                     .height = panel->height,
                                     .codes = shots->codes + (ptrdiff_t)stop * shots->n_codes,
                                     .black = pictures[shots->black],
                                     .white = pictures[shots->white],
                                     .linear = import->settings->linear_images};
    FfpImage map = {0};
    FfpGrayReport report;
    if (!ffp_gray_decode_view(&map, &report, &from, err)) return false;
    view->correspondence =
        ffp_codes_rectify(&map, report.step, camera, &view->camera, panel, &view->projector);
    ffp_image_free(&map);
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    for (ptrdiff_t i = 0; i < pixels; i++)
        if (!(view->coverage.data[i] > 0)) memset(view->correspondence.data + 3 * i, 0, 3 * sizeof(real));
    const FfpCodesFit fit = ffp_codes_check(view);
    ffp_note(
        "view '%s': Gray codes decoded at %.1f %% of the lit pixels, %d of the object's; median distance "
        "from the camera's rays %.2f pixels of the projector",
        view->id, 100.0 * report.decoded / report.lit, fit.kept, fit.off);
    if (report.dropped[0] > 0 || report.dropped[1] > 0)
        ffp_note("  the finest %d codes of columns and %d of rows are too fine for the photographs",
                 report.dropped[0], report.dropped[1]);
    if (report.clipped > CLIPPED_MAX)
        ffp_note("  under white %.0f %% of the light pixels are overexposed: shorten the exposure",
                 100 * report.clipped);
    if (report.fine_sum < FINE_SUM_MIN && !import->settings->linear_images)
        ffp_note("  the finest codes and their inverses add up to %.2f of white: the photographs' values "
                 "look like "
                 "linear light: if they are, import them as linear images",
                 report.fine_sum);
    return (fit.known > 0 && fit.off <= CODES_OFF_MAX) ||
           ffp_fail(err, FFP_ERROR_FILE, "gray_codes",
                    "view '%s': half of %d decoded positions are %.1f or more projector pixels away from "
                    "where the calibration puts them: check the order of the photographs (coarsest first, "
                    "columns before rows, each followed by its inverse), the projector's size and the poses",
                    view->id, fit.known, fit.off);
}

bool ffp_importing_load_codes(FfpImporting *import, FfpError *err) {
    if (!import->shots.codes) return true;
    FfpTask progress = ffp_task("decoding", import->capture.n_views);
    bool ok = true;
    for (int v = 0; v < import->capture.n_views && ok; v++) {
        ok = decode_view(import, v, err);
        if (ok) ffp_task_step(&progress, v + 1, import->capture.views[v].id);
    }
    ffp_task_end(&progress);
    return ok;
}
