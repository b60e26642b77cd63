// Import: the empty stage, as each view's camera sees it.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/import/import_steps.h"

static const char *const *files_of(const FfpImporting *import, int stop) {
    return import->shots.empty + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
}

// True if two stops share their pictures of the stage: the same files, seen by the same camera.
static bool is_shared(const FfpImporting *import, int a, int b) {
    const FfpOptics *optics[2] = {&import->calibration.stops[a].camera, &import->calibration.stops[b].camera};
    for (int p = 0; p < import->shots.n_patterns; p++) {
        const char *paths[2] = {files_of(import, a)[p], files_of(import, b)[p]};
        if (!paths[0] != !paths[1] || (paths[0] && strcmp(paths[0], paths[1]) != 0)) return false;
    }
    return memcmp(optics[0], optics[1], sizeof *optics[0]) == 0;
}

// On a turntable all views have one camera; elsewhere the stage looks different from each place.
static bool check_camera(const FfpImporting *import, FfpError *err) {
    const bool turns = ffp_turntable_is_given(&import->settings->turntable);
    const int n = import->capture.n_views;
    if (turns || n < 2 ||
        strcmp(files_of(import, 0)[import->shots.white], files_of(import, 1)[import->shots.white]) != 0)
        return true;
    return ffp_fail(
        err, FFP_ERROR_ARGUMENT, "empty",
        "one picture of the stage for %d views, but there is no turntable: where the camera moves "
        "each view has its own ({view} in the file's name)",
        n);
}

static bool load(FfpImporting *import, int stop, FfpError *err) {
    FfpEmptyStage *stage = &import->stages[stop];
    stage->images = ffp_alloc((size_t)import->shots.n_patterns, sizeof *stage->images);
    for (int p = 0; p < import->shots.n_patterns; p++) {
        const char *path = files_of(import, stop)[p];
        if (path && !ffp_importing_read_picture(import, path, stop, &stage->images[p], NULL, err))
            return false;
    }
    return true;
}

bool ffp_importing_load_stage(FfpImporting *import, FfpError *err) {
    const int n = import->capture.n_views;
    if (!import->shots.empty) return true;
    if (!check_camera(import, err)) return false;
    import->stages = ffp_alloc((size_t)n, sizeof *import->stages);
    for (int v = 0; v < n; v++) {
        if (v > 0 && is_shared(import, 0, v))
            import->stages[v] = import->stages[0];
        else if (!load(import, v, err))
            return false;
    }
    return true;
}

void ffp_importing_free_stage(FfpImporting *import) {
    for (int v = 0; import->stages && v < import->capture.n_views; v++) {
        FfpImage *images = import->stages[v].images;
        if (!images || (v > 0 && images == import->stages[0].images)) continue;
        for (int p = 0; p < import->shots.n_patterns; p++) ffp_image_free(&images[p]);
        if (v > 0) ffp_free(images);
    }
    if (import->stages) ffp_free(import->stages[0].images);
    ffp_free(import->stages);
    import->stages = NULL;
}
