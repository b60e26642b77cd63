// The default rig: a turntable's eight stops with camera and projector fixed (docs/design/architecture.md,
// "rig"), and the new poses, whose distribution is that of the held-back poses of the reference captures:
// camera 2.85 to 3.25 away, 63 to 106 degrees from the pole; projector 1.9 to 2.3 away, 18 to 45 degrees to a
// side, 20 below to 45 above the camera. And free rigs, in which every view has a camera and a projector of
// its own.
#include "world/synth/rig.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/real.h"
#include "core/base/rng.h"
#include "world/shapes/mesh.h"

static const double DEGREE = FFP_PI_DOUBLE / 180;
enum {
    STREAM_LIGHT = 101,
    STREAM_RIG = 102,
    STREAM_FREE_RIG = 103,
    STREAM_INPUT = 1000,
    STREAM_TARGET = 5000,
    STREAM_FREE_INPUT = 9000
};

FfpRigLight ffp_rig_light(const FfpSceneSpec *spec) {
    FfpRigLight rig = {{7.96F, 7.96F, 7.96F}, 0.3F};
    if (!spec->jitter) return rig;
    FfpRng rng = ffp_rng(spec->seed, STREAM_LIGHT);
    rig.ambient = ffp_rng_range(&rng, 0.1F, 0.5F);
    const float scale = ffp_rng_range(&rng, 0.6F, 1.5F);
    for (int c = 0; c < 3; c++) rig.intensity[c] *= scale;
    return rig;
}

// A device at `at` that looks at `aim`, its image upright where `up` is up.
static void look(FfpCamera *camera, const double at[3], const double aim[3], const double up[3]) {
    double x[3], y[3], z[3], n = 0, m = 0;
    for (int k = 0; k < 3; k++) z[k] = aim[k] - at[k], n += z[k] * z[k];
    for (int k = 0; k < 3; k++) z[k] /= sqrt(n);
    for (int k = 0; k < 3; k++) { // forward cross up; + 0.0 makes +0 of -0
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        x[k] = z[i] * up[j] - z[j] * up[i] + 0.0, m += x[k] * x[k];
    }
    for (int k = 0; k < 3; k++) x[k] /= sqrt(m);
    for (int k = 0; k < 3; k++) y[k] = z[(k + 1) % 3] * x[(k + 2) % 3] - z[(k + 2) % 3] * x[(k + 1) % 3];
    memset(camera->pose, 0, sizeof camera->pose);
    for (int k = 0; k < 3; k++) {
        camera->pose[4 * k] = (real)x[k], camera->pose[4 * k + 1] = (real)y[k],
                         camera->pose[4 * k + 2] = (real)z[k];
        camera->pose[4 * k + 3] = (real)at[k];
    }
    camera->pose[15] = 1;
}

void ffp_rig_place(FfpCamera *camera, double radius, double polar, double azimuth, const double aim[3]) {
    const double s = sin(polar * DEGREE), c = cos(polar * DEGREE), up[3] = {0, 0, 1};
    const double at[3] = {radius * s * cos(azimuth * DEGREE), radius * s * sin(azimuth * DEGREE), radius * c};
    look(camera, at, aim, up);
}

static void optics(FfpCamera *camera, int side, double field) {
    camera->width = camera->height = side;
    camera->fx = camera->fy = (real)(0.5 * side / tan(0.5 * field * DEGREE));
    camera->cx = camera->cy = (real)(0.5 * side);
}

static void aim_near(FfpRng *rng, double reach, double aim[3]) {
    for (int k = 0; k < 3; k++) aim[k] = ffp_rng_range(rng, (float)-reach, (float)reach);
}

