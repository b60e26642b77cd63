// The classical start: matching in every view, the views' say on each other, filling, and the maps that
// follow.
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/arena.h"
#include "base/call.h"
#include "capture/reduce.h"
#include "match/coded.h"
#include "match/consistency.h"
#include "match/enlarge.h"
#include "match/fill.h"
#include "match/line.h"
#include "match/match.h"
#include "match/matching.h"
#include "match/material.h"
#include "match/observe.h"
#include "match/reduce.h"
#include "match/surface.h"
#include "match/sweep.h"
#include "match/unlit.h"

#define NORMAL_REACH 2                // pixels
#define COVERAGE_LEAST 0.05F          // of a pixel that gets a splat
#define FAINT 0.2F                    // times the coverage: opacity of a faint splat
#define MATCH_BYTES ((size_t)2 << 30) // of working memory for the hypotheses of all views matched at a time

static bool check_picture(const FfpImage *image, const FfpCamera *camera, int channels, const char *what,
                          const FfpView *view, FfpError *err) {
    if (image->data == NULL)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the view has no %s image", what);
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
            return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the view's size is not that of the others");
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

static FfpStart allocate(const FfpCapture *capture) {
    const int width = capture->views[0].camera.width, height = capture->views[0].camera.height;
    const size_t n = (size_t)capture->n_views * (size_t)width * (size_t)height;
    FfpStart start = {.views = capture->n_views, .width = width, .height = height};
    real **maps[] = {&start.t,         &start.confidence, &start.lit,      &start.coverage,
                     &start.agreement, &start.violation,  &start.footprint};
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; i++) *maps[i] = ffp_alloc(n, sizeof(real));
    start.normal = ffp_alloc(n, 3 * sizeof(real));
    start.albedo = ffp_alloc(n, 3 * sizeof(real));
    start.ambient = ffp_alloc(n, 3 * sizeof(real));
    return start;
}

void ffp_start_free(FfpStart *start) {
    if (start == NULL) return;
    ffp_free(start->t), ffp_free(start->confidence), ffp_free(start->lit), ffp_free(start->coverage),
        ffp_free(start->agreement);
    ffp_free(start->violation), ffp_free(start->footprint), ffp_free(start->normal), ffp_free(start->albedo),
        ffp_free(start->ambient);
    if (start->reduced != NULL) {
        ffp_start_free(&start->reduced->start);
        ffp_capture_reduced_free(&start->reduced->capture);
        ffp_free(start->reduced);
    }
    *start = (FfpStart){0};
}

// Normals of a view's row, [w,3]; zero where there is no depth.
static void row_normals(real *normals, const FfpSheet *sheet, const FfpCamera *camera, int y) {
    memset(normals, 0, 3 * (size_t)sheet->width * sizeof(real));
    const real *depth = sheet->depth + (size_t)(y + sheet->reach) * (size_t)sheet->stride + sheet->reach;
    for (int x = 0; x < sheet->width; x += FFP_MATCH_LANES) {
        FfpPlane planes[FFP_MATCH_LANES];
        bool any = false;
        for (int n = 0; n < FFP_MATCH_LANES; n++) any |= depth[x + n] > 0;
        if (!any) continue;
        ffp_fit_planes(planes, sheet, x, y);
        for (int n = 0; n < FFP_MATCH_LANES && x + n < sheet->width; n++)
            if (planes[n].q0 > 0)
                ffp_plane_normal(&planes[n], camera, (real)(x + n) + 0.5F, (real)y + 0.5F,
                                 normals + 3 * (size_t)(x + n));
    }
}

typedef struct Normals {
    real *normals;
    const FfpDepths *depths;
} Normals;

static void view_normals(void *argument, int64_t view) {
    const Normals *n = argument;
    const FfpDepths *depths = n->depths;
    const size_t width = (size_t)depths->width, area = (size_t)depths->height * width;
    const FfpCamera *camera = &depths->capture->views[view].camera;
    const size_t first = (size_t)view * area;
    FfpSheet sheet = ffp_sheet_new(depths->depth + first, depths->trust + first, camera, NORMAL_REACH);
    for (int y = 0; y < depths->height; y++)
        row_normals(n->normals + 3 * (first + (size_t)y * width), &sheet, camera, y);
    ffp_sheet_free(&sheet);
    ffp_cancel_point();
}

