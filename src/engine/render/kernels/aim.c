// Gradients of projector and camera from the light of a row of samples (aim.h).
#include "engine/render/kernels/kernels.h"

// out[0..2] += g, out[3..5] += p x g: of what moves rigidly with a device, g the gradient of point p.
static void add_wrench(const real p[3], const real g[3], double sign, double out[6]) {
    real moment[3];
    ffp_cross3(p, g, moment);
    for (int k = 0; k < 3; k++) {
        out[k] += sign * (double)g[k];
        out[3 + k] += sign * (double)moment[k];
    }
}

// The ray through a pixel is (x - cx) / fx along the camera's first axis, and likewise along the second; the
// view direction is the ray's other way round.
static void add_camera_focal(const FfpCamera *c, int x, int y, const FfpLit *s, const FfpLitGrad *d,
                             double focal[2]) {
    const real length = sqrt(ffp_dot3(s->slope, s->slope)), along = ffp_dot3(d->v, s->v);
    const real off[2] = {((real)x + 0.5F - c->cx) / c->fx / c->fx, ((real)y + 0.5F - c->cy) / c->fy / c->fy};
    for (int k = 0; k < 3; k++) {
        const real d_slope = s->z * d->point[k] - (d->v[k] - along * s->v[k]) / length;
        for (int a = 0; a < 2; a++) focal[a] -= (double)(d_slope * c->pose[4 * k + a] * off[a]);
    }
}

static void add_sample(const FfpLitView *view, int x, int y, const FfpLit *s, const FfpArrival *grad,
                       FfpAimGradient *out) {
    FfpLitGrad d;
    real point[3], place[3], by_light[3], by_place[3], turned[3];
    ffp_reflect_backward(s, grad->factor, &d);
    for (int k = 0; k < 3; k++) {
        place[k] = view->projector->pose[4 * k + 3];
        point[k] = view->camera->pose[4 * k + 3] + s->z * s->slope[k];
        by_light[k] = d.point[k];
    }
    ffp_position_backward(view->projector, s, grad->uv, &d);
    for (int k = 0; k < 3; k++) by_place[k] = d.point[k] - by_light[k];
    add_wrench(point, d.point, 1, out->camera);
    ffp_cross3(s->v, d.v, turned);
    for (int k = 0; k < 3; k++) out->camera[3 + k] += (double)turned[k];
    add_camera_focal(view->camera, x, y, s, &d, out->camera_focal);
    add_wrench(place, by_light, -1, out->projector); // light comes from where the projector is,
    add_wrench(point, by_place, -1, out->projector); // the pattern moves as if the point had moved against it
    for (int a = 0; a < 2; a++)
        out->projector_focal[a] += (double)(grad->uv[a] * s->in_projector[a] / s->in_projector[2]);
}

void FFP_K(aim_row)(const FfpLitScene *scene, int y, const FfpTransport *grad, FfpAimGradient *out) {
    const FfpGbuffer *g = scene->gbuffer;
    for (int x = 0; x < g->width; x++) {
        const ptrdiff_t p = (ptrdiff_t)y * g->width + x;
        const real *factor = grad->factor + 3 * p, *uv = grad->uv + 2 * p;
        if (factor[0] == 0 && factor[1] == 0 && factor[2] == 0 && uv[0] == 0 && uv[1] == 0) continue;
        const real *n = g->normal + 3 * p, *a = g->albedo + 3 * p;
        const FfpSums sums = {g->opacity[p],      g->depth[p],     {n[0], n[1], n[2]},
                              {a[0], a[1], a[2]}, g->roughness[p], scene->mapping->visibility[p]};
        const FfpArrival d = {{factor[0], factor[1], factor[2]}, {uv[0], uv[1]}};
        FfpLit s;
        real place[2];
        ffp_lit_geometry(&scene->view, x, y, &sums, &s, place);
        if (s.lit) add_sample(&scene->view, x, y, &s, &d, out);
    }
}
