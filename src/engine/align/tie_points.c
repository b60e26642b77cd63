#include "engine/align/tie_points.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/image/lookup.h"
#include "engine/match/observe.h"

#define TRUST_LEAST 0.2
#define LIT_LEAST 0.1
#define AROUND 2        // pixels around that the pattern is compared over
#define NOISE 0.05      // of a pattern value seen
#define CODES_NOISE 0.3 // of a known position, projector pixels
#define DAMPING 0.05    // against the greater of the two directions
#define MOVE_MAX 2.0    // footprints of a camera pixel in the projector
#define STEP 1e-5       // of the derivatives: radians, the capture's unit, logarithms of focal lengths

FfpDeviceAt ffp_device_at(const FfpCamera *camera) {
    return (FfpDeviceAt){ffp_rigid_from_pose(camera->pose), (double)camera->fx, (double)camera->fy,
                         (double)camera->cx, (double)camera->cy};
}

// --- Where rays meet. ---

// A camera pixel's ray as the projector sees it: homogeneous position a + z b.
static void ray_in(const FfpDeviceAt *camera, const FfpDeviceAt *projector, double x, double y, double a[3],
                   double b[3], double direction[3]) {
    const double local[3] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy, 1};
    double p[3] = {0}, d[3] = {0}, from[3];
    for (int i = 0; i < 3; i++) {
        direction[i] = ffp_dot(camera->at.r + 3 * i, local);
        from[i] = camera->at.t[i] - projector->at.t[i];
    }
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            p[i] += projector->at.r[3 * k + i] * from[k];
            d[i] += projector->at.r[3 * k + i] * direction[k];
        }
    a[0] = projector->fx * p[0] + projector->cx * p[2], a[1] = projector->fy * p[1] + projector->cy * p[2];
    b[0] = projector->fx * d[0] + projector->cx * d[2], b[1] = projector->fy * d[1] + projector->cy * d[2];
    a[2] = p[2];
    b[2] = d[2];
}

// The point of the camera's ray that is nearest to position (u, v), and how far (u, v) lies beside the ray.
static bool meet(const FfpDeviceAt *camera, const FfpDeviceAt *projector, const FfpTiePoint *s,
                 double point[3], double *off) {
    double a[3], b[3], direction[3];
    ray_in(camera, projector, s->x, s->y, a, b, direction);
    const double p[2] = {a[0] - s->u * a[2], a[1] - s->v * a[2]},
                 q[2] = {b[0] - s->u * b[2], b[1] - s->v * b[2]};
    const double square = q[0] * q[0] + q[1] * q[1],
                 z = square > 0 ? -(p[0] * q[0] + p[1] * q[1]) / square : 0;
    const double w = a[2] + z * b[2];
    if (!(z > 0) || !(w > 1e-9)) return false;
    // q is the ray's direction in the projector's picture, as long as the ray passes close by.
    *off = (p[0] * q[1] - p[1] * q[0]) / (sqrt(square) * w);
    for (int i = 0; i < 3; i++) point[i] = camera->at.t[i] + z * direction[i];
    return true;
}

static void turned(FfpDeviceAt *device, int axis, double by) {
    double v[3] = {0}, r[9], out[9];
    v[axis] = by;
    ffp_rotation_from_vector(v, r);
    ffp_rotation_product(device->at.r, r, out);
    memcpy(device->at.r, out, sizeof out);
}

// The devices with number k moved by a step.
static void move(FfpDeviceAt *camera, FfpDeviceAt *projector, int k, double step) {
    FfpDeviceAt *device = k < 6 || k == 12 ? camera : projector;
    if (k >= 12) {
        device->fx *= exp(step);
        device->fy *= exp(step);
    } else if (k % 6 < 3) {
        turned(device, k % 6, step);
    } else {
        device->at.t[k % 6 - 3] += step;
    }
}

