#include "rig/selfcal/devices.h"
#include <math.h>
#include <string.h>
#include "core/base/lens.h"

enum { NEARNESS_STEPS = 6 };
#define UNIT_HELD 1e-5 // relative: the unit of length, which no photograph tells
#define BEHIND 1e3     // pixels: what a sighting counts whose point is behind the camera

// Deviations from 0 that are usual, of the shares of the width and of the lens terms; of focal lengths any.
static const double usual[FFP_BUNDLE_OPTICS] = {
    [FFP_BUNDLE_CAMERA_X] = 0.01,       [FFP_BUNDLE_CAMERA_Y] = 0.01,
    [FFP_BUNDLE_CAMERA_K1] = 0.2,       [FFP_BUNDLE_CAMERA_K2] = 0.05,
    [FFP_BUNDLE_CAMERA_P1] = 0.001,     [FFP_BUNDLE_CAMERA_P2] = 0.001,
    [FFP_BUNDLE_CAMERA_ASPECT] = 0.002, [FFP_BUNDLE_PROJECTOR_X] = 0.03,
    [FFP_BUNDLE_PROJECTOR_Y] = 0.5,     [FFP_BUNDLE_PROJECTOR_K1] = 0.1,
    [FFP_BUNDLE_PROJECTOR_K2] = 0.02,   [FFP_BUNDLE_PROJECTOR_P1] = 0.001,
    [FFP_BUNDLE_PROJECTOR_P2] = 0.001,  [FFP_BUNDLE_PROJECTOR_ASPECT] = 0.002,
    [FFP_BUNDLE_PROJECTOR_SKEW] = 0.002};

// The numbers of one device begin with its focal length and lie in one order.
enum { FOCAL, X, Y, K1, K2, P1, P2, ASPECT };

static FfpBundleDevice device_of(const double *numbers, int width, int height) {
    const double focal = exp(numbers[FOCAL]);
    return (FfpBundleDevice){focal * (1 - 0.5 * numbers[ASPECT]),
                             focal * (1 + 0.5 * numbers[ASPECT]),
                             (0.5 + numbers[X]) * width,
                             0.5 * height + numbers[Y] * width,
                             {numbers[K1], numbers[K2], numbers[P1], numbers[P2]},
                             0};
}

FfpBundleDevice ffp_bundle_camera(const FfpTracks *t, const double optics[FFP_BUNDLE_OPTICS]) {
    return device_of(optics + FFP_BUNDLE_CAMERA_FOCAL, t->width, t->height);
}

FfpBundleDevice ffp_bundle_camera_at(const FfpTracks *t, const double optics[FFP_BUNDLE_OPTICS],
                                     const double own[FFP_OWN]) {
    double there[FFP_BUNDLE_OPTICS];
    memcpy(there, optics, sizeof there);
    there[FFP_BUNDLE_CAMERA_FOCAL] += own[FFP_OWN_FOCAL];
    there[FFP_BUNDLE_CAMERA_K1] += own[FFP_OWN_K1];
    there[FFP_BUNDLE_CAMERA_X] += own[FFP_OWN_X], there[FFP_BUNDLE_CAMERA_Y] += own[FFP_OWN_Y];
    return ffp_bundle_camera(t, there);
}

FfpBundleDevice ffp_bundle_projector(const FfpTracks *t, const double optics[FFP_BUNDLE_OPTICS]) {
    FfpBundleDevice projector =
        device_of(optics + FFP_BUNDLE_PROJECTOR_FOCAL, t->panel_width, t->panel_height);
    projector.skew = projector.fy * optics[FFP_BUNDLE_PROJECTOR_SKEW];
    return projector;
}

bool ffp_bundle_ray(const FfpBundleDevice *device, const double pixel[2], double ray[3]) {
    const double y = (pixel[1] - device->y) / device->fy,
                 x = (pixel[0] - device->x - device->skew * y) / device->fx;
    const bool ok = ffp_lens_undistort(device->lens, x, y, ray);
    ray[2] = ok;
    return ok;
}

bool ffp_bundle_pixel(const FfpBundleDevice *camera, const double x[3], double at[2]) {
    double u, v;
    if (!(x[2] > 0)) return false;
    ffp_lens_distort(camera->lens, x[0] / x[2], x[1] / x[2], &u, &v);
    at[0] = camera->x + camera->fx * u + camera->skew * v, at[1] = camera->y + camera->fy * v;
    return true;
}