// Normals of all pixels with depth, neighbours counted by their trust.
static void find_normals(real *normals, const FfpDepths *depths) {
    ffp_parallel_for(depths->capture->n_views, 0, view_normals, &(Normals){normals, depths});
}

typedef struct Filling {
    real *filled;
    const real *normals, *range;
    FfpDepths *depths;
} Filling;

static void fill_view(void *argument, int64_t index) {
    const Filling *f = argument;
    const FfpDepths *depths = f->depths;
    const FfpCapture *capture = depths->capture;
    const int v = (int)index;
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    real *out = f->filled + (size_t)v * area;
    const FfpCamera *camera = &capture->views[v].camera;
    ffp_fill_from_others(out, depths, f->normals, v);
    ffp_fill_smoothly(out, capture->views[v].coverage.data, f->range + 2 * (size_t)v * area, depths->width,
                      depths->height);
    real x, y;
    const real middle = fmax(ffp_project(camera, capture->centre, &x, &y), 0.1F * capture->radius);
    for (size_t i = 0; i < area; i++) {
        if (capture->views[v].coverage.data[i] <= 0)
            out[i] = 0;
        else if (out[i] <= 0)
            out[i] = middle; // a part of the object about which nothing at all is known
    }
    ffp_cancel_point();
}

// Gives every pixel on the object a depth: from the other views' trusted points, then smoothly, then where
// the pictures under black clearly know better.
static void fill(FfpDepths *depths, real *range, unsigned char *const *hulls,
                 const FfpMatchSettings *settings, int threads) {
    const FfpCapture *capture = depths->capture;
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    real *normals = ffp_alloc(area * (size_t)capture->n_views, 3 * sizeof(real));
    real *filled = ffp_alloc(area * (size_t)capture->n_views, sizeof(real));
    find_normals(normals, depths);
    ffp_free_space(range, depths);
    ffp_parallel_for(capture->n_views, 0, fill_view, &(Filling){filled, normals, range, depths});
    real *found = ffp_alloc(area * (size_t)capture->n_views, sizeof(real));
    ffp_unlit_depths(found, depths, filled, hulls, settings, threads);
    memcpy(depths->depth, found, area * (size_t)capture->n_views * sizeof(real));
    ffp_free(found), ffp_free(filled), ffp_free(normals);
}

// Opacity of a pixel's own splat. Splats of several views overlap at an outline, so that each must show less
// than the pixel's coverage for all of them together to show it; pixels that are covered by less than half
// leave the outline to the splats of their neighbours, and have but a faint one for later stages to work
// with.
static real own_share(real coverage) {
    if (coverage < COVERAGE_LEAST) return 0;
    return fmax((coverage - 0.5F) / 0.5F, FAINT * coverage);
}

// Where each pixel's point lies along its ray, and what the other views of `depths`, which may be those of
// reduced pictures, say of it. depth [views,h,w]: camera z at the size of `start`.
static void judge(FfpStart *start, const FfpCapture *capture, const real *depth, const FfpDepths *depths) {
    FfpSupportViews support_views = ffp_support_views_new(depths);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < start->views * start->height; row++) {
        const int v = row / start->height, y = row % start->height;
        const FfpView *view = &capture->views[v];
        for (int x = 0; x < start->width; x++) {
            const size_t i = (size_t)row * (size_t)start->width + (size_t)x;
            const real z = depth[i], at_x = (real)x + 0.5F, at_y = (real)y + 0.5F;
            if (z <= 0) continue;
            real direction[3];
            start->t[i] = z / ffp_pixel_ray(&view->camera, at_x, at_y, direction);
            start->footprint[i] = z / view->camera.fx;
            const FfpSupport support = ffp_support_at(&support_views, v, &view->camera, at_x, at_y, z);
            const int said = support.agree + support.past;
            start->coverage[i] =
                fmin(own_share(view->coverage.data[(size_t)y * (size_t)start->width + (size_t)x]),
                     support.coverage);
            start->agreement[i] = said > 0 ? (real)support.agree / (real)said : 0;
            start->violation[i] = support.views > 0 ? (real)support.past / (real)support.views : 0;
        }
    }
    ffp_support_views_free(&support_views);
}

