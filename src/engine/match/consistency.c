#include "engine/match/consistency.h"
#include <omp.h>
#include <stdbool.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "engine/match/line.h"

#define FREE_STEPS 256 // pixel footprints that are tried along a ray
#define OUTSIDE 0.2F   // coverage at another view's outline up to which a point counts as outside it,
#define INSIDE 0.6F    // and from which as inside: a surface point on the very outline shows about one half

static FfpDepthBounds hear(const real *depth, const real *trust, size_t width) {
    const size_t around[4] = {0, 1, width, width + 1};
    FfpDepthBounds out = {0, 0, 0};
    for (int n = 0; n < 4; n++) {
        const real z = depth[around[n]], t = trust[around[n]];
        if (z <= 0 || t <= 0) continue;
        out.low = out.low > 0 && out.low < z ? out.low : z;
        out.high = out.high > z ? out.high : z;
        out.trust = out.trust > t ? out.trust : t;
    }
    return out;
}

typedef struct Distance {
    real square;
    int view;
} Distance;

static int nearer_first(const void *a, const void *b) {
    const Distance *x = a, *y = b;
    if (x->square != y->square) return x->square < y->square ? -1 : 1;
    return x->view - y->view;
}

static int ascending(const void *a, const void *b) {
    return *(const int *)a - *(const int *)b;
}

FfpAsked ffp_asked(const FfpCapture *capture, int view) {
    const int n = capture->n_views;
    FfpAsked out = {.count = n < FFP_ASKED ? n : FFP_ASKED};
    Distance *sorted = ffp_alloc((size_t)n, sizeof *sorted);
    for (int v = 0; v < n; v++) {
        const real *a = capture->views[view].camera.pose, *b = capture->views[v].camera.pose;
        const real off[3] = {a[3] - b[3], a[7] - b[7], a[11] - b[11]};
        sorted[v] = (Distance){v == view ? -1 : ffp_dot3(off, off), v};
    }
    qsort(sorted, (size_t)n, sizeof *sorted, nearer_first);
    out.view[0] = view;
    for (int k = 1; k < out.count; k++) out.view[k] = sorted[1 + (k - 1) * (n - 1) / (out.count - 1)].view;
    qsort(out.view, (size_t)out.count, sizeof *out.view, ascending);
    ffp_free(sorted);
    return out;
}

FfpSupportViews ffp_support_views_new(const FfpDepths *depths) {
    const size_t width = (size_t)depths->width, views = (size_t)depths->capture->n_views;
    const int rows = depths->capture->n_views * depths->height;
    FfpSupportViews out = {depths, ffp_alloc(views, sizeof(FfpAsked)),
                           ffp_alloc(views * (size_t)depths->height * width, sizeof(FfpDepthBounds))};
    for (size_t v = 0; v < views; v++) out.asked[v] = ffp_asked(depths->capture, (int)v);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < rows; row++) {
        if (row % depths->height == depths->height - 1) continue; // nothing lies below
        const size_t first = (size_t)row * width;
        for (size_t i = first; i + 1 < first + width; i++)
            out.bounds[i] = hear(depths->depth + i, depths->trust + i, width);
    }
    return out;
}

void ffp_support_views_free(FfpSupportViews *support_views) {
    ffp_free(support_views->asked);
    ffp_free(support_views->bounds);
    *support_views = (FfpSupportViews){0};
}

FfpDepthBounds ffp_depth_bounds_at(const FfpSupportViews *support_views, int view, real x, real y) {
    const int width = support_views->depths->width, height = support_views->depths->height;
    const FfpView *seer = &support_views->depths->capture->views[view];
    const real u = x - 0.5F, v = y - 0.5F;
    if (!(u >= 0 && v >= 0 && u < (real)(ffp_frame_width(seer) - 1) &&
          v < (real)(ffp_frame_height(seer) - 1)))
        return (FfpDepthBounds){0, 0, 0};
    return support_views->bounds[((size_t)view * (size_t)height + (size_t)v) * (size_t)width + (size_t)u];
}

typedef struct Place { // where another view has a point
    real z, a, b;      // depth, and the share of the way to the next pixel's centre, right and down
    size_t first;      // the upper left of the four pixels around
} Place;

// False when it is not within what `seer` saw.
static bool find_place(Place *out, const FfpLine *line, real z, const FfpView *seer) {
    const int width = ffp_frame_width(seer), height = ffp_frame_height(seer);
    real u = -1, v = -1;
    out->z = ffp_line_at(line, z, &u, &v);
    u -= 0.5F;
    v -= 0.5F;
    if (!(u >= 0 && v >= 0 && u < (real)(width - 1) && v < (real)(height - 1))) return false;
    const int x = (int)u, y = (int)v;
    out->a = u - (real)x;
    out->b = v - (real)y;
    out->first = (size_t)y * (size_t)seer->camera.width + (size_t)x;
    return true;
}

// How much of a point the silhouette leaves: interpolated coverage, with a soft threshold.
static real share_inside(const FfpImage *coverage, const Place *at) {
    const real *p = coverage->data + at->first, *q = p + coverage->width, a = at->a, b = at->b;
    const real shown = (p[0] * (1 - a) + p[1] * a) * (1 - b) + (q[0] * (1 - a) + q[1] * a) * b;
    const real share = (shown - OUTSIDE) / (INSIDE - OUTSIDE);
    return share < 0 ? 0 : share > 1 ? 1 : share;
}

