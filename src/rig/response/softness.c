#include "rig/response/softness.h"
#include <string.h>
#include "core/base/arena.h"
#include "core/capture/project.h"
#include "engine/match/match.h"
#include "rig/response/blur.h"
#include "rig/response/seen.h"

#define TRUSTED 0.5 // matching's confidence, where there are no codes

// Positions of all views' trusted pixels as matching finds them, for captures without Gray codes.
static void take_positions(FfpCapture *capture, const FfpInitialisation *start) {
    const size_t pixels = (size_t)start->width * (size_t)start->height;
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        view->correspondence = ffp_image_new(start->width, start->height, 3);
        for (size_t i = 0; i < pixels; i++) {
            const size_t k = (size_t)v * pixels + i;
            real ray[3], point[3], *at = view->correspondence.data + 3 * i;
            if (!(start->confidence[k] > (real)TRUSTED)) continue;
            ffp_pixel_ray(&view->camera, (real)(i % (size_t)start->width) + 0.5F,
                          (real)(i / (size_t)start->width) + 0.5F, ray);
            for (int c = 0; c < 3; c++) point[c] = view->camera.pose[4 * c + 3] + start->t[k] * ray[c];
            if (ffp_project(&view->projector, point, &at[0], &at[1]) > 0) at[2] = 1;
        }
    }
}

// The views of `matched` are the caller's. False: matching is not possible.
static bool match(FfpCapture *matched, const int *patterns, int n) {
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpInitialisation start;
    const size_t views = (size_t)matched->n_views;
    FfpView *own = ffp_alloc(views, sizeof *own);
    memcpy(own, matched->views, views * sizeof *own);
    matched->views = own;
    const real centre[3] = {matched->centre[0], matched->centre[1], matched->centre[2]};
    ffp_capture_normalise(matched, centre, matched->radius);
    if (!ffp_initialisation_new(&start, matched, patterns, n, &settings, NULL)) return false;
    take_positions(matched, &start);
    ffp_initialisation_free(&start);
    return true;
}

static bool is_coded(const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++)
        if (capture->views[v].correspondence.data) return true;
    return false;
}

// The blur, and the spread beside it, of a capture whose pixels have places.
static FfpSoftness fit(FfpCapture *placed) {
    FfpSoftness out = {.blur = ffp_fit_blur(placed)};
    FfpPattern *patterns = ffp_alloc((size_t)placed->n_patterns, sizeof *patterns);
    for (int p = 0; p < placed->n_patterns; p++) {
        patterns[p] = placed->patterns[p];
        patterns[p].image = ffp_image_copy(&placed->patterns[p].image);
        ffp_image_blur(&patterns[p].image, (real)out.blur);
    }
    placed->patterns = patterns;
    out.spread = ffp_fit_spread(placed);
    for (int p = 0; p < placed->n_patterns; p++) ffp_image_free(&patterns[p].image);
    ffp_free(patterns);
    return out;
}

FfpSoftness ffp_fit_softness(const FfpCapture *capture) {
    FfpCapture placed = *capture;
    FfpSoftness out = {0};
    int patterns[FFP_PATTERNS_MAX];
    const int n = ffp_seen_patterns(capture, patterns);
    if (n == 0) return out;
    if (is_coded(capture)) return fit(&placed);
    if (match(&placed, patterns, n)) {
        out = fit(&placed);
        for (int v = 0; v < placed.n_views; v++) ffp_image_free(&placed.views[v].correspondence);
    }
    ffp_free(placed.views);
    return out;
}
