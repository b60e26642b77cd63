// One attitude after another: black and white, the board, the codes.
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/image/photograph.h"
#include "rig/chessboard/chessboard.h"
#include "rig/chessboard/notes.h"
#include "rig/findings/tell.h"
#include "rig/graycode/graycode.h"
#include "rig/shots/tags.h"
#include "rig/shots/taken.h"

// Text without the path to the attitude's folder, whose name stays.
static void shorten_paths(char *text, const char *file, const char *folder) {
    const size_t length = strlen(ffp_basename(file)) + strlen(folder) + 1, all = strlen(file);
    const size_t before = all > length ? all - length : 0;
    for (char *at; before > 0 && (at = strstr(text, file)) != NULL;)
        memmove(at, at + before, strlen(at + before) + 1);
}

// An error of one attitude's pictures leaves that attitude out; all others end the call.
static bool as_problem(FfpAttitude *a, const FfpShotFolder *folder, FfpError *error, FfpError *err) {
    if (error->code == FFP_ERROR_FILE || error->code == FFP_ERROR_IO ||
        error->code == FFP_ERROR_UNSUPPORTED) {
        for (int i = 0; i < folder->n_files; i++)
            if (folder->files[i]) shorten_paths(error->text, folder->files[i], folder->name);
        ffp_attitude_leave_out(a, error);
        return true;
    }
    if (err) *err = *error;
    return false;
}

// The size that most folders' photographs have counts; those of another are left out.
static void settle_size(FfpRigFit *fit, FfpAttitude *a, const FfpImage *white) {
    const FfpCvDevice *camera = &fit->devices[0];
    char usual[40];
    FfpError why = {0};
    if (camera->width == white->width && camera->height == white->height) return;
    snprintf(usual, sizeof usual, "%d x %d", camera->width, camera->height);
    ffp_fail_by(FFP_RULE_TURNED_PICTURES, &(FfpFacts){.x = white->width, .y = white->height, .a = usual},
                NULL, &why);
    ffp_attitude_leave_out(a, &why);
}

static bool read_codes(const FfpRigFit *fit, FfpAttitude *a, const FfpShotFolder *folder,
                       const FfpGrayPhotographs *photographs, const FfpImage *white, FfpError *err) {
    const int size[2] = {photographs->width, photographs->height};
    FfpImage map, region = ffp_board_region(&fit->board, a, white->width, white->height);
    FfpGrayReport report;
    FfpError error = {0};
    FfpGrayPhotographs of_board = *photographs;
    of_board.region = &region;
    const bool ok = ffp_gray_decode_view(&map, &report, &of_board, &error);
    ffp_image_free(&region);
    if (!ok) return as_problem(a, folder, &error, err);
    ffp_gray_tell_light(&report, folder->name);
    a->clipped = report.clipped;
    memcpy(a->dropped, report.dropped, sizeof a->dropped);
    const bool done = ffp_board_project(&fit->board, &map, report.dropped, size, a, err);
    ffp_image_free(&map);
    return done;
}

// The white photograph as the corners' detector has it, off the cache.
static FfpImage take_white(FfpGrayCache *cache) {
    FfpImage white = {0};
    for (int i = 0; i < cache->n && !white.data; i++) {
        white = cache->files[i].luma;
        cache->files[i].luma = (FfpImage){0};
    }
    return white;
}

static bool read_attitude(FfpRigFit *fit, FfpAttitude *a, const FfpShotFolder *folder, FfpImage *seen,
                          FfpError *err) {
    FfpGrayCache cache = {.n = 0}; // each photograph is read once
    FfpGrayPhotographs photographs = {.width = fit->devices[1].width,
                                      .height = fit->devices[1].height,
                                      .linear = fit->linear,
                                      .others = folder->others,
                                      .cache = &cache};
    FfpError error = {0};
    a->name = folder->name;
    if (a->problem[0]) return true;
    if (folder->problem) {
        snprintf(a->problem, sizeof a->problem, "%s", folder->problem);
        return true;
    }
    if (!ffp_gray_find_plain(&photographs, folder->files, folder->n_files, &error)) {
        ffp_gray_cache_free(&cache);
        return as_problem(a, folder, &error, err);
    }
    FfpImage white = take_white(&cache);
    settle_size(fit, a, &white);
    bool ok = a->problem[0] || ffp_board_find(&fit->board, &white, a, err);
    if (ok && !a->problem[0]) ok = read_codes(fit, a, folder, &photographs, &white, err);
    ffp_gray_cache_free(&cache);
    if (ok && a->n == 0 && !seen->data) {
        *seen = white;
    } else {
        ffp_image_free(&white);
    }
    return ok;
}

