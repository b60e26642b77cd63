// A turntable's axis from a capture's pictures, and the poses that it gives the views.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "rig/checks/measure.h"
#include "rig/findings/tell.h"
#include "rig/turntable/fit_axis.h"
#include "rig/turntable/turntable.h"

#define MISFIT_MAX 0.1 // of the object's pixels, which an axis that is right leaves unexplained by the others

static void place_stops(FfpCalibration *calibration, const FfpAxis *axis, bool reversed) {
    FfpTurntable *turntable = ffp_alloc(1, sizeof *turntable);
    memcpy(turntable->axis, axis->direction, sizeof turntable->axis);
    memcpy(turntable->point, axis->point, sizeof turntable->point);
    ffp_turntable_place(turntable, reversed, calibration);
    ffp_free(turntable);
}

// Tells the user how well the axis explains the whole capture; refuses one that explains it badly.
static bool accept_axis(FfpCapture *capture, const FfpAxis *axis, const FfpAxisReport *report, int active,
                        FfpError *err) {
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
        return ffp_refuse(FFP_RULE_AXIS_CONTRADICTS, &(FfpFacts){.figure = misfit, .limit = MISFIT_MAX},
                          "turntable.axis", err);
    return (found.pixels > 0 && found.error < FFP_RIG_CHANCE_MAX * found.chance) ||
           ffp_refuse(FFP_RULE_AXIS_CHANCE, &(FfpFacts){0}, "turntable.axis", err);
}

bool ffp_turntable_find(const FfpImportTurntable *given, FfpCalibration *calibration, FfpCapture *capture,
                        FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    FfpAxis axis, guess;
    FfpAxisReport report;
    double angles[FFP_VIEWS_MAX];
    if (active < 0) return false;
    memcpy(guess.direction, given->axis, sizeof guess.direction);
    memcpy(guess.point, given->point, sizeof guess.point);
    if (given->guessed) ffp_unit(guess.direction);
    for (int v = 0; v < capture->n_views; v++) angles[v] = calibration->stops[v].angle;
    if (!ffp_fit_axis(&axis, &report, capture, active, calibration->p2c, angles,
                      given->guessed ? &guess : NULL, err))
        return false;
    place_stops(calibration, &axis, report.reversed);
    ffp_calibration_pose_views(calibration, capture);
    return accept_axis(capture, &axis, &report, active, err);
}
