// A camera and a projector before a chessboard, rendered with nothing of the library but its lens and its
// patterns, so that a calibration has a truth to be held against.
#ifndef FFP_TESTS_BOARD_RIG_H
#define FFP_TESTS_BOARD_RIG_H

#include <math.h>
#include <sys/stat.h>
#include "core/base/rigid.h"
#include "core/base/rng.h"
#include "core/image/image.h"
#include "core/patterns/patterns.h"
#include "rig/optics/lens.h"
#include "scratch.h"

enum {
    CAMERA_W = 480,
    CAMERA_H = 360,
    PANEL_W = 250, // no power of two: some codes name no column
    PANEL_H = 190,
    COLUMNS = 7,
    ROWS = 5,
    PAIRS = 16,
    SUB = 3 // samples a side of a pixel
};
#define SQUARE 30.0
#define NOISE 0.006

typedef struct Device { // OpenCV's pixels: centres at integers
    double fx, fy, cx, cy, lens[5];
} Device;
static const Device camera = {620, 615, 247, 174, {-0.18, 0.11, 0.0011, -0.0007, 0}};
static const Device projector = {310, 312, 121, 141, {-0.06, 0.04, -0.0005, 0.0008, 0}};
static const double c2p_turn[3] = {0.06, -0.32, 0.02}, c2p_shift[3] = {170, 15, 20}; // X_p = R X_c + T

typedef struct Placed { // a board before the camera
    double r[9], t[3];
    double margin; // white around its squares, squares
    bool no_squares;
} Placed;

static Placed placed(double x, double y, double z, double tx, double ty, double tz) {
    const double v[3] = {x, y, z};
    Placed p = {.t = {tx, ty, tz}, .margin = 1};
    ffp_rotation_from_vector(v, p.r);
    return p;
}

static void undistorted(const Device *d, double px, double py, double ray[3]) {
    const double x = (px - d->cx) / d->fx, y = (py - d->cy) / d->fy;
    ray[0] = x, ray[1] = y, ray[2] = 1;
    for (int i = 0; i < 12; i++) {
        double u, v;
        ffp_lens_distort(d->lens, ray[0], ray[1], &u, &v);
        ray[0] += x - u, ray[1] += y - v;
    }
}

// Linear albedo at a place of the board's plane, in squares from its first inner corner.
static double albedo(const Placed *board, double x, double y) {
    const bool inside = x > -1 && y > -1 && x < COLUMNS && y < ROWS;
    const bool margin = x > -1 - board->margin && y > -1 - board->margin && x < COLUMNS + board->margin &&
                        y < ROWS + board->margin;
    if (inside && !board->no_squares) return ((int)floor(x) + (int)floor(y)) & 1 ? 0.75 : 0.06;
    return margin ? 0.75 : 0.3;
}

typedef struct Sample {
    float albedo, share; // share: cosine towards the projector
    int column, row;     // -1: outside the panel
} Sample;

// The rays of all samples, worked out once.
static const double *camera_rays(void) {
    static double rays[3 * CAMERA_W * CAMERA_H * SUB * SUB];
    const bool done = rays[2] != 0; // z is 1 then
    for (int i = 0; !done && i < CAMERA_W * CAMERA_H * SUB * SUB; i++) {
        const int pixel = i / (SUB * SUB), k = i % (SUB * SUB), x = pixel % CAMERA_W, y = pixel / CAMERA_W;
        undistorted(&camera, x + (k % SUB + 0.5) / SUB - 0.5, y + (k / SUB + 0.5) / SUB - 0.5,
                    rays + 3 * (size_t)i);
    }
    return rays;
}

