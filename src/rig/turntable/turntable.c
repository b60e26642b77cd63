#include "rig/turntable/turntable.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/base/rigid.h"
#include "rig/findings/tell.h"
#include "rig/optics/document.h"
#include "rig/optics/matrix.h"

#define UNITS 25          // times the baseline, or its part, that no rig has its axis away
#define PLACE "turntable" // the setting, for errors
#define ANGLE_MAX 36000.0

static bool check_angle(double angle, const char *where, FfpError *err) {
    return fabs(angle) <= ANGLE_MAX ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, where, "invalid angle: %g degrees", angle);
}

static bool add_angle(FfpTurntable *turntable, double angle, const char *where, FfpError *err) {
    if (!check_angle(angle, where, err)) return false;
    if (turntable->count == FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, where, "more than %d angles", FFP_VIEWS_MAX);
    turntable->angles[turntable->count++] = angle;
    return true;
}

static bool add_steps(FfpTurntable *turntable, double count, double step, const char *where, FfpError *err) {
    if (!(count >= 1 && count <= FFP_VIEWS_MAX) || count != floor(count))
        return ffp_fail(err, FFP_ERROR_FILE, where, "invalid number of stops %g: expected 1 to %d", count,
                        FFP_VIEWS_MAX);
    for (int i = 0; i < (int)count; i++) {
        if (!add_angle(turntable, i * step, where, err)) return false;
    }
    return true;
}

static bool check_axis(FfpTurntable *turntable, const char *where, FfpError *err) {
    const double *a = turntable->axis, length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(length > 1e-6 && length < 1e9))
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "the axis has no direction: angles need the axis.json that `calibrate` writes");
    for (int i = 0; i < 3; i++) turntable->axis[i] /= length;
    for (int i = 0; i < 3; i++) {
        if (!(fabs(turntable->point[i]) < 1e9))
            return ffp_fail(err, FFP_ERROR_FILE, where, "invalid coordinate %g of the axis' point",
                            turntable->point[i]);
    }
    return true;
}

// --- A file. ---