static bool differentiate(FfpTiePoint *s, const FfpDeviceAt *camera, const FfpDeviceAt *projector) {
    if (!meet(camera, projector, s, s->point, &s->off)) return false;
    for (int k = 0; k < FFP_TIE_POINT_NUMBERS; k++) {
        FfpDeviceAt c = *camera, p = *projector;
        double point[3], off;
        move(&c, &p, k, STEP);
        if (!meet(&c, &p, s, point, &off)) return false;
        for (int i = 0; i < 3; i++) s->point_by[k][i] = (point[i] - s->point[i]) / STEP;
        s->off_by[k] = (off - s->off) / STEP;
    }
    return true;
}

// --- What a pixel sees. ---

typedef struct Looking {
    const FfpView *view;
    const FfpInitialisation *start;
    size_t first; // of the view's pixels in the start's maps
    FfpObservation seen;
    FfpSummed pattern;
    real box; // pattern pixels that a camera pixel spans
} Looking;

static bool position_of(const Looking *l, int x, int y, real at[2]) {
    const size_t i = l->first + (size_t)y * (size_t)l->start->width + (size_t)x;
    real direction[3], point[3];
    if (!(l->start->t[i] > 0) || !((double)l->start->confidence[i] > TRUST_LEAST)) return false;
    ffp_pixel_ray(&l->view->camera, (real)x + 0.5F, (real)y + 0.5F, direction);
    for (int k = 0; k < 3; k++) point[k] = l->view->camera.pose[4 * k + 3] + l->start->t[i] * direction[k];
    return ffp_project(&l->view->projector, point, &at[0], &at[1]) > 0;
}

typedef struct Normal { // equations of a move in the projector's picture
    double h[3], g[2];
} Normal;

static void add_pixel(Normal *n, const Looking *l, int x, int y) {
    const size_t pixel = (size_t)y * (size_t)l->start->width + (size_t)x;
    real at[2], here[3], right[3], left[3], above[3], below[3];
    const real half = l->box / 2;
    if (!((double)l->seen.lit[pixel] > LIT_LEAST) || !position_of(l, x, y, at)) return;
    ffp_lookup(&l->pattern, at[0], at[1], l->box, l->box, here);
    ffp_lookup(&l->pattern, at[0] + half, at[1], l->box, l->box, right);
    ffp_lookup(&l->pattern, at[0] - half, at[1], l->box, l->box, left);
    ffp_lookup(&l->pattern, at[0], at[1] + half, l->box, l->box, below);
    ffp_lookup(&l->pattern, at[0], at[1] - half, l->box, l->box, above);
    for (int c = 0; c < 3; c++) {
        const double u = (double)((right[c] - left[c]) / l->box),
                     v = (double)((below[c] - above[c]) / l->box);
        const double w = (double)l->seen.weight[3 * pixel + (size_t)c],
                     r = (double)(l->seen.ratio[3 * pixel + (size_t)c] - here[c]);
        n->h[0] += w * u * u, n->h[1] += w * u * v, n->h[2] += w * v * v;
        n->g[0] += w * u * r, n->g[1] += w * v * r;
    }
}

