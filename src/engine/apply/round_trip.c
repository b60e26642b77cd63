// How well the two correspondence maps of a camera and a projector fit each other.
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/numerics/rank.h"
#include "engine/apply/procams.h"

#define STEEPEST                                                                                             \
    4 // depth steps of more pixel widths between neighbours are not surface (a tilt of 76 degrees)

// Camera position at (u, v) of the inverse for a point at depth z; false when no pixel has that depth.
static bool way_back(const FfpImage *inverse, const FfpCamera *projector, real u, real v, real z,
                     real out[2]) {
    const real x = u - 0.5F, y = v - 0.5F;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    const real same = STEEPEST * z / fmin(projector->fx, projector->fy);
    real weight = 0;
    out[0] = out[1] = 0;
    for (int k = 0; k < 4; k++) {
        const int i = x0 + (k & 1), j = y0 + (k >> 1);
        if (i < 0 || j < 0 || i >= inverse->width || j >= inverse->height) continue;
        const real *pixel = inverse->data + 3 * ((size_t)j * (size_t)inverse->width + (size_t)i);
        if (!(pixel[2] > 0) || fabs(pixel[2] - z) > same) continue;
        const real share = (1 - fabs(x - (real)i)) * (1 - fabs(y - (real)j));
        weight += share;
        out[0] += share * pixel[0], out[1] += share * pixel[1];
    }
    if (!(weight > 1e-3F)) return false;
    out[0] /= weight, out[1] /= weight;
    return true;
}

// Distance in pixels, -2 when there is no way back.
static real one_trip(const FfpCamera *camera, const FfpCamera *projector, const FfpImage *inverse, real px,
                     real py, real z) {
    real ray[3], point[3], u, v, back[2];
    const real along = ffp_pixel_ray(camera, px, py, ray);
    for (int k = 0; k < 3; k++) point[k] = camera->pose[4 * k + 3] + z / along * ray[k];
    const real depth = ffp_project(projector, point, &u, &v);
    if (!way_back(inverse, projector, u, v, depth, back)) return -2;
    return hypot(back[0] - px, back[1] - py);
}

FfpRoundTrip ffp_round_trip(const FfpCamera *camera, const FfpCamera *projector, FfpImage *lit,
                            const FfpImage *inverse) {
    FfpRoundTrip trip = {0};
    real *errors = lit->data; // each behind the depths that are still needed
    int within = 0;
    for (int y = 0; y < camera->height; y++)
        for (int x = 0; x < camera->width; x++) {
            const real z = lit->data[(size_t)y * (size_t)camera->width + (size_t)x];
            if (!(z > 0)) continue;
            const real error = one_trip(camera, projector, inverse, (real)x + 0.5F, (real)y + 0.5F, z);
            trip.lost += error < 0;
            if (!(error >= 0)) continue;
            within += error <= 0.5F;
            errors[trip.pixels++] = error;
        }
    if (trip.pixels) {
        const size_t n = (size_t)trip.pixels;
        trip.within_half = (double)within / trip.pixels;
        trip.median = (double)ffp_median(errors, n);
        trip.most = (double)ffp_rank(errors, n, n - 1);
    }
    return trip;
}
