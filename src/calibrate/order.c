// Photographs out of order: which of them, told by the one swap after which the codes lie in a plane.
#include <math.h>
#include <stdio.h>
#include "base/alloc.h"
#include "base/call.h"
#include "base/file.h"
#include "calibrate/board.h"
#include "patterns/patterns.h"

enum { A_SIDE = 16, BITS_MAX = 15 };
#define FITS 0.85 // share of the places that lie in one plane
#define TOLERANCE 4.0

typedef struct Places {
    double from[2 * A_SIDE * A_SIDE]; // camera pixels
    int value[2][A_SIDE * A_SIDE];    // columns and rows as they were decoded
    int n;
} Places;

// Bit `first` of an axis changed over with bit `second`; the same bit twice: the code with its inverse.
typedef struct Swap {
    int axis, first, second;
} Swap;

// Decoded pixels spread over the board.
static void take_places(const FfpBoard *board, const FfpCodeMap *map, const FfpAttitude *a, Places *p) {
    const double *c = a->camera;
    const int ends[4] = {0, board->columns - 1, a->n - board->columns, a->n - 1};
    p->n = 0;
    for (int k = 0; k < A_SIDE * A_SIDE; k++) {
        const double s = (k % A_SIDE + 0.5) / A_SIDE, t = ((k - k % A_SIDE) / (double)A_SIDE + 0.5) / A_SIDE;
        const double weights[4] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
        double x = 0, y = 0;
        for (int e = 0; e < 4; e++)
            x += weights[e] * c[2 * (size_t)ends[e]], y += weights[e] * c[2 * (size_t)ends[e] + 1];
        const int i = (int)lround(x), j = (int)lround(y);
        if (i < 0 || j < 0 || i >= map->width || j >= map->height) continue;
        const size_t at = (size_t)j * (size_t)map->width + (size_t)i;
        if (map->column[at] < 0 || map->row[at] < 0) continue;
        p->from[2 * p->n] = i, p->from[2 * p->n + 1] = j;
        p->value[0][p->n] = (int)map->column[at], p->value[1][p->n] = (int)map->row[at];
        p->n++;
    }
}

// The number that a decoded one would have been after the swap, of `count` bits.
static int swapped(int value, int count, const Swap *swap) {
    bool bits[BITS_MAX];
    const unsigned code = (unsigned)value ^ ((unsigned)value >> 1);
    for (int k = 0; k < count; k++) bits[k] = code >> (count - 1 - k) & 1U;
    const bool held = bits[swap->first];
    bits[swap->first] = swap->first == swap->second ? !held : bits[swap->second];
    if (swap->first != swap->second) bits[swap->second] = held;
    return ffp_gray_decode(bits, count);
}

static bool fits(const Places *p, const Swap *swap, int count, bool *answer, FfpError *err) {
    double *to = ffp_alloc((size_t)p->n + 1, 2 * sizeof *to), h[9];
    unsigned char *inside = ffp_alloc((size_t)p->n + 1, 1);
    bool found;
    int good = 0;
    for (int i = 0; i < p->n; i++)
        for (int axis = 0; axis < 2; axis++)
            to[2 * i + axis] =
                axis == swap->axis ? swapped(p->value[axis][i], count, swap) : p->value[axis][i];
    const bool ok = ffp_cv_homography(p->from, to, p->n, TOLERANCE, h, inside, &found, err);
    for (int i = 0; ok && found && i < p->n; i++) good += inside[i];
    const double *at = p->from, w = ok && found ? h[6] * at[0] + h[7] * at[1] + h[8] : 1;
    *answer = ok && found && good >= FITS * p->n &&
              (h[0] - to[0] * h[6]) * (h[4] - to[1] * h[7]) / (w * w) >
                  (h[1] - to[0] * h[7]) * (h[3] - to[1] * h[6]) / (w * w);
    ffp_free(to), ffp_free(inside);
    return ok;
}

static void name_swap(const FfpCodeShots *shots, int first, const Swap *swap, char text[768]) {
    const char *const *pair = shots->files + first + 2 * (size_t)swap->first +
                              (swap->axis == 1 ? 2 * (size_t)ffp_gray_code_bits(shots->width) : 0);
    if (swap->first == swap->second) {
        snprintf(text, 768, "%.120s and %.120s seem to be swapped, a code and its inverse",
                 ffp_basename(pair[0]), ffp_basename(pair[1]));
        return;
    }
    const char *const *other = pair + 2 * (swap->second - swap->first);
    snprintf(text, 768, "the pairs of %.120s and %.120s seem to be swapped", ffp_basename(pair[0]),
             ffp_basename(other[0]));
}

bool ffp_explain_order(const FfpBoard *board, const FfpCodeMap *map, const FfpCodeShots *shots, int first,
                       const FfpAttitude *attitude, char text[768], FfpError *err) {
    Places *places = ffp_alloc(1, sizeof *places);
    Swap found = {0};
    int explanations = 0;
    bool ok = true;
    take_places(board, map, attitude, places);
    for (int axis = 0; axis < 2; axis++) {
        const int count = ffp_gray_code_bits(axis == 0 ? shots->width : shots->height);
        for (int i = 0; ok && i < count; i++)
            for (int j = i; ok && j < count; j++) {
                const Swap swap = {axis, i, j};
                bool answer;
                ffp_cancel_point();
                ok = fits(places, &swap, count, &answer, err);
                if (ok && answer && explanations++ == 0) found = swap;
            }
    }
    if (explanations == 1)
        name_swap(shots, first, &found, text);
    else
        snprintf(
            text, 768,
            "the codes do not put the board into one plane: the photographs' numbering is not the order in "
            "which the patterns were shown, the picture is mirrored, the panel is of another size, or the "
            "board moved");
    ffp_free(places);
    return ok;
}
