// Import: the sizes of all pictures, in files and in the capture, and the devices that go with them.
#include <string.h>
#include <tgmath.h>
#include "core/capture/manifest.h"
#include "core/capture/panel.h"
#include "core/image/photograph.h"
#include "rig/import/import_steps.h"

#define RIM 4 // pixels of darkness around a picture whose end is in view

static bool settle_projector(FfpImporting *import, FfpCamera *pinhole, FfpError *err) {
    FfpOptics *optics = &import->calibration.projector;
    const FfpCalibratedAt *at = &import->settings->projector;
    int width = 0, height = 0;
    const char *path = NULL;
    for (int i = 0; i < import->shots.n_patterns && !path; i++) path = import->shots.patterns[i].file;
    const bool coded = !path && (import->settings->gray_codes || import->shots.codes);
    if (!path && !coded)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns",
                        "no pattern besides black and white: matching is impossible");
    if (coded) { // as many pixels as it was calibrated at
        path = import->shots.codes ? import->shots.shown.folder : import->settings->gray_codes;
        width = at->width > 0 ? at->width : optics->width,
        height = at->width > 0 ? at->height : optics->height;
        if (width == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "projector.width",
                            "neither the calibration nor a pattern gives the panel's size, which decoding "
                            "Gray codes requires");
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
    if (import->settings->scene) ffp_optics_frame_all(optics, RIM, pinhole);
    if (panel.width == 0) panel.width = optics->width, panel.height = optics->height;
    ffp_panel_describe(&import->capture.panel, &panel);
    import->coded = at->fit == FFP_FIT_CROPPED ? panel : *optics; // codes are never cut out
    return true;
}

static bool settle_camera(FfpImporting *import, int stop, FfpError *err) {
    FfpOptics *optics = &import->calibration.stops[stop].camera;
    const FfpCalibratedAt *at = &import->settings->camera;
    const char *path = ffp_shots_white(&import->shots, stop);
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
           ffp_fail(err, FFP_ERROR_ARGUMENT, "width", "pictures of %d x %d pixels are too small or too large",
                    camera->width, camera->height);
}

bool ffp_importing_has_size(const char *path, int width, int height, const FfpOptics *optics, FfpError *err) {
    return (width == optics->width && height == optics->height) ||
           ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, but the others are %d x %d", width, height,
                    optics->width, optics->height);
}

bool ffp_importing_check_size(const char *path, const FfpOptics *optics, FfpError *err) {
    int width = 0, height = 0;
    return ffp_image_read_size(&width, &height, path, err) &&
           ffp_importing_has_size(path, width, height, optics, err);
}

// The pattern, where Gray codes are all there is, runs across the line from projector to camera.
static bool find_codes(FfpImporting *import, FfpError *err) {
    const FfpOptics *panel = &import->coded;
    const FfpStop *stop = &import->calibration.stops[0];
    double along[2] = {0};
    for (int axis = 0; axis < 2; axis++)
        for (int k = 0; k < 3; k++)
            along[axis] += stop->p2w[4 * k + axis] * (stop->c2w[4 * k + 3] - stop->p2w[4 * k + 3]);
    return ffp_shots_find_codes(&import->shots, import->settings, &import->calibration, panel->width,
                                panel->height, fabs(along[1]) > fabs(along[0]), err);
}

bool ffp_importing_settle_views(FfpImporting *import, FfpError *err) {
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
    ffp_calibration_pose_views(&import->calibration, capture);
    return true;
}
