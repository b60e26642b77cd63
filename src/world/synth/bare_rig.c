#include "world/synth/bare_rig.h"
#include <math.h>
#include <string.h>
#include "core/base/lens.h"
#include "core/base/rigid.h"
#include "core/base/rng.h"
#include "world/synth/rig.h"

enum { COLUMNS = 9, ROWS = 6, STREAM_ATTITUDE = 7000 };
static const double DEGREE = FFP_PI_DOUBLE / 180;

void ffp_bare_rig_optics(FfpCamera *device, int width, int height, double focal, double off_x, double off_y) {
    const int side = width < height ? width : height;
    device->width = width, device->height = height;
    device->fx = (real)(focal * side), device->fy = (real)(1.004 * focal * side);
    device->cx = (real)(0.5 * width + off_x * side), device->cy = (real)(0.5 * height + off_y * side);
}

// The object's sphere fills nearly the whole height of both fields.
FfpBareRig ffp_bare_rig(int height, int panel_width, int panel_height) {
    FfpBareRig rig = {.camera_lens = {-0.12, 0.05, 0.0008, -0.0006, 0},
                      .projector_lens = {-0.05, 0.02, -0.0005, 0.001, 0},
                      .intensity = 17.9F,
                      .ambient = 0.04F,
                      .square = 0.16};
    const double middle[3] = {0, 0, 0};
    ffp_bare_rig_optics(&rig.camera, (4 * height + 2) / 3, height, 1.36, 0.013, -0.009);
    ffp_bare_rig_optics(&rig.projector, panel_width, panel_height, 1.27, -0.01, 0.05);
    ffp_rig_place(&rig.camera, 3, 75, 0, middle);
    ffp_rig_place(&rig.projector, 3, 55, 22, middle);
    return rig;
}

void ffp_bare_rig_exchange(FfpBareRig *rig) {
    static const double lens[5] = {-0.02, 0.008, 0, 0.0003, 0}, middle[3] = {0, 0, 0};
    ffp_bare_rig_optics(&rig->projector, rig->projector.width, rig->projector.height, 1.48, 0.02, 0.06);
    memcpy(rig->projector_lens, lens, sizeof lens);
    ffp_rig_place(&rig->projector, 3.5, 63, -31, middle);
    rig->intensity *= 1.2F;
}

// R_z(-angle) applied to a pose.
static void turn_back(const FfpCamera *device, double angle, FfpCamera *turned) {
    const double c = cos(angle * DEGREE), s = sin(angle * DEGREE);
    *turned = *device;
    for (int k = 0; k < 4; k++) {
        const double x = (double)device->pose[k], y = (double)device->pose[4 + k];
        turned->pose[k] = (real)(c * x + s * y), turned->pose[4 + k] = (real)(c * y - s * x);
    }
}

void ffp_bare_rig_devices(const FfpBareRig *rig, double angle, FfpCamera *camera, FfpCamera *projector) {
    turn_back(&rig->camera, angle, camera);
    turn_back(&rig->projector, angle, projector);
}

void ffp_bare_rig_in_frame(const FfpCamera *device, const double v[3], bool is_point, double out[3]) {
    const FfpRigid pose = ffp_rigid_from_pose(device->pose);
    for (int k = 0; k < 3; k++) {
        out[k] = 0;
        for (int m = 0; m < 3; m++) out[k] += pose.r[3 * m + k] * (v[m] - (is_point ? pose.t[m] : 0));
        if (is_point) out[k] *= FFP_BARE_RIG_UNIT;
    }
}

bool ffp_bare_rig_pixel(const FfpCamera *device, const double lens[5], const float point[3],
                        double pixel[2]) {
    const FfpRigid pose = ffp_rigid_from_pose(device->pose);
    double local[3] = {0};
    for (int k = 0; k < 3; k++)
        for (int m = 0; m < 3; m++) local[k] += pose.r[3 * m + k] * ((double)point[m] - pose.t[m]);
    if (local[2] <= 0) return false;
    ffp_lens_distort(lens, local[0] / local[2], local[1] / local[2], &pixel[0], &pixel[1]);
    pixel[0] = (double)device->cx + (double)device->fx * pixel[0];
    pixel[1] = (double)device->cy + (double)device->fy * pixel[1];
    return pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] <= device->width && pixel[1] <= device->height;
}

