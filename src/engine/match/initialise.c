// The classical initialisation: matching in every view, the views' say on each other, filling, and the maps
// that follow.
#include <omp.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/capture/reduce.h"
#include "engine/match/coded.h"
#include "engine/match/consistency.h"
#include "engine/match/derive.h"
#include "engine/match/enlarge.h"
#include "engine/match/match.h"
#include "engine/match/matching.h"
#include "engine/match/material.h"
#include "engine/match/observe.h"
#include "engine/match/reduce.h"
#include "engine/match/search_there.h"
#include "engine/match/sweep.h"

#define SUPPORT 2 // other views that must agree with a depth in a scene that no pattern told
#define MATCH_BYTES ((size_t)2 << 30) // of working memory for the hypotheses of all views matched at a time

static bool check_picture(const FfpImage *image, const FfpCamera *camera, int channels, const char *what,
                          const FfpView *view, FfpError *err) {
    if (!image->data) return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the view has no %s image", what);
    if (image->width != camera->width || image->height != camera->height || image->channels != channels)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the %s image does not have the camera's size",
                        what);
    return true;
}

static bool check(const FfpCapture *capture, const int *patterns, int n, FfpError *err) {
    if (capture->n_views < 1) return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "no views");
    for (int k = 0; k < n; k++)
        if (patterns[k] < 0 || patterns[k] >= capture->n_patterns)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "no such active pattern");
    const FfpCamera *first = &capture->views[0].camera;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (view->camera.width != first->width || view->camera.height != first->height)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id,
                            "the view's size differs from that of the others");
        if (!check_picture(&view->images[capture->black], first, 3, "black", view, err) ||
            !check_picture(&view->images[capture->white], first, 3, "white", view, err) ||
            !check_picture(&view->coverage, first, 1, "coverage", view, err))
            return false;
        for (int k = 0; k < n; k++) {
            const FfpImage *image = &view->images[patterns[k]];
            const char *name = capture->patterns[patterns[k]].name;
            if ((k == 0 || image->data) && !check_picture(image, first, 3, name, view, err)) return false;
        }
    }
    return true;
}

enum { SCALARS = 7, MAPS = 10 };

// The maps, those of one number a pixel first, then those of three.
static void list_maps(FfpInitialisation *initial, real **maps[MAPS]) {
    real **const all[MAPS] = {
        &initial->t,         &initial->confidence, &initial->lit,    &initial->coverage, &initial->agreement,
        &initial->violation, &initial->footprint,  &initial->normal, &initial->albedo,   &initial->ambient};
    memcpy(maps, all, sizeof all);
}

static FfpInitialisation allocate(const FfpCapture *capture) {
    const int width = capture->views[0].camera.width, height = capture->views[0].camera.height;
    const size_t n = (size_t)capture->n_views * (size_t)width * (size_t)height;
    FfpInitialisation initial = {.views = capture->n_views, .width = width, .height = height};
    real **maps[MAPS];
    list_maps(&initial, maps);
    for (int i = 0; i < MAPS; i++) *maps[i] = ffp_alloc(n, (i < SCALARS ? 1 : 3) * sizeof(real));
    return initial;
}

void ffp_initialisation_free(FfpInitialisation *initial) {
    if (!initial) return;
    real **maps[MAPS];
    list_maps(initial, maps);
    for (int i = 0; i < MAPS; i++) ffp_free(*maps[i]);
    if (initial->reduced) {
        ffp_initialisation_free(&initial->reduced->start);
        ffp_capture_reduced_free(&initial->reduced->capture);
        ffp_free(initial->reduced);
    }
    *initial = (FfpInitialisation){0};
}

static FfpDepths depths_new(const FfpCapture *capture, const FfpInitialisation *initial) {
    const size_t n = (size_t)initial->views * (size_t)initial->width * (size_t)initial->height;
    return (FfpDepths){capture, initial->width, initial->height, ffp_alloc(n, sizeof(real)),
                       ffp_alloc(n, sizeof(real))};
}

