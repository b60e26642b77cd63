// From calibration files and photographs to a capture folder.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "rig/import.h"
#include "base/file.h"
#include "base/log.h"
#include "base/memory.h"
#include "capture/manifest.h"
#include "image/photograph.h"
#include "patterns/patterns.h"
#include "rig/checks.h"
#include "rig/codes.h"
#include "rig/fit_axis.h"
#include "rig/grow_masks.h"
#include "rig/mask.h"
#include "rig/panel.h"
#include "rig/response.h"

#define CHANCE_MAX 0.75 // of what chance explains: more, and the pattern explains nothing

typedef struct Import {
    const FfpImportSettings *settings;
    FfpCalibration calibration;
    FfpShots shots;
    FfpCapture capture;
    FfpResponse response; // where it is asked for
    bool *made;           // [views] masks made by Otsu's method
    FfpImage *holes;      // [views] and what was filled of them
    int64_t too_bright;   // values of pictures
    FfpDeveloped developed;
} Import;

// --- What is asked for. ---

static bool keep_chosen_stops(Import *import, FfpError *err) {
    const FfpImportSettings *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    for (int i = 0; i < calibration->n_stops; i++) calibration->stops[i].index = i;
    if (settings->n_views == 0) return true;
    if (calibration->n_pictures > 0 && settings->sources.n_images == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views",
                        "the calibration names the pictures itself: name them to choose among its views");
    bool twice = false;
    FfpStop *chosen = ffp_alloc((size_t)settings->n_views, sizeof *chosen);
    for (int i = 0; i < settings->n_views; i++) {
        int k = 0;
        while (k < calibration->n_stops && strcmp(calibration->stops[k].id, settings->views[i]) != 0) k++;
        if (k == calibration->n_stops) {
            ffp_free(chosen);
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "the calibration has no view '%.96s'",
                            settings->views[i]);
        }
        chosen[i] = calibration->stops[k];
        for (int j = 0; j < i; j++) twice = twice || strcmp(chosen[j].id, chosen[i].id) == 0;
    }
    if (twice) {
        ffp_free(chosen);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "a view is asked for twice");
    }
    ffp_free(calibration->stops);
    calibration->stops = chosen;
    calibration->n_stops = settings->n_views;
    return true;
}

// An axis that is to be found is only where the stops' poses are until then.
static bool read_turntable(const FfpImportSettings *settings, FfpTurntable *turntable, FfpError *err) {
    const bool known = settings->axis == FFP_AXIS_KNOWN;
    if (settings->turntable_file != NULL) {
        return known ? ffp_turntable_read(turntable, settings->turntable_file, err)
                     : ffp_turntable_read_angles(turntable, settings->turntable_file, err);
    }
    const FfpTurntable unknown = ffp_turntable_unknown();
    *turntable = settings->turntable != NULL ? *settings->turntable : unknown;
    if (!known) {
        memcpy(turntable->axis, unknown.axis, sizeof turntable->axis);
        memcpy(turntable->point, unknown.point, sizeof turntable->point);
    }
    return ffp_turntable_check_angles(turntable, err) && ffp_turntable_check_axis(turntable, err);
}

static bool read_rig(Import *import, FfpError *err) {
    const FfpImportSettings *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    const char *projector = settings->projector_image != NULL ? settings->projector_image : "calib";
    if (settings->n_views > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "more than %d views", FFP_VIEWS_MAX);
    if (!ffp_calibration_read(calibration, settings->calibrations, settings->n_calibrations, projector, err))
        return false;
    if (settings->turntable_file != NULL || settings->turntable != NULL || settings->axis != FFP_AXIS_KNOWN) {
        FfpTurntable *turntable = ffp_alloc(1, sizeof *turntable);
        const bool ok =
            read_turntable(settings, turntable, err) && ffp_turntable_apply(turntable, calibration, err);
        ffp_free(turntable);
        if (!ok) return false;
    } else if (calibration->n_stops == 0 && !ffp_single_stop(calibration, err)) {
        return false;
    }
    return keep_chosen_stops(import, err);
}

// --- Sizes. ---

