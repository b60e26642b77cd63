#include "engine/match/derive.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/fill.h"
#include "engine/match/layout.h"
#include "engine/match/line.h"
#include "engine/match/material.h"
#include "engine/match/surface.h"
#include "engine/match/unlit.h"

#define NORMAL_REACH 2       // pixels
#define COVERAGE_LEAST 0.05F // of a pixel that gets a splat
#define FAINT 0.2F           // times the coverage: opacity of a faint splat

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
    for (size_t i = 0; i < area && capture->scene; i++)
        if (out[i] <= 0) out[i] = depths->depth[(size_t)v * area + i];
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
static void fill(FfpDepths *depths, const real *lit, real *range, unsigned char *const *hulls,
                 const FfpMatchSettings *settings, int threads) {
    const FfpCapture *capture = depths->capture;
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    real *normals = ffp_alloc(area * (size_t)capture->n_views, 3 * sizeof(real));
    real *filled = ffp_alloc(area * (size_t)capture->n_views, sizeof(real));
    find_normals(normals, depths);
    if (!capture->scene) ffp_free_space(range, depths);
    ffp_parallel_for(capture->n_views, 0, fill_view, &(Filling){filled, normals, range, depths});
    real *found = ffp_alloc(area * (size_t)capture->n_views, sizeof(real));
    if (capture->scene)
        ffp_layout_depths(found, depths, normals, filled, lit);
    else
        ffp_unlit_depths(found, depths, filled, hulls, settings, threads);
    memcpy(depths->depth, found, area * (size_t)capture->n_views * sizeof(real));
    ffp_free(found);
    ffp_free(filled);
    ffp_free(normals);
}

// Opacity of a pixel's own splat. Splats of several views overlap at an outline, so that each must show less
// than the pixel's coverage for all of them together to show it; pixels that are covered by less than half
// leave the outline to the splats of their neighbours, and have but a faint one for later stages to work
// with.
static real own_share(real coverage) {
    if (coverage < COVERAGE_LEAST) return 0;
    return fmax((coverage - 0.5F) / 0.5F, FAINT * coverage);
}

void ffp_judge(FfpInitialisation *initial, const FfpCapture *capture, const real *depth,
               const FfpDepths *depths) {
    FfpSupportViews support_views = ffp_support_views_new(depths);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < initial->views * initial->height; row++) {
        const int v = row / initial->height, y = row % initial->height;
        const FfpView *view = &capture->views[v];
        for (int x = 0; x < initial->width; x++) {
            const size_t i = (size_t)row * (size_t)initial->width + (size_t)x;
            const real z = depth[i], at_x = (real)x + 0.5F, at_y = (real)y + 0.5F;
            if (z <= 0) continue;
            real direction[3];
            initial->t[i] = z / ffp_pixel_ray(&view->camera, at_x, at_y, direction);
            initial->footprint[i] = z / view->camera.fx;
            const FfpSupport support = ffp_support_at(&support_views, v, &view->camera, at_x, at_y, z);
            const int said = support.agree + support.past;
            initial->coverage[i] =
                fmin(own_share(view->coverage.data[(size_t)y * (size_t)initial->width + (size_t)x]),
                     support.coverage);
            initial->agreement[i] = said > 0 ? (real)support.agree / (real)said : 0;
            initial->violation[i] = support.views > 0 ? (real)support.past / (real)support.views : 0;
        }
    }
    ffp_support_views_free(&support_views);
}

void ffp_derive(FfpInitialisation *initial, FfpDepths *depths, real *range, unsigned char *const *hulls,
                const FfpMatchSettings *settings, int threads) {
    const size_t n = (size_t)initial->views * (size_t)initial->width * (size_t)initial->height;
    fill(depths, initial->lit, range, hulls, settings, threads);
    memcpy(initial->confidence, depths->trust, n * sizeof(real));
    for (size_t i = 0; i < n; i++)
        if (depths->depth[i] > 0) depths->trust[i] = 1; // a fit's robust weights serve better than these
    find_normals(initial->normal, depths);
    ffp_judge(initial, depths->capture, depths->depth, depths);
    ffp_initialisation_materials(initial, depths->capture);
}