// --- Boards. ---

// A board about `middle` whose rows and columns run along two directions.
static FfpChessboard board_at(double square, const double middle[3], const double right[3],
                              const double down[3]) {
    FfpChessboard board = {.columns = COLUMNS, .rows = ROWS, .square = (float)square};
    for (int k = 0; k < 3; k++) {
        board.right[k] = (float)right[k], board.down[k] = (float)down[k];
        board.origin[k] =
            (float)(middle[k] - 0.5 * square * ((COLUMNS - 1) * right[k] + (ROWS - 1) * down[k]));
    }
    return board;
}

// True if its squares are in the frame, and half a square of the margin around them.
static bool holds(const FfpCamera *device, const double lens[5], const FfpChessboard *board) {
    for (int corner = 0; corner < 4; corner++) {
        float point[3];
        double pixel[2];
        ffp_chessboard_point(board, corner % 2 ? COLUMNS + 0.5F : -1.5F, corner / 2 ? ROWS + 0.5F : -1.5F,
                             point);
        if (!ffp_bare_rig_pixel(device, lens, point, pixel)) return false;
    }
    return true;
}

// Axes of a board that faces between camera and projector, upright as the camera is.
static void facing_axes(const FfpBareRig *rig, double right[3], double down[3]) {
    double normal[3], to_camera[3], to_projector[3];
    for (int k = 0; k < 3; k++) {
        to_camera[k] = (double)rig->camera.pose[4 * k + 3];
        to_projector[k] = (double)rig->projector.pose[4 * k + 3];
        right[k] = (double)rig->camera.pose[4 * k];
    }
    ffp_unit(to_camera), ffp_unit(to_projector);
    for (int k = 0; k < 3; k++) normal[k] = to_camera[k] + to_projector[k];
    ffp_unit(normal);
    const double along = ffp_dot(right, normal);
    for (int k = 0; k < 3; k++) right[k] -= along * normal[k];
    ffp_unit(right);
    ffp_cross(right, normal, down);
}

static void turn_by(const double turn[9], double v[3]) {
    const double from[3] = {v[0], v[1], v[2]};
    for (int k = 0; k < 3; k++) v[k] = ffp_dot(turn + 3 * k, from);
}

FfpChessboard ffp_bare_rig_attitude(const FfpBareRig *rig, int index, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, STREAM_ATTITUDE + (uint64_t)index);
    double right[3], down[3], normal[3], tilt[3], turn[9];
    facing_axes(rig, right, down);
    ffp_cross(down, right, normal);
    // tilted towards another side every time, and a little about its own normal
    const double side = (137.5 * index + (double)ffp_rng_range(&rng, -20, 20)) * DEGREE;
    const double steep = (double)ffp_rng_range(&rng, 14, 30) * DEGREE,
                 roll = (double)ffp_rng_range(&rng, -8, 8) * DEGREE;
    for (int k = 0; k < 3; k++)
        tilt[k] = steep * (cos(side) * right[k] + sin(side) * down[k]) + roll * normal[k];
    double shift[3];
    for (int k = 0; k < 3; k++) shift[k] = (double)ffp_rng_range(&rng, -0.6F, 0.6F);
    ffp_rotation_from_vector(tilt, turn);
    turn_by(turn, right), turn_by(turn, down);
    FfpChessboard board = {0};
    for (int tries = 0; tries < 40; tries++) { // nearer to the middle until both devices see it all
        double middle[3];
        for (int k = 0; k < 3; k++)
            middle[k] = shift[0] * (double)rig->camera.pose[4 * k] +
                        shift[1] * (double)rig->camera.pose[4 * k + 1] + shift[2] * normal[k];
        board = board_at(rig->square, middle, right, down);
        if (holds(&rig->camera, rig->camera_lens, &board) &&
            holds(&rig->projector, rig->projector_lens, &board))
            break;
        for (int k = 0; k < 3; k++) shift[k] *= 0.85;
    }
    return board;
}

FfpChessboard ffp_bare_rig_turntable_board(const FfpBareRig *rig) {
    const double lean = 15 * DEGREE, middle[3] = {0.1, 0.05, 0}, right[3] = {0, 1, 0},
                 down[3] = {sin(lean), 0, -cos(lean)};
    return board_at(rig->square, middle, right, down);
}