static bool settle_projector(Import *import, FfpCamera *pinhole, FfpError *err) {
    FfpOptics *optics = &import->calibration.projector;
    const FfpPictureSize *at = &import->settings->projector;
    int width = 0, height = 0;
    const char *path = NULL;
    for (int i = 0; i < import->shots.n_patterns && path == NULL; i++) path = import->shots.patterns[i].file;
    const bool coded = path == NULL && import->settings->sources.codes != NULL;
    if (path == NULL && !coded)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns",
                        "no pattern besides black and white: nothing could be matched");
    if (coded) { // as many pixels as it was calibrated at
        path = import->settings->sources.codes;
        width = at->width > 0 ? at->width : optics->width,
        height = at->width > 0 ? at->height : optics->height;
        if (width == 0)
            return ffp_fail(
                err, FFP_ERROR_ARGUMENT, "projector.width",
                "neither the calibration nor a pattern tells the panel's size, by which Gray codes "
                "are read");
    } else if (!ffp_image_read_size(&width, &height, path, err)) {
        return false;
    }
    if (width < FFP_PATTERN_SIDE_MIN || height < FFP_PATTERN_SIDE_MIN)
        return ffp_fail(err, FFP_ERROR_FILE, path, "a pattern of %d x %d pixels is too small", width, height);
    // nepmap's matrices are those of the pictures that lie with them.
    if (import->calibration.n_pictures > 0 && optics->width == 0 && at->width == 0)
        optics->width = width, optics->height = height;
    FfpOptics panel = *optics; // as it was calibrated, whatever was done to the patterns since
    if (at->width > 0) panel.width = at->width, panel.height = at->height;
    if (!ffp_optics_settle(optics, at, width, height, "projector", path, err) ||
        !ffp_optics_check(optics, "projector", err)) {
        return false;
    }
    ffp_optics_pinhole(optics, 0, pinhole);
    if (panel.width == 0) panel.width = optics->width, panel.height = optics->height;
    ffp_panel_describe(&import->capture.panel, &panel);
    return true;
}

static bool settle_camera(Import *import, int stop, FfpError *err) {
    FfpOptics *optics = &import->calibration.stops[stop].camera;
    const FfpPictureSize *at = &import->settings->camera;
    const char *path = import->shots.pictures[stop * FFP_PATTERNS_MAX + import->shots.white];
    int width = 0, height = 0;
    if (!ffp_photograph_read_size(&width, &height, path, err)) return false;
    if (import->calibration.n_pictures > 0 && optics->width == 0 && at->width == 0)
        optics->width = width, optics->height = height;
    if (!ffp_optics_settle(optics, at, width, height, "camera", path, err) ||
        !ffp_optics_check(optics, "camera", err)) {
        return false;
    }
    ffp_optics_pinhole(optics, import->settings->width, &import->capture.views[stop].camera);
    const FfpCamera *camera = &import->capture.views[stop].camera;
    return (camera->width >= FFP_CAMERA_SIDE_MIN && camera->height >= FFP_CAMERA_SIDE_MIN &&
            camera->height <= FFP_IMAGE_SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "width", "pictures of %d x %d pixels", camera->width,
                    camera->height);
}

static void take_poses(Import *import) {
    for (int v = 0; v < import->capture.n_views; v++) {
        const FfpStop *stop = &import->calibration.stops[v];
        for (int i = 0; i < 16; i++) {
            import->capture.views[v].camera.pose[i] = (real)stop->c2w[i];
            import->capture.views[v].projector.pose[i] = (real)stop->p2w[i];
        }
    }
}

// The pattern, where Gray codes are all there is, runs across the line from projector to camera.
static bool find_codes(Import *import, FfpError *err) {
    const FfpOptics *panel = &import->calibration.projector;
    const FfpStop *stop = &import->calibration.stops[0];
    double along[2] = {0};
    for (int axis = 0; axis < 2; axis++)
        for (int k = 0; k < 3; k++)
            along[axis] += stop->p2w[4 * k + axis] * (stop->c2w[4 * k + 3] - stop->p2w[4 * k + 3]);
    return ffp_shots_find_codes(&import->shots, &import->settings->sources, &import->calibration,
                                panel->width, panel->height, fabs(along[1]) > fabs(along[0]), err);
}