static void turntable_input(const FfpSceneSpec *spec, int index, FfpView *view) {
    optics(&view->camera, spec->resolution, 40);
    optics(&view->projector, spec->pattern_side, 55);
    const double turn = 360.0 * index / spec->views;
    snprintf(view->id, sizeof view->id, "path_0_theta%03d", (int)turn);
    double radius = 3, polar = 90, start = 0, throw_radius = 2, throw_polar = 60, throw_side = 0;
    double aim[3] = {0, 0, 0}, throw_aim[3] = {0, 0, 0}, wobble = 0;
    if (spec->jitter) {
        FfpRng rig = ffp_rng(spec->seed, STREAM_RIG); // one rig for all stops, as on a table
        radius *= ffp_rng_range(&rig, 0.95F, 1.05F);
        polar = ffp_rng_range(&rig, 80, 100);
        start = ffp_rng_range(&rig, 0, 360);
        throw_radius *= ffp_rng_range(&rig, 0.9F, 1.1F);
        throw_polar += ffp_rng_range(&rig, -5, 5);
        throw_side = ffp_rng_range(&rig, -5, 5);
        FfpRng stop = ffp_rng(spec->seed, STREAM_INPUT + (uint64_t)index);
        aim_near(&stop, 0.02, aim);
        aim_near(&stop, 0.05, throw_aim);
        wobble = ffp_rng_range(&stop, -2, 2);
    }
    ffp_rig_place(&view->camera, radius, polar, start + turn + wobble, aim);
    ffp_rig_place(&view->projector, throw_radius, throw_polar, start + turn + wobble + throw_side, throw_aim);
}

// Where on the sphere a free rig's camera stands, in degrees: the band between the polar angles 40 and 130 in
// spec->views strips of equal area, a view in each; from strip to strip on by the golden angle. Anywhere
// within the strip, and to a side by up to a quarter of the mean distance of neighbours. The order of the
// strips is random.
static void free_direction(const FfpSceneSpec *spec, int index, FfpRng *rng, double *polar, double *azimuth) {
    const double top = cos(40 * DEGREE), bottom = cos(130 * DEGREE), golden = 137.50776405;
    int strips[FFP_VIEWS_MAX] = {0};
    FfpRng rig = ffp_rng(spec->seed, STREAM_FREE_RIG);
    const double start = ffp_rng_range(&rig, 0, 360);
    for (int i = 0; i < spec->views; i++) strips[i] = i;
    for (int i = 0; i <= index; i++) { // Fisher and Yates, as far as it is needed
        const int k = i + (int)ffp_rng_below(&rig, (uint32_t)(spec->views - i)), swap = strips[k];
        strips[k] = strips[i], strips[i] = swap;
    }
    const double share = (strips[index] + (double)ffp_rng_uniform(rng)) / spec->views;
    *polar = acos(top + share * (bottom - top)) / DEGREE;
    *azimuth = start + golden * strips[index] + ffp_rng_range(rng, -42, 42) / sqrt(spec->views);
}

// Turns a device about its viewing axis.
static void roll(FfpCamera *device, double degrees) {
    const double c = cos(degrees * DEGREE), s = sin(degrees * DEGREE);
    for (int k = 0; k < 3; k++) {
        const double x = (double)device->pose[4 * k], y = (double)device->pose[4 * k + 1];
        device->pose[4 * k] = (real)(c * x + s * y), device->pose[4 * k + 1] = (real)(c * y - s * x);
    }
}

// The projector of a camera in the direction (polar, azimuth): `side` and `above` degrees from there, as the
// camera sees right and up, and upright as the camera is.
static void place_beside(FfpCamera *projector, double radius, double polar, double azimuth, double side,
                         double above, const double aim[3]) {
    const double s = sin(polar * DEGREE), c = cos(polar * DEGREE);
    const double cos_a = cos(azimuth * DEGREE), sin_a = sin(azimuth * DEGREE);
    const double out[3] = {s * cos_a, s * sin_a, c}, right[3] = {-sin_a, cos_a, 0},
                 up[3] = {-c * cos_a, -c * sin_a, s};
    double at[3];
    for (int k = 0; k < 3; k++)
        at[k] =
            radius * (cos(above * DEGREE) * (cos(side * DEGREE) * out[k] + sin(side * DEGREE) * right[k]) +
                      sin(above * DEGREE) * up[k]);
    look(projector, at, aim, up);
}

