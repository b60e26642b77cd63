// Finding the board in a picture.
#include "rig/chessboard/board.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/image/photograph.h"

#define PICTURE_SIDE 640 // longest side of the report's pictures
#define DIAGONAL 0.3     // squares from a corner to where its four squares are looked at
#define SADDLE 0.5       // of the corners' own contrast: there is one more
#define SADDLES 0.8      // share of a row of them: the board goes on
#define AROUND 0.8       // squares beyond the outermost corners that count as the board

void ffp_attitude_free(FfpAttitude *a) {
    ffp_free(a->camera), ffp_free(a->projector);
    ffp_free(a->camera_state), ffp_free(a->projector_state);
    ffp_free(a->camera_off), ffp_free(a->projector_off);
    ffp_image_free(&a->picture);
    *a = (FfpAttitude){0};
}

void ffp_attitude_leave_out(FfpAttitude *a, const FfpError *why) {
    snprintf(a->problem, sizeof a->problem, "%s", why->text);
    a->finding = why->finding;
}

bool ffp_board_read(FfpImage *grey, const char *path, FfpError *err) {
    FfpImage image;
    if (!ffp_photograph_read(&image, NULL, path, false, NULL, err)) return false;
    *grey = ffp_photograph_luma(&image);
    ffp_image_free(&image);
    return true;
}

static unsigned char *bytes_of(const FfpImage *grey) {
    const size_t pixels = (size_t)grey->width * (size_t)grey->height;
    unsigned char *bytes = ffp_alloc(pixels, 1);
    for (size_t i = 0; i < pixels; i++)
        bytes[i] = (unsigned char)(255 * fminf(1, fmaxf(0, (float)grey->data[i])) + 0.5F);
    return bytes;
}

static bool search(const FfpImage *grey, int columns, int rows, double *corners, bool *found, FfpError *err) {
    unsigned char *bytes = bytes_of(grey);
    const bool ok = ffp_cv_chessboard(bytes, grey->width, grey->height, columns, rows, corners, found, err);
    ffp_free(bytes);
    return ok;
}

static void map_point(const double h[9], double x, double y, double out[2]) {
    const double w = h[6] * x + h[7] * y + h[8];
    out[0] = (h[0] * x + h[1] * y + h[2]) / w, out[1] = (h[3] * x + h[4] * y + h[5]) / w;
}

// --- Whether there are more corners than were asked for. ---

// How much of a saddle lies at a place of the board: the lighter two of four squares across less the darker
// two; not positive where there is none, NAN outside the picture.
static double saddle(const FfpImage *grey, const double h[9], double column, double row) {
    double v[4];
    for (int k = 0; k < 4; k++) {
        double p[2];
        map_point(h, column + (k % 2 ? DIAGONAL : -DIAGONAL), row + (k / 2 ? DIAGONAL : -DIAGONAL), p);
        if (!(p[0] >= 0 && p[1] >= 0 && p[0] <= grey->width - 1 && p[1] <= grey->height - 1)) return NAN;
        real value;
        ffp_image_sample(grey, (real)p[0] + 0.5F, (real)p[1] + 0.5F, &value);
        v[k] = (double)value;
    }
    return fmax(fmin(v[0], v[3]) - fmax(v[1], v[2]), fmin(v[1], v[2]) - fmax(v[0], v[3]));
}

// Share of the corners of a row (or column) that exist, of those inside the picture; 0 for few.
static double share_there(const FfpImage *grey, const double h[9], const FfpBoard *board, int side,
                          double least) {
    const bool across = side < 2; // above, below; then left, right
    const int n = across ? board->columns : board->rows;
    const double beyond = side % 2 == 0 ? -1 : (across ? board->rows : board->columns);
    int seen = 0, there = 0;
    for (int i = 0; i < n; i++) {
        const double s = saddle(grey, h, across ? i : beyond, across ? beyond : i);
        if (isnan(s)) continue;
        seen++, there += s > least;
    }
    return 2 * seen >= n ? (double)there / seen : 0;
}

bool ffp_board_homography(const FfpBoard *board, const FfpAttitude *a, double tolerance, double h[9],
                          bool *found, FfpError *err) {
    double *flat = ffp_alloc((size_t)a->n, 2 * sizeof *flat);
    unsigned char *inside = ffp_alloc((size_t)a->n, 1);
    for (int i = 0; i < a->n; i++)
        flat[2 * i] = ffp_corner_column(board, i), flat[2 * i + 1] = ffp_corner_row(board, i);
    const bool ok = ffp_cv_homography(flat, a->camera, a->n, tolerance, h, inside, found, err);
    ffp_free(flat), ffp_free(inside);
    return ok;
}

