// One attitude after another: black and white, the board, the codes.
#include <stdio.h>
#include <string.h>
#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "calibrate/calibrate.h"

// An error of one attitude's pictures leaves that attitude out; all others end the call.
static bool as_problem(FfpAttitude *a, FfpError *error, FfpError *err) {
    if (error->code == FFP_ERROR_FILE || error->code == FFP_ERROR_IO) {
        snprintf(a->problem, sizeof a->problem, "%s", error->text);
        return true;
    }
    if (err) *err = *error;
    return false;
}

static bool settle_size(FfpRigFit *fit, const FfpImage *white, const char *name, FfpError *err) {
    FfpCvDevice *camera = &fit->devices[0];
    if (camera->width == 0) camera->width = white->width, camera->height = white->height;
    return (camera->width == white->width && camera->height == white->height) ||
           ffp_fail(err, FFP_ERROR_FILE, name,
                    "the photographs are of %d x %d pixels, those of other attitudes of %d x %d",
                    white->width, white->height, camera->width, camera->height);
}

static bool read_codes(const FfpRigFit *fit, FfpAttitude *a, const FfpCodeShots *shots, int first,
                       const FfpImage *black, const FfpImage *white, FfpError *err) {
    FfpCodeMap map;
    FfpError error = {0};
    unsigned char *region = ffp_board_region(&fit->board, a, white->width, white->height);
    const bool ok = ffp_code_map_read(&map, shots, first, black, white, region, &error);
    ffp_free(region);
    if (!ok) return as_problem(a, &error, err);
    for (int axis = 0; axis < 2; axis++)
        if (map.lost[axis] > 0)
            ffp_note("%s: the camera cannot tell the finest %d bits of the %s: they are known to %d pixels",
                     a->name, map.lost[axis], axis == 0 ? "columns" : "rows", 1 << map.lost[axis]);
    const bool done = ffp_board_project(&fit->board, &map, shots, first, a, err);
    ffp_code_map_free(&map);
    return done;
}

static bool read_attitude(FfpRigFit *fit, FfpAttitude *a, const FfpShotFolder *folder, FfpImage *seen,
                          FfpError *err) {
    const FfpCodeShots shots = {folder->files, folder->n_files, fit->devices[1].width,
                                fit->devices[1].height};
    FfpImage black, white;
    FfpError error = {0};
    int first;
    a->name = folder->name;
    if (!ffp_code_shots_open(&shots, &black, &white, &first, &error)) return as_problem(a, &error, err);
    bool ok = settle_size(fit, &white, folder->name, err) && ffp_board_find(&fit->board, &white, a, err);
    if (ok && !a->problem[0]) ok = read_codes(fit, a, &shots, first, &black, &white, err);
    if (ok && a->n == 0 && seen->data == NULL) {
        *seen = white;
    } else {
        ffp_image_free(&white);
    }
    ffp_image_free(&black);
    return ok;
}

// The error where no folder shows the board.
static bool check_seen(const FfpRigFit *fit, const FfpImage *unseen, FfpError *err) {
    char guess[160] = "";
    for (int i = 0; i < fit->n; i++)
        if (fit->attitudes[i].n > 0) return true;
    if (unseen->data == NULL) return true; // nor did any have photographs to look at: that is told later
    return ffp_board_guess(&fit->board, unseen, guess, err) &&
           ffp_fail(err, FFP_ERROR_FILE, NULL,
                    "no chessboard with %d x %d corners inside it is in any of %d attitudes%s (corners are "
                    "counted where four squares meet; it must be whole in the picture, with a light margin)",
                    fit->board.columns, fit->board.rows, fit->n, guess);
}

bool ffp_read_attitudes(FfpRigFit *fit, const FfpShotFolders *folders, FfpError *err) {
    const FfpTask task = ffp_task("reading attitudes", folders->n);
    FfpImage unseen = {0};
    bool ok = true;
    fit->n = folders->n;
    fit->attitudes = ffp_alloc((size_t)folders->n, sizeof *fit->attitudes);
    for (int i = 0; ok && i < folders->n; i++) {
        ok = read_attitude(fit, &fit->attitudes[i], &folders->folders[i], &unseen, err);
        ffp_task_step(&task, i + 1, NULL);
    }
    ffp_task_end(&task);
    ok = ok && check_seen(fit, &unseen, err);
    ffp_image_free(&unseen);
    return ok;
}

void ffp_rig_fit_free(FfpRigFit *fit) {
    for (int i = 0; i < fit->n; i++) ffp_attitude_free(&fit->attitudes[i]);
    ffp_free(fit->attitudes);
    fit->attitudes = NULL, fit->n = 0;
}
