// Silhouettes as a test of the poses: a pixel that shows the object needs a point on its ray that no other
// view shows as background (Laurentini 1994, the visual hull).
#include <math.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/capture/pixel.h"
#include "rig/checks/chord.h"
#include "rig/checks/measure.h"

#define PIXELS 6400       // of all views together,
#define PIXELS_A_VIEW 400 // of each at most,
#define PIXELS_OF_MANY 32 // and of each at least: work grows as the number of views
#define DEPTHS 160
#define ODD_LEAST 0.01 // of the pixels: less says nothing about any view

// True if no view shows the point as background. If a single one does, it is marked in `deniers` [n_views]
// (NULL: not wanted).
static bool is_possible(const FfpCapture *capture, const real point[3], unsigned char *deniers) {
    int denier = -1;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        const bool ahead = ffp_project(&view->camera, point, &x, &y) > 0;
        const bool shown =
            ahead && x >= 0 && y >= 0 && x < (real)view->camera.width && y < (real)view->camera.height;
        if (!shown || !ffp_is_background(&view->coverage, (int)x, (int)y)) continue;
        if (!deniers || denier >= 0) return false;
        denier = v;
    }
    if (denier >= 0) deniers[denier] = 1;
    return denier < 0;
}

static bool has_point(const FfpCapture *capture, const FfpView *view, size_t pixel, unsigned char *deniers) {
    FfpChord chord;
    const int parts = ffp_chord(capture, &view->camera, pixel, &chord) ? DEPTHS : 0;
    for (int k = 0; k < parts; k++) {
        real point[3];
        ffp_chord_point(&chord, k, parts, point);
        if (is_possible(capture, point, deniers)) return true;
    }
    return false;
}

// Evenly strided pixels of the object in *chosen (the caller frees it), hardly more than `most`; returns
// their number.
static ptrdiff_t choose_pixels(const FfpView *view, int most, ptrdiff_t **chosen) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    ptrdiff_t covered = 0, seen = 0, count = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) covered += view->coverage.data[i] >= 0.5F;
    const ptrdiff_t step = covered / most + 1;
    *chosen = ffp_alloc((size_t)(covered / step + 1), sizeof **chosen);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] >= 0.5F && seen++ % step == 0) (*chosen)[count++] = i;
    }
    return count;
}

typedef struct Tally { // of a view
    int looked, bad;   // its pixels, and those of them without a point
    int denied;        // of other views, that would have a point if it were not for this one
} Tally;

static int pixels_a_view(const FfpCapture *capture) {
    const int share = PIXELS / capture->n_views;
    return share > PIXELS_A_VIEW ? PIXELS_A_VIEW : share < PIXELS_OF_MANY ? PIXELS_OF_MANY : share;
}

// Counts a view's pixels in its tally, and in those of the others what they alone deny it.
static void count_view(const FfpCapture *capture, int v, Tally *tallies, bool deniers) {
    const FfpView *view = &capture->views[v];
    const size_t row = deniers ? (size_t)capture->n_views : 0;
    ptrdiff_t *chosen = NULL;
    const ptrdiff_t count = choose_pixels(view, pixels_a_view(capture), &chosen);
    unsigned char *bad = ffp_alloc((size_t)count + 1, 1),
                  *marks = deniers ? ffp_alloc((size_t)count * row + 1, 1) : NULL;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t k = 0; k < count; k++)
        bad[k] = !has_point(capture, view, (size_t)chosen[k], marks ? marks + (size_t)k * row : NULL);
    tallies[v].looked += (int)count;
    for (ptrdiff_t k = 0; k < count; k++) {
        tallies[v].bad += bad[k];
        for (size_t w = 0; w < row && bad[k]; w++) tallies[w].denied += marks[(size_t)k * row + w];
    }
    ffp_free(chosen);
    ffp_free(bad);
    ffp_free(marks);
    ffp_cancel_point();
}

static Tally *count_views(const FfpCapture *capture, bool deniers, Tally *all) {
    Tally *tallies = ffp_alloc((size_t)capture->n_views, sizeof *tallies);
    for (int v = 0; v < capture->n_views; v++) count_view(capture, v, tallies, deniers);
    *all = (Tally){0};
    for (int v = 0; v < capture->n_views; v++) {
        all->looked += tallies[v].looked;
        all->bad += tallies[v].bad;
    }
    return tallies;
}

static double share_of(int bad, int looked) {
    return looked > 0 ? (double)bad / looked : 0;
}

double ffp_rig_misfit_below(const FfpCapture *capture, double enough) {
    const double most = enough * (pixels_a_view(capture) + 1.0) * capture->n_views;
    Tally *tallies = ffp_alloc((size_t)capture->n_views, sizeof *tallies), all = {0};
    for (int v = 0; v < capture->n_views && all.bad <= most; v++) {
        count_view(capture, v, tallies, false);
        all.looked += tallies[v].looked;
        all.bad += tallies[v].bad;
    }
    ffp_free(tallies);
    return all.bad <= most ? share_of(all.bad, all.looked) : INFINITY;
}

double ffp_rig_silhouette_misfit(const FfpCapture *capture) {
    return ffp_rig_misfit_below(capture, 1);
}

// Looks for the view without which the others agree: neither its pixels count then, nor what it denies.
static void accuse(FfpSilhouettes *out, const FfpCapture *capture, const Tally *tallies, const Tally *all) {
    for (int v = 0; v < capture->n_views; v++) {
        const Tally *t = &tallies[v];
        const double others = share_of(all->bad - t->bad - t->denied, all->looked - t->looked);
        out->blame[v] = share_of(t->bad + t->denied, all->looked);
        if (!(others < out->without)) continue;
        out->without = others;
        out->odd = v;
    }
    if (!(out->without < FFP_RIG_EXPLAINED * out->misfit)) out->odd = -1;
}

FfpSilhouettes ffp_rig_silhouettes(const FfpCapture *capture) {
    const size_t n = (size_t)capture->n_views;
    FfpSilhouettes out = {
        .odd = -1, .own = ffp_alloc(n, sizeof *out.own), .blame = ffp_alloc(n, sizeof *out.blame)};
    Tally all, *tallies = count_views(capture, false, &all);
    out.misfit = out.without = share_of(all.bad, all.looked);
    for (size_t v = 0; v < n; v++) out.own[v] = share_of(tallies[v].bad, tallies[v].looked);
    ffp_free(tallies);
    if (out.misfit < ODD_LEAST || capture->n_views < FFP_RIG_VIEWS_TO_ACCUSE) return out;
    tallies = count_views(capture, true, &all);
    accuse(&out, capture, tallies, &all);
    ffp_free(tallies);
    return out;
}

void ffp_rig_silhouettes_free(FfpSilhouettes *silhouettes) {
    ffp_free(silhouettes->own);
    ffp_free(silhouettes->blame);
    *silhouettes = (FfpSilhouettes){0};
}
