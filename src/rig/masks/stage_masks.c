#include <math.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "rig/checks/chord.h"
#include "rig/findings/tell.h"
#include "rig/masks/carve.h"
#include "rig/masks/limits.h"
#include "rig/masks/shade.h"
#include "rig/masks/steps.h"

typedef struct Work {
    FfpCapture *capture;
    const FfpEmptyStage *const *stages;
    FfpCompared *compared;  // [n_views]
    unsigned char **shaded; // [n_views][height*width]
    FfpFreeSpace space;
} Work;

static size_t pixels_of(const FfpView *view) {
    return (size_t)view->camera.width * (size_t)view->camera.height;
}

// Pieces of object that are small beside the largest become unknown.
static void drop_pieces(const FfpView *view, FfpCompared *compared) {
    FfpImage mask = ffp_image_new(view->camera.width, view->camera.height, 1);
    for (size_t i = 0; i < pixels_of(view); i++) mask.data[i] = compared->kinds[i] == FFP_PIXEL_OBJECT;
    ffp_mask_drop_pieces(&mask);
    for (size_t i = 0; i < pixels_of(view); i++)
        if (compared->kinds[i] == FFP_PIXEL_OBJECT && !(mask.data[i] > 0))
            compared->kinds[i] = FFP_PIXEL_UNKNOWN;
    ffp_image_free(&mask);
}

static bool compare_all(Work *w, const char *const *paths, FfpError *err) {
    for (int v = 0; v < w->capture->n_views; v++) {
        ffp_cancel_point();
        if (!ffp_stage_compare(&w->compared[v], w->capture, v, w->stages[v], paths[v], err)) return false;
        drop_pieces(&w->capture->views[v], &w->compared[v]);
    }
    return true;
}

// The mask without a hull: what is object for sure.
static void take_object(Work *w) {
    for (int v = 0; v < w->capture->n_views; v++) {
        FfpView *view = &w->capture->views[v];
        ffp_image_free(&view->coverage);
        view->coverage = ffp_image_new(view->camera.width, view->camera.height, 1);
        for (size_t i = 0; i < pixels_of(view); i++)
            view->coverage.data[i] = w->compared[v].kinds[i] == FFP_PIXEL_OBJECT;
    }
}

static bool shows_object(const Work *w) {
    for (int v = 0; v < w->capture->n_views; v++)
        for (size_t i = 0; i < pixels_of(&w->capture->views[v]); i++)
            if (w->compared[v].kinds[i] == FFP_PIXEL_OBJECT) return true;
    return false;
}

static bool may_be_object(const Work *w, int v, size_t pixel) {
    const unsigned char kind = w->compared[v].kinds[pixel];
    return kind != FFP_PIXEL_STAGE && kind != FFP_PIXEL_OBJECT && !w->shaded[v][pixel];
}

// Uncertain pixels are object inside the hull.
static void fill_by_hull(Work *w) {
    FfpHull hull = ffp_hull_new(w->capture, w->compared, w->shaded, &w->space);
    for (int v = 0; v < w->capture->n_views; v++) {
        FfpView *view = &w->capture->views[v];
        ffp_cancel_point();
#pragma omp parallel for schedule(dynamic, 64)
        for (size_t i = 0; i < pixels_of(view); i++) {
            const bool object = w->compared[v].kinds[i] == FFP_PIXEL_OBJECT;
            view->coverage.data[i] =
                object || (may_be_object(w, v, i) && ffp_hull_length(&hull, v, i) > HULL_RUN_LEAST);
        }
        ffp_mask_fill_specks(&view->coverage);
        ffp_mask_drop_pieces(&view->coverage);
    }
    ffp_hull_free(&hull);
}

// Shadows on the stage within the mask; what is around it lies within the hull's sphere.
static void find_shade(Work *w, int v) {
    const FfpView *view = &w->capture->views[v];
    unsigned char *mask = ffp_alloc(pixels_of(view), 1), *around = ffp_alloc(pixels_of(view), 1);
    FfpChord chord;
    for (size_t i = 0; i < pixels_of(view); i++) {
        mask[i] = view->coverage.data[i] >= 0.5F;
        around[i] = !mask[i] && ffp_chord(w->capture, &view->camera, i, &chord);
    }
    ffp_free(w->shaded[v]);
    w->shaded[v] = ffp_shade_find(w->capture, v, w->stages[v], &w->compared[v], mask, around);
    ffp_free(mask), ffp_free(around);
}

// Matching within the first masks tells which space is free; the second masks show more of the
// shadows, with which the third ones are made.
static void complete(Work *w) {
    fill_by_hull(w);
    if (ffp_free_space_new(&w->space, w->capture)) fill_by_hull(w);
    for (int v = 0; v < w->capture->n_views; v++) find_shade(w, v);
    fill_by_hull(w);
}

static FfpStageMasks report_of(const Work *w) {
    FfpStageMasks out = {.gain_least = INFINITY};
    const int n = w->capture->n_views;
    for (int v = 0; v < n; v++) {
        const FfpView *view = &w->capture->views[v];
        const double pixel = 1 / ((double)pixels_of(view) * n);
        out.stage += w->compared[v].stage / n;
        out.noise[v] = w->compared[v].noise;
        out.gain_least = fmin(out.gain_least, w->compared[v].gain);
        out.gain_most = fmax(out.gain_most, w->compared[v].gain);
        for (size_t i = 0; i < pixels_of(view); i++) {
            const bool object = w->compared[v].kinds[i] == FFP_PIXEL_OBJECT;
            out.object += object * pixel;
            out.decided += (!object && view->coverage.data[i] >= 0.5F) * pixel;
            out.shade += w->shaded[v][i] * pixel;
        }
    }
    return out;
}

static bool run(Work *w, bool posed, const char *const *paths, FfpError *err) {
    FfpCapture *capture = w->capture;
    if (!compare_all(w, paths, err)) return false;
    take_object(w);
    if (!shows_object(w)) return ffp_fail_by(FFP_RULE_NO_OBJECT, &(FfpFacts){0}, paths[0], err);
    const bool hull = posed && capture->n_views >= HULL_VIEWS_LEAST && ffp_hull_bounds(capture, w->compared);
    if (hull) complete(w);
    for (int v = 0; v < capture->n_views; v++)
        if (!hull) ffp_mask_fill_holes(&capture->views[v].coverage);
    return true;
}

bool ffp_stage_masks(FfpStageMasks *report, FfpCapture *capture, const FfpEmptyStage *const *stages,
                     bool posed, const char *const *paths, FfpError *err) {
    const int n = capture->n_views;
    Work w = {capture,
              stages,
              ffp_alloc((size_t)n, sizeof *w.compared),
              ffp_alloc((size_t)n, sizeof *w.shaded),
              {0}};
    for (int v = 0; v < n; v++) w.shaded[v] = ffp_alloc(pixels_of(&capture->views[v]), 1);
    const bool ok = run(&w, posed, paths, err);
    if (ok) *report = report_of(&w);
    for (int v = 0; v < n; v++) ffp_free(w.compared[v].kinds), ffp_free(w.shaded[v]);
    ffp_free(w.compared), ffp_free(w.shaded);
    ffp_free_space_free(&w.space);
    return ok;
}