// The surface that each sample of the camera's pixels sees. [CAMERA_H * CAMERA_W * SUB * SUB]
static Sample *see(const Placed *board) {
    Sample *samples = ffp_alloc((size_t)CAMERA_W * CAMERA_H * SUB * SUB, sizeof *samples);
    double turn[9];
    ffp_rotation_from_vector(c2p_turn, turn);
    const double normal[3] = {board->r[2], board->r[5], board->r[8]};
    size_t at = 0;
    const double *rays = camera_rays();
    for (int y = 0; y < CAMERA_H; y++)
        for (int x = 0; x < CAMERA_W; x++)
            for (int k = 0; k < SUB * SUB; k++) {
                const double *ray = rays + 3 * at;
                double p[3], rel[3], q[3], u, v;
                const double far = ffp_dot(normal, board->t) / ffp_dot(normal, ray);
                Sample *s = &samples[at++];
                *s = (Sample){.column = -1, .row = -1};
                if (!(far > 0)) continue;
                for (int i = 0; i < 3; i++) p[i] = far * ray[i], rel[i] = p[i] - board->t[i];
                double on[2] = {0, 0}; // R^T rel, from the board's middle
                for (int i = 0; i < 3; i++)
                    on[0] += board->r[3 * i] * rel[i], on[1] += board->r[3 * i + 1] * rel[i];
                s->albedo = (float)albedo(board, on[0] / SQUARE + 0.5 * (COLUMNS - 1),
                                          on[1] / SQUARE + 0.5 * (ROWS - 1));
                for (int i = 0; i < 3; i++) q[i] = ffp_dot(turn + 3 * i, p) + c2p_shift[i];
                if (!(q[2] > 0)) continue;
                ffp_lens_distort(projector.lens, q[0] / q[2], q[1] / q[2], &u, &v);
                const double column = floor(projector.fx * u + projector.cx + 0.5),
                             row = floor(projector.fy * v + projector.cy + 0.5);
                if (column < 0 || row < 0 || column >= PANEL_W || row >= PANEL_H) continue;
                s->column = (int)column, s->row = (int)row, s->share = 1;
            }
    return samples;
}

// The photograph under a pattern of the panel's size, NULL for a dark projector.
static void photograph(const Sample *samples, const FfpImage *pattern, double gain, FfpRng *rng,
                       const char *path) {
    FfpImage out = ffp_image_new(CAMERA_W, CAMERA_H, 1);
    FfpError err = {0};
    for (size_t i = 0; i < (size_t)CAMERA_W * CAMERA_H; i++) {
        double sum = 0;
        for (int k = 0; k < SUB * SUB; k++) {
            const Sample *s = &samples[i * SUB * SUB + (size_t)k];
            const double light = pattern && s->column >= 0
                                     ? (double)pattern->data[(size_t)s->row * PANEL_W + (size_t)s->column]
                                     : 0;
            sum += (double)s->albedo * (0.03 + light);
        }
        const double linear = gain * sum / (SUB * SUB);
        out.data[i] = (real)pow(fmin(1, linear), 1 / 2.2) + (real)(NOISE * (double)ffp_rng_normal(rng));
    }
    if (!ffp_image_write_png(&out, path, &err)) fail_msg("%s", err.text);
    ffp_image_free(&out);
}

// The pictures of one attitude into a folder: black, white, codes; `codes_first`: codes, white, black.
static void shoot(const Placed *board, const char *folder, bool codes_first) {
    FfpRng rng = ffp_rng(7, 1);
    char path[FFP_PATH_MAX + 32];
    Sample *samples = see(board);
    assert_int_equal(mkdir(folder, 0777), 0);
    for (int i = 0; i < 2 * PAIRS + 2; i++) {
        const int code = codes_first ? i : i - 2;
        FfpImage pattern = {0};
        if (code >= 0 && code < 2 * PAIRS)
            pattern = ffp_pattern_gray_code(PANEL_W, PANEL_H, code / PAIRS, code / 2 % (PAIRS / 2), code % 2);
        else if (codes_first ? code == 2 * PAIRS : i == 1)
            pattern = ffp_pattern_plain(PANEL_W, PANEL_H, 255);
        snprintf(path, sizeof path, "%s/shot_%d.png", folder, i + 1);
        photograph(samples, pattern.data ? &pattern : NULL, 1, &rng, path);
        ffp_image_free(&pattern);
    }
    ffp_free(samples);
}

#endif
