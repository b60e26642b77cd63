// The rig's own calibration, from its options to its files.
#include "rig/calibrate/rig.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "rig/calibrate/calibrate.h"
#include "rig/chessboard/chessboard.h"
#include "rig/chessboard/terms.h"
#include "rig/optics/calibration.h"

enum { SIDE_MIN = 64, SIDE_MAX = 16384, BOARD_MIN = 3, BOARD_MAX = 100, ANGLES_MIN = 3 };

static bool check_board(const FfpRigCalibration *o, FfpError *err) {
    const int n[2] = {o->columns, o->rows};
    for (int i = 0; i < 2; i++)
        if (n[i] < BOARD_MIN || n[i] > BOARD_MAX)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "board", "%d corners are not in %d to %d", n[i],
                            BOARD_MIN, BOARD_MAX);
    return (o->square > 0 && o->square < 1e9) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "square", "invalid side of a square: %g", o->square);
}

static bool check_table(const FfpRigCalibration *o, FfpError *err) {
    if (!o->turntable_board)
        return (!o->turntable_file && o->n_angles == 0) ||
               ffp_fail(err, FFP_ERROR_ARGUMENT, "turntable board", "no photographs given");
    if (o->n_angles < ANGLES_MIN || o->n_angles > FFP_SHOT_FOLDERS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "angles", "%d are not in %d to %d", o->n_angles, ANGLES_MIN,
                        FFP_SHOT_FOLDERS_MAX);
    for (int i = 0; i < o->n_angles; i++)
        if (!(fabs(o->angles[i]) <= 36000))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "angles", "invalid angle: %g degrees", o->angles[i]);
    return true;
}

static bool check(const FfpRigCalibration *o, FfpError *err) {
    const unsigned all = 2U * FFP_FIX_ASPECT - 1;
    if (!check_board(o, err) || !check_table(o, err)) return false;
    if ((o->fix_camera | o->fix_projector) & ~all)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "fix", "invalid set of terms: %u",
                        o->fix_camera | o->fix_projector);
    if (o->n_attitudes == 0)
        return (o->turntable_board && o->n_calibrations > 0 && !o->file) ||
               ffp_fail(err, FFP_ERROR_ARGUMENT, "attitudes",
                        o->turntable_board
                            ? "without photographs of the board in several attitudes, give the camera's "
                              "calibration, and no file for one"
                            : "no photographs given");
    if (o->n_calibrations > 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "calibration",
                        "cannot be combined with photographs to calibrate from");
    if (!o->file) return ffp_fail(err, FFP_ERROR_ARGUMENT, "output", "no file to write to");
    return o->shown ||
           (o->width >= SIDE_MIN && o->width <= SIDE_MAX && o->height >= SIDE_MIN && o->height <= SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "a side of %d x %d is not in %d to %d pixels",
                    o->width, o->height, SIDE_MIN, SIDE_MAX);
}

// The camera of an existing calibration, in OpenCV's pixels.
static bool read_camera(const FfpRigCalibration *o, FfpCvDevice *camera, FfpError *err) {
    FfpCalibration calibration;
    if (!ffp_calibration_read(&calibration, o->calibrations, o->n_calibrations, NULL, err)) return false;
    const FfpOptics *optics = &calibration.camera;
    const double matrix[9] = {optics->fx, 0, optics->cx - 0.5, 0, optics->fy, optics->cy - 0.5, 0, 0, 1};
    *camera = (FfpCvDevice){.width = optics->width, .height = optics->height};
    memcpy(camera->matrix, matrix, sizeof matrix);
    memcpy(camera->lens, optics->lens, sizeof camera->lens);
    memcpy(camera->deviation, calibration.camera_deviation, sizeof calibration.camera_deviation);
    const bool known = calibration.has_camera;
    ffp_calibration_free(&calibration);
    if (!known) return ffp_fail(err, FFP_ERROR_FILE, o->calibrations[0], "does not contain a camera");
    return camera->width > 0 || ffp_fail(err, FFP_ERROR_FILE, o->calibrations[0],
                                         "does not say at which image size the camera was calibrated");
}

