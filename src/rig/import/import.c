// From calibration files and photographs to a capture folder: the order of the steps (import_steps.h).
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/file.h"
#include "core/base/memory.h"
#include "rig/graycode/codes.h"
#include "rig/import/import_steps.h"

// Refuses what would not fit the machine's memory before any of it is taken: the result, and one source.
static bool check_memory(const FfpImporting *import, FfpError *err) {
    const FfpCapture *capture = &import->capture;
    const int patterns = import->shots.n_patterns + ffp_importing_codes_looked_at(import);
    double values = 3.0 * capture->views[0].projector.width * capture->views[0].projector.height * patterns;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        const FfpOptics *optics = &import->calibration.stops[v].camera;
        values += (3.0 * patterns + 8) * camera->width * camera->height;
        if (v == 0) values += 8.0 * FFP_IMPORT_READERS * optics->width * optics->height;
        if (import->shots.empty) values += 3.0 * import->shots.n_patterns * camera->width * camera->height;
    }
    return ffp_memory_suffices(values * sizeof(real), "the pictures", "make them narrower", "width", err);
}

static bool settle_object(FfpImporting *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    const double *object = import->settings->object;
    const bool codes = import->shots.codes != NULL;
    if (!(codes && capture->scene && ffp_codes_scene_bounds(capture))) ffp_capture_estimate_bounds(capture);
    if (!(object[3] > 0)) {
        if (codes && !capture->scene) ffp_codes_bounds(capture);
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

static bool name_capture(FfpImporting *import, FfpError *err) {
    char folder[FFP_PATH_MAX];
    const char *name = import->settings->name;
    size_t length = strlen(import->settings->folder);
    if (length == 0 || length >= sizeof folder)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "folder", "not a path for a folder");
    memcpy(folder, import->settings->folder, length + 1);
    while (length > 1 && folder[length - 1] == '/') folder[--length] = 0;
    if (name && !ffp_is_name(name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "name", "invalid name '%.100s'", name);
    if (!name) name = ffp_is_name(ffp_basename(folder)) ? ffp_basename(folder) : "capture";
    snprintf(import->capture.name, sizeof import->capture.name, "%s", name);
    return ffp_capture_probe(folder, err);
}

static bool check_settings(const FfpImport *settings, FfpError *err) {
    return (settings->kept_codes >= 0 && settings->kept_codes <= FFP_CODES_MOST) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "kept_codes", "%d is not in 0 to %d", settings->kept_codes,
                    FFP_CODES_MOST);
}

bool ffp_importing_finish(const char *folder, void *context, FfpError *err) {
    return ffp_importing_keep_response(folder, context, err) &&
           ffp_importing_keep_size(folder, context, err) && ffp_importing_write_sheet(folder, context, err) &&
           ffp_importing_write_masks(folder, context, err);
}

static bool find_axis(FfpImporting *import, FfpError *err) {
    const FfpImportTurntable *turntable = &import->settings->turntable;
    return !turntable->find_axis ||
           ffp_turntable_find(turntable, &import->calibration, &import->capture, err);
}

static bool fit_object(FfpImporting *import) {
    ffp_importing_fit_object(import);
    return true;
}

static bool make_capture(FfpImporting *import, FfpError *err) {
    return check_settings(import->settings, err) && ffp_importing_check_scene(import, err) &&
           name_capture(import, err) && ffp_importing_read_rig(import, err) &&
           ffp_shots_find(&import->shots, import->settings, &import->calibration, err) &&
           ffp_importing_check_tags(import, err) && ffp_importing_settle_views(import, err) &&
           fit_object(import) && check_memory(import, err) && ffp_importing_load_pixels(import, err) &&
           ffp_importing_load_stage(import, err) && ffp_importing_complete_masks(import, err) &&
           ffp_importing_load_codes(import, err) && find_axis(import, err) && settle_object(import, err) &&
           ffp_importing_look_at_codes(import, err) && ffp_importing_find_response(import, err);
}

static bool run(FfpImporting *import, FfpError *err) {
    import->capture.scene = import->settings->scene;
    if (!make_capture(import, err)) return false;
    ffp_importing_tell_size(import);
    if (!import->settings->other_projector) ffp_importing_find_softness(import);
    ffp_importing_keep_codes(import);
    return ffp_capture_write_whole(&import->capture, import->settings->folder, ffp_importing_finish, import,
                                   err);
}

bool ffp_import(const FfpImport *settings, FfpError *err) {
    FfpImporting *import = ffp_alloc(1, sizeof *import);
    import->settings = settings;
    const bool ok = run(import, err);
    for (int v = 0; import->holes && v < import->capture.n_views; v++) ffp_image_free(&import->holes[v]);
    ffp_free(import->holes), ffp_free(import->made);
    for (int v = 0; import->thumbs && v < import->capture.n_views; v++) ffp_image_free(&import->thumbs[v]);
    ffp_free(import->thumbs);
    ffp_importing_free_stage(import);
    ffp_capture_free(&import->capture);
    ffp_shots_free(&import->shots);
    ffp_calibration_free(&import->calibration);
    ffp_free(import);
    return ok;
}
