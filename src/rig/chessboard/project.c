// Corners of the board on the projector's panel.
#include <math.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "rig/chessboard/board.h"
#include "rig/findings/tell.h"

#define WINDOW 0.5 // half a side of a corner's surroundings, in distances to its nearest neighbour
enum { HALF_LEAST = 5, HALF_MOST = 40, SAMPLES_A_SIDE = 40 };
#define DECODED 0.3   // share of the surroundings that must be decoded
#define INSIDE 0.7    // share of those that must lie in one plane
#define TOLERANCE 1.5 // projector pixels: rounding, and a pixel that sees two
#define PLANE 0.01    // of the panel: distance of a corner from where the board's plane puts it; lenses bend
#define PLANE_LEAST 4 // projector pixels
#define FITTING 0.6   // share of the decoded corners that must lie in the board's plane
#define ENOUGH 0.4    // share of all corners that must be decoded

typedef struct Points {
    double *from, *to;     // [n,2]
    unsigned char *inside; // [n]
    int n, seen;
} Points;

static double nearest_neighbour(const FfpBoard *board, const FfpAttitude *a, int i) {
    const int column = i % board->columns, row = i / board->columns;
    double least = INFINITY;
    for (int k = 0; k < 4; k++) {
        const int x = column + (k == 0) - (k == 1), y = row + (k == 2) - (k == 3);
        if (x < 0 || y < 0 || x >= board->columns || y >= board->rows) continue;
        const double *p = a->camera + 2 * ((size_t)y * (size_t)board->columns + (size_t)x),
                     *here = a->camera + 2 * (size_t)i;
        least = fmin(least, hypot(p[0] - here[0], p[1] - here[1]));
    }
    return least;
}

// Positions around a corner; camera pixels relative to it.
static void surroundings(const FfpImage *map, const double corner[2], int half, Points *p) {
    const int cx = (int)lround(corner[0]), cy = (int)lround(corner[1]);
    const int step = (2 * half + SAMPLES_A_SIDE) / SAMPLES_A_SIDE;
    p->n = p->seen = 0;
    for (int y = cy - half; y <= cy + half; y += step)
        for (int x = cx - half; x <= cx + half; x += step) {
            if (x < 0 || y < 0 || x >= map->width || y >= map->height) continue;
            const real *at = map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x);
            p->seen++;
            if (!(at[2] > 0)) continue;
            p->from[2 * p->n] = x - corner[0], p->from[2 * p->n + 1] = y - corner[1];
            for (int k = 0; k < 2; k++) p->to[2 * p->n + k] = (double)at[k] - 0.5; // centres at integers
            p->n++;
        }
}

// By the homography of its surroundings; *mirrored is its sense.
static bool place_corner(const FfpBoard *board, const FfpImage *map, double tolerance, FfpAttitude *a, int i,
                         Points *p, bool *mirrored, FfpError *err) {
    const double distance = WINDOW * nearest_neighbour(board, a, i);
    double h[9];
    bool found;
    int inside = 0;
    surroundings(map, a->camera + 2 * (size_t)i, (int)fmax(HALF_LEAST, fmin(HALF_MOST, distance)), p);
    a->projector_state[i] = FFP_CORNER_DARK;
    if (p->n < DECODED * p->seen || p->n < 12) return true;
    if (!ffp_cv_homography(p->from, p->to, p->n, tolerance, h, p->inside, &found, err)) return false;
    for (int k = 0; found && k < p->n; k++) inside += p->inside[k];
    a->projector_state[i] = FFP_CORNER_UNEVEN;
    if (inside < INSIDE * p->n) return true;
    a->projector_state[i] = FFP_CORNER_USED;
    const double *to = &a->projector[2 * (size_t)i];
    a->projector[2 * (size_t)i] = h[2] / h[8], a->projector[2 * (size_t)i + 1] = h[5] / h[8];
    *mirrored = (h[0] - to[0] * h[6]) * (h[4] - to[1] * h[7]) < (h[1] - to[0] * h[7]) * (h[3] - to[1] * h[6]);
    return true;
}

// Corners that lie away from the plane of the others are uneven; *share is that of the decoded ones in it.
static bool check_plane(const FfpBoard *board, double longest, FfpAttitude *a, Points *p, double *share,
                        FfpError *err) {
    double h[9];
    bool found;
    int inside = 0;
    p->n = 0;
    for (int i = 0; i < a->n; i++) {
        if (a->projector_state[i] != FFP_CORNER_USED) continue;
        p->from[2 * p->n] = ffp_corner_column(board, i), p->from[2 * p->n + 1] = ffp_corner_row(board, i);
        for (int k = 0; k < 2; k++) p->to[2 * p->n + k] = a->projector[2 * (size_t)i + (size_t)k];
        p->n++;
    }
    *share = 0;
    if (p->n < 8) return true;
    if (!ffp_cv_homography(p->from, p->to, p->n, fmax(PLANE_LEAST, PLANE * longest), h, p->inside, &found,
                           err))
        return false;
    for (int i = 0, k = 0; found && i < a->n; i++) {
        if (a->projector_state[i] != FFP_CORNER_USED) continue;
        inside += p->inside[k];
        if (!p->inside[k++]) a->projector_state[i] = FFP_CORNER_UNEVEN;
    }
    *share = (double)inside / p->n;
    return true;
}

// Finds faults of the codes as a whole.
static void judge(FfpAttitude *a, const int states[FFP_CORNER_STATES], double share, bool mirrored) {
    const int good = states[FFP_CORNER_USED], uneven = states[FFP_CORNER_UNEVEN];
    const FfpRuleId rule = good + uneven < ENOUGH * a->n                         ? FFP_RULE_BOARD_DARK
                           : good < FITTING * (good + uneven) || share < FITTING ? FFP_RULE_BOARD_UNEVEN
                                                                                 : FFP_RULE_BOARD_MIRRORED;
    FfpError why = {0};
    if (rule == FFP_RULE_BOARD_MIRRORED && !mirrored) return;
    ffp_fail_by(rule, &(FfpFacts){.x = good + uneven, .y = a->n}, NULL, &why);
    ffp_attitude_leave_out(a, &why);
}

bool ffp_board_project(const FfpBoard *board, const FfpImage *map, const int dropped[2], const int size[2],
                       FfpAttitude *a, FfpError *err) {
    const size_t room = (size_t)(SAMPLES_A_SIDE + 2) * (SAMPLES_A_SIDE + 2) + (size_t)a->n;
    const double tolerance = TOLERANCE * fmax(1 << dropped[0], 1 << dropped[1]);
    Points points = {.from = ffp_alloc(room, 2 * sizeof(double)),
                     .to = ffp_alloc(room, 2 * sizeof(double)),
                     .inside = ffp_alloc(room, 1)};
    int states[FFP_CORNER_STATES] = {0}, mirrored = 0;
    double share = 0;
    bool ok = true;
    for (int i = 0; ok && i < a->n; i++) {
        bool other_way = false;
        ffp_cancel_point();
        ok = place_corner(board, map, tolerance, a, i, &points, &other_way, err);
        mirrored += other_way;
        states[a->projector_state[i]]++;
    }
    ok = ok && check_plane(board, fmax(size[0], size[1]), a, &points, &share, err);
    if (ok) judge(a, states, share, 2 * mirrored > states[FFP_CORNER_USED]);
    ffp_free(points.from), ffp_free(points.to), ffp_free(points.inside);
    return ok;
}
