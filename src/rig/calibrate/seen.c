// Where the board is in a photograph, told while it can still be held another way.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/rigid.h"
#include "rig/calibrate/calibrate.h"

#define CLIPPED 0.99 // of full scale

// Share of the board that is saturated.
static double clipped_share(const FfpBoard *board, const FfpAttitude *a, const FfpImage *grey) {
    FfpImage region = ffp_board_region(board, a, grey->width, grey->height);
    size_t inside = 0, clipped = 0;
    for (size_t i = 0; i < (size_t)grey->width * (size_t)grey->height; i++) {
        inside += region.data[i] > 0;
        clipped += region.data[i] > 0 && (double)grey->data[i] >= CLIPPED;
    }
    ffp_image_free(&region);
    return inside > 0 ? (double)clipped / (double)inside : 0;
}

// Pixel centres lie at integer + 0.5 here, as everywhere outside this room.
static bool write_corners(FILE *stream, const FfpBoard *board, const FfpAttitude *a, const FfpImage *grey,
                          FfpError *err) {
    double normal[3];
    if (!ffp_board_normal(board, a, grey->width, grey->height, normal, err)) return false;
    const double sense = normal[2] < 0 ? -1 : 1, tilt = acos(fmin(1, fabs(normal[2])));
    fprintf(stream, ", \"tilt\": %.1f, \"towards\": [%.3f, %.3f], \"clipped\": %.4f,\n  \"corners\": [",
            tilt * 180 / FFP_PI_DOUBLE, sense * normal[0], sense * normal[1], clipped_share(board, a, grey));
    for (int i = 0; i < a->n; i++)
        fprintf(stream, "%s[%.2f, %.2f]", i > 0 ? ", " : "", a->camera[2 * (size_t)i] + 0.5,
                a->camera[2 * (size_t)i + 1] + 0.5);
    fputs("]", stream);
    return true;
}

static bool look(FILE *stream, const FfpBoard *board, const char *path, FfpError *err) {
    FfpImage grey;
    FfpAttitude a = {.name = path};
    char guess[160] = "";
    if (!ffp_board_read(&grey, path, err)) return false;
    bool ok = ffp_board_find(board, &grey, &a, err) && (a.n > 0 || ffp_board_guess(board, &grey, guess, err));
    fprintf(stream, "{\"width\": %d, \"height\": %d, \"found\": %s, \"problem\": \"%s%s\"", grey.width,
            grey.height, a.n > 0 && !a.problem[0] ? "true" : "false", a.problem, guess);
    ok = ok && (a.n == 0 || write_corners(stream, board, &a, &grey, err));
    fputs("}", stream);
    ffp_attitude_free(&a);
    ffp_image_free(&grey);
    return ok;
}

bool ffp_write_boards_seen(const FfpBoard *board, const char *const *photographs, int n, const char *path,
                           FfpError *err) {
    FfpOutput out;
    bool ok = true;
    if (!ffp_output_open(&out, path, err)) return false;
    fputs("{\n \"version\": 1,\n \"photographs\": [", out.stream);
    for (int i = 0; ok && i < n; i++) {
        if (i > 0) fputs(",\n  ", out.stream);
        ok = look(out.stream, board, photographs[i], err);
    }
    fputs("]\n}\n", out.stream);
    if (ok) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return false;
}
