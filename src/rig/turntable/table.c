#include "rig/turntable/table.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/pose.h"
#include "rig/findings/tell.h"

#define PLACE "turntable board"
#define SAME_ANGLE 5.0   // degrees that two stops must differ by to tell a direction, modulo half a turn
#define ANGLE_MAX 4.0    // degrees: root mean square of the turns that angles and axis leave over
#define RIVAL 2.0        // times the least disagreement: the other sense is as good
#define RIVAL_LEAST 0.01 // of the disagreement: radians
#define NEAR_AXIS 1.0    // squares from the axis to the board's middle: nearer gives no direction
#define STOP_FAR 4       // times the median of the stops' root mean squares
#define STOP_LEAST 1.0   // pixels
enum { TURNS = 8 };

// The board's frame turned into itself: corners may be numbered from any of them, and either way round. The
// first four serve every board, the others square ones.
static const double symmetries[TURNS][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1},   {-1, 0, 0, 0, -1, 0, 0, 0, 1},
                                            {1, 0, 0, 0, -1, 0, 0, 0, -1}, {-1, 0, 0, 0, 1, 0, 0, 0, -1},
                                            {0, -1, 0, 1, 0, 0, 0, 0, 1},  {0, 1, 0, -1, 0, 0, 0, 0, 1},
                                            {0, 1, 0, 1, 0, 0, 0, 0, -1},  {0, -1, 0, -1, 0, 0, 0, 0, -1}};

typedef struct Stop {
    FfpAttitude *attitude;
    double angle; // radians
    FfpBoardPose pose;
    int symmetry; // of its numbering against the base's
} Stop;

typedef struct Table {
    const FfpBoard *board;
    const FfpCvDevice *camera;
    Stop *stops;
    int n, base;
    double r[9], t[3]; // the board at angle 0
    FfpAxis axis;
} Table;

// --- A first axis, from the poses. ---

static double angle_between(const double a[9], const double b[9]) {
    double difference[9], v[3];
    ffp_rotation_difference(a, b, difference);
    ffp_rotation_to_vector(difference, v);
    return sqrt(ffp_dot(v, v));
}

static void rotation_about(const double u[3], double angle, double r[9]) {
    const double v[3] = {angle * u[0], angle * u[1], angle * u[2]};
    ffp_rotation_from_vector(v, r);
}

// The numbering of a stop that fits the board turned from the base by this axis best; the angle left over.
static double best_symmetry(const Table *table, const Stop *stop, const double u[3], int *symmetry) {
    const Stop *base = &table->stops[table->base];
    const int count = table->board->columns == table->board->rows ? TURNS : TURNS / 2;
    double turn[9], expected[9], least = INFINITY;
    rotation_about(u, stop->angle - base->angle, turn);
    ffp_rotation_product(turn, base->pose.r, expected);
    for (int s = 0; s < count; s++) {
        double r[9];
        ffp_rotation_product(stop->pose.r, symmetries[s], r);
        const double angle = angle_between(expected, r);
        if (angle < least) least = angle, *symmetry = s;
    }
    return least;
}

// The point of the axis from the boards' middles: (I - R) p = t - R t_base, least squares, the component
// along the axis held near the boards. Returns the root mean square left over, as a share of the distance.
static double find_point(const Table *table, const double u[3], double point[3]) {
    const Stop *base = &table->stops[table->base];
    double a[9] = {0}, b[3] = {0}, square = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < table->n; i++) {
            double turn[9], right[3], row[3];
            rotation_about(u, table->stops[i].angle - base->angle, turn);
            for (int k = 0; k < 3; k++)
                right[k] = table->stops[i].pose.t[k] - ffp_dot(turn + 3 * k, base->pose.t);
            for (int k = 0; k < 3; k++) {
                for (int c = 0; c < 3; c++) row[c] = (c == k) - turn[3 * k + c];
                if (pass == 1) square += pow(ffp_dot(row, point) - right[k], 2);
                for (int c = 0; pass == 0 && c < 9; c++) a[c] += row[c / 3] * row[c % 3];
                for (int c = 0; pass == 0 && c < 3; c++) b[c] -= row[c] * right[k];
            }
            if (pass == 1 || i + 1 < table->n) continue;
            for (int c = 0; c < 9; c++) a[c] += u[c / 3] * u[c % 3] + (c % 4 == 0 ? 1e-9 : 0);
            for (int c = 0; c < 3; c++) b[c] -= u[c] * ffp_dot(u, base->pose.t);
            ffp_solve_positive(a, b, 3, point);
        }
    return sqrt(square / table->n) / sqrt(ffp_dot(base->pose.t, base->pose.t));
}

