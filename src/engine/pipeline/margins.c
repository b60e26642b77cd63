#include "engine/pipeline/margins.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "engine/network/network.h"

#define WIDTH 0.1F   // of a margin, in widths of the picture
#define FACING 0.05F // least cosine of incidence that a surface goes on at
#define STRETCH 2.0F // most that its depth may change from the frame's edge on
#define BEHIND 1.03F // of the depth that another view has there: beyond it a point is hidden from that view
#define OPAQUE 1.0F  // coverage of what is added

// A view with its margin: the frame is [margin, margin + width) of the wide picture.
typedef struct Wide {
    const FfpCapture *capture;
    const FfpInitialisation *start;
    int margin, width, height; // of the wide picture
} Wide;

static int mirrored(int at, int side) {
    const int inside = at < 0 ? -1 - at : at >= side ? 2 * side - 1 - at : at;
    return inside < 0 ? 0 : inside >= side ? side - 1 : inside;
}

static int clamped(int at, int side) {
    return at < 0 ? 0 : at >= side ? side - 1 : at;
}

// True if another view sees the point, or past it.
static bool is_seen(const Wide *w, int view, const real point[3]) {
    const FfpInitialisation *start = w->start;
    const size_t area = (size_t)start->width * (size_t)start->height;
    for (int v = 0; v < start->views; v++) {
        const FfpView *seer = &w->capture->views[v];
        real x = 0, y = 0;
        const real z = v == view ? 0 : ffp_project(&seer->camera, point, &x, &y);
        if (!(z > 0) ||
            !(x >= 0 && y >= 0 && x < (real)ffp_frame_width(seer) && y < (real)ffp_frame_height(seer)))
            continue;
        const size_t i = (size_t)v * area + (size_t)y * (size_t)start->width + (size_t)x;
        if (z <= BEHIND * start->footprint[i] * seer->camera.fx) return true;
    }
    return false;
}

// True if an earlier view's margin has the point, or what hides it.
static bool is_taken(const Wide *w, const FfpInitialisation *out, int view, const real point[3]) {
    for (int v = 0; v < view; v++) {
        const FfpCamera *camera = &w->capture->views[v].camera;
        real x, y;
        const real z = ffp_project(camera, point, &x, &y);
        x += (real)w->margin, y += (real)w->margin;
        if (!(z > 0) || !(x >= 0 && y >= 0 && x < (real)w->width && y < (real)w->height)) continue;
        const size_t i = ((size_t)v * (size_t)w->height + (size_t)y) * (size_t)w->width + (size_t)x;
        if (out->coverage[i] > 0 && z <= BEHIND * out->footprint[i] * camera->fx) return true;
    }
    return false;
}