static bool settle_views(Import *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    FfpCamera projector;
    if (!settle_projector(import, &projector, err) || !find_codes(import, err)) return false;
    capture->n_views = import->calibration.n_stops;
    capture->views = ffp_alloc((size_t)capture->n_views, sizeof *capture->views);
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        const FfpStop *stop = &import->calibration.stops[v];
        if (!settle_camera(import, v, err)) return false;
        memcpy(view->id, stop->id, sizeof view->id);
        view->projector = projector;
    }
    take_poses(import);
    return true;
}

// Refuses what would not fit the machine's memory before any of it is taken: the result, and one source.
static bool check_memory(const Import *import, FfpError *err) {
    const FfpCapture *capture = &import->capture;
    double values = 3.0 * capture->views[0].projector.width * capture->views[0].projector.height *
                    import->shots.n_patterns;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        const FfpOptics *optics = &import->calibration.stops[v].camera;
        values += (3.0 * import->shots.n_patterns + 8) * camera->width * camera->height;
        if (v == 0) values += 8.0 * optics->width * optics->height;
    }
    return ffp_memory_suffices(values * sizeof(real), "the pictures", "make them narrower", "width", err);
}

// --- Pixels. ---

static bool has_size(const char *path, int width, int height, const FfpOptics *optics, FfpError *err) {
    return (width == optics->width && height == optics->height) ||
           ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, the others have %d x %d", width, height,
                    optics->width, optics->height);
}

static bool check_size(const char *path, const FfpOptics *optics, FfpError *err) {
    int width = 0, height = 0;
    return ffp_image_read_size(&width, &height, path, err) && has_size(path, width, height, optics, err);
}

// The light of the Gray code with this number.
static FfpImage code_pattern(const FfpOptics *panel, int index) {
    const int columns = ffp_gray_code_bits(panel->width), pair = index / 2, axis = pair >= columns;
    FfpImage grey = ffp_pattern_gray_code(panel->width, panel->height, axis, axis ? pair - columns : pair,
                                          index % 2 == 1);
    FfpImage out = ffp_image_new(panel->width, panel->height, 3);
    const size_t count = 3 * (size_t)out.width * (size_t)out.height;
    for (size_t i = 0; i < count; i++) out.data[i] = grey.data[i / 3];
    ffp_image_free(&grey);
    return out;
}

static bool load_pattern(Import *import, int index, FfpError *err) {
    FfpPattern *pattern = &import->capture.patterns[index];
    const FfpShotPattern *shot = &import->shots.patterns[index];
    const FfpOptics *optics = &import->calibration.projector;
    const FfpCamera *pinhole = &import->capture.views[0].projector;
    FfpImage raw = {0};
    memcpy(pattern->name, shot->name, sizeof pattern->name);
    pattern->novel = shot->novel;
    if (shot->file != NULL) {
        if (!check_size(shot->file, optics, err) ||
            !(import->settings->linear_patterns ? ffp_image_read_light
                                                : ffp_image_read_over_black)(&raw, NULL, shot->file, err))
            return false;
    } else if (shot->code > 0) {
        raw = code_pattern(optics, shot->code - 1);
    } else {
        raw = ffp_image_new(optics->width, optics->height, 3);
        const ptrdiff_t count = (ptrdiff_t)raw.width * raw.height * 3;
        for (ptrdiff_t i = 0; i < count; i++) raw.data[i] = index == import->shots.white;
    }
    pattern->image = ffp_optics_rectify(optics, pinhole, &raw);
    ffp_image_free(&raw);
    return true;
}

// Exposure of linear values; what then exceeds 1 is cut off when the capture is written, and counted.
static void expose(Import *import, FfpImage *image) {
    const real factor = (real)exp2(import->settings->exposure);
    const ptrdiff_t count = (ptrdiff_t)image->width * image->height * 3;
    for (ptrdiff_t i = 0; i < count; i++) {
        image->data[i] *= factor;
        import->too_bright += image->data[i] > 1.002F;
    }
}

