// Import: photographs of Gray codes as positions in the projector's picture.
#include <math.h>
#include <string.h>
#include "core/base/log.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/codes.h"
#include "rig/import/import_steps.h"

#define PIXELS_LEFT 2.0
#define PANEL_LEFT 2.0
#define LOOKED_AT 8       // codes at least, whose photographs tell how soft patterns are
#define HELD_OUT 2        // codes that no fit sees
#define CODES_OFF_MAX 3.0 // pixels: median by which the codes may contradict the calibration

int ffp_importing_codes_held_out(const FfpImporting *import) {
    if (!import->shots.codes || import->settings->kept_codes == 0) return 0;
    for (int p = 0; p < import->shots.n_patterns; p++)
        if (import->shots.patterns[p].novel) return 0;
    return HELD_OUT;
}

int ffp_importing_codes_looked_at(const FfpImporting *import) {
    const int kept = import->settings->kept_codes;
    if (!import->shots.codes) return 0;
    return (kept > LOOKED_AT ? kept : LOOKED_AT) + ffp_importing_codes_held_out(import);
}

// *first: the first of them, -1: none.
static int count_missing(const FfpImporting *import, int stop, int *first) {
    const int n = import->shots.n_codes;
    int missing = 0;
    *first = -1;
    for (int i = n - 1; i >= 0; i--) {
        if (import->shots.codes[(ptrdiff_t)stop * n + i]) continue;
        *first = i, missing++;
    }
    return missing;
}

// Notes the quality of a view's photographs of the codes.
static void note_report(const FfpImporting *import, const FfpView *view, const FfpGrayReport *report,
                        const FfpCodesFit *fit) {
    ffp_note("view '%s': Gray codes decoded at %.1f %% of the lit pixels, %d of the object's; median "
             "distance from "
             "the camera's rays %.2f pixels of the projector",
             view->id, 100.0 * report->decoded / report->lit, fit->kept, fit->off);
    int first;
    char name[32];
    const int missing = count_missing(import, (int)(view - import->capture.views), &first);
    if (missing > 0) {
        ffp_gray_code_name(import->coded.width, first, name);
        ffp_note("  %d of %d photographs of Gray codes are missing, first that of %s", missing,
                 import->shots.n_codes, name);
    }
    if (report->dropped[0] > 0 || report->dropped[1] > 0)
        ffp_note("  the finest %d codes of columns and %d of rows are too fine for the photographs",
                 report->dropped[0], report->dropped[1]);
    ffp_gray_tell_light(report, view->id);
    ffp_gray_note_clipped(report, view->id);
}

// The view's correspondence from the decoded map, checked against the poses.
static bool place_codes(FfpImporting *import, int stop, const FfpOptics *camera, const FfpImage *map,
                        const FfpGrayReport *report, bool silent, FfpError *err) {
    FfpView *view = &import->capture.views[stop];
    view->correspondence =
        ffp_codes_rectify(map, report->step, camera, &view->camera, &import->coded, &view->projector);
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    for (ptrdiff_t i = 0; i < pixels; i++)
        if (!(view->coverage.data[i] > 0)) memset(view->correspondence.data + 3 * i, 0, 3 * sizeof(real));
    const int bits[2] = {ffp_gray_code_bits(import->coded.width), ffp_gray_code_bits(import->coded.height)};
    for (int axis = 0; axis < 2; axis++)
        import->unlike[axis] |= report->unlike[axis] | ~0U << (bits[axis] - report->dim[axis]);
    import->code_step = fmax(import->code_step, report->step * camera->fx / (double)view->camera.fx);
    if (import->settings->other_projector) {
        ffp_note("view '%s': Gray codes decoded at %.1f %% of the lit pixels", view->id,
                 100.0 * report->decoded / report->lit);
        ffp_gray_tell_light(report, view->id);
        return true;
    }
    const double panel = hypot(import->coded.width, import->coded.height);
    FfpCodesFit fit = ffp_codes_check(view);
    fit.off = fmin(fit.off, panel); // infinite behind the projector
    if (!silent) note_report(import, view, report, &fit);
    return (fit.known > 0 && fit.off <= CODES_OFF_MAX) ||
           ffp_fail_by(
               FFP_RULE_CODES_ELSEWHERE,
               &(FfpFacts){.view = view->id, .x = fit.known, .figure = fit.off, .limit = CODES_OFF_MAX},
               "gray_codes", err);
}

// By what the photographs are reduced before: down to two pixels a side for one of the capture or the panel.
static int shrink_by(const FfpImporting *import, int stop) {
    const FfpOptics *camera = &import->calibration.stops[stop].camera, *panel = &import->coded;
    const double panel_pixels = (double)panel->width * panel->height;
    return ffp_optics_shrink_by(
        camera, fmin(camera->fx / (double)import->capture.views[stop].camera.fx / PIXELS_LEFT,
                     sqrt((double)camera->width * camera->height / panel_pixels) / PANEL_LEFT));
}