// The distance along the ray at which the plane of the frame's pixel `edge` goes on; 0: it does not.
static real go_on(const FfpInitialisation *out, const Wide *w, const FfpCamera *camera, size_t edge, int x,
                  int y, const real direction[3]) {
    const FfpInitialisation *start = w->start;
    const real *normal = start->normal + 3 * edge, t = start->t[edge];
    const real eye[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    real own[3], point[3];
    ffp_pixel_ray(camera, (real)clamped(x, start->width) + 0.5F, (real)clamped(y, start->height) + 0.5F, own);
    const real towards = ffp_dot3(normal, direction);
    if (!(t > 0) || !(towards < -FACING)) return 0;
    const real far = t * ffp_dot3(normal, own) / towards;
    if (!(far < STRETCH * t && STRETCH * far > t)) return 0;
    for (int k = 0; k < 3; k++) point[k] = eye[k] + far * direction[k];
    const int view = (int)(edge / ((size_t)start->width * (size_t)start->height));
    return is_seen(w, view, point) || is_taken(w, out, view, point) ? 0 : far;
}

static void copy_pixel(const FfpInitialisation *out, size_t to, const FfpInitialisation *start, size_t from,
                       size_t edge) {
    memcpy(out->normal + 3 * to, start->normal + 3 * edge, 3 * sizeof(real));
    memcpy(out->albedo + 3 * to, start->albedo + 3 * from, 3 * sizeof(real));
    memcpy(out->ambient + 3 * to, start->ambient + 3 * from, 3 * sizeof(real));
}

// (x, y): in the frame's pixels, outside it.
static void add_pixel(const FfpInitialisation *out, const Wide *w, const FfpCamera *camera, int view, int x,
                      int y) {
    const FfpInitialisation *start = w->start;
    const size_t width = (size_t)start->width, first = (size_t)view * width * (size_t)start->height;
    const size_t edge = first + (size_t)clamped(y, start->height) * width + (size_t)clamped(x, start->width),
                 from =
                     first + (size_t)mirrored(y, start->height) * width + (size_t)mirrored(x, start->width);
    real direction[3];
    const real along = ffp_pixel_ray(camera, (real)x + 0.5F, (real)y + 0.5F, direction);
    const real t = start->coverage[edge] > 0 && start->coverage[from] > 0
                       ? go_on(out, w, camera, edge, x, y, direction)
                       : 0;
    if (!(t > 0)) return;
    const size_t to = ((size_t)view * (size_t)w->height + (size_t)(y + w->margin)) * (size_t)w->width +
                      (size_t)(x + w->margin);
    copy_pixel(out, to, start, from, edge);
    out->t[to] = t;
    out->footprint[to] = t * along / camera->fx;
    out->coverage[to] = OPAQUE;
}

static FfpInitialisation wide_start(const Wide *w) {
    const size_t n = (size_t)w->start->views * (size_t)w->width * (size_t)w->height;
    FfpInitialisation out = {.views = w->start->views, .width = w->width, .height = w->height};
    out.t = ffp_alloc(n, sizeof(real)), out.footprint = ffp_alloc(n, sizeof(real));
    out.coverage = ffp_alloc(n, sizeof(real));
    out.normal = ffp_alloc(n, 3 * sizeof(real)), out.albedo = ffp_alloc(n, 3 * sizeof(real));
    out.ambient = ffp_alloc(n, 3 * sizeof(real));
    for (int view = 0; view < out.views; view++) // in order: each leaves out what those before it have
#pragma omp parallel for schedule(static)
        for (int row = 0; row < out.height; row++)
            for (int x = -w->margin, y = row - w->margin; x < w->width - w->margin; x++)
                if (x < 0 || y < 0 || x >= w->start->width || y >= w->start->height)
                    add_pixel(&out, w, &w->capture->views[view].camera, view, x, y);
    return out;
}

// The cameras of the wide pictures.
static FfpCapture wide_capture(const Wide *w) {
    FfpCapture out = *w->capture;
    out.views = ffp_alloc((size_t)out.n_views, sizeof *out.views);
    for (int v = 0; v < out.n_views; v++) {
        out.views[v].camera = w->capture->views[v].camera;
        out.views[v].camera.cx += (real)w->margin;
        out.views[v].camera.cy += (real)w->margin;
        out.views[v].camera.width = w->width;
        out.views[v].camera.height = w->height;
    }
    return out;
}

static void append(FfpGaussians *to, const FfpGaussians *more) {
    FfpGaussians all = ffp_gaussians_new(to->count + more->count);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute whole = ffp_attribute(&all, a), first = ffp_attribute(to, a),
                           second = ffp_attribute(more, a);
        const size_t split = (size_t)to->count * (size_t)whole.width;
        memcpy(whole.data, first.data, split * sizeof(real));
        memcpy(whole.data + split, second.data, (size_t)more->count * (size_t)whole.width * sizeof(real));
    }
    memcpy(all.made_from, to->made_from, sizeof all.made_from);
    ffp_gaussians_take_notes(&all, to);
    ffp_gaussians_free(to);
    *to = all;
}

int64_t ffp_margins_add(FfpGaussians *gaussians, const FfpCapture *capture, const FfpInitialisation *start) {
    const int margin = (int)round(WIDTH * (real)start->width);
    const Wide w = {capture, start, margin, start->width + 2 * margin, start->height + 2 * margin};
    FfpInitialisation around = wide_start(&w);
    FfpCapture seen = wide_capture(&w);
    FfpGaussians more = ffp_initialisation_gaussians(&seen, &around);
    const int64_t count = more.count;
    if (count > 0) append(gaussians, &more);
    ffp_gaussians_free(&more);
    ffp_free(seen.views);
    ffp_initialisation_free(&around);
    return count;
}
