// Cameras and projectors while rays are traced.
#include <math.h>
#include "core/base/lens.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate_work.h"

FfpTracedDevice ffp_device_of(const FfpCamera *c, const double *lens) {
    FfpTracedDevice d = {.lens = lens && !ffp_lens_is_ideal(lens) ? lens : NULL,
                         .fx = (float)c->fx,
                         .fy = (float)c->fy,
                         .cx = (float)c->cx,
                         .cy = (float)c->cy,
                         .width = (float)c->width,
                         .height = (float)c->height};
    for (int a = 0; a < 3; a++) {
        d.origin[a] = (float)c->pose[4 * a + 3];
        for (int k = 0; k < 3; k++) d.axes[3 * k + a] = (float)c->pose[4 * a + k];
    }
    return d;
}

void ffp_device_pixel(const FfpTracedDevice *c, float x, float y, float z, float *u, float *v) {
    if (c->lens) {
        double a, b;
        ffp_lens_distort(c->lens, (double)(x / z), (double)(y / z), &a, &b);
        *u = c->fx * (float)a + c->cx, *v = c->fy * (float)b + c->cy;
    } else {
        *u = c->fx * x / z + c->cx, *v = c->fy * y / z + c->cy;
    }
}

void ffp_camera_ray(const FfpTracedDevice *c, float x, float y, float d[3]) {
    float a = (x - c->cx) / c->fx, b = (y - c->cy) / c->fy;
    double ray[2];
    if (c->lens && ffp_lens_undistort(c->lens, (double)a, (double)b, ray))
        a = (float)ray[0], b = (float)ray[1];
    for (int k = 0; k < 3; k++) d[k] = a * c->axes[k] + b * c->axes[3 + k] + c->axes[6 + k];
}

bool ffp_arrive(const FfpViewWork *w, const FfpHit *hit, const float normal[3], FfpIncoming *a,
                FfpRays *shadow) {
    const FfpTracedDevice *p = &w->projector;
    float way[3], start[3];
    for (int k = 0; k < 3; k++) way[k] = p->origin[k] - hit->point[k];
    if (ffp_along(way, normal) <= 0) return false;
    for (int k = 0; k < 3; k++) a->local[k] = -ffp_along(p->axes + 3 * k, way);
    if (a->local[2] <= 1e-6F) return false;
    ffp_device_pixel(p, a->local[0], a->local[1], a->local[2], &a->u, &a->v);
    if (!(a->u >= 0 && a->v >= 0 && a->u <= p->width && a->v <= p->height)) return false;
    const float square = ffp_along(way, way), scale = 1 / sqrtf(square);
    a->fall = 1 / square;
    if (w->sim->sensor && w->sim->sensor->throw_fall > 0)
        a->fall *= ffp_sensor_vignette(w->sim->sensor->throw_fall, &w->view->projector, a->u, a->v);
    for (int k = 0; k < 3; k++) {
        start[k] = hit->point[k] + FFP_RAY_OFFSET * hit->facet[k];
        a->towards[k] = way[k] * scale;
        way[k] = p->origin[k] - start[k];
    }
    ffp_rays_add(shadow, start, way);
    return true;
}