// Everything that follows from trusted depths. Takes depths->depth and ->trust over: trust becomes the
// confidence. hulls: as ffp_unlit_depths'.
static void derive(FfpStart *start, FfpDepths *depths, real *range, unsigned char *const *hulls,
                   const FfpMatchSettings *settings, int threads) {
    const size_t n = (size_t)start->views * (size_t)start->width * (size_t)start->height;
    fill(depths, range, hulls, settings, threads);
    memcpy(start->confidence, depths->trust, n * sizeof(real));
    for (size_t i = 0; i < n; i++)
        if (depths->depth[i] > 0) depths->trust[i] = 1; // a fit's robust weights serve better than these
    find_normals(start->normal, depths);
    judge(start, depths->capture, depths->depth, depths);
    ffp_start_materials(start, depths->capture);
}

static FfpDepths depths_new(const FfpCapture *capture, const FfpStart *start) {
    const size_t n = (size_t)start->views * (size_t)start->width * (size_t)start->height;
    return (FfpDepths){capture, start->width, start->height, ffp_alloc(n, sizeof(real)),
                       ffp_alloc(n, sizeof(real))};
}

// The surfaces that a finished start has, all of them trusted, as its own maps were judged by.
static FfpDepths depths_of_start(const FfpCapture *capture, const FfpStart *start) {
    FfpDepths out = depths_new(capture, start);
    const size_t area = (size_t)start->width * (size_t)start->height;
    for (size_t i = 0; i < (size_t)start->views * area; i++) {
        out.depth[i] = start->footprint[i] * capture->views[i / area].camera.fx;
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
    FfpStart *start;
    FfpDepths *depths;
    real *range;
    unsigned char **hulls;
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns;
    const FfpBlurred *blurred;
    const FfpMatchSettings *settings;
} Matching;

static void match_one(void *argument, int64_t index) {
    const Matching *m = argument;
    const int v = (int)index;
    const size_t area = (size_t)m->start->width * (size_t)m->start->height;
    FfpObservation seen = ffp_observe(m->capture, v, m->patterns, m->n_patterns);
    memcpy(m->start->lit + (size_t)v * area, seen.lit, area * sizeof(real));
    ffp_match_view(m->depths->depth + (size_t)v * area, m->depths->trust + (size_t)v * area,
                   m->range + 2 * (size_t)v * area, &m->hulls[v], m->capture, v, &seen, m->blurred,
                   m->settings);
    ffp_observation_free(&seen);
    ffp_cancel_point();
}

// Matches the capture's own pictures.
static void match(FfpStart *start, const FfpCapture *capture, const int *patterns, int n,
                  const FfpMatchSettings *settings) {
    const int threads = views_at_a_time(capture, settings);
    *start = allocate(capture);
    FfpDepths depths = depths_new(capture, start);
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, 0));
    const size_t area = (size_t)start->width * (size_t)start->height;
    real *range = ffp_alloc((size_t)start->views * area, 2 * sizeof(real));
    unsigned char **hulls = ffp_alloc((size_t)start->views, sizeof *hulls);
    ffp_parallel_for(capture->n_views, threads, match_one,
                     &(Matching){start, &depths, range, hulls, capture, patterns, n, &blurred, settings});
    ffp_blurred_free(&blurred);
    ffp_reject_inconsistent(&depths);
    derive(start, &depths, range, hulls, settings, threads);
    for (int v = 0; v < capture->n_views; v++) ffp_free(hulls[v]);
    ffp_free(depths.depth), ffp_free(depths.trust), ffp_free(range), ffp_free(hulls);
}

typedef struct Enlarging {
    FfpStart *start;
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
    const size_t area = (size_t)e->start->width * (size_t)e->start->height, first = (size_t)v * area;
    FfpObservation seen = ffp_observe(e->capture, v, e->patterns, e->n_patterns);
    memcpy(e->start->lit + first, seen.lit, area * sizeof(real));
    const FfpEnlarged out = {e->depth + first, e->start->normal + 3 * first, e->start->confidence + first};
    ffp_enlarge(&out, e->start->reduced, &e->capture->views[v], v, &seen, e->blurred);
    ffp_coded_depths(out.depth, out.confidence, e->capture, v, e->bounds);
    ffp_observation_free(&seen);
    ffp_cancel_point();
}