// An alpha channel that is 1 everywhere tells nothing: programs add such to any picture.
static bool tells_shape(const FfpImage *alpha) {
    const ptrdiff_t pixels = alpha->data != NULL ? (ptrdiff_t)alpha->width * alpha->height : 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (alpha->data[i] < 1) return true;
    }
    return false;
}

// *alpha stays empty when the file has none.
static bool load_picture(Import *import, int stop, int pattern, FfpImage *alpha, FfpError *err) {
    const char *path = import->shots.pictures[stop * FFP_PATTERNS_MAX + pattern];
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    FfpView *view = &import->capture.views[stop];
    FfpImage raw = {0}, raw_alpha = {0};
    if (!ffp_photograph_read(&raw, &raw_alpha, path, import->settings->linear_images, &import->developed,
                             err) ||
        !has_size(path, raw.width, raw.height, optics, err)) {
        ffp_image_free(&raw);
        ffp_image_free(&raw_alpha);
        return false;
    }
    expose(import, &raw);
    view->images[pattern] = ffp_optics_rectify(optics, &view->camera, &raw);
    if (tells_shape(&raw_alpha)) *alpha = ffp_optics_rectify(optics, &view->camera, &raw_alpha);
    ffp_image_free(&raw);
    ffp_image_free(&raw_alpha);
    return true;
}

static bool load_mask(Import *import, int stop, FfpError *err) {
    const char *path = import->shots.masks[stop];
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    FfpView *view = &import->capture.views[stop];
    FfpImage rgba = {0};
    if (!check_size(path, optics, err) || !ffp_image_read(&rgba, path, FFP_COLOUR_ENCODED, err)) return false;
    FfpImage mask = ffp_mask_of(&rgba);
    view->coverage = ffp_optics_rectify(optics, &view->camera, &mask);
    ffp_image_free(&mask);
    ffp_image_free(&rgba);
    return true;
}

// The mask as it was asked for: a file; else the white picture's alpha channel, unless Otsu's was named; else
// Otsu's. Pictures that are over black by an alpha channel of their own are left alone in the second case.
static bool cover(Import *import, int stop, const FfpImage *alphas, FfpError *err) {
    const FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    const bool by_alpha = shots->masks == NULL && import->settings->sources.mask == FFP_MASKS_ALPHA &&
                          alphas[shots->white].data != NULL;
    if (shots->masks != NULL) {
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
        if (!by_alpha || alphas[p].data == NULL) ffp_mask_apply(&view->coverage, &view->images[p]);
    }
    return true;
}

static bool load_view(Import *import, int stop, FfpError *err) {
    const int n = import->shots.n_patterns;
    FfpView *view = &import->capture.views[stop];
    FfpImage *alphas = ffp_alloc((size_t)n, sizeof *alphas);
    bool ok = true;
    view->images = ffp_alloc((size_t)n, sizeof *view->images);
    for (int p = 0; p < n && ok; p++) {
        if (import->shots.pictures[stop * FFP_PATTERNS_MAX + p] != NULL)
            ok = load_picture(import, stop, p, &alphas[p], err);
    }
    ok = ok && cover(import, stop, alphas, err);
    for (int p = 0; p < n; p++) ffp_image_free(&alphas[p]);
    ffp_free(alphas);
    return ok;
}

static void note_developed(const FfpDeveloped *developed) {
    if (developed->raws > 0)
        ffp_note(
            "%d raw photographs were developed by dcraw_emu to linear light, with one white balance for all",
            developed->raws);
    if (developed->films > 0)
        ffp_note("%d films were read by ffmpeg, each as the mean of its frames (%d frames)", developed->films,
                 developed->frames);
}

#define VIEWS_GROWN 4 // from which on views know enough of each other

