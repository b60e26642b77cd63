// Where the board is in a photograph, told while it can still be held another way.
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/rigid.h"
#include "core/capture/node.h"
#include "rig/chessboard/chessboard.h"

// Share of the board that is saturated.
static double clipped_share(const FfpBoard *board, const FfpAttitude *a, const FfpImage *grey) {
    FfpImage region = ffp_board_region(board, a, grey->width, grey->height);
    size_t inside = 0, clipped = 0;
    for (size_t i = 0; i < (size_t)grey->width * (size_t)grey->height; i++) {
        inside += region.data[i] > 0;
        clipped += region.data[i] > 0 && (double)grey->data[i] >= FFP_CLIPPED_LUMA;
    }
    ffp_image_free(&region);
    return inside > 0 ? (double)clipped / (double)inside : 0;
}

// Pixel centres lie at integer + 0.5 here, as everywhere outside this room.
static json_t *corners_of(const FfpAttitude *a) {
    json_t *corners = json_array();
    for (int i = 0; i < a->n; i++)
        json_array_append_new(
            corners, json_pack("[f, f]", a->camera[2 * (size_t)i] + 0.5, a->camera[2 * (size_t)i + 1] + 0.5));
    return corners;
}

static bool describe_board(json_t *seen, const FfpBoard *board, const FfpAttitude *a, const FfpImage *grey,
                           FfpError *err) {
    double normal[3];
    if (!ffp_board_normal(board, a, grey->width, grey->height, normal, err)) return false;
    const double sense = normal[2] < 0 ? -1 : 1, tilt = acos(fmin(1, fabs(normal[2])));
    json_object_set_new(seen, "tilt", json_real(tilt * 180 / FFP_PI_DOUBLE));
    json_object_set_new(seen, "towards", json_pack("[f, f]", sense * normal[0], sense * normal[1]));
    json_object_set_new(seen, "clipped", json_real(clipped_share(board, a, grey)));
    json_object_set_new(seen, "corners", corners_of(a));
    return true;
}

static bool look(json_t *photographs, const FfpBoard *board, const char *path, FfpError *err) {
    FfpImage grey;
    FfpAttitude a = {.name = path};
    char guess[160] = "", problem[2 * sizeof guess + sizeof a.problem];
    if (!ffp_board_read(&grey, path, err)) return false;
    bool ok = ffp_board_find(board, &grey, &a, err) && (a.n > 0 || ffp_board_guess(board, &grey, guess, err));
    json_t *seen = json_object();
    json_array_append_new(photographs, seen);
    snprintf(problem, sizeof problem, "%s%s", a.problem, guess);
    json_object_set_new(seen, "width", json_integer(grey.width));
    json_object_set_new(seen, "height", json_integer(grey.height));
    json_object_set_new(seen, "found", json_boolean(a.n > 0 && !a.problem[0]));
    json_object_set_new(seen, "problem", json_string(problem));
    ok = ok && (a.n == 0 || describe_board(seen, board, &a, &grey, err));
    ffp_attitude_free(&a);
    ffp_image_free(&grey);
    return ok;
}

static bool write_json(const json_t *root, const char *path, FfpError *err) {
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(6));
    if (!text) return ffp_fail(err, FFP_ERROR_MEMORY, path, "cannot write the JSON");
    const bool ok = ffp_write_file(path, text, strlen(text), err);
    free(text);
    return ok;
}

bool ffp_write_boards_seen(const FfpBoard *board, const char *const *photographs, int n, const char *path,
                           FfpError *err) {
    bool ok = true;
    json_t *seen = json_array(), *root = json_pack("{s:i, s:o}", "version", 1, "photographs", seen);
    ffp_json_own(root);
    for (int i = 0; ok && i < n; i++) ok = look(seen, board, photographs[i], err);
    ok = ok && write_json(root, path, err);
    ffp_json_release(root);
    return ok;
}
