// Import: optics and poses of the views that are asked for.
#include <string.h>
#include "core/numerics/resection.h"
#include "rig/import/import_steps.h"
#include "rig/optics/colmap_write.h"

static void drop_left_out(FfpCalibration *calibration) {
    int n = 0;
    for (int i = 0; i < calibration->n_stops; i++)
        if (!calibration->stops[i].left_out) calibration->stops[n++] = calibration->stops[i];
    calibration->n_stops = n;
}

static bool keep_chosen_stops(FfpImporting *import, FfpError *err) {
    const FfpImport *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    for (int i = 0; i < calibration->n_stops; i++) calibration->stops[i].index = i;
    drop_left_out(calibration);
    if (settings->n_views == 0) return true;
    if (calibration->n_pictures > 0 && settings->n_images == 0)
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, "views",
            "the calibration itself names the pictures: to choose among its views, name the pictures too");
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
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "a view is named twice");
    }
    ffp_free(calibration->stops);
    calibration->stops = chosen;
    calibration->n_stops = settings->n_views;
    return true;
}

// A projector that the calibration does not describe, in the middle of what is usual; its poses are those of
// the one that it describes.
static bool take_other_projector(const FfpImport *settings, FfpCalibration *calibration, FfpError *err) {
    const int width = settings->projector.width, height = settings->projector.height;
    if (!settings->other_projector) return true;
    if (width <= 0 || height <= 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "projector.width",
                        "another projector requires its panel's size");
    calibration->projector = (FfpOptics){.width = width,
                                         .height = height,
                                         .fx = FFP_USUAL_FOCAL * width,
                                         .fy = FFP_USUAL_FOCAL * width,
                                         .cx = 0.5 * width,
                                         .cy = 0.5 * height};
    return true;
}

bool ffp_importing_read_rig(FfpImporting *import, FfpError *err) {
    const FfpImport *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    const char *projector = settings->projector_image ? settings->projector_image : FFP_COLMAP_PROJECTOR;
    if (settings->n_views > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "more than %d views", FFP_VIEWS_MAX);
    if (!ffp_calibration_read(calibration, settings->calibrations, settings->n_calibrations, projector,
                              err) ||
        !take_other_projector(settings, calibration, err))
        return false;
    if (!ffp_turntable_settle(&settings->turntable, calibration, err)) return false;
    return keep_chosen_stops(import, err);
}
