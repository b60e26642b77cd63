// Silhouettes as a test of the poses: a pixel that shows the object needs a point on its ray that no other
// view shows as background (Laurentini 1994, the visual hull).
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "rig/checks/checks.h"
#include "rig/checks/suspect_parts.h"
#include "rig/masks/chord.h"

#define PIXELS_A_VIEW 400
#define DEPTHS 160
#define ODD_LEAST 0.01 // of the pixels: less says nothing about any view

// Background in the pixel and all around it.
static bool is_background(const FfpImage *coverage, real x, real y) {
    const int column = (int)floor((double)x), row = (int)floor((double)y);
    for (int k = 0; k < 9; k++) {
        const int px = column + k % 3 - 1, py = row + k / 3 - 1;
        if (px < 0 || py < 0 || px >= coverage->width || py >= coverage->height) return false;
        if (coverage->data[(ptrdiff_t)py * coverage->width + px] > 0) return false;
    }
    return true;
}

static bool is_possible(const FfpCapture *capture, const real point[3]) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        const bool ahead = ffp_project(&view->camera, point, &x, &y) > 0;
        const bool shown =
            ahead && x >= 0 && y >= 0 && x < (real)view->camera.width && y < (real)view->camera.height;
        if (shown && is_background(&view->coverage, x, y)) return false;
    }
    return true;
}

static bool has_point(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    FfpChord chord;
    const int parts = ffp_chord(capture, &view->camera, pixel, &chord) ? DEPTHS : 0;
    for (int k = 0; k < parts; k++) {
        real point[3];
        ffp_chord_point(&chord, k, parts, point);
        if (is_possible(capture, point)) return true;
    }
    return false;
}

// Evenly strided pixels of the object in *chosen (the caller frees it); returns their number.
static ptrdiff_t choose_pixels(const FfpView *view, ptrdiff_t **chosen) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    ptrdiff_t covered = 0, seen = 0, count = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) covered += view->coverage.data[i] >= 0.5F;
    const ptrdiff_t step = covered / PIXELS_A_VIEW + 1;
    *chosen = ffp_alloc((size_t)(covered / step + 1), sizeof **chosen);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] >= 0.5F && seen++ % step == 0) (*chosen)[count++] = i;
    }
    return count;
}

// Adds a view's pixels that were looked at, and those of them that have no point.
static void count_misfit(const FfpCapture *capture, int v, int *looked, int *bad) {
    const FfpView *view = &capture->views[v];
    ptrdiff_t *chosen = NULL;
    const ptrdiff_t count = choose_pixels(view, &chosen);
    int without = 0;
#pragma omp parallel for schedule(static) reduction(+ : without)
    for (ptrdiff_t k = 0; k < count; k++) without += !has_point(capture, view, (size_t)chosen[k]);
    ffp_free(chosen);
    *looked += (int)count, *bad += without;
}

double ffp_rig_view_misfit(const FfpCapture *capture, int view) {
    int looked = 0, bad = 0;
    count_misfit(capture, view, &looked, &bad);
    return looked > 0 ? (double)bad / looked : 0;
}

double ffp_rig_silhouette_misfit(const FfpCapture *capture) {
    int looked = 0, bad = 0;
    for (int v = 0; v < capture->n_views; v++) count_misfit(capture, v, &looked, &bad);
    return looked > 0 ? (double)bad / looked : 0;
}

static double misfit_without(const FfpCapture *capture, int view) {
    FfpCapture alias = ffp_rig_alias(capture);
    alias.n_views--;
    memmove(alias.views + view, alias.views + view + 1, (size_t)(alias.n_views - view) * sizeof *alias.views);
    const double misfit = ffp_rig_silhouette_misfit(&alias);
    ffp_free(alias.views);
    return misfit;
}

int ffp_rig_odd_view(const FfpCapture *capture, double misfit, double *without) {
    int odd = -1;
    *without = misfit;
    if (misfit < ODD_LEAST || capture->n_views < FFP_RIG_VIEWS_TO_ACCUSE) return -1;
    for (int v = 0; v < capture->n_views; v++) {
        const double others = misfit_without(capture, v);
        if (!(others < *without)) continue;
        *without = others;
        odd = v;
    }
    return *without < FFP_RIG_EXPLAINED * misfit ? odd : -1;
}