static bool check_whole(const FfpBoard *board, const FfpImage *grey, FfpAttitude *a, FfpError *err) {
    double h[9], sum = 0;
    bool found;
    const bool ok = ffp_board_homography(board, a, 3, h, &found, err);
    if (!ok || !found) return ok;
    for (int i = 0; i < a->n; i++)
        sum += saddle(grey, h, ffp_corner_column(board, i), ffp_corner_row(board, i));
    for (int side = 0; side < 4; side++)
        if (share_there(grey, h, board, side, SADDLE * sum / a->n) >= SADDLES) {
            snprintf(a->problem, sizeof a->problem,
                     "the chessboard has more than %d x %d corners: count the inner corners, where four "
                     "squares meet",
                     board->columns, board->rows);
        }
    return true;
}

// --- Finding it. ---

static void keep_picture(const FfpImage *grey, FfpAttitude *a) {
    const int longest = grey->width > grey->height ? grey->width : grey->height;
    a->scale = longest > PICTURE_SIDE ? (double)PICTURE_SIDE / longest : 1;
    a->picture = ffp_image_resize(grey, (int)fmax(1, round(grey->width * a->scale)),
                                  (int)fmax(1, round(grey->height * a->scale)));
}

bool ffp_board_find(const FfpBoard *board, const FfpImage *grey, FfpAttitude *a, FfpError *err) {
    const int n = board->columns * board->rows;
    bool found;
    keep_picture(grey, a);
    a->camera = ffp_alloc((size_t)n, 2 * sizeof *a->camera);
    if (!search(grey, board->columns, board->rows, a->camera, &found, err)) return false;
    if (!found) {
        snprintf(a->problem, sizeof a->problem, "no chessboard with %d x %d inner corners found",
                 board->columns, board->rows);
        return true;
    }
    a->n = n;
    a->projector = ffp_alloc((size_t)n, 2 * sizeof *a->projector);
    a->camera_off = ffp_alloc((size_t)n, 2 * sizeof *a->camera_off);
    a->projector_off = ffp_alloc((size_t)n, 2 * sizeof *a->projector_off);
    a->camera_state = ffp_alloc((size_t)n, 1), a->projector_state = ffp_alloc((size_t)n, 1);
    memset(a->projector_state, FFP_CORNER_DARK, (size_t)n);
    return check_whole(board, grey, a, err);
}

bool ffp_board_guess(const FfpBoard *board, const FfpImage *grey, char text[160], FfpError *err) {
    double *corners =
        ffp_alloc((size_t)(board->columns + 2) * (size_t)(board->rows + 2), 2 * sizeof *corners);
    bool ok = true, found = false;
    *text = 0;
    for (int dx = 1; ok && !found && dx >= -1; dx--)
        for (int dy = 1; ok && !found && dy >= -1; dy--) {
            const int columns = board->columns + dx, rows = board->rows + dy;
            if ((dx == 0 && dy == 0) || columns < 3 || rows < 3) continue;
            ffp_cancel_point();
            ok = search(grey, columns, rows, corners, &found, err);
            if (ok && found) snprintf(text, 160, "; there is one with %d x %d", columns, rows);
        }
    ffp_free(corners);
    return ok;
}

// --- Its region. ---

static bool is_left(const double a[2], const double b[2], double x, double y) {
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0;
}

FfpImage ffp_board_region(const FfpBoard *board, const FfpAttitude *a, int width, int height) {
    const int ends[4] = {0, board->columns - 1, a->n - 1, a->n - board->columns};
    double rim[8];
    for (int k = 0; k < 4; k++) // each outermost corner moved on along both rows of corners that end there
        for (int c = 0; c < 2; c++) {
            const double *at = a->camera + c;
            const double here = at[2 * (size_t)ends[k]], across = here - at[2 * (size_t)ends[k ^ 1]],
                         down = here - at[2 * (size_t)ends[3 - k]];
            rim[2 * k + c] = here + AROUND * (across / (board->columns - 1) + down / (board->rows - 1));
        }
    FfpImage region = ffp_image_new(width, height, 1);
    const bool sense = is_left(rim, rim + 2, rim[4], rim[5]);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            bool in = true;
            for (int k = 0; in && k < 4; k++)
                in = is_left(rim + 2 * k, rim + 2 * ((k + 1) % 4), x, y) == sense;
            region.data[(size_t)y * (size_t)width + (size_t)x] = in;
        }
    return region;
}
