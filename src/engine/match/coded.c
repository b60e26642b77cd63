#include "engine/match/coded.h"
#include <tgmath.h>
#include "engine/match/line.h"

#define OFF_MAX 4.0F      // pixels of the projector that a ray may pass a position by
#define COST_A_PLANE 0.5F // of a plane beside the known one, all channels,
#define COST_MOST 3.0F    // and of any

real ffp_coded_depth(const FfpView *view, size_t pixel, real *off) {
    const real *p = view->correspondence.data + 3 * pixel;
    const size_t width = (size_t)view->camera.width;
    if (!(p[2] > 0)) return 0;
    const FfpLine line =
        ffp_line(&view->camera, (real)(pixel % width) + 0.5F, (real)(pixel / width) + 0.5F, &view->projector);
    // (u - p w)(z) = a + b z for both coordinates, least squares.
    const real a[2] = {line.u[0] - p[0] * line.w[0], line.v[0] - p[1] * line.w[0]};
    const real b[2] = {line.u[1] - p[0] * line.w[1], line.v[1] - p[1] * line.w[1]};
    const real square = b[0] * b[0] + b[1] * b[1], z = square > 0 ? -(a[0] * b[0] + a[1] * b[1]) / square : 0;
    real u = 0, v = 0;
    if (!(z > 0) || !(ffp_line_at(&line, z, &u, &v) > 1e-6F)) return 0;
    *off = hypot(u - p[0], v - p[1]);
    return z;
}

// The depth of a pixel's position that can be believed; 0: there is none.
static real believed(const FfpView *view, size_t pixel, real low, real high) {
    real off = 0;
    if (!(view->coverage.data[pixel] > 0)) return 0;
    const real z = ffp_coded_depth(view, pixel, &off);
    return z >= low && z <= high && off <= OFF_MAX ? z : 0;
}

static void range_of(real range[2], const FfpCapture *capture, int view, real bounds) {
    real x, y;
    if (capture->scene) {
        range[0] = capture->views[view].near;
        range[1] = capture->views[view].far;
        return;
    }
    const real middle = ffp_project(&capture->views[view].camera, capture->centre, &x, &y);
    range[0] = middle - bounds * capture->radius;
    range[1] = middle + bounds * capture->radius;
}

void ffp_coded_depths(real *depth, real *trust, const FfpCapture *capture, int view, real bounds) {
    const FfpView *self = &capture->views[view];
    if (!self->correspondence.data) return;
    const size_t pixels = (size_t)self->camera.width * (size_t)self->camera.height;
    real range[2];
    range_of(range, capture, view, bounds);
    for (size_t i = 0; i < pixels; i++) {
        const real z = believed(self, i, range[0], range[1]);
        if (z > 0) {
            depth[i] = z;
            trust[i] = self->correspondence.data[3 * i + 2];
        }
    }
}

void ffp_coded_costs(real *cost, const FfpCapture *capture, int view, const FfpForeground *foreground,
                     const FfpPlanes *planes) {
    const FfpView *self = &capture->views[view];
    if (!self->correspondence.data) return;
    const real first = ffp_plane_depth(planes, 0), last = ffp_plane_depth(planes, (real)(planes->count - 1));
    const real low = fmin(first, last), high = fmax(first, last);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const real z = believed(self, foreground->pixel[slot], low, high);
        real *row = cost + slot * (size_t)planes->count;
        if (!(z > 0)) continue;
        const real at = ffp_plane_at(planes, z);
        for (int k = 0; k < planes->count; k++) row[k] = fmin(COST_A_PLANE * fabs((real)k - at), COST_MOST);
    }
}