// Fails if no folder shows the board.
static bool check_seen(const FfpRigFit *fit, const FfpImage *unseen, FfpError *err) {
    char guess[160] = "";
    for (int i = 0; i < fit->n; i++)
        if (fit->attitudes[i].n > 0) return true;
    if (!unseen->data) return true; // nor had any of them photographs to look at, which is reported later
    const size_t pixels = (size_t)unseen->width * (size_t)unseen->height;
    size_t clipped = 0;
    for (size_t i = 0; i < pixels; i++) clipped += (double)unseen->data[i] >= FFP_CLIPPED_LUMA;
    const double share = (double)clipped / (double)pixels;
    if (share > ffp_rule(FFP_RULE_PLAIN_CLIPPED)->limit)
        return ffp_refuse(FFP_RULE_PLAIN_CLIPPED, &(FfpFacts){.a = fit->attitudes[0].name, .figure = share},
                          "white", err);
    return ffp_board_guess(&fit->board, unseen, guess, err) &&
           ffp_refuse(FFP_RULE_NO_BOARD,
                      &(FfpFacts){.x = fit->board.columns,
                                  .y = fit->board.rows,
                                  .z = fit->n,
                                  .a = guess[0] ? guess + 2 : "nor with a row or column more or less"},
                      NULL, err);
}

// --- What most of the folders are like. ---

typedef struct Size {
    int width, height;
} Size;

static Size size_of(const FfpShotFolder *folder) {
    Size size = {0};
    FfpError none = {0};
    if (folder->n_files > 0) ffp_shot_folder_size(folder, &size.width, &size.height, &none);
    return size;
}

static int times(const Size *sizes, int n, const Size *like) {
    int count = 0;
    for (int i = 0; i < n; i++) count += sizes[i].width == like->width && sizes[i].height == like->height;
    return count;
}

// Sets the camera's size to that of most.
static void settle_camera(FfpRigFit *fit, const FfpShotFolders *folders) {
    Size *sizes = ffp_alloc((size_t)folders->n, sizeof *sizes), usual = {0};
    for (int i = 0; i < folders->n; i++) sizes[i] = size_of(&folders->folders[i]);
    for (int i = 0; i < folders->n; i++)
        if (i == 0 || times(sizes, folders->n, &sizes[i]) > times(sizes, folders->n, &usual))
            usual = sizes[i];
    fit->devices[0].width = usual.width, fit->devices[0].height = usual.height;
    ffp_free(sizes);
}

// Folders with photographs that are tagged differently have a problem.
static void check_tags(FfpRigFit *fit, const FfpShotFolders *folders) {
    int *tags = ffp_alloc((size_t)folders->n, sizeof *tags);
    FfpError mixed = {0}, other = {0};
    for (int i = 0; i < folders->n; i++) {
        const FfpShotFolder *folder = &folders->folders[i];
        tags[i] = ffp_tag_of(folder->files, folder->n_files, NULL, &mixed);
        if (tags[i] == 0) ffp_attitude_leave_out(&fit->attitudes[i], &mixed);
    }
    const int usual = ffp_tag_usual(tags, folders->n);
    for (int i = 0; i < folders->n; i++) {
        if (tags[i] == 0 || tags[i] == usual) continue;
        ffp_tag_fail(folders->folders[i].name, tags[i], usual, NULL, &other);
        ffp_attitude_leave_out(&fit->attitudes[i], &other);
    }
    ffp_free(tags);
}

bool ffp_read_attitudes(FfpRigFit *fit, const FfpShotFolders *folders, FfpError *err) {
    const FfpTask task = ffp_task("reading attitudes", folders->n);
    FfpImage unseen = {0};
    bool ok = true;
    fit->n = folders->n;
    fit->attitudes = ffp_alloc((size_t)folders->n, sizeof *fit->attitudes);
    settle_camera(fit, folders);
    check_tags(fit, folders);
    ffp_taken_compare(folders->folders, folders->n, true, NULL);
    for (int i = 0; ok && i < folders->n; i++) {
        ok = read_attitude(fit, &fit->attitudes[i], &folders->folders[i], &unseen, err);
        ffp_task_step(&task, i + 1, NULL);
    }
    ffp_task_end(&task);
    ok = ok && check_seen(fit, &unseen, err);
    if (ok) ffp_note_photographs(fit);
    ffp_image_free(&unseen);
    return ok;
}

void ffp_rig_fit_free(FfpRigFit *fit) {
    for (int i = 0; i < fit->n; i++) ffp_attitude_free(&fit->attitudes[i]);
    ffp_free(fit->attitudes);
    fit->attitudes = NULL, fit->n = 0;
}