// The shadows in them, from what the other views show.
static void add_shadows(Import *import) {
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
static void complete_masks(Import *import) {
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

static bool load_pixels(Import *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    import->made = ffp_alloc((size_t)capture->n_views, sizeof *import->made);
    import->holes = ffp_alloc((size_t)capture->n_views, sizeof *import->holes);
    capture->n_patterns = import->shots.n_patterns;
    capture->patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *capture->patterns);
    capture->black = import->shots.black, capture->white = import->shots.white;
    for (int p = 0; p < capture->n_patterns; p++) {
        if (!load_pattern(import, p, err)) return false;
    }
    FfpTask progress = ffp_task("importing", capture->n_views);
    bool ok = true;
    for (int v = 0; v < capture->n_views && ok; v++) {
        ok = load_view(import, v, err);
        if (ok) ffp_task_step(&progress, v + 1, capture->views[v].id);
    }
    ffp_task_end(&progress);
    if (ok) note_developed(&import->developed);
    if (ok) complete_masks(import);
    return ok;
}

// --- Gray codes. ---

#define FINE_SUM_MIN 0.75 // of white
#define CLIPPED_MAX 0.2   // of the light pixels, under white
#define CODES_OFF_MAX 3.0 // pixels: median by which the codes may contradict the calibration

static bool decode_view(Import *import, int stop, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const FfpOptics *camera = &import->calibration.stops[stop].camera,
                    *panel = &import->calibration.projector;
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
        "view '%s': Gray codes decode at %.1f %% of the lit pixels, %d of the object's; median distance from "
        "the camera's rays %.2f pixels of the projector",
        view->id, 100.0 * report.decoded / report.lit, fit.kept, fit.off);
    if (report.dropped[0] > 0 || report.dropped[1] > 0)
        ffp_note("  the finest %d codes of columns and %d of rows are too fine for the photographs",
                 report.dropped[0], report.dropped[1]);
    if (report.clipped > CLIPPED_MAX)
        ffp_note("  under white %.0f %% of the light pixels are overexposed: expose shorter",
                 100 * report.clipped);
    if (report.fine_sum < FINE_SUM_MIN && !import->settings->linear_images)
        ffp_note("  the finest codes and their inverses add up to %.2f of white: the photographs' values "
                 "look like "
                 "linear light, which `linear` images are",
                 report.fine_sum);
    return (fit.known > 0 && fit.off <= CODES_OFF_MAX) ||
           ffp_fail(
               err, FFP_ERROR_FILE, "gray_codes",
               "view '%s': of %d decoded positions half lie %.1f or more pixels of the projector beside "
               "where the calibration has them: check the order of the photographs (coarsest first, columns "
               "before rows, each followed by its inverse), the projector's size and the poses",
               view->id, fit.known, fit.off);
}

static bool load_codes(Import *import, FfpError *err) {
    if (import->shots.codes == NULL) return true;
    FfpTask progress = ffp_task("decoding", import->capture.n_views);
    bool ok = true;
    for (int v = 0; v < import->capture.n_views && ok; v++) {
        ok = decode_view(import, v, err);
        if (ok) ffp_task_step(&progress, v + 1, import->capture.views[v].id);
    }
    ffp_task_end(&progress);
    return ok;
}

// --- The projector's response from the pictures. ---

static void log_response(const FfpResponse *r, double before, double after) {
    ffp_note(
        "projector gamma %.3f %.3f %.3f (+- %.2g %.2g %.2g), from %d pixels; pattern lookup %.1f dB, before "
        "%.1f",
        r->gamma[0], r->gamma[1], r->gamma[2], r->gamma_deviation[0], r->gamma_deviation[1],
        r->gamma_deviation[2], r->samples, -20 * log10(after), -20 * log10(before));
    ffp_note("  black level %s%.4f %.4f %.4f of white%s", r->black_known ? "" : "at most ", r->black[0],
             r->black[1], r->black[2],
             r->black_known ? "" : " (the room's light hides it: photograph in the dark to know)");
}

