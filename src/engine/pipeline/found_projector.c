#include "engine/pipeline/found_projector.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "core/numerics/resection.h"
#include "engine/pipeline/relight.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"

enum { POINTS_MOST = 4000 }; // more tell no more
enum { LOOKED_AT = 250 };    // pixels for each of them at most
#define SOLID 0.95F          // opacity of a surface
#define BENT 0.02F           // share of the depth by which a surface's may leave its neighbours' mean
#define LIT 0.01             // radiance that white must add
#define STRAY 0.005          // of the Gaussians, at each end

typedef struct Points {
    double *points, *pixels; // [n,3] in the frame below, [n,2]
    double *ratios[3];       // [n_ratios] of photographed and drawn light
    int n, n_ratios[3];
    int stride; // of all pixels every stride-th is looked at
} Points;

// The frame in which the projector stands still.
static FfpRigid frame_of(const FfpCapture *capture, const FfpView *view) {
    return capture->scene ? (FfpRigid){.r = {1, 0, 0, 0, 1, 0, 0, 0, 1}}
                          : ffp_rigid_from_pose(view->camera.pose);
}

// The depth of a surface that is smooth around pixel i; 0: none.
static real depth_at(const FfpGbuffer *g, int i) {
    const int beside[] = {-1, 1, -g->width, g->width}, x = i % g->width, y = i / g->width;
    real mean = 0;
    if (x == 0 || y == 0 || x + 1 == g->width || y + 1 == g->height || g->opacity[i] < SOLID) return 0;
    for (int k = 0; k < 4; k++) {
        if (g->opacity[i + beside[k]] < SOLID) return 0;
        mean += g->depth[i + beside[k]] / g->opacity[i + beside[k]] / 4;
    }
    const real depth = g->depth[i] / g->opacity[i];
    return (real)fabs((double)(depth - mean)) < BENT * depth ? depth : 0;
}

static void add_points(const FfpCapture *capture, const FfpView *view, const FfpGbuffer *g, Points *p) {
    FfpRigid world, frame = frame_of(capture, view);
    ffp_rigid_inverse(&frame, &world);
    for (int i = 0; i < g->width * g->height; i += p->stride) {
        const real *at = view->correspondence.data + (ptrdiff_t)3 * i, depth = at[2] > 0 ? depth_at(g, i) : 0;
        real ray[3];
        double x[3];
        if (!(depth > 0)) continue;
        const real across =
            ffp_pixel_ray(&view->camera, (real)(i % g->width) + 0.5F, (real)(i / g->width) + 0.5F, ray);
        for (int k = 0; k < 3; k++)
            x[k] = (double)view->camera.pose[4 * k + 3] + (double)(depth / across * ray[k]);
        for (int k = 0; k < 3; k++)
            p->points[3 * (size_t)p->n + (size_t)k] = ffp_dot(world.r + 3 * (size_t)k, x) + world.t[k];
        for (int k = 0; k < 2; k++) p->pixels[2 * (size_t)p->n + (size_t)k] = (double)at[k];
        p->n++;
    }
}

// Keeps every step-th point.
static void thin(Points *p) {
    const int step = (p->n + POINTS_MOST - 1) / POINTS_MOST;
    int n = 0;
    for (int i = 0; step > 1 && i < p->n; i += step, n++) {
        memcpy(p->points + 3 * (size_t)n, p->points + 3 * (size_t)i, 3 * sizeof(double));
        memcpy(p->pixels + 2 * (size_t)n, p->pixels + 2 * (size_t)i, 2 * sizeof(double));
    }
    if (step > 1) p->n = n;
}

static void place(FfpCapture *capture, const FfpResection *r) {
    FfpPanel *panel = &capture->panel;
    FfpRigid own;
    ffp_rigid_inverse(&r->pose, &own); // the projector in the frame
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        FfpCamera *projector = &view->projector;
        const FfpRigid frame = frame_of(capture, view);
        FfpRigid pose;
        ffp_rigid_product(&frame, &own, &pose);
        ffp_rigid_store(&pose, projector->pose);
        projector->fx = (real)r->fx, projector->fy = (real)r->fy;
        projector->cx = (real)r->x, projector->cy = (real)r->y;
    }
    if (!panel->known) return;
    const FfpCamera *ideal = &capture->views[0].projector;
    const real x = (real)panel->width / (real)ideal->width, y = (real)panel->height / (real)ideal->height;
    panel->fx = x * ideal->fx, panel->fy = y * ideal->fy, panel->cx = x * ideal->cx,
    panel->cy = y * ideal->cy;
    memset(panel->lens, 0, sizeof panel->lens);
}