static bool read_angles(FfpTurntable *turntable, const FfpNode *root, FfpError *err) {
    FfpNode list, item;
    int n = 0;
    if (!ffp_node_find(root, "angles", &list)) {
        if (!ffp_node_find(root, "count", &list)) return true;
        int count = 0;
        real step = 0;
        return ffp_get_whole(root, "count", 1, FFP_VIEWS_MAX, &count, err) &&
               ffp_get_number(root, "step", -ANGLE_MAX, ANGLE_MAX, &step, err) &&
               add_steps(turntable, count, (double)step, root->file, err);
    }
    if (!ffp_node_count(&list, 1, FFP_VIEWS_MAX, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        real angle = 0;
        if (!ffp_node_item(&list, i, &item, err) ||
            !ffp_node_number(&item, -ANGLE_MAX, ANGLE_MAX, &angle, err) ||
            !add_angle(turntable, (double)angle, root->file, err)) {
            return false;
        }
    }
    return true;
}

// Names of views, all different: of every stop, and of those that are left out.
static bool read_views(FfpTurntable *turntable, const FfpNode *root, FfpError *err) {
    FfpNode views, left_out, item;
    char name[FFP_NAME_MAX];
    int n = 0, left = 0;
    if (!ffp_node_find(root, "views", &views)) return true;
    turntable->named = true;
    if (!ffp_node_count(&views, turntable->count, turntable->count, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        if (!ffp_node_item(&views, i, &item, err) || !ffp_node_name(&item, turntable->views[i], err))
            return false;
        for (int k = 0; k < i; k++)
            if (strcmp(turntable->views[k], turntable->views[i]) == 0)
                return ffp_node_fail(&item, err, "is a second view '%s'", turntable->views[i]);
    }
    if (!ffp_node_find(root, "left_out", &left_out)) return true;
    if (!ffp_node_count(&left_out, 0, n - 1, &left, err)) return false;
    for (int i = 0; i < left; i++) {
        if (!ffp_node_item(&left_out, i, &item, err) || !ffp_node_name(&item, name, err)) return false;
        int k = 0;
        while (k < n && strcmp(turntable->views[k], name) != 0) k++;
        if (k == n) return ffp_node_fail(&item, err, "no view is called '%s'", name);
        turntable->left_out[k] = true;
    }
    return true;
}

static bool read_sense(FfpTurntable *turntable, const FfpNode *root, FfpError *err) {
    FfpNode field;
    double square = 0;
    if (ffp_node_find(root, "clockwise", &field)) {
        if (!json_is_boolean(field.value)) return ffp_node_fail(&field, err, "not true or false");
        turntable->clockwise = json_is_true(field.value);
    }
    if (!ffp_node_find(root, "zero", &field)) return true;
    if (!ffp_node_matrix_of(&field, 3, 1, turntable->zero, err)) return false;
    for (int i = 0; i < 3; i++) square += turntable->zero[i] * turntable->zero[i];
    return (square > 1e-12 && square < 1e18) || ffp_node_fail(&field, err, "has no direction");
}

static bool read_axis(FfpTurntable *turntable, const FfpNode *root, FfpError *err) {
    FfpNode axis, point;
    return ffp_node_get(root, "axis", &axis, err) && ffp_node_matrix_of(&axis, 3, 1, turntable->axis, err) &&
           ffp_node_get(root, "point", &point, err) &&
           ffp_node_matrix_of(&point, 3, 1, turntable->point, err) && read_sense(turntable, root, err);
}

static bool read_file(FfpTurntable *turntable, const char *path, bool with_axis, FfpError *err) {
    FfpNode root;
    if (!ffp_document_open(&root, path, err)) return false;
    const bool ok = (!with_axis || read_axis(turntable, &root, err)) && read_angles(turntable, &root, err) &&
                    read_views(turntable, &root, err);
    ffp_node_close(&root);
    return ok;
}

// --- What the caller says. ---

bool ffp_turntable_is_given(const FfpImportTurntable *given) {
    return given->file || given->n_angles != 0 || given->find_axis;
}

static bool take_angles(FfpTurntable *turntable, const FfpImportTurntable *given, FfpError *err) {
    if (given->n_angles < 0 || given->n_angles > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "turntable.angles", "%d angles: expected at most %d",
                        given->n_angles, FFP_VIEWS_MAX);
    if (given->n_angles > 0 && turntable->named) {
        ffp_note("%s: the angles and views of its stops are replaced by the angles given", given->file);
        turntable->named = false;
        memset(turntable->left_out, 0, sizeof turntable->left_out);
    }
    if (given->n_angles > 0) turntable->count = given->n_angles;
    for (int i = 0; i < given->n_angles; i++) turntable->angles[i] = given->angles[i];
    if (turntable->count < 1 && given->file)
        return ffp_fail(
            err, FFP_ERROR_FILE, given->file,
            "the file has no angles (those by which the object had turned at its stops), and none "
            "are given");
    if (turntable->count < 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, PLACE, "no rotation angles of the object given");
    for (int i = 0; i < turntable->count; i++)
        if (!check_angle(turntable->angles[i], PLACE, err)) return false;
    return true;
}

// Its axis from numbers, at unit length.
static bool take_axis(FfpTurntable *turntable, const FfpImportTurntable *given, FfpError *err) {
    memcpy(turntable->axis, given->axis, sizeof turntable->axis);
    memcpy(turntable->point, given->point, sizeof turntable->point);
    return check_axis(turntable, PLACE, err);
}

bool ffp_turntable_take(FfpTurntable *turntable, const FfpImportTurntable *given, FfpError *err) {
    const bool known = !given->find_axis;
    *turntable = (FfpTurntable){0};
    if (given->find_axis && given->guessed && !take_axis(turntable, given, err)) return false;
    if (given->file && (!read_file(turntable, given->file, known, err) ||
                        (known && !check_axis(turntable, given->file, err))))
        return false;
    if (!take_angles(turntable, given, err)) return false;
    if (known) return given->file || take_axis(turntable, given, err);
    memcpy(turntable->axis, (double[]){0, -1, 0}, sizeof turntable->axis);
    memcpy(turntable->point, (double[]){0, 0, 1}, sizeof turntable->point);
    return true;
}

// --- Stops. ---

static bool across(const double axis[3], const double v[3], double out[3]) {
    const double along = v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
    double square = 0, whole = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = v[i] - along * axis[i];
        square += out[i] * out[i];
        whole += v[i] * v[i];
    }
    for (int i = 0; i < 3 && square > 0; i++) out[i] /= sqrt(square);
    return square > 1e-12 * whole && square > 0;
}

// World axes in camera coordinates: rows x, y, z. Without `zero`, x points from the axis to the camera; where
// that has no direction, any will do.
static void world_axes(const FfpTurntable *turntable, double rows[9]) {
    double to_camera[3];
    for (int i = 0; i < 3; i++) to_camera[i] = -turntable->point[i];
    memcpy(rows + 6, turntable->axis, 3 * sizeof *rows);
    if (!across(turntable->axis, turntable->zero, rows) && !across(turntable->axis, to_camera, rows)) {
        const bool steep = fabs(turntable->axis[0]) > 0.9;
        const double any[3] = {!steep, steep, 0};
        across(turntable->axis, any, rows);
    }
    ffp_cross(rows + 6, rows, rows + 3);
}

static void place(const FfpTurntable *turntable, double degrees, const FfpCalibration *calibration,
                  FfpStop *stop) {
    double rows[9], turn[9];
    world_axes(turntable, rows);
    const double angle = -degrees * acos(-1.0) / 180,
                 about[3] = {angle * turntable->axis[0], angle * turntable->axis[1],
                             angle * turntable->axis[2]};
    ffp_rotation_from_vector(about, turn);
    for (int i = 0; i < 3; i++) {
        stop->c2w[4 * i + 3] = 0;
        for (int j = 0; j < 3; j++) {
            double sum = 0;
            for (int k = 0; k < 3; k++) sum += rows[3 * i + k] * turn[3 * k + j];
            stop->c2w[4 * i + j] = sum;
            stop->c2w[4 * i + 3] -= sum * turntable->point[j];
        }
        stop->c2w[12 + i] = 0;
    }
    stop->c2w[15] = 1;
    ffp_pose_product(stop->c2w, calibration->p2c, stop->p2w);
}

void ffp_turntable_place(const FfpTurntable *turntable, bool reversed, FfpCalibration *calibration) {
    for (int i = 0; i < calibration->n_stops; i++) {
        FfpStop *stop = &calibration->stops[i];
        place(turntable, reversed ? -stop->angle : stop->angle, calibration, stop);
    }
}

static bool check_fixed(const FfpCalibration *calibration, FfpError *err) {
    if (calibration->n_stops > 0)
        return ffp_fail(err, FFP_ERROR_FILE, PLACE,
                        "the calibration already has poses for all views: omit the turntable");
    return true;
}

bool ffp_turntable_apply(const FfpTurntable *turntable, FfpCalibration *calibration, FfpError *err) {
    const FfpNode place_field = {.file = PLACE};
    if (!check_fixed(calibration, err) ||
        !ffp_calibration_new_stops(calibration, &place_field, turntable->count, err))
        return false;
    bool used[360] = {false}, twice = false;
    for (int i = 0; i < turntable->count; i++) {
        FfpStop *stop = &calibration->stops[i];
        const int degree = (int)((lround(turntable->angles[i]) % 360 + 360) % 360);
        twice = twice || used[degree];
        used[degree] = true;
        if (turntable->named)
            snprintf(stop->id, sizeof stop->id, "%s", turntable->views[i]);
        else
            snprintf(stop->id, sizeof stop->id, "%03d", degree);
        stop->camera = calibration->camera;
        stop->angle = turntable->angles[i];
        stop->left_out = turntable->left_out[i];
    }
    ffp_turntable_place(turntable, turntable->clockwise, calibration);
    for (int i = 0; i < turntable->count && twice && !turntable->named; i++)
        snprintf(calibration->stops[i].id, sizeof calibration->stops[i].id, "stop_%03d", i);
    return true;
}

// Doubts an axis far nearer or farther than the projector is from the camera.
static void compare_units(const FfpTurntable *turntable, const FfpCalibration *calibration) {
    double across[3], apart = 0;
    ffp_cross(turntable->axis, turntable->point, across);
    const double away = sqrt(ffp_dot(across, across));
    for (int i = 3; i < 12; i += 4) apart += calibration->p2c[i] * calibration->p2c[i];
    const double ratio = sqrt(apart) / away;
    if (ratio > UNITS || ratio * UNITS < 1)
        ffp_tell(FFP_RULE_AXIS_UNIT, &(FfpFacts){.x = sqrt(apart), .y = away});
}

// One stop, "000", whose world is the camera's frame.
static bool single_stop(FfpCalibration *calibration, FfpError *err) {
    const FfpNode place_field = {.file = PLACE};
    if (!check_fixed(calibration, err) || !ffp_calibration_new_stops(calibration, &place_field, 1, err))
        return false;
    FfpStop *stop = &calibration->stops[0];
    snprintf(stop->id, sizeof stop->id, "000");
    stop->camera = calibration->camera;
    for (int i = 0; i < 16; i++) stop->c2w[i] = i % 5 == 0;
    memcpy(stop->p2w, calibration->p2c, sizeof stop->p2w);
    return true;
}

bool ffp_turntable_settle(const FfpImportTurntable *given, FfpCalibration *calibration, FfpError *err) {
    if (!ffp_turntable_is_given(given)) return calibration->n_stops > 0 || single_stop(calibration, err);
    FfpTurntable *turntable = ffp_alloc(1, sizeof *turntable);
    const bool ok =
        ffp_turntable_take(turntable, given, err) && ffp_turntable_apply(turntable, calibration, err);
    if (ok && !given->find_axis) compare_units(turntable, calibration);
    ffp_free(turntable);
    return ok;
}