// Patterns become the light that the projector made of them.
static bool find_response(Import *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    const bool linear = import->settings->linear_patterns;
    capture->panel.power = linear || import->settings->fit_response;
    for (int c = 0; c < 3; c++) capture->panel.gamma[c] = 1;
    if (!import->settings->fit_response) return true;
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    if (active < 0 || !ffp_fit_response(&import->response, capture, active, linear, err)) return false;
    const double before = ffp_rig_explain(capture, active).error;
    for (int p = 0; p < capture->n_patterns; p++) {
        if (p != capture->black && p != capture->white)
            ffp_response_apply(&import->response, linear, &capture->patterns[p].image);
    }
    for (int c = 0; c < 3; c++) {
        capture->intensity[c] = (real)import->response.intensity;
        capture->panel.gamma[c] = (real)import->response.gamma[c];
    }
    capture->intensity_known = true;
    const FfpExplanation found = ffp_rig_explain(capture, active);
    if (!(found.error < CHANCE_MAX * found.chance))
        return ffp_fail(err, FFP_ERROR_FILE, "fit_response",
                        "with the best response the pattern explains the pictures hardly better than chance: "
                        "check poses and the pattern's file");
    log_response(&import->response, before, found.error);
    return true;
}

// Puts the response into the capture's JSON: what was found is kept though patterns hold it already.
static bool keep_response(const char *folder, void *context, FfpError *err) {
    const Import *import = context;
    char path[FFP_PATH_MAX];
    FfpField root;
    const FfpResponse *r = &import->response;
    if (!import->settings->fit_response) return true;
    if (!ffp_join_path(path, folder, "scene.json"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    if (!ffp_field_open(&root, path, err)) return false;
    json_t *response =
        json_pack("{s:[f,f,f], s:[f,f,f], s:b}", "gamma", r->gamma[0], r->gamma[1], r->gamma[2],
                  "black_level", r->black[0], r->black[1], r->black[2], "black_level_known", r->black_known);
    json_object_set_new(json_object_get(root.value, "projector"), "response", response);
    char *text = json_dumps(root.value, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    ffp_field_close(&root);
    const bool ok = text != NULL ? ffp_write_file(path, text, strlen(text), err)
                                 : ffp_fail(err, FFP_ERROR_IO, path, "cannot write the JSON");
    free(text);
    return ok;
}

// --- The turntable's axis from the pictures. ---

#define MISFIT_MAX 0.1 // of the object's pixels, which an axis that is right leaves unexplained by the others

static FfpAxis guess_of(const FfpImportSettings *settings) {
    FfpAxis guess;
    FfpTurntable turntable = *settings->turntable; // its direction brought to length 1
    ffp_turntable_check_axis(&turntable, NULL);
    memcpy(guess.direction, turntable.axis, sizeof guess.direction);
    memcpy(guess.point, turntable.point, sizeof guess.point);
    return guess;
}

static void place_stops(Import *import, const FfpAxis *axis, bool reversed) {
    FfpTurntable *turntable = ffp_alloc(1, sizeof *turntable);
    memcpy(turntable->axis, axis->direction, sizeof turntable->axis);
    memcpy(turntable->point, axis->point, sizeof turntable->point);
    ffp_turntable_place(turntable, reversed, &import->calibration);
    ffp_free(turntable);
    take_poses(import);
}

// What the whole capture says about the axis found, to the user; refuses one that explains it badly.
static bool accept_axis(Import *import, const FfpAxis *axis, const FfpAxisReport *report, int active,
                        FfpError *err) {
    FfpCapture *capture = &import->capture;
    ffp_capture_estimate_bounds(capture);
    const double misfit = ffp_rig_silhouette_misfit(capture);
    const FfpExplanation found = ffp_rig_explain(capture, active);
    ffp_note("axis found: direction and point %.6g,%.6g,%.6g,%.6g,%.6g,%.6g%s", axis->direction[0],
             axis->direction[1], axis->direction[2], axis->point[0], axis->point[1], axis->point[2],
             report->reversed ? ", with the angles' signs changed: the object turned the other way" : "");
    ffp_note("  uncertain by %.2g degrees and %.2g %% of the distance; silhouettes agree within %.2f pixels "
             "(overlap with the visual hull %.1f %%), surfaces of neighbouring stops within %.2f %% of the "
             "distance (%d points)",
             report->tilt, 100 * report->shift, report->outline, 100 * (1 - misfit), 100 * report->surface,
             report->surface_points);
    ffp_note("  pattern lookup %.1f dB (by chance %.1f)", -20 * log10(found.error),
             -20 * log10(found.chance));
    if (misfit > MISFIT_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, "turntable.axis",
                        "with the best axis %.0f %% of the object's pixels contradict the other views' "
                        "silhouettes: check angles, order of pictures and masks",
                        100 * misfit);
    return (found.pixels > 0 && found.error < CHANCE_MAX * found.chance) ||
           ffp_fail(
               err, FFP_ERROR_FILE, "turntable.axis",
               "with the best axis the pattern explains the pictures hardly better than chance: check the "
               "pattern's file and the calibration");
}

static bool find_axis(Import *import, FfpError *err) {
    const FfpCapture *capture = &import->capture;
    if (import->settings->axis == FFP_AXIS_KNOWN) return true;
    const bool guessed = import->settings->axis == FFP_AXIS_GUESSED;
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    FfpAxis axis, guess;
    FfpAxisReport report;
    double angles[FFP_VIEWS_MAX];
    if (active < 0) return false;
    if (guessed) guess = guess_of(import->settings);
    for (int v = 0; v < capture->n_views; v++) angles[v] = import->calibration.stops[v].angle;
    if (!ffp_fit_axis(&axis, &report, capture, active, import->calibration.p2c, angles,
                      guessed ? &guess : NULL, err))
        return false;
    place_stops(import, &axis, report.reversed);
    return accept_axis(import, &axis, &report, active, err);
}

static bool settle_object(Import *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    const double *object = import->settings->object;
    ffp_capture_estimate_bounds(capture);
    if (!(object[3] > 0)) {
        if (import->shots.codes != NULL) ffp_codes_bounds(capture);
        return true;
    }
    for (int i = 0; i < 4; i++) {
        if (!(fabs(object[i]) < 1e9))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "object", "%g is too large", object[i]);
    }
    for (int i = 0; i < 3; i++) capture->centre[i] = (real)object[i];
    capture->radius = (real)object[3];
    return true;
}

static bool name_capture(Import *import, FfpError *err) {
    char folder[FFP_PATH_MAX];
    const char *name = import->settings->name;
    size_t length = strlen(import->settings->folder);
    if (length == 0 || length >= sizeof folder)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "folder", "not a path for a folder");
    memcpy(folder, import->settings->folder, length + 1);
    while (length > 1 && folder[length - 1] == '/') folder[--length] = 0;
    if (name != NULL && !ffp_is_name(name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "name", "'%.100s' is no name", name);
    if (name == NULL) name = ffp_is_name(ffp_basename(folder)) ? ffp_basename(folder) : "capture";
    snprintf(import->capture.name, sizeof import->capture.name, "%s", name);
    return ffp_capture_probe(folder, err);
}

static bool check_settings(const FfpImportSettings *settings, FfpError *err) {
    if (settings->folder == NULL) return ffp_fail(err, FFP_ERROR_ARGUMENT, "folder", "none is given");
    if (settings->axis != FFP_AXIS_GUESSED) return true;
    if (settings->turntable == NULL)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "turntable", "there is no axis to begin at");
    FfpTurntable turntable = *settings->turntable;
    return ffp_turntable_check_axis(&turntable, err);
}

static bool run(Import *import, FfpError *err) {
    return check_settings(import->settings, err) && name_capture(import, err) && read_rig(import, err) &&
           ffp_shots_find(&import->shots, &import->settings->sources, &import->calibration, err) &&
           settle_views(import, err) && check_memory(import, err) && load_pixels(import, err) &&
           load_codes(import, err) && find_axis(import, err) && settle_object(import, err) &&
           find_response(import, err) &&
           ffp_capture_write_whole(&import->capture, import->settings->folder, keep_response, import, err);
}

bool ffp_import(const FfpImportSettings *settings, FfpError *err) {
    Import *import = ffp_alloc(1, sizeof *import);
    import->settings = settings;
    const bool ok = run(import, err);
    for (int v = 0; import->holes != NULL && v < import->capture.n_views; v++)
        ffp_image_free(&import->holes[v]);
    ffp_free(import->holes), ffp_free(import->made);
    ffp_capture_free(&import->capture);
    ffp_shots_free(&import->shots);
    ffp_calibration_free(&import->calibration);
    ffp_free(import);
    return ok;
}