// The light that white adds to the photographs, as a ratio to that of the picture drawn with intensity 1.
static void add_ratios(FfpViewPass *pass, const FfpCapture *capture, const FfpView *view, Points *p) {
    static const real one[3] = {1, 1, 1};
    FfpSummed light = ffp_pattern_summed(&capture->patterns[capture->white].image);
    FfpImage black = ffp_view_pass_picture_new(pass), white = ffp_view_pass_picture_new(pass);
    const FfpGbuffer *g = ffp_view_pass_gbuffer(pass);
    ffp_view_pass_radiance(pass, one, NULL, &black);
    ffp_view_pass_radiance(pass, one, &light, &white);
    const size_t grown = (size_t)(white.width / g->width); // samples a side
    for (size_t i = 0; i < (size_t)g->width * (size_t)g->height; i += (size_t)p->stride) {
        const size_t at = (i / (size_t)g->width * (size_t)white.width + i % (size_t)g->width) * grown;
        for (size_t c = 0; c < 3 && g->opacity[i] >= SOLID; c++) {
            const double seen = (double)(view->images[capture->white].data[3 * i + c] -
                                         view->images[capture->black].data[3 * i + c]),
                         drawn = (double)(white.data[3 * at + c] - black.data[3 * at + c]);
            if (seen > LIT && drawn > 0) p->ratios[c][p->n_ratios[c]++] = seen / drawn;
        }
    }
    ffp_image_free(&black), ffp_image_free(&white);
    ffp_summed_free(&light);
}

static void set_intensity(FfpCapture *capture, Points *p) {
    bool known = true;
    for (int c = 0; c < 3; c++) known = known && p->n_ratios[c] > 0;
    for (int c = 0; known && c < 3; c++)
        capture->intensity[c] = (real)ffp_median(p->ratios[c], (size_t)p->n_ratios[c]);
    capture->intensity_known = known;
}

static double norm_of(const double v[3]) {
    return sqrt(ffp_dot(v, v));
}

static void tell(const FfpCapture *capture, const FfpResection *r, int n, FfpFoundProjector *found) {
    const FfpCamera *projector = &capture->views[0].projector;
    double to[3];
    for (int k = 0; k < 3; k++) to[k] = (double)(projector->pose[4 * k + 3] - capture->centre[k]);
    *found = (FfpFoundProjector){.distance = norm_of(to),
                                 .turned = norm_of(r->deviation) * 180 / FFP_PI_DOUBLE,
                                 .moved = norm_of(r->deviation + FFP_RESECTED_PLACE),
                                 .focal = r->deviation[FFP_RESECTED_FOCAL],
                                 .centre = {r->deviation[FFP_RESECTED_X] * projector->width,
                                            r->deviation[FFP_RESECTED_Y] * projector->width},
                                 .rms = r->rms,
                                 .points = n,
                                 .used = r->used};
}

// The object's sphere as the Gaussians have it: what a capture of codes alone tells of it came from the poses
// of another projector.
static void settle_sphere(FfpCapture *capture, const FfpGaussians *gaussians) {
    const size_t n = (size_t)gaussians->count;
    real *values = ffp_alloc(n + 1, sizeof *values), centre[3];
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < n; i++) values[i] = gaussians->centre[3 * i + (size_t)k];
        centre[k] = (ffp_quantile(values, n, STRAY) + ffp_quantile(values, n, 1 - STRAY)) / 2;
    }
    for (size_t i = 0; i < n; i++) {
        real square = 0;
        for (int k = 0; k < 3; k++) {
            const real d = gaussians->centre[3 * i + (size_t)k] - centre[k];
            square += d * d;
        }
        values[i] = (real)sqrt((double)square);
    }
    const real radius = ffp_quantile(values, n, 1 - STRAY);
    ffp_free(values);
    if (capture->scene || !(radius > 0)) return;
    memcpy(capture->centre, centre, sizeof centre);
    capture->radius = radius;
}

static void gather(FfpViewPass *pass, const FfpCapture *capture, const FfpGaussians *gaussians, Points *p) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!view->correspondence.data) continue;
        ffp_cancel_point();
        ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
        add_points(capture, view, ffp_view_pass_gbuffer(pass), p);
    }
    thin(p);
}

static void measure_light(FfpViewPass *pass, FfpCapture *capture, const FfpGaussians *gaussians, Points *p) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        ffp_cancel_point();
        ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
        add_ratios(pass, capture, view, p);
    }
    set_intensity(capture, p);
}

bool ffp_found_projector(FfpCapture *capture, const FfpGaussians *gaussians, FfpFoundProjector *found,
                         FfpError *err) {
    size_t pixels = 0;
    bool coded = false;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        pixels += (size_t)view->camera.width * (size_t)view->camera.height;
        coded = coded || view->correspondence.data;
    }
    if (!coded)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "capture",
                        "no view has Gray codes, by which the projector's place is found");
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){0}, NULL);
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    const size_t stride = pixels / (LOOKED_AT * POINTS_MOST) + 1,
                 most = pixels / stride + (size_t)capture->n_views;
    Points p = {.points = ffp_alloc(most, 3 * sizeof(double)),
                .pixels = ffp_alloc(most, 2 * sizeof(double)),
                .stride = (int)stride};
    for (int c = 0; c < 3; c++) p.ratios[c] = ffp_alloc(most, sizeof(double));
    const FfpCamera *panel = &capture->views[0].projector;
    FfpResection r;
    settle_sphere(capture, gaussians);
    gather(pass, capture, gaussians, &p);
    const bool ok = ffp_resect(p.points, p.pixels, p.n, panel->width, panel->height, &r, err);
    if (ok) place(capture, &r);
    if (ok) measure_light(pass, capture, gaussians, &p);
    if (ok && found) tell(capture, &r, p.n, found);
    ffp_free(p.points), ffp_free(p.pixels);
    for (int c = 0; c < 3; c++) ffp_free(p.ratios[c]);
    ffp_view_pass_free(pass);
    return ok;
}