// How badly an axis direction explains all poses: angles left over and middles off their circle, radians.
static double disagreement(const Table *table, const double u[3], double point[3]) {
    double sum = 0;
    for (int i = 0; i < table->n; i++) {
        int symmetry;
        const double angle = best_symmetry(table, &table->stops[i], u, &symmetry);
        sum += angle * angle;
    }
    return sqrt(sum / table->n) + find_point(table, u, point);
}

// Directions that take the base to another stop, for every numbering of that one.
static double try_stop(Table *table, const Stop *stop, double best[2], double u_best[3]) {
    const Stop *base = &table->stops[table->base];
    const double angle = stop->angle - base->angle;
    for (int s = 0; s < TURNS; s++) {
        double r[9], relative[9], back[9], v[3], point[3];
        ffp_rotation_product(stop->pose.r, symmetries[s], r);
        for (int i = 0; i < 9; i++) back[i] = base->pose.r[3 * (i % 3) + i / 3];
        ffp_rotation_product(r, back, relative);
        ffp_rotation_to_vector(relative, v);
        const double length = ffp_unit(v);
        // The turn is known up to whole ones: sin tells the direction.
        for (int i = 0; i < 3 && sin(angle) < 0; i++) v[i] = -v[i];
        if (length < 1e-3) continue;
        const double d = disagreement(table, v, point);
        const bool other = ffp_dot(v, u_best) < 0;
        if (d < best[0]) {
            if (other) best[1] = best[0];
            best[0] = d;
            memcpy(u_best, v, sizeof v);
        } else if (other) {
            best[1] = fmin(best[1], d);
        }
    }
    return best[0];
}

static bool refuse_axis(double degrees, double most, FfpError *err) {
    return ffp_refuse(FFP_RULE_BOARD_NO_AXIS, &(FfpFacts){.figure = degrees, .limit = most}, PLACE, err);
}

static bool first_axis(Table *table, FfpError *err) {
    double best[2] = {INFINITY, INFINITY}, u[3] = {0, -1, 0}; // of the direction, and of those against it
    for (int i = 0; i < table->n; i++) {
        const double angle = table->stops[i].angle - table->stops[table->base].angle;
        ffp_cancel_point();
        if (fabs(sin(angle)) > sin(SAME_ANGLE * FFP_PI_DOUBLE / 180))
            try_stop(table, &table->stops[i], best, u);
    }
    if (!isfinite(best[0]))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, PLACE,
            "the angles are all equal or half a turn apart: at least three different ones are needed");
    if (best[0] > 2 * ANGLE_MAX * FFP_PI_DOUBLE / 180)
        return refuse_axis(best[0] * 180 / FFP_PI_DOUBLE, 2 * ANGLE_MAX, err);
    if (best[1] < RIVAL * best[0] + RIVAL_LEAST)
        return ffp_refuse(FFP_RULE_BOARD_HALF_TURN, &(FfpFacts){0}, PLACE, err);
    memcpy(table->axis.direction, u, sizeof u);
    find_point(table, u, table->axis.point);
    for (int i = 0; i < table->n; i++) best_symmetry(table, &table->stops[i], u, &table->stops[i].symmetry);
    const Stop *base = &table->stops[table->base];
    double turn[9];
    rotation_about(u, -base->angle, turn);
    ffp_rotation_product(turn, base->pose.r, table->r);
    ffp_axis_rotate(&table->axis, -base->angle, base->pose.t, table->t);
    return true;
}

// --- The best one, from all corners. ---

enum { BOARD_TURN = 0, BOARD_SHIFT = 3, AXIS_TILT = 6, AXIS_SHIFT = 8, NUMBERS = 10 };

static void moved(const Table *table, const double *by, double r[9], double t[3], FfpAxis *axis) {
    double turn[9], first[3], second[3], tilt[3];
    ffp_rotation_from_vector(by + BOARD_TURN, turn);
    ffp_rotation_product(turn, table->r, r);
    ffp_perpendiculars(table->axis.direction, first, second);
    for (int i = 0; i < 3; i++) {
        t[i] = table->t[i] + by[BOARD_SHIFT + i];
        tilt[i] = by[AXIS_TILT] * first[i] + by[AXIS_TILT + 1] * second[i];
        axis->point[i] = table->axis.point[i] + by[AXIS_SHIFT] * first[i] + by[AXIS_SHIFT + 1] * second[i];
    }
    ffp_rotation_from_vector(tilt, turn);
    for (int i = 0; i < 3; i++) axis->direction[i] = ffp_dot(turn + 3 * i, table->axis.direction);
}

