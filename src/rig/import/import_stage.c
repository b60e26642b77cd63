// Import: the empty stage, as each view's camera sees it.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"
#include "rig/masks/stage_moved.h"

#define LIGHT_LEAST 0.001 // of full scale, by which the room's light must differ, and
#define LIGHT_CHANGE 0.25 // of the brighter one

static const char *const *files_of(const FfpImporting *import, int stop) {
    return import->shots.empty + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
}

// Whether two stops share their pictures of the stage: the same files, seen by the same camera.
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

// Names what was bumped or photographed from another place: most views, then it is the stage, or one of them.
static void warn_of_displacement(const FfpImporting *import) {
    const FfpCapture *capture = &import->capture;
    const int black = import->shots.black, white = import->shots.white;
    int count = 0, odd = 0, most[2] = {0, 0};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *images = capture->views[v].images, *stage = import->stages[v].images;
        int moved[2];
        if (!import->made[v] || !stage[black].data || !stage[white].data) continue;
        ffp_stage_moved(moved, &images[black], &images[white], &stage[black], &stage[white]);
        if (moved[0] == 0 && moved[1] == 0) continue;
        count++;
        if (hypot(moved[0], moved[1]) > hypot(most[0], most[1]))
            most[0] = moved[0], most[1] = moved[1], odd = v;
    }
    if (count > 0)
        ffp_tell(2 * count > capture->n_views ? FFP_RULE_STAGE_ELSEWHERE : FFP_RULE_VIEW_ELSEWHERE,
                 &(FfpFacts){.view = capture->views[odd].id, .x = most[0], .y = most[1]});
}

static double median_of(const FfpImage *black) {
    const size_t pixels = (size_t)black->width * (size_t)black->height;
    double *levels = ffp_alloc(pixels + 1, sizeof *levels);
    for (size_t i = 0; i < pixels; i++)
        levels[i] = (double)(black->data[3 * i] + black->data[3 * i + 1] + black->data[3 * i + 2]) / 3;
    const double out = ffp_median(levels, pixels);
    ffp_free(levels);
    return out;
}

// Lamps that were switched, and daylight that changed, after the stage was photographed.
static void warn_of_other_room_light(const FfpImporting *import) {
    const int black = import->shots.black;
    int odd = -1;
    double here = 0, there = 0, most = 0;
    for (int v = 0; v < import->capture.n_views; v++) {
        if (!import->made[v] || !import->stages[v].images[black].data) continue;
        const double view = median_of(&import->capture.views[v].images[black]),
                     stage = median_of(&import->stages[v].images[black]), off = fabs(view - stage);
        if (off > fmax(LIGHT_LEAST, LIGHT_CHANGE * fmax(view, stage)) && off > most)
            odd = v, most = off, here = view, there = stage;
    }
    if (odd >= 0)
        ffp_tell(FFP_RULE_STAGE_LIGHT,
                 &(FfpFacts){.view = import->capture.views[odd].id, .figure = here, .x = there});
}

static double mean_of(const FfpImage *image) {
    const size_t numbers = 3 * (size_t)image->width * (size_t)image->height;
    double sum = 0;
    for (size_t i = 0; i < numbers; i++) sum += (double)image->data[i];
    return sum / (double)numbers;
}

static bool check_order(const FfpImporting *import, FfpError *err) {
    for (int v = 0; v < import->capture.n_views; v++) {
        const FfpImage *black = &import->stages[v].images[import->shots.black],
                       *white = &import->stages[v].images[import->shots.white];
        if (!black->data || !white->data || mean_of(black) <= mean_of(white) + LIGHT_LEAST) continue;
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "empty",
                        "the stage is brighter under black (%.4f of full scale) than under white (%.4f): the "
                        "two pictures are exchanged",
                        mean_of(black), mean_of(white));
    }
    return true;
}

bool ffp_importing_compare_stage(const FfpImporting *import, FfpError *err) {
    if (!check_order(import, err)) return false;
    warn_of_displacement(import);
    warn_of_other_room_light(import);
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
    return ffp_importing_compare_stage(import, err);
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
