// Import: optics and poses of the views that are asked for.
#include <string.h>
#include "rig/import/import_steps.h"

static bool keep_chosen_stops(FfpImporting *import, FfpError *err) {
    const FfpImportSettings *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    for (int i = 0; i < calibration->n_stops; i++) calibration->stops[i].index = i;
    if (settings->n_views == 0) return true;
    if (calibration->n_pictures > 0 && settings->sources.n_images == 0)
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

// An axis that is to be found is only where the stops' poses are until then.
static bool read_turntable(const FfpImportSettings *settings, FfpTurntable *turntable, FfpError *err) {
    const bool known = settings->axis == FFP_AXIS_KNOWN;
    if (settings->turntable_file) {
        const char *path = settings->turntable_file;
        const bool read = known ? ffp_turntable_read(turntable, path, err)
                                : ffp_turntable_read_angles(turntable, path, err);
        return read && ffp_turntable_set_angles(turntable, settings->turntable, path, err) &&
               ffp_turntable_check_angles(turntable, err);
    }
    const FfpTurntable unknown = ffp_turntable_unknown();
    *turntable = settings->turntable ? *settings->turntable : unknown;
    if (!known) {
        memcpy(turntable->axis, unknown.axis, sizeof turntable->axis);
        memcpy(turntable->point, unknown.point, sizeof turntable->point);
    }
    return ffp_turntable_check_angles(turntable, err) && ffp_turntable_check_axis(turntable, err);
}

bool ffp_importing_read_rig(FfpImporting *import, FfpError *err) {
    const FfpImportSettings *settings = import->settings;
    FfpCalibration *calibration = &import->calibration;
    const char *projector = settings->projector_image ? settings->projector_image : "calib";
    if (settings->n_views > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "more than %d views", FFP_VIEWS_MAX);
    if (!ffp_calibration_read(calibration, settings->calibrations, settings->n_calibrations, projector, err))
        return false;
    if (settings->turntable_file || settings->turntable || settings->axis != FFP_AXIS_KNOWN) {
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