static void differences(const void *state, const double *by, double *out) {
    const Table *table = state;
    double r[9], t[3];
    FfpAxis axis;
    moved(table, by, r, t, &axis);
    for (int i = 0; i < table->n; i++) {
        const Stop *stop = &table->stops[i];
        double turn[9], at[9], numbered[9], middle[3];
        rotation_about(axis.direction, stop->angle, turn);
        ffp_rotation_product(turn, r, at);
        // Symmetries are their own inverse or each other's: R of the stop's numbering is R S^T.
        for (int k = 0; k < 9; k++)
            numbered[k] = ffp_dot(at + 3 * (k / 3), symmetries[stop->symmetry] + 3 * (k % 3));
        ffp_axis_rotate(&axis, stop->angle, t, middle);
        for (int k = 0; k < stop->attitude->n; k++) {
            double point[3], x[3], pixel[2];
            ffp_board_point(table->board, k, point);
            for (int c = 0; c < 3; c++) x[c] = ffp_dot(numbered + 3 * c, point) + middle[c];
            ffp_device_project(table->camera, x, pixel);
            for (int c = 0; c < 2; c++) *out++ = pixel[c] - stop->attitude->camera[2 * k + c];
        }
    }
}

static void move(void *state, const double *by) {
    Table *table = state;
    double r[9], t[3];
    FfpAxis axis;
    moved(table, by, r, t, &axis);
    memcpy(table->r, r, sizeof r), memcpy(table->t, t, sizeof t);
    table->axis = axis;
    ffp_unit(table->axis.direction);
}

static int corners_of(const Table *table) {
    return table->board->columns * table->board->rows;
}

// Leaves out the stop that is farthest out of line; false when none is.
static bool drop_stop(Table *table) {
    const double none[NUMBERS] = {0};
    const int n = corners_of(table);
    double *off = ffp_alloc((size_t)table->n * (size_t)n, 2 * sizeof *off), most = 0;
    double *sorted = ffp_alloc((size_t)table->n, sizeof *sorted);
    int worst = 0;
    differences(table, none, off);
    for (int i = 0; i < table->n; i++) {
        double square = 0;
        for (int k = 0; k < 2 * n; k++) square += pow(off[2 * (size_t)n * (size_t)i + (size_t)k], 2);
        FfpAttitude *a = table->stops[i].attitude;
        memcpy(a->camera_off, off + 2 * (size_t)n * (size_t)i, 2 * (size_t)n * sizeof *off);
        for (int k = 0; k < 2 * n; k++) a->camera_off[k] = -a->camera_off[k]; // found minus expected
        sorted[i] = a->camera_rms = sqrt(square / n);
        if (a->camera_rms > most) most = a->camera_rms, worst = i;
    }
    const double middle = ffp_median(sorted, (size_t)table->n);
    ffp_free(off), ffp_free(sorted);
    if (table->n <= FFP_TABLE_STOPS_LEAST || most < fmax(STOP_LEAST, STOP_FAR * middle)) return false;
    FfpAttitude *a = table->stops[worst].attitude;
    snprintf(a->problem, sizeof a->problem,
             "its corners are %.1f pixels (rms) away from where axis and angle put them, those of others "
             "typically "
             "%.2f",
             most, middle);
    memmove(table->stops + worst, table->stops + worst + 1, (size_t)(table->n - worst - 1) * sizeof(Stop));
    table->n--;
    return true;
}

// The cost reached.
static double descend(Table *table, double *covariance) {
    const double far = sqrt(ffp_dot(table->t, table->t)), s = 1e-6 * far;
    const double step[NUMBERS] = {1e-6, 1e-6, 1e-6, s, s, s, 1e-6, 1e-6, s, s};
    const FfpLeastSquares least = {.state = table,
                                   .numbers = NUMBERS,
                                   .count = 2 * table->n * corners_of(table),
                                   .differences = differences,
                                   .move = move,
                                   .step = step,
                                   .steps = FFP_FIT_STEPS,
                                   .worth = FFP_FIT_WORTH};
    return ffp_least_squares(&least, covariance);
}