// The field holds the mesh's whole sphere, also where the camera looks beside its centre.
static void free_input(const FfpSceneSpec *spec, int index, FfpView *view) {
    const double reach = 0.03;
    FfpRng rng = ffp_rng(spec->seed, STREAM_FREE_INPUT + (uint64_t)index);
    double polar, azimuth, aim[3];
    snprintf(view->id, sizeof view->id, "free_%02d", index);
    free_direction(spec, index, &rng, &polar, &azimuth);
    const double radius = ffp_rng_range(&rng, 2.7F, 3.4F);
    const double least = 2 * asin((FFP_MESH_RADIUS + reach * sqrt(3)) / radius) / DEGREE + 0.5;
    optics(&view->camera, spec->resolution, ffp_rng_range(&rng, (float)fmax(34, least), 46));
    aim_near(&rng, reach, aim);
    ffp_rig_place(&view->camera, radius, polar, azimuth, aim);
    roll(&view->camera, ffp_rng_range(&rng, -5, 5));

    optics(&view->projector, spec->pattern_side, 55);
    const double throw_radius = ffp_rng_range(&rng, 1.8F, 2.4F), side = ffp_rng_range(&rng, 15, 50);
    const double sign = ffp_rng_uniform(&rng) < 0.5F ? -1 : 1, above = ffp_rng_range(&rng, -20, 45);
    aim_near(&rng, 0.05, aim);
    place_beside(&view->projector, throw_radius, polar, azimuth, sign * side, above, aim);
    roll(&view->projector, ffp_rng_range(&rng, -5, 5));
}

// The acquisition of Nepmap and GS-ProCams: the turntable's projector at its first stop, and the camera on a
// spiral of four turns from near the pole to below the equator, equal areas of the sphere between its views.
static void sphere_input(const FfpSceneSpec *spec, int index, FfpView *view) {
    const double top = cos(20 * DEGREE), bottom = cos(110 * DEGREE), turns = 4, origin[3] = {0, 0, 0};
    const double share = (index + 0.5) / spec->views;
    optics(&view->camera, spec->resolution, 40);
    optics(&view->projector, spec->pattern_side, 55);
    snprintf(view->id, sizeof view->id, "sphere_%03d", index);
    ffp_rig_place(&view->camera, 3, acos(top + share * (bottom - top)) / DEGREE, 360 * turns * share, origin);
    ffp_rig_place(&view->projector, 2, 60, 0, origin);
}

void ffp_rig_input(const FfpSceneSpec *spec, int index, FfpView *view) {
    if (spec->rig == FFP_SCENE_FREE)
        free_input(spec, index, view);
    else if (spec->rig == FFP_SCENE_SPHERE)
        sphere_input(spec, index, view);
    else
        turntable_input(spec, index, view);
}

void ffp_rig_target(const FfpSceneSpec *spec, int index, FfpView *view) {
    optics(&view->camera, spec->resolution, 40);
    optics(&view->projector, spec->pattern_side, 55);
    snprintf(view->id, sizeof view->id, "novel_%02d", index);
    FfpRng rng = ffp_rng(spec->seed, STREAM_TARGET + (uint64_t)index);
    const double origin[3] = {0, 0, 0};
    const double azimuth = ffp_rng_range(&rng, 0, 360),
                 polar = ffp_rng_range(&rng, spec->jitter ? 52 : 63, 106);
    const double radius = ffp_rng_range(&rng, 2.85F, 3.25F), side = ffp_rng_range(&rng, 18, 45);
    const double sign = ffp_rng_uniform(&rng) < 0.5F ? -1 : 1, above = ffp_rng_range(&rng, -20, 45);
    ffp_rig_place(&view->camera, radius, polar, azimuth, origin);
    const double throw_polar = fmin(94, fmax(35, polar - above));
    ffp_rig_place(&view->projector, ffp_rng_range(&rng, 1.9F, 2.3F), throw_polar, azimuth + sign * side,
                  origin);
}