static void free_depths(FfpDepths *depths) {
    ffp_free(depths->depth);
    ffp_free(depths->trust);
}

// The surfaces that a finished initialisation has, all of them trusted, as its own maps were judged by.
static FfpDepths depths_of_initialisation(const FfpCapture *capture, const FfpInitialisation *initial) {
    FfpDepths out = depths_new(capture, initial);
    const size_t area = (size_t)initial->width * (size_t)initial->height;
    for (size_t i = 0; i < (size_t)initial->views * area; i++) {
        out.depth[i] = initial->footprint[i] * capture->views[i / area].camera.fx;
        out.trust[i] = out.depth[i] > 0 ? 1 : 0;
    }
    return out;
}

// How many views are matched at a time: so many that their costs fit MATCH_BYTES, at least one.
static int views_at_a_time(const FfpCapture *capture, const FfpMatchSettings *settings) {
    const size_t fit = MATCH_BYTES / ffp_match_bytes(&capture->views[0].camera, settings),
                 threads = (size_t)omp_get_max_threads();
    return fit > threads ? (int)threads : fit > 1 ? (int)fit : 1;
}

typedef struct Matching {
    FfpInitialisation *initial;
    FfpDepths *depths;
    real *range;
    unsigned char **hulls;
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns;
    const FfpBlurred *blurred;
    const FfpStereo *stereo; // of a whole scene
    const FfpMatchSettings *settings;
    FfpObservation *observed; // [views] for a device
} Matching;

static FfpObservation observe(const Matching *m, int view) {
    const size_t area = (size_t)m->initial->width * (size_t)m->initial->height;
    FfpObservation observed = ffp_observe(m->capture, view, m->patterns, m->n_patterns);
    memcpy(m->initial->lit + (size_t)view * area, observed.lit, area * sizeof(real));
    return observed;
}

static void observe_one(void *argument, int64_t view) {
    const Matching *m = argument;
    m->observed[view] = observe(m, (int)view);
}

static void match_there(Matching *m) {
    const size_t views = (size_t)m->capture->n_views;
    m->observed = ffp_alloc(views, sizeof *m->observed);
    ffp_parallel_for(m->capture->n_views, 0, observe_one, m);
    ffp_search_there(m->depths->depth, m->depths->trust, m->range, m->hulls, m->capture, m->observed,
                     m->blurred, m->settings);
    for (size_t v = 0; v < views; v++) ffp_observation_free(&m->observed[v]);
    ffp_free(m->observed);
}

static void match_one(void *argument, int64_t index) {
    const Matching *m = argument;
    const int v = (int)index;
    const size_t area = (size_t)m->initial->width * (size_t)m->initial->height;
    FfpObservation observed = observe(m, v);
    real *depth = m->depths->depth + (size_t)v * area, *trust = m->depths->trust + (size_t)v * area;
    if (m->capture->scene)
        ffp_match_scene_view(depth, trust, m->stereo, v, &observed, m->blurred, m->settings);
    else
        ffp_match_view(depth, trust, m->range + 2 * (size_t)v * area, &m->hulls[v], m->capture, v, &observed,
                       m->blurred, m->settings);
    ffp_observation_free(&observed);
    ffp_cancel_point();
}

// Matches the capture's own pictures.
static void match(FfpInitialisation *initial, const FfpCapture *capture, const int *patterns, int n,
                  const FfpMatchSettings *settings) {
    const int threads = views_at_a_time(capture, settings);
    *initial = allocate(capture);
    FfpDepths depths = depths_new(capture, initial);
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, 0));
    const size_t area = (size_t)initial->width * (size_t)initial->height;
    real *range = ffp_alloc((size_t)initial->views * area, 2 * sizeof(real));
    unsigned char **hulls = ffp_alloc((size_t)initial->views, sizeof *hulls);
    FfpStereo stereo = {0};
    if (capture->scene) stereo = ffp_stereo_new(capture, patterns[0]);
    Matching m = {initial, &depths, range, hulls, capture, patterns, n, &blurred, &stereo, settings, NULL};
    if (ffp_can_search_there(capture, settings))
        match_there(&m);
    else
        ffp_parallel_for(capture->n_views, threads, match_one, &m);
    ffp_stereo_free(&stereo);
    ffp_blurred_free(&blurred);
    ffp_reject_inconsistent(&depths);
    if (capture->scene) ffp_require_support(&depths, initial->lit, SUPPORT);
    ffp_derive(initial, &depths, range, hulls, settings, threads);
    for (int v = 0; v < capture->n_views; v++) ffp_free(hulls[v]);
    free_depths(&depths);
    ffp_free(range);
    ffp_free(hulls);
}