// Adds the squares of what the axis turns and moves by where the camera is off by a deviation: in its focal
// lengths, which err together, and in either coordinate of its principal point.
static void add_camera(const Table *table, double *tilt, double *shift) {
    static const int places[4] = {0, 4, 2, 5};
    const double *deviation = table->camera->deviation, *u = table->axis.direction;
    const double focal = deviation[0] / table->camera->matrix[0];
    const double by[3][4] = {{deviation[0], focal * table->camera->matrix[4], 0, 0},
                             {0, 0, deviation[2], 0},
                             {0, 0, 0, deviation[3]}};
    for (int k = 0; k < 3; k++) {
        FfpCvDevice camera = *table->camera;
        Table other = *table;
        double off[3], across[3];
        for (int i = 0; i < 4; i++) camera.matrix[places[i]] += by[k][i];
        other.camera = &camera;
        descend(&other, NULL);
        for (int i = 0; i < 3; i++) off[i] = other.axis.point[i] - table->axis.point[i];
        ffp_cross(off, u, across);
        *shift += ffp_dot(across, across);
        ffp_cross(other.axis.direction, u, across);
        *tilt += ffp_dot(across, across);
    }
}

static void refine(Table *table, FfpTableFit *fit) {
    double covariance[NUMBERS * NUMBERS], cost;
    do cost = descend(table, covariance);
    while (drop_stop(table));
    fit->used = table->n;
    fit->rms = sqrt(cost / (table->n * corners_of(table)));
    double tilt = covariance[NUMBERS * 6 + 6] + covariance[NUMBERS * 7 + 7],
           shift = covariance[NUMBERS * 8 + 8] + covariance[NUMBERS * 9 + 9];
    if (table->camera->deviation[0] > 0)
        add_camera(table, &tilt, &shift);
    else
        ffp_note(
            "the camera's calibration does not say how uncertain it is: neither does the axis' uncertainty");
    fit->tilt = sqrt(tilt) * 180 / FFP_PI_DOUBLE;
    fit->shift = sqrt(shift);
}

// --- The photographs. ---

static bool read_stop(FfpTableFit *fit, const FfpBoard *board, const FfpCvDevice *camera, const char *file,
                      int i, FfpError *err) {
    FfpAttitude *a = &fit->attitudes[i];
    char usual[40];
    FfpImage grey;
    if (!ffp_board_read(&grey, file, err)) return false;
    a->name = file;
    const bool same = grey.width == camera->width && grey.height == camera->height;
    snprintf(usual, sizeof usual, "%d x %d", camera->width, camera->height);
    const bool ok =
        same ? ffp_board_find(board, &grey, a, err)
             : ffp_refuse(
                   FFP_RULE_STOP_SIZE,
                   &(FfpFacts){.view = ffp_basename(file), .x = grey.width, .y = grey.height, .a = usual},
                   file, err);
    ffp_image_free(&grey);
    return ok;
}

static bool read_stops(FfpTableFit *fit, Table *table, const FfpShotFolder *folder, FfpError *err) {
    const FfpTask task = ffp_task("reading the turntable's board", folder->n_files);
    bool ok = true;
    for (int i = 0; ok && i < folder->n_files; i++) {
        ffp_cancel_point();
        FfpAttitude *a = &fit->attitudes[i];
        Stop *stop = &table->stops[table->n];
        bool found = false;
        ok = read_stop(fit, table->board, table->camera, folder->files[i], i, err);
        if (ok && !a->problem[0])
            ok = ffp_board_pose(table->board, table->camera, a, &stop->pose, &found, err);
        if (ok && !found && !a->problem[0])
            snprintf(a->problem, sizeof a->problem,
                     "its corners do not lie on a plane in front of this camera");
        if (found) {
            stop->attitude = a, stop->angle = fit->angles[i] * FFP_PI_DOUBLE / 180;
            table->n++;
        }
        ffp_task_step(&task, i + 1, NULL);
    }
    ffp_task_end(&task);
    return ok;
}

