// The default rig: a turntable's eight stops with camera and projector fixed (docs/architecture.md, "rig"),
// and the new poses, whose distribution is that of the held-back poses of the reference captures: camera 2.85
// to 3.25 away, 63 to 106 degrees from the pole; projector 1.9 to 2.3 away, 18 to 45 degrees to a side, 20
// below to 45 above the camera.
#include "synth/rig.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "base/rng.h"

static const double DEGREE = 3.14159265358979323846 / 180;
enum { STREAM_LIGHT = 101, STREAM_RIG = 102, STREAM_INPUT = 1000, STREAM_TARGET = 5000 };

FfpRig ffp_rig_light(const FfpSceneSpec *spec) {
    FfpRig rig = {{7.96F, 7.96F, 7.96F}, 0.3F};
    if (!spec->jitter) return rig;
    FfpRng rng = ffp_rng(spec->seed, STREAM_LIGHT);
    rig.ambient = ffp_rng_range(&rng, 0.1F, 0.5F);
    const float scale = ffp_rng_range(&rng, 0.6F, 1.5F);
    for (int c = 0; c < 3; c++) rig.intensity[c] *= scale;
    return rig;
}

// A device at (radius, polar, azimuth in degrees) that looks at `aim`, its image upright (z up).
static void place(FfpCamera *camera, double radius, double polar, double azimuth, const double aim[3]) {
    const double s = sin(polar * DEGREE), c = cos(polar * DEGREE);
    const double at[3] = {radius * s * cos(azimuth * DEGREE), radius * s * sin(azimuth * DEGREE), radius * c};
    double z[3], n = 0;
    for (int k = 0; k < 3; k++) z[k] = aim[k] - at[k], n += z[k] * z[k];
    for (int k = 0; k < 3; k++) z[k] /= sqrt(n);
    const double flat = sqrt(z[0] * z[0] + z[1] * z[1]);
    const double x[3] = {z[1] / flat, -z[0] / flat, 0}; // forward cross up
    const double y[3] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    memset(camera->pose, 0, sizeof camera->pose);
    for (int k = 0; k < 3; k++) {
        camera->pose[4 * k] = (real)x[k], camera->pose[4 * k + 1] = (real)y[k],
                         camera->pose[4 * k + 2] = (real)z[k];
        camera->pose[4 * k + 3] = (real)at[k];
    }
    camera->pose[15] = 1;
}

static void optics(FfpCamera *camera, int side, double field) {
    camera->width = camera->height = side;
    camera->fx = camera->fy = (real)(0.5 * side / tan(0.5 * field * DEGREE));
    camera->cx = camera->cy = (real)(0.5 * side);
}

static void aim_near(FfpRng *rng, double reach, double aim[3]) {
    for (int k = 0; k < 3; k++) aim[k] = ffp_rng_range(rng, (float)-reach, (float)reach);
}

void ffp_rig_input(const FfpSceneSpec *spec, int index, FfpView *view) {
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
    place(&view->camera, radius, polar, start + turn + wobble, aim);
    place(&view->projector, throw_radius, throw_polar, start + turn + wobble + throw_side, throw_aim);
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
    place(&view->camera, radius, polar, azimuth, origin);
    const double throw_polar = fmin(94, fmax(35, polar - above));
    place(&view->projector, ffp_rng_range(&rng, 1.9F, 2.3F), throw_polar, azimuth + sign * side, origin);
}