// Moves the matched position across the ray, and says how well it is known there.
static bool look_across(const Looking *l, FfpTiePoint *s, int x, int y, const FfpDeviceAt *camera,
                        const FfpDeviceAt *projector) {
    Normal n = {{0}, {0}};
    double a[3], b[3], direction[3];
    for (int j = y > AROUND ? y - AROUND : 0; j <= y + AROUND && j < l->start->height; j++)
        for (int i = x > AROUND ? x - AROUND : 0; i <= x + AROUND && i < l->start->width; i++)
            add_pixel(&n, l, i, j);
    ray_in(camera, projector, s->x, s->y, a, b, direction);
    const double along[2] = {b[0] - s->u * b[2], b[1] - s->v * b[2]}, length = hypot(along[0], along[1]);
    if (!(length > 0)) return false;
    const double e[2] = {along[0] / length, along[1] / length}, f[2] = {-e[1], e[0]};
    const double ee = e[0] * (n.h[0] * e[0] + n.h[1] * e[1]) + e[1] * (n.h[1] * e[0] + n.h[2] * e[1]);
    const double ef = f[0] * (n.h[0] * e[0] + n.h[1] * e[1]) + f[1] * (n.h[1] * e[0] + n.h[2] * e[1]);
    const double ff = f[0] * (n.h[0] * f[0] + n.h[1] * f[1]) + f[1] * (n.h[1] * f[0] + n.h[2] * f[1]);
    const double ge = n.g[0] * e[0] + n.g[1] * e[1], gf = n.g[0] * f[0] + n.g[1] * f[1];
    if (!(ee > 0)) return false;
    const double known = ff - ef * ef / ee; // across, whatever the depth
    const double across = (gf - ge * ef / ee) / (known + DAMPING * fmax(ee, ff));
    s->weight = known / (NOISE * NOISE);
    if (!(fabs(across) <= MOVE_MAX * (double)l->box)) return false;
    s->u += across * f[0];
    s->v += across * f[1];
    return true;
}

static bool find_tie_point(const Looking *l, int x, int y, const FfpDeviceAt *camera,
                           const FfpDeviceAt *projector, FfpTiePoint *s) {
    const size_t pixel = (size_t)y * (size_t)l->start->width + (size_t)x, i = l->first + pixel;
    real at[2];
    if (!(l->view->coverage.data[pixel] >= 1) || !position_of(l, x, y, at)) return false;
    *s = (FfpTiePoint){.x = x + 0.5, .y = y + 0.5, .u = (double)at[0], .v = (double)at[1]};
    s->trust = (double)l->start->confidence[i];
    s->footprint = (double)l->start->footprint[i];
    for (int k = 0; k < 3; k++) s->normal[k] = (double)l->start->normal[3 * i + (size_t)k];
    const real *code = l->view->correspondence.data ? l->view->correspondence.data + 3 * pixel : NULL;
    if (code && code[2] > 0) {
        s->u = (double)code[0];
        s->v = (double)code[1];
        s->weight = 1 / (CODES_NOISE * CODES_NOISE);
    } else if (!look_across(l, s, x, y, camera, projector)) {
        return false;
    }
    return differentiate(s, camera, projector);
}

FfpTiePoints ffp_tie_points_new(const FfpCapture *capture, const FfpInitialisation *start, int view,
                                int active) {
    const size_t area = (size_t)start->width * (size_t)start->height;
    FfpTiePoints out = {.view = view, .width = start->width, .height = start->height};
    out.all = ffp_alloc(area, sizeof *out.all);
    out.index = ffp_alloc(area, sizeof *out.index);
    Looking l = {.view = &capture->views[view],
                 .start = start,
                 .first = (size_t)view * area,
                 .seen = ffp_observe(capture, view, &active, 1),
                 .pattern = ffp_summed_new(&capture->patterns[active].image),
                 .box = ffp_typical_footprint(capture, view)};
    const FfpDeviceAt camera = ffp_device_at(&l.view->camera), projector = ffp_device_at(&l.view->projector);
    for (int y = 0; y < out.height; y++) {
        for (int x = 0; x < out.width; x++) {
            const bool seen = find_tie_point(&l, x, y, &camera, &projector, &out.all[out.count]);
            out.index[(size_t)y * (size_t)out.width + (size_t)x] = seen ? (int)out.count : -1;
            out.count += seen;
        }
        ffp_cancel_point();
    }
    ffp_summed_free(&l.pattern);
    ffp_observation_free(&l.seen);
    return out;
}

void ffp_tie_points_free(FfpTiePoints *tie_points) {
    ffp_free(tie_points->all);
    ffp_free(tie_points->index);
    *tie_points = (FfpTiePoints){0};
}