// The attitudes' names are the folders'.
static bool fit_rig(const FfpRigCalibration *o, FfpShotFolders *folders, FfpRigFit *fit, FfpError *err) {
    if (!ffp_shot_folders_find(folders, o->attitudes, o->n_attitudes, err)) return false;
    fit->linear = o->linear;
    fit->fixed[0] = o->fix_camera;
    fit->fixed[1] = o->fix_projector;
    FfpCvDevice *panel = &fit->devices[1];
    panel->width = o->width, panel->height = o->height;
    if (o->shown && !ffp_shot_folders_select_codes(folders, o->shown, &panel->width, &panel->height, err))
        return false;
    return ffp_read_attitudes(fit, folders, err) && ffp_fit_rig(fit, err) && ffp_judge_terms(fit, err);
}

static void tell(const FfpRigFit *fit, const FfpTableFit *table, FfpRigCalibrationStats *stats) {
    *stats = (FfpRigCalibrationStats){.attitudes = fit->n,
                                      .used = ffp_attitudes_used(fit),
                                      .camera = fit->devices[0].rms,
                                      .projector = fit->devices[1].rms,
                                      .both = fit->rms};
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        for (int k = 0; a->problem[0] == 0 && k < a->n; k++) {
            stats->corners += 2;
            stats->left_out +=
                (a->camera_state[k] != FFP_CORNER_USED) + (a->projector_state[k] != FFP_CORNER_USED);
        }
    }
    for (int d = 0; d < 2 && fit->n > 0; d++)
        for (int term = 4; term < FFP_TERMS; term++)
            stats->open_terms += ffp_term_open(&fit->devices[d], term);
    if (!table) return;
    stats->has_axis = true;
    stats->reversed = table->reversed;
    memcpy(stats->axis, table->axis.direction, sizeof stats->axis);
    memcpy(stats->point, table->axis.point, sizeof stats->point);
    stats->stops = table->n;
    stats->stops_used = table->used;
    stats->stops_rms = table->rms;
    stats->tilt = table->tilt;
    stats->shift = table->shift;
}

// Every file that is wanted could be written, told before the work.
static bool probe(const FfpRigCalibration *o, FfpError *err) {
    return ffp_output_probe(o->file, err) && ffp_output_probe(o->report, err) &&
           ffp_output_probe(o->turntable_file, err);
}

// The photographs are looked at, and nothing is fitted.
static bool look(const FfpRigCalibration *o, FfpError *err) {
    const FfpBoard board = {o->columns, o->rows, o->square};
    if (o->file || o->report || o->turntable_board || o->n_calibrations > 0 || o->n_attitudes == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "seen",
                        "takes photographs of the board, and writes no calibration, report or axis");
    return ffp_cv_available(err) && check_board(o, err) && ffp_output_probe(o->seen, err) &&
           ffp_write_boards_seen(&board, o->attitudes, o->n_attitudes, o->seen, err);
}

bool ffp_calibration_run(const FfpRigCalibration *o, FfpRigCalibrationStats *stats, FfpError *err) {
    if (o->seen) return look(o, err);
    FfpRigFit *fit = ffp_alloc(1, sizeof *fit);
    FfpTableFit *table = ffp_alloc(1, sizeof *table);
    FfpShotFolders folders = {0};
    fit->board = (FfpBoard){o->columns, o->rows, o->square};
    const bool with_table = o->turntable_board != NULL;
    bool ok = ffp_cv_available(err) && check(o, err) && probe(o, err) &&
              (o->n_attitudes > 0 ? fit_rig(o, &folders, fit, err) : read_camera(o, &fit->devices[0], err));
    if (ok && with_table)
        ok = ffp_fit_table(table, &fit->board, &fit->devices[0], o->turntable_board, o->angles, o->n_angles,
                           err);
    ok = ok && (!o->report || ffp_write_calibration_report(fit, with_table ? table : NULL, o->report, err)) &&
         (!o->turntable_file || ffp_write_table(table, o->turntable_file, err)) &&
         (!o->file || ffp_write_calibration(fit, o->file, err));
    if (ok && stats) tell(fit, with_table ? table : NULL, stats);
    ffp_table_free(table);
    ffp_rig_fit_free(fit);
    ffp_shot_folders_free(&folders);
    ffp_free(table);
    ffp_free(fit);
    return ok;
}
