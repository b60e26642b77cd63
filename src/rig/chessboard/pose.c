#include "rig/chessboard/pose.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/rigid.h"
#include "core/numerics/least_squares.h"
#include "rig/optics/lens.h"

// --- A device. ---

bool ffp_device_ray(const FfpCvDevice *device, const double pixel[2], double ray[2]) {
    const double *m = device->matrix;
    return ffp_lens_undistort(device->lens, (pixel[0] - m[2]) / m[0], (pixel[1] - m[5]) / m[4], ray);
}

void ffp_device_project(const FfpCvDevice *device, const double point[3], double pixel[2]) {
    double u, v;
    ffp_lens_distort(device->lens, point[0] / point[2], point[1] / point[2], &u, &v);
    pixel[0] = device->matrix[0] * u + device->matrix[2];
    pixel[1] = device->matrix[4] * v + device->matrix[5];
}

// --- The board before it. ---

void ffp_board_point(const FfpBoard *board, int i, double point[3]) {
    point[0] = (ffp_corner_column(board, i) - 0.5 * (board->columns - 1)) * board->square;
    point[1] = (ffp_corner_row(board, i) - 0.5 * (board->rows - 1)) * board->square;
    point[2] = 0;
}

typedef struct PoseState {
    const FfpBoard *board;
    const FfpCvDevice *camera;
    const double *seen; // [n,2]
    int n;
    double r[9], t[3];
} PoseState;

static void moved(const PoseState *s, const double *by, double r[9], double t[3]) {
    double turn[9];
    ffp_rotation_from_vector(by, turn);
    ffp_rotation_product(turn, s->r, r);
    for (int i = 0; i < 3; i++) t[i] = s->t[i] + by[3 + i];
}

static void pose_differences(const void *state, const double *by, double *out) {
    const PoseState *s = state;
    double r[9], t[3];
    moved(s, by, r, t);
    for (int i = 0; i < s->n; i++) {
        double point[3], x[3], at[2];
        ffp_board_point(s->board, i, point);
        for (int k = 0; k < 3; k++) x[k] = ffp_dot(r + 3 * k, point) + t[k];
        ffp_device_project(s->camera, x, at);
        for (int k = 0; k < 2; k++) out[2 * i + k] = at[k] - s->seen[2 * i + k];
    }
}

static void pose_move(void *state, const double *by) {
    PoseState *s = state;
    double r[9], t[3];
    moved(s, by, r, t);
    memcpy(s->r, r, sizeof r), memcpy(s->t, t, sizeof t);
}

// From a homography, board to rays: H = [r1 r2 t] up to scale (Zhang 2000, section 3.1).
static void take_apart(const double h[9], double r[9], double t[3]) {
    double x[3] = {h[0], h[3], h[6]}, y[3] = {h[1], h[4], h[7]}, z[3];
    double scale = 2 / (sqrt(ffp_dot(x, x)) + sqrt(ffp_dot(y, y)));
    if (h[8] < 0) scale = -scale;
    for (int i = 0; i < 3; i++) x[i] *= scale, y[i] *= scale, t[i] = scale * h[3 * i + 2];
    ffp_unit(x);
    const double along = ffp_dot(x, y);
    for (int i = 0; i < 3; i++) y[i] -= along * x[i];
    ffp_unit(y);
    ffp_cross(x, y, z);
    for (int i = 0; i < 3; i++) r[3 * i] = x[i], r[3 * i + 1] = y[i], r[3 * i + 2] = z[i];
}

bool ffp_board_pose(const FfpBoard *board, const FfpCvDevice *camera, const FfpAttitude *a,
                    FfpBoardPose *pose, bool *found, FfpError *err) {
    double *flat = ffp_alloc((size_t)a->n, 2 * sizeof *flat),
           *rays = ffp_alloc((size_t)a->n, 2 * sizeof *rays);
    unsigned char *inside = ffp_alloc((size_t)a->n, 1);
    double h[9];
    int n = 0; // corners that have a ray
    for (int i = 0; i < a->n; i++) {
        double point[3];
        ffp_board_point(board, i, point);
        flat[2 * n] = point[0], flat[2 * n + 1] = point[1];
        n += ffp_device_ray(camera, a->camera + 2 * (size_t)i, rays + 2 * (size_t)n);
    }
    *found = false;
    const bool ok = n < 4 || ffp_cv_homography(flat, rays, n, 10 / camera->matrix[0], h, inside, found, err);
    ffp_free(flat), ffp_free(rays), ffp_free(inside);
    if (!ok || !*found) return ok;
    PoseState s = {board, camera, a->camera, a->n, {0}, {0}};
    take_apart(h, s.r, s.t);
    const double far = s.t[2], step[6] = {1e-6, 1e-6, 1e-6, 1e-6 * far, 1e-6 * far, 1e-6 * far};
    const FfpLeastSquares fit = {.state = &s,
                                 .numbers = 6,
                                 .count = 2 * a->n,
                                 .differences = pose_differences,
                                 .move = pose_move,
                                 .step = step,
                                 .steps = FFP_FIT_STEPS,
                                 .worth = FFP_FIT_WORTH};
    const double cost = ffp_least_squares(&fit, NULL);
    memcpy(pose->r, s.r, sizeof s.r), memcpy(pose->t, s.t, sizeof s.t);
    pose->rms = sqrt(cost / a->n);
    *found = isfinite(cost);
    return true;
}