// Points up in the picture, and its point is the one nearest to the board, which gives the direction of angle
// 0.
static void settle(Table *table, FfpTableFit *fit) {
    FfpAxis *axis = &table->axis;
    double along = 0;
    fit->reversed = axis->direction[1] > 0;
    for (int i = 0; i < 3 && fit->reversed; i++) axis->direction[i] = -axis->direction[i];
    for (int i = 0; i < 3; i++) along += (table->t[i] - axis->point[i]) * axis->direction[i];
    for (int i = 0; i < 3; i++) axis->point[i] += along * axis->direction[i];
    for (int i = 0; i < 3; i++) fit->zero[i] = table->t[i] - axis->point[i];
    if (ffp_unit(fit->zero) < NEAR_AXIS * table->board->square) memset(fit->zero, 0, sizeof fit->zero);
    if (!(ffp_dot(fit->zero, fit->zero) > 0))
        ffp_note("the board's middle lies on the axis and gives angle 0 no direction: another calibration of "
                 "this rig "
                 "has another world");
    fit->axis = *axis;
}

// How far each stop's own pose is from axis and angle.
static double leftover(const Table *table) {
    double sum = 0;
    for (int i = 0; i < table->n; i++) {
        const Stop *stop = &table->stops[i];
        double turn[9], expected[9], r[9];
        rotation_about(table->axis.direction, stop->angle, turn);
        ffp_rotation_product(turn, table->r, expected);
        ffp_rotation_product(stop->pose.r, symmetries[stop->symmetry], r);
        sum += pow(angle_between(expected, r), 2);
    }
    return sqrt(sum / table->n) * 180 / FFP_PI_DOUBLE;
}

static void tell_left_out(const FfpAttitude *a) {
    char names[80];
    snprintf(names, sizeof names, "%.70s is", a->name);
    ffp_tell(FFP_RULE_ATTITUDE, &(FfpFacts){.view = a->name, .a = names, .b = a->problem});
}

// Refuses too few photographs, with the reason of the first that is left out.
static bool check_stops(const FfpTableFit *fit, const Table *table, FfpError *err) {
    char why[640] = "none left out";
    if (table->n >= FFP_TABLE_STOPS_LEAST) return true;
    for (int i = fit->n - 1; i >= 0; i--)
        if (fit->attitudes[i].problem[0])
            snprintf(why, sizeof why, "%.120s: %.500s", fit->attitudes[i].name, fit->attitudes[i].problem);
    return ffp_refuse(FFP_RULE_TOO_FEW,
                      &(FfpFacts){.x = table->n,
                                  .y = fit->n,
                                  .z = FFP_TABLE_STOPS_LEAST,
                                  .a = "photographs show the board",
                                  .b = why},
                      PLACE, err);
}

static bool fit_axis(FfpTableFit *fit, Table *table, FfpError *err) {
    if (!check_stops(fit, table, err)) return false;
    if (!first_axis(table, err)) return false;
    refine(table, fit);
    fit->off_angle = leftover(table);
    if (fit->off_angle > ANGLE_MAX) return refuse_axis(fit->off_angle, ANGLE_MAX, err);
    settle(table, fit);
    return true;
}

bool ffp_fit_table(FfpTableFit *fit, const FfpBoard *board, const FfpCvDevice *camera, const char *path,
                   const double *angles, int n_angles, FfpError *err) {
    FfpShotFolders folders;
    *fit = (FfpTableFit){.angles = angles};
    if (!ffp_shot_folders_find(&folders, &path, 1, err)) return false;
    const FfpShotFolder *folder = &folders.folders[0];
    bool ok = true;
    if (folders.n != 1 || folder->n_files != n_angles)
        ok = ffp_fail(err, FFP_ERROR_FILE, path,
                      "%d photographs in %d folders, and %d angles: one photograph per "
                      "angle is needed, all in one folder",
                      folder->n_files, folders.n, n_angles);
    if (ok) {
        Table table = {.board = board, .camera = camera, .stops = ffp_alloc((size_t)n_angles, sizeof(Stop))};
        fit->n = n_angles;
        fit->attitudes = ffp_alloc((size_t)n_angles, sizeof *fit->attitudes);
        ok = read_stops(fit, &table, folder, err) && fit_axis(fit, &table, err);
        for (int i = 0; i < fit->n; i++)
            if (fit->attitudes[i].problem[0]) tell_left_out(&fit->attitudes[i]);
        ffp_free(table.stops);
        for (int i = 0; i < fit->n; i++) fit->attitudes[i].name = "";
    }
    ffp_shot_folders_free(&folders);
    return ok;
}

void ffp_table_free(FfpTableFit *fit) {
    for (int i = 0; i < fit->n; i++) ffp_attitude_free(&fit->attitudes[i]);
    ffp_free(fit->attitudes);
    *fit = (FfpTableFit){0};
}
