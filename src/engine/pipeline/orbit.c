#include "engine/pipeline/orbit.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"

static void mean_up(const FfpCapture *capture, real up[3]) {
    for (int k = 0; k < 3; k++) up[k] = 0;
    for (int v = 0; v < capture->n_views; v++)
        for (int k = 0; k < 3; k++) up[k] -= capture->views[v].camera.pose[4 * k + 1];
    if (ffp_normalise3(up) > 0) return;
    for (int k = 0; k < 3; k++) up[k] = -capture->views[0].camera.pose[4 * k + 1];
}

// Rodrigues' formula.
static void rotation_vector(const real axis[3], real angle, real v[3]) {
    real across[3];
    const real c = cos(angle), s = sin(angle), along = ffp_dot3(axis, v) * (1 - c);
    ffp_cross3(axis, v, across);
    for (int k = 0; k < 3; k++) v[k] = c * v[k] + s * across[k] + along * axis[k];
}

static void rotate_device(FfpCamera *device, const real centre[3], const real axis[3], real angle) {
    for (int column = 0; column < 4; column++) {
        real v[3];
        for (int k = 0; k < 3; k++) v[k] = device->pose[4 * k + column] - (column == 3 ? centre[k] : 0);
        rotation_vector(axis, angle, v);
        for (int k = 0; k < 3; k++) device->pose[4 * k + column] = v[k] + (column == 3 ? centre[k] : 0);
    }
}

FfpView *ffp_orbit_views(const FfpCapture *capture, const FfpView *base, FfpOrbit orbit, int count) {
    FfpView *views = ffp_alloc((size_t)count, sizeof *views);
    real up[3];
    mean_up(capture, up);
    for (int f = 0; f < count; f++) {
        // turning the object is turning both devices the other way round
        const real turn = 6.283185307F * (real)f / (real)count;
        const real angle = orbit == FFP_ORBIT_OBJECT ? -turn : turn;
        views[f].camera = base->camera;
        views[f].projector = base->projector;
        strcpy(views[f].id, "frame");
        if (orbit != FFP_ORBIT_PROJECTOR) rotate_device(&views[f].camera, capture->centre, up, angle);
        if (orbit != FFP_ORBIT_CAMERA) rotate_device(&views[f].projector, capture->centre, up, angle);
    }
    return views;
}
