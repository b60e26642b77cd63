#include "rig/shots/sets.h"
#include <string.h>
#include "core/base/alloc.h"
#include "core/image/photograph.h"
#include "rig/shots/file_names.h"

#define PIXELS_MOST 3e5 // of a photograph that is looked at

// By what photographs of this size are reduced for a look at their order.
static int shrink_for(const char *file) {
    int width, height, shrink = 1;
    FfpError none = {0};
    if (!ffp_photograph_read_size(&width, &height, file, &none)) return 1;
    while (shrink < 8 && width % (2 * shrink) == 0 && height % (2 * shrink) == 0 &&
           (double)width * height > PIXELS_MOST * shrink * shrink)
        shrink *= 2;
    return shrink;
}

static const char *among(const char *const *files, int n, const char *path) {
    for (int i = 0; i < n; i++)
        if (files[i] == path) return path;
    return NULL;
}

bool ffp_set_sort(FfpShots *shots, int stop, const FfpGrayPhotographs *panel, const char *const *files,
                  int n) {
    FfpGrayCache cache = {.n = 0};
    FfpGrayPhotographs seen = *panel;
    FfpError none = {0};
    seen.cache = &cache, seen.shrink = shrink_for(files[0]);
    const bool ok = ffp_gray_find_plain(&seen, files, n, &none);
    if (ok) {
        const char **pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
        pictures[shots->black] = among(files, n, seen.black);
        pictures[shots->white] = among(files, n, seen.white);
        for (int i = 0; i < shots->n_codes; i++) shots->codes[stop * shots->n_codes + i] = seen.codes[i];
    }
    ffp_gray_cache_free(&cache);
    return ok;
}

static int count_plain(const FfpShots *shots, int stop) {
    const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    return (pictures[shots->black] != NULL) + (pictures[shots->white] != NULL);
}

// The view's files that exist, black and white first, [2 + n_codes].
static int list_view(const FfpShots *shots, int stop, const char **files) {
    const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    int n = 0;
    for (int i = -2; i < shots->n_codes; i++) {
        const int plain = i == -2 ? shots->black : shots->white;
        const char *file = i < 0 ? pictures[plain] : shots->codes[stop * shots->n_codes + i];
        if (file) files[n++] = file;
    }
    return n;
}

void ffp_sets_sort_found(FfpShots *shots, int stops, const FfpGrayPhotographs *panel) {
    const char **files = ffp_alloc((size_t)shots->n_codes + 2, sizeof *files);
    for (int stop = 0; stop < stops; stop++) {
        const int n = list_view(shots, stop, files), there = n - count_plain(shots, stop);
        // Where some are missing, the files' numbers say which.
        const bool whole = there == shots->n_codes || 2 * there == shots->n_codes;
        if (whole && ffp_set_sort(shots, stop, panel, files, n)) continue;
        const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
        const bool missing[2] = {!pictures[shots->black], !pictures[shots->white]};
        if (there > 0) ffp_gray_tell_made(missing, shots->codes + (ptrdiff_t)stop * shots->n_codes);
    }
    ffp_free(files);
}

bool ffp_sets_find(FfpShots *shots, const char *template, const FfpCalibration *calibration,
                   const FfpShown *shown, const FfpGrayPhotographs *panel) {
    const int stops = calibration->n_stops, most = 2 * shots->n_codes + 8;
    FfpShotFolder *views = ffp_arena_alloc(shots->arena, (size_t)stops, sizeof *views);
    const char **files = ffp_arena_alloc(shots->arena, (size_t)most, sizeof *files);
    bool ok = ffp_files_list(views, shots->arena, template, calibration);
    for (int stop = 0; ok && stop < stops; stop++) {
        FfpShotFolder *view = &views[stop];
        memset(shots->codes + (ptrdiff_t)stop * shots->n_codes, 0,
               (size_t)shots->n_codes * sizeof *shots->codes);
        const int n = list_view(shots, stop, files);
        ok = (!shown || !ffp_shot_folder_select(view, shown, shots->arena)) && n + view->n_files <= most;
        if (ok) memcpy(files + n, view->files, (size_t)view->n_files * sizeof *files);
        FfpGrayPhotographs own = *panel;
        own.others = view->others;
        ok = ok && ffp_set_sort(shots, stop, &own, files, n + view->n_files);
    }
    return ok;
}