typedef struct Enlarging {
    FfpInitialisation *initial;
    real *depth;
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns;
    const FfpBlurred *blurred;
    real bounds;
} Enlarging;

static void enlarge_view(void *argument, int64_t index) {
    const Enlarging *e = argument;
    const int v = (int)index;
    const size_t area = (size_t)e->initial->width * (size_t)e->initial->height, first = (size_t)v * area;
    FfpObservation observed = ffp_observe(e->capture, v, e->patterns, e->n_patterns);
    memcpy(e->initial->lit + first, observed.lit, area * sizeof(real));
    const FfpEnlarged out = {e->depth + first, e->initial->normal + 3 * first,
                             e->initial->confidence + first};
    ffp_enlarge(&out, e->initial->reduced, &e->capture->views[v], v, &observed, e->blurred);
    ffp_coded_depths(out.depth, out.confidence, e->capture, v, e->bounds);
    ffp_observation_free(&observed);
    ffp_cancel_point();
}

// Carries what was found on the reduced pictures to full size, a view at a time.
static void enlarge_views(FfpInitialisation *initial, real *depth, const FfpCapture *capture,
                          const int *patterns, int n, real bounds) {
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, 0));
    ffp_parallel_for(capture->n_views, 0, enlarge_view,
                     &(Enlarging){initial, depth, capture, patterns, n, &blurred, bounds});
    ffp_blurred_free(&blurred);
}

static void match_reduced(FfpInitialisation *initial, const FfpCapture *capture, const int *patterns, int n,
                          const FfpMatchSettings *settings, int factor) {
    const FfpCamera *camera = &capture->views[0].camera;
    int *photographs = ffp_alloc((size_t)n + 2, sizeof *photographs);
    photographs[0] = capture->black;
    photographs[1] = capture->white;
    memcpy(photographs + 2, patterns, (size_t)n * sizeof *photographs);
    FfpReduced *reduced = ffp_alloc(1, sizeof *reduced);
    reduced->capture =
        ffp_capture_reduced(capture, capture->n_views, photographs, n + 2,
                            (camera->width + factor - 1) / factor, (camera->height + factor - 1) / factor);
    ffp_free(photographs);
    match(&reduced->start, &reduced->capture, patterns, n, settings);
    *initial = allocate(capture);
    initial->reduced = reduced;
    real *depth =
        ffp_alloc((size_t)initial->views * (size_t)initial->width * (size_t)initial->height, sizeof(real));
    enlarge_views(initial, depth, capture, patterns, n, settings->bounds);
    FfpDepths depths = depths_of_initialisation(&reduced->capture, &reduced->start);
    ffp_judge(initial, capture, depth, &depths);
    ffp_initialisation_materials(initial, capture);
    free_depths(&depths);
    ffp_free(depth);
}

bool ffp_initialisation_new(FfpInitialisation *initial, const FfpCapture *capture, const int *patterns, int n,
                            const FfpMatchSettings *settings, FfpError *err) {
    *initial = (FfpInitialisation){0};
    if (!check(capture, patterns, n, err)) return false;
    const int factor = ffp_reduction(capture);
    if (factor > 1)
        match_reduced(initial, capture, patterns, n, settings, factor);
    else
        match(initial, capture, patterns, n, settings);
    initial->device = settings->device;
    return true;
}