// Adds the evidence of view `other` on the point at depth z of the pixel whose ray it sees as `line`.
static void ask(FfpSupport *out, const FfpSupportViews *support_views, int other, const FfpLine *line,
                real z) {
    const FfpDepths *depths = support_views->depths;
    const FfpView *seer = &depths->capture->views[other];
    Place at;
    if (!find_place(&at, line, z, seer)) return;
    const real share = depths->capture->scene ? 1 : share_inside(&seer->coverage, &at);
    const size_t first = (size_t)other * (size_t)depths->height * (size_t)depths->width;
    out->views++;
    out->coverage = share < out->coverage ? share : out->coverage;
    ffp_support_count(out, &support_views->bounds[first + at.first], at.z,
                      FFP_SUPPORT_SLACK * at.z / seer->camera.fx);
}

FfpSupport ffp_support_at(const FfpSupportViews *support_views, int view, const FfpCamera *camera, real x,
                          real y, real z) {
    const FfpCapture *capture = support_views->depths->capture;
    FfpSupport out = {.coverage = 1};
    const FfpAsked *asked = &support_views->asked[view];
    for (int k = 0; k < asked->count; k++) {
        const int other = asked->view[k];
        if (other == view) continue;
        const FfpLine line = ffp_line(camera, x, y, &capture->views[other].camera);
        ask(&out, support_views, other, &line, z);
    }
    return out;
}

void ffp_reject_inconsistent(FfpDepths *depths) {
    const int rows = depths->capture->n_views * depths->height;
    FfpSupportViews support_views = ffp_support_views_new(depths);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < rows; row++) {
        for (int x = 0; x < depths->width; x++) {
            const size_t i = (size_t)row * (size_t)depths->width + (size_t)x;
            if (depths->trust[i] <= 0) continue;
            const int view = row / depths->height, y = row % depths->height;
            const FfpSupport support =
                ffp_support_at(&support_views, view, &depths->capture->views[view].camera, (real)x + 0.5F,
                               (real)y + 0.5F, depths->depth[i]);
            // The support views have their own copy of what is trusted.
            if (support.trust_past > depths->trust[i] + support.trust_agree || support.coverage <= 0)
                depths->trust[i] = 0;
        }
    }
    ffp_support_views_free(&support_views);
}

void ffp_require_support(FfpDepths *depths, const real *lit, int least) {
    const int rows = depths->capture->n_views * depths->height;
    FfpSupportViews support_views = ffp_support_views_new(depths);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < rows; row++) {
        for (int x = 0; x < depths->width; x++) {
            const size_t i = (size_t)row * (size_t)depths->width + (size_t)x;
            if (depths->trust[i] <= 0 || lit[i] >= FFP_LIT_MIN) continue;
            const int view = row / depths->height, y = row % depths->height;
            const FfpSupport support =
                ffp_support_at(&support_views, view, &depths->capture->views[view].camera, (real)x + 0.5F,
                               (real)y + 0.5F, depths->depth[i]);
            if (support.agree < least) depths->trust[i] = 0;
        }
    }
    ffp_support_views_free(&support_views);
}

// The first depth from range[0] on, at most range[1], at which not too many views see past the ray.
static real free_until(const FfpSupportViews *support_views, int view, int x, int y, const real range[2],
                       FfpLine *lines) {
    const FfpCapture *capture = support_views->depths->capture;
    const real growth = 1 + 1 / capture->views[view].camera.fx;
    const FfpAsked *asked = &support_views->asked[view];
    for (int k = 0; k < asked->count; k++)
        lines[k] = ffp_line(&capture->views[view].camera, (real)x + 0.5F, (real)y + 0.5F,
                            &capture->views[asked->view[k]].camera);
    real z = range[0];
    for (int step = 0; step < FREE_STEPS && z < range[1]; step++) {
        FfpSupport support = {.coverage = 1};
        for (int k = 0; k < asked->count; k++)
            if (asked->view[k] != view) ask(&support, support_views, asked->view[k], &lines[k], z);
        if (!ffp_support_is_free_space(&support)) break;
        z *= growth;
    }
    return z < range[1] ? z : range[1];
}

void ffp_free_space(real *range, const FfpDepths *depths) {
    const FfpCapture *capture = depths->capture;
    FfpSupportViews support_views = ffp_support_views_new(depths);
    FfpLine *all = ffp_alloc((size_t)omp_get_max_threads() * FFP_ASKED, sizeof *all);
#pragma omp parallel
    {
        FfpLine *lines = all + (size_t)omp_get_thread_num() * FFP_ASKED;
#pragma omp for schedule(static)
        for (int row = 0; row < capture->n_views * depths->height; row++) {
            const int view = row / depths->height, y = row % depths->height;
            const real *coverage = capture->views[view].coverage.data + (size_t)y * (size_t)depths->width;
            for (int x = 0; x < depths->width; x++) {
                const size_t i = (size_t)row * (size_t)depths->width + (size_t)x;
                if (depths->trust[i] > 0 || coverage[x] <= 0) continue;
                range[2 * i] = free_until(&support_views, view, x, y, range + 2 * i, lines);
            }
        }
    }
    ffp_free(all);
    ffp_support_views_free(&support_views);
}