void ffp_rigid_apply(const FfpRigid *m, const double p[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = ffp_dot(m->r + 3 * (size_t)k, p) + m->t[k];
}

// --- One track: its nearness, and how far its sightings lie from where that puts them. ---

bool ffp_devices_count(const FfpDevices *d, const FfpSighting *s) {
    return s->used && d->known[s->place];
}

// A pixel and its change with the nearness, in the camera's frame x + nearness t for the ray's x.
static bool sight(const FfpBundleDevice *c, const double x[3], const double t[3], double nearness,
                  double at[2], double slope[2]) {
    const double z = x[2] + nearness * t[2];
    if (!(z > 0)) return false;
    const double u = (x[0] + nearness * t[0]) / z, v = (x[1] + nearness * t[1]) / z;
    const double du = (t[0] - u * t[2]) / z, dv = (t[1] - v * t[2]) / z;
    const double r2 = u * u + v * v, dr2 = 2 * (u * du + v * dv), *k = c->lens;
    const double radial = 1 + r2 * (k[0] + r2 * k[1]), more = dr2 * (k[0] + 2 * r2 * k[1]);
    const double uv = 2 * u * v, duv = 2 * (u * dv + v * du);
    at[0] = c->x + c->fx * (u * radial + k[2] * uv + k[3] * (r2 + 2 * u * u));
    at[1] = c->y + c->fy * (v * radial + k[3] * uv + k[2] * (r2 + 2 * v * v));
    slope[0] = c->fx * (du * radial + u * more + k[2] * duv + k[3] * (dr2 + 4 * u * du));
    slope[1] = c->fy * (dv * radial + v * more + k[3] * duv + k[2] * (dr2 + 4 * v * dv));
    return true;
}

// A first nearness, linear in it: a x_2 = x_0 for each sighting at a.
static double first_nearness(const FfpDevices *d, const FfpSighting *s, int n, const double ray[3]) {
    double above = 0, below = 0;
    for (int i = 0; i < n; i++) {
        if (!ffp_devices_count(d, &s[i])) continue;
        const FfpRigid *pose = &d->places[s[i].place];
        const FfpBundleDevice *camera = &d->cameras[s[i].place];
        const double a[2] = {(s[i].at[0] - camera->x) / camera->fx, (s[i].at[1] - camera->y) / camera->fy};
        for (int k = 0; k < 2; k++) {
            const double fixed = a[k] * ffp_dot(pose->r + 6, ray) - ffp_dot(pose->r + 3 * k, ray);
            const double moves = a[k] * pose->t[2] - pose->t[k];
            above -= fixed * moves, below += moves * moves;
        }
    }
    return below > 0 ? above / below : 0;
}

bool ffp_devices_miss(const FfpDevices *d, const double ray[3], const FfpSighting *s, double nearness,
                      double off[2], double slope[2]) {
    const FfpRigid *pose = &d->places[s->place];
    const double x[3] = {ffp_dot(pose->r, ray), ffp_dot(pose->r + 3, ray), ffp_dot(pose->r + 6, ray)};
    double at[2] = {s->at[0] + BEHIND, s->at[1]};
    slope[0] = slope[1] = 0;
    const bool seen = nearness > 0 && sight(&d->cameras[s->place], x, pose->t, nearness, at, slope);
    for (int k = 0; k < 2; k++) off[k] = at[k] - s->at[k];
    return seen;
}

double ffp_devices_nearness(const FfpDevices *d, const double ray[3], const FfpSighting *s, int n,
                            double start, double *differences) {
    const bool ok = ray[2] > 0;
    double nearness = start > 0 ? start : ok ? first_nearness(d, s, n, ray) : 0;
    for (int step = 0; ok && step <= NEARNESS_STEPS; step++) {
        double above = 0, below = 0;
        for (int i = 0; i < n; i++) {
            double off[2], slope[2];
            if (!ffp_devices_count(d, &s[i])) continue;
            ffp_devices_miss(d, ray, &s[i], nearness, off, slope);
            for (int k = 0; k < 2; k++) {
                if (differences) differences[2 * i + k] = off[k];
                above += slope[k] * off[k], below += slope[k] * slope[k];
            }
        }
        if (step == NEARNESS_STEPS || !(below > 0)) break;
        const double by = above / below;
        nearness = fmax(nearness - by, 0.2 * nearness);
        if (fabs(by) < 1e-9 * nearness) step = NEARNESS_STEPS - 1; // once more, for the differences
    }
    return ok && nearness > 0 ? nearness : 0;
}

void ffp_optics_unusual(const double optics[FFP_BUNDLE_OPTICS], const FfpUsual *beforehand, double firm,
                        double distance, double *out) {
    const FfpKnownFocal *known = &beforehand->focal;
    const double panel = beforehand->panel;
    for (int i = 0; i < FFP_BUNDLE_OPTICS; i++) out[i] = usual[i] > 0 ? firm * optics[i] / usual[i] : 0;
    for (int i = FFP_BUNDLE_PROJECTOR_ASPECT; i <= FFP_BUNDLE_PROJECTOR_SKEW && panel > 0; i++)
        out[i] = firm * optics[i] / panel;
    if (known->deviation > 0) // as one coordinate of a sighting, of which `firm` counts both
        out[FFP_BUNDLE_CAMERA_FOCAL] =
            sqrt(0.5) * firm * (optics[FFP_BUNDLE_CAMERA_FOCAL] - known->log) / known->deviation;
    out[FFP_BUNDLE_OPTICS] = log(distance) / UNIT_HELD * FFP_BUNDLE_NOISE;
}

void ffp_optics_to_cv(const FfpTracks *t, const double optics[FFP_BUNDLE_OPTICS], const double *deviation,
                      FfpCvDevice devices[2]) {
    const FfpBundleDevice both[2] = {ffp_bundle_camera(t, optics), ffp_bundle_projector(t, optics)};
    for (int d = 0; d < 2; d++) {
        const FfpBundleDevice *from = &both[d];
        const double *off = deviation + (d == 0 ? FFP_BUNDLE_CAMERA_FOCAL : FFP_BUNDLE_PROJECTOR_FOCAL);
        FfpCvDevice *to = &devices[d];
        to->width = d == 0 ? t->width : t->panel_width, to->height = d == 0 ? t->height : t->panel_height;
        const double matrix[9] = {from->fx, 0, from->x - 0.5, 0, from->fy, from->y - 0.5, 0, 0, 1};
        memcpy(to->matrix, matrix, sizeof matrix), memcpy(to->lens, from->lens, sizeof to->lens);
        const double deviations[9] = {from->fx * off[FOCAL],
                                      from->fy * off[FOCAL],
                                      to->width * off[X],
                                      to->width * off[Y],
                                      off[K1],
                                      off[K2],
                                      off[P1],
                                      off[P2]};
        memcpy(to->deviation, deviations, sizeof deviations);
    }
}
