// Where camera and projector stand around the object, and what they see of it.
#include <math.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "rig/checks/measure.h"

#define SPHERE_POINTS 200

static void widen(FfpRange *range, double value) {
    range->low = fmin(range->low, value), range->high = fmax(range->high, value);
}

static double degrees(double radians) {
    return radians * 180 / acos(-1.0);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double ffp_rig_direction(const FfpCapture *capture, const FfpCamera *device, double out[3]) {
    double square = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = (double)device->pose[4 * i + 3] - (double)capture->centre[i];
        square += out[i] * out[i];
    }
    for (int i = 0; i < 3 && square > 0; i++) out[i] /= sqrt(square);
    return sqrt(square);
}

bool ffp_rig_is_behind(const FfpCapture *capture, const FfpCamera *device) {
    real x, y;
    return !(ffp_project(device, capture->centre, &x, &y) > 0);
}

// Evenly spread directions (a Fibonacci lattice).
static void sphere_point(const FfpCapture *capture, int index, real point[3]) {
    const double z = 1 - (2 * index + 1.0) / SPHERE_POINTS, ring = sqrt(1 - z * z),
                 turn = 2.399963229728653 * index;
    const double unit[3] = {ring * cos(turn), ring * sin(turn), z};
    for (int i = 0; i < 3; i++) point[i] = capture->centre[i] + capture->radius * (real)unit[i];
}

bool ffp_rig_falls_into(const FfpCamera *device, const real point[3]) {
    real x, y;
    return ffp_project(device, point, &x, &y) > 0 && x >= -1 && y >= -1 && x <= (real)device->width + 1 &&
           y <= (real)device->height + 1;
}

static double share_inside(const FfpCapture *capture, const FfpCamera *device) {
    int inside = 0;
    for (int k = 0; k < SPHERE_POINTS; k++) {
        real point[3];
        sphere_point(capture, k, point);
        inside += ffp_rig_falls_into(device, point);
    }
    return (double)inside / SPHERE_POINTS;
}

FfpFrusta ffp_rig_frusta(const FfpCapture *capture) {
    FfpFrusta out = {.camera = 1, .projector = 1, .ahead = true};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        out.camera = fmin(out.camera, share_inside(capture, &view->camera));
        out.projector = fmin(out.projector, share_inside(capture, &view->projector));
        out.ahead = out.ahead && !ffp_rig_is_behind(capture, &view->camera) &&
                    !ffp_rig_is_behind(capture, &view->projector);
    }
    return out;
}

bool ffp_rig_frusta_hold(FfpFrusta frusta) {
    return frusta.ahead && frusta.camera > FFP_RIG_CAMERA_LEAST && frusta.projector > FFP_RIG_PROJECTOR_LEAST;
}

// Full angle of the narrower side of a device's picture, were its principal point in the middle.
static double field_of_view(const FfpCamera *device) {
    const double x = (double)device->width / (double)device->fx,
                 y = (double)device->height / (double)device->fy;
    return degrees(2 * atan(fmin(x, y) / 2));
}

void ffp_rig_ranges(const FfpCapture *capture, FfpRange ranges[FFP_RIG_NUMBERS]) {
    for (int i = 0; i < FFP_RIG_NUMBERS; i++) ranges[i] = (FfpRange){INFINITY, -INFINITY};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        double to_camera[3], to_projector[3], cosine = 0;
        widen(&ranges[FFP_RIG_CAMERA_DISTANCE],
              ffp_rig_direction(capture, &view->camera, to_camera) / (double)capture->radius);
        widen(&ranges[FFP_RIG_PROJECTOR_DISTANCE],
              ffp_rig_direction(capture, &view->projector, to_projector) / (double)capture->radius);
        for (int i = 0; i < 3; i++) cosine += to_camera[i] * to_projector[i];
        widen(&ranges[FFP_RIG_BETWEEN], degrees(acos(fmin(fmax(cosine, -1), 1))));
        widen(&ranges[FFP_RIG_CAMERA_HEIGHT], degrees(asin(fmin(fmax(to_camera[2], -1), 1))));
        widen(&ranges[FFP_RIG_CAMERA_FIELD], field_of_view(&view->camera));
        widen(&ranges[FFP_RIG_PROJECTOR_FIELD], field_of_view(&view->projector));
        // Upright: the picture's x axis is level, and its y axis points down.
        widen(&ranges[FFP_RIG_ROLL],
              degrees(atan2((double)view->camera.pose[8], -(double)view->camera.pose[9])));
    }
}

double ffp_rig_widest_gap(const FfpCapture *capture) {
    double *azimuths = ffp_alloc((size_t)capture->n_views, sizeof *azimuths);
    for (int v = 0; v < capture->n_views; v++) {
        double to[3];
        ffp_rig_direction(capture, &capture->views[v].camera, to);
        azimuths[v] = degrees(atan2(to[1], to[0]));
    }
    qsort(azimuths, (size_t)capture->n_views, sizeof *azimuths, ascending);
    double gap = 360 + azimuths[0] - azimuths[capture->n_views - 1];
    for (int v = 1; v < capture->n_views; v++) gap = fmax(gap, azimuths[v] - azimuths[v - 1]);
    ffp_free(azimuths);
    return gap;
}

static double angle_between(const double a[3], const double b[3]) {
    return degrees(acos(fmax(-1, fmin(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]))));
}

double ffp_rig_widest_step(const FfpCapture *capture) {
    double widest = 0;
    for (int v = 0; v < capture->n_views; v++) {
        double own[3], other[3], nearest = INFINITY;
        ffp_rig_direction(capture, &capture->views[v].camera, own);
        for (int w = 0; w < capture->n_views; w++) {
            if (ffp_same_device(&capture->views[v].camera, &capture->views[w].camera)) continue;
            ffp_rig_direction(capture, &capture->views[w].camera, other);
            nearest = fmin(nearest, angle_between(own, other));
        }
        if (isfinite(nearest)) widest = fmax(widest, nearest);
    }
    return widest;
}