// The view's codes are in another order than was said: so is the picture under the one that is a pattern.
static bool relabel(FfpImporting *import, int stop, const char *const *codes, FfpError *err) {
    FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    memcpy(shots->codes + (ptrdiff_t)stop * shots->n_codes, codes, (size_t)shots->n_codes * sizeof *codes);
    for (int p = 0; p < shots->n_patterns; p++) {
        const int code = shots->patterns[p].code;
        const char **picture = &shots->pictures[(ptrdiff_t)stop * FFP_PATTERNS_MAX + p];
        FfpImage alpha = {0};
        if (code == 0 || *picture == codes[code - 1]) continue;
        if (!codes[code - 1])
            return ffp_fail(
                err, FFP_ERROR_FILE, *picture,
                "shows a pattern of the object, but is left out of the codes: photograph it again");
        *picture = codes[code - 1];
        ffp_image_free(&view->images[p]);
        if (!ffp_importing_read_picture(import, *picture, stop, &view->images[p], &alpha, err)) return false;
        if (!alpha.data) ffp_mask_apply(&view->coverage, &view->images[p]);
        ffp_image_free(&alpha);
    }
    return true;
}

// Decodes a view's photographs, as linear light or not; what is only tried is silent.
static bool decode(FfpImporting *import, int stop, bool linear, FfpError *err) {
    const FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    const int shrink = shrink_by(import, stop);
    const FfpOptics camera = ffp_optics_shrunk(&import->calibration.stops[stop].camera, shrink);
    FfpGrayCache cache = {.n = 0};
    FfpImage map = {0}, region = ffp_codes_region(&view->coverage, &view->camera, &camera);
    const FfpGrayPhotographs from = {.width = import->coded.width,
                                     .height = import->coded.height,
                                     .codes = shots->codes + (ptrdiff_t)stop * shots->n_codes,
                                     .black = pictures[shots->black],
                                     .white = pictures[shots->white],
                                     .shrink = shrink,
                                     .others = shots->others,
                                     .linear = linear,
                                     .cache = &cache,
                                     .region = &region};
    FfpGrayReport report;
    bool ok = ffp_gray_decode_view(&map, &report, &from, err);
    if (ok && cache.other) ok = relabel(import, stop, cache.other, err);
    const bool silent = linear != import->settings->linear_images;
    ok = ok && place_codes(import, stop, &camera, &map, &report, silent, err);
    ffp_gray_cache_free(&cache);
    ffp_image_free(&map);
    ffp_image_free(&region);
    return ok;
}

// Where sRGB does not fit and linear light does, that is the error.
static bool decode_view(FfpImporting *import, int stop, FfpError *err) {
    FfpError error = {0}, other = {0};
    if (decode(import, stop, import->settings->linear_images, &error)) return true;
    int first;
    const int missing = count_missing(import, stop, &first), n = import->shots.n_codes;
    if (err) *err = error;
    if (missing > 0)
        ffp_fail_by(FFP_RULE_CODES_MISSING, &(FfpFacts){.x = n - missing, .y = n, .a = error.text}, NULL,
                    err);
    if (err) err->code = error.code;
    if (import->settings->linear_images || error.code != FFP_ERROR_FILE || stop > 0) return false;
    ffp_image_free(&import->capture.views[stop].correspondence);
    if (!decode(import, stop, true, &other)) return false;
    ffp_image_free(&import->capture.views[stop].correspondence);
    return ffp_fail(err, FFP_ERROR_ARGUMENT, "linear_images",
                    "the photographs hold linear light, not sRGB: read as such, those of Gray codes fit "
                    "together; import them as linear images");
}

// A view whose photographs are at fault does without codes: its depth is matched. Other errors end the call.
static bool leave_out(FfpView *view, const FfpError *error, FfpError *err) {
    if (error->code != FFP_ERROR_FILE && error->code != FFP_ERROR_IO &&
        error->code != FFP_ERROR_UNSUPPORTED) {
        if (err) *err = *error;
        return false;
    }
    ffp_image_free(&view->correspondence);
    ffp_tell(FFP_RULE_CODES_LEFT_OUT, &(FfpFacts){.view = view->id, .a = error->text});
    return true;
}

bool ffp_importing_load_codes(FfpImporting *import, FfpError *err) {
    if (!import->shots.codes) return true;
    FfpTask progress = ffp_task("decoding", import->capture.n_views);
    FfpError first = {0};
    int decoded = 0;
    bool ok = true, failed = false;
    for (int v = 0; v < import->capture.n_views && ok; v++) {
        FfpView *view = &import->capture.views[v];
        FfpError error = {0};
        const bool done = decode_view(import, v, &error);
        if (!done && !failed) first = error;
        failed = failed || !done;
        decoded += done;
        ok = done || import->capture.n_views == 1 || leave_out(view, &error, err);
        if (ok) ffp_task_step(&progress, v + 1, view->id);
    }
    ffp_task_end(&progress);
    if (ok && decoded == 0 && err) *err = first;
    return ok && decoded > 0;
}