// Carries what was found on the reduced pictures to full size, a view at a time.
static void enlarge_views(FfpStart *start, real *depth, const FfpCapture *capture, const int *patterns, int n,
                          real bounds) {
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, 0));
    ffp_parallel_for(capture->n_views, 0, enlarge_view,
                     &(Enlarging){start, depth, capture, patterns, n, &blurred, bounds});
    ffp_blurred_free(&blurred);
}

static void match_reduced(FfpStart *start, const FfpCapture *capture, const int *patterns, int n,
                          const FfpMatchSettings *settings, int factor) {
    const FfpCamera *camera = &capture->views[0].camera;
    int *photographs = ffp_alloc((size_t)n + 2, sizeof *photographs);
    photographs[0] = capture->black, photographs[1] = capture->white;
    memcpy(photographs + 2, patterns, (size_t)n * sizeof *photographs);
    FfpReduced *reduced = ffp_alloc(1, sizeof *reduced);
    reduced->capture =
        ffp_capture_reduced(capture, capture->n_views, photographs, n + 2,
                            (camera->width + factor - 1) / factor, (camera->height + factor - 1) / factor);
    ffp_free(photographs);
    match(&reduced->start, &reduced->capture, patterns, n, settings);
    *start = allocate(capture);
    start->reduced = reduced;
    real *depth =
        ffp_alloc((size_t)start->views * (size_t)start->width * (size_t)start->height, sizeof(real));
    enlarge_views(start, depth, capture, patterns, n, settings->bounds);
    FfpDepths depths = depths_of_start(&reduced->capture, &reduced->start);
    judge(start, capture, depth, &depths);
    ffp_start_materials(start, capture);
    ffp_free(depths.depth), ffp_free(depths.trust), ffp_free(depth);
}

bool ffp_start_new(FfpStart *start, const FfpCapture *capture, const int *patterns, int n,
                   const FfpMatchSettings *settings, FfpError *err) {
    *start = (FfpStart){0};
    if (!check(capture, patterns, n, err)) return false;
    const int factor = ffp_reduction(capture);
    if (factor > 1)
        match_reduced(start, capture, patterns, n, settings, factor);
    else
        match(start, capture, patterns, n, settings);
    return true;
}

typedef struct Observing {
    FfpStart *start;
    real *range;
    const FfpCapture *capture;
    int active;
} Observing;

static void observe_view(void *argument, int64_t index) {
    const Observing *o = argument;
    const int v = (int)index;
    const size_t area = (size_t)o->start->width * (size_t)o->start->height;
    ffp_hull_ranges(o->range + 2 * (size_t)v * area, o->capture, v);
    FfpObservation seen = ffp_observe(o->capture, v, &o->active, 1);
    memcpy(o->start->lit + (size_t)v * area, seen.lit, area * sizeof(real));
    ffp_observation_free(&seen);
}

bool ffp_start_from_depth(FfpStart *start, const FfpCapture *capture, int active, const real *depth,
                          FfpError *err) {
    *start = (FfpStart){0};
    if (!check(capture, &active, 1, err)) return false;
    const FfpMatchSettings settings = ffp_match_defaults();
    const int threads = views_at_a_time(capture, &settings);
    *start = allocate(capture);
    FfpDepths depths = depths_new(capture, start);
    const size_t area = (size_t)start->width * (size_t)start->height;
    real *range = ffp_alloc((size_t)start->views * area, 2 * sizeof(real));
    ffp_parallel_for(capture->n_views, 0, observe_view, &(Observing){start, range, capture, active});
    for (size_t i = 0; i < (size_t)start->views * area; i++) {
        const bool known = depth[i] > 0 && capture->views[i / area].coverage.data[i % area] > 0;
        depths.depth[i] = known ? depth[i] : 0;
        depths.trust[i] = known ? 1 : 0;
    }
    derive(start, &depths, range, NULL, &settings, threads);
    ffp_free(depths.depth), ffp_free(depths.trust), ffp_free(range);
    return true;
}
