#include "world/synth/sensor.h"
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "world/shapes/noise.h"
#include "world/shapes/scalar.h"

static bool in_range(float value, float low, float high) {
    return value >= low && value <= high; // false for NaN
}

static bool check_light(const FfpSensor *s, FfpError *err) {
    for (int c = 0; c < 3; c++)
        if (!in_range(s->spread[c], 0, 0.5F))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor", "spread %g is not in 0..0.5",
                            (double)s->spread[c]);
    if (!in_range(s->spread_reach, 0, 200) || !in_range(s->glare, 0, 0.5F) || !in_range(s->glare_reach, 0, 1))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "spread_reach %g, glare %g or glare_reach %g is not in 0..200, 0..0.5, 0..1",
                        (double)s->spread_reach, (double)s->glare, (double)s->glare_reach);
    if (!in_range(s->power, 0, 5) || (s->power > 0 && s->gamma != 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "power %g is not in 0..5, or gamma is set as well, which it replaces",
                        (double)s->power);
    if (!in_range(s->real_light, 0, 1) || !in_range(s->vignetting, 0, 0.9F) ||
        !in_range(s->throw_fall, 0, 0.9F))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "real_light %g, vignetting %g or throw_fall %g is not in 0..1, 0..0.9, 0..0.9",
                        (double)s->real_light, (double)s->vignetting, (double)s->throw_fall);
    if (!in_range(s->focus_blur, 0, 64) || !in_range(s->focus_at, 0, 100))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "focus_blur %g or focus_at %g is not in 0..64, 0..100", (double)s->focus_blur,
                        (double)s->focus_at);
    return true;
}

bool ffp_sensor_check(const FfpSensor *s, FfpError *err) {
    if (!in_range(s->exposure, -8, 8))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor", "exposure %g is not in -8..8",
                        (double)s->exposure);
    if (!in_range(s->shot, 0, 1) || !in_range(s->read, 0, 1))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor", "shot %g or read noise %g is not in 0..1",
                        (double)s->shot, (double)s->read);
    if (!in_range(s->defocus, 0, 64))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor", "defocus %g is not in 0..64", (double)s->defocus);
    if (!in_range(s->gamma, -0.9F, 4) || !in_range(s->black_level, 0, 0.9F))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "projector gamma %g or black level %g is out of range", (double)s->gamma,
                        (double)s->black_level);
    if (!in_range(s->turn_error, 0, 0.5F) || !in_range(s->shift_error, 0, 0.5F))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor", "pose errors %g and %g are not in 0..0.5",
                        (double)s->turn_error, (double)s->shift_error);
    return check_light(s, err);
}

bool ffp_sensor_changes_light(const FfpSensor *s) {
    return s->gamma != 0 || s->power > 0 || s->black_level > 0 || s->defocus > 0 || s->spread[0] > 0 ||
           s->spread[1] > 0 || s->spread[2] > 0;
}

// The light of a linear value whose sRGB encoding is in the file.
static float bend(float value, const FfpSensor *s) {
    if (s->power > 0) return powf((float)ffp_srgb_encode((real)value), s->power);
    return s->gamma != 0 ? powf(value, 1 + s->gamma) : value;
}

FfpImage ffp_sensor_emit(const FfpImage *pattern, const FfpSensor *s) {
    FfpImage out = ffp_image_copy(pattern);
    const size_t values = (size_t)out.width * (size_t)out.height * (size_t)out.channels;
    for (size_t i = 0; i < values; i++) {
        const float value = (float)out.data[i], bent = bend(value, s);
        out.data[i] = (real)(s->black_level + (1 - s->black_level) * bent);
    }
    ffp_sensor_spread(&out, s);
    if (s->defocus > 0) ffp_image_blur(&out, (real)s->defocus);
    return out;
}

bool ffp_sensor_emit_file(FfpImage *emitted, const char *path, const FfpSensor *sensor, FfpError *err) {
    FfpImage pattern;
    if (!ffp_image_read_over_black(&pattern, NULL, path, err)) return false;
    if (!ffp_sensor_changes_light(sensor)) {
        *emitted = pattern;
        return true;
    }
    *emitted = ffp_sensor_emit(&pattern, sensor);
    ffp_image_free(&pattern);
    return true;
}

float ffp_sensor_noise(float value, float shot, float read, uint32_t pixel, uint32_t picture) {
    const float variance = shot * ffp_max(value, 0) + read * read;
    if (variance <= 0) return value;
    const uint32_t a = ffp_hash32(pixel ^ ffp_hash32(picture)), b = ffp_hash32(a ^ 0x9e3779b9U);
    // Box and Muller 1958; photons are counted in such numbers that a normal stands for their Poisson
    const float radius = sqrtf(-2 * logf(1 - ffp_hash_unit(a)));
    return value + sqrtf(variance) * radius * cosf(6.2831853F * ffp_hash_unit(b));
}

void ffp_sensor_expose(FfpImage *light, const FfpSensor *sensor, uint32_t picture) {
    const size_t values = (size_t)light->width * (size_t)light->height * (size_t)light->channels;
    for (size_t i = 0; i < values; i++)
        light->data[i] =
            (real)ffp_sensor_noise((float)light->data[i], sensor->shot, sensor->read, (uint32_t)i, picture);
}

void ffp_sensor_misplace(FfpCamera *device, float turn, float shift, FfpRng *rng) {
    double v[3], angle = 0, moved[3];
    for (int k = 0; k < 3; k++) v[k] = (double)(turn * ffp_rng_normal(rng)), angle += v[k] * v[k];
    for (int k = 0; k < 3; k++) moved[k] = (double)(shift * ffp_rng_normal(rng));
    angle = sqrt(angle);
    const double s = angle > 0 ? sin(angle) / angle : 1,
                 c = angle > 0 ? (1 - cos(angle)) / (angle * angle) : 0.5;
    for (int axis = 0; axis < 3; axis++) { // Rodrigues' formula on each axis of the device
        double a[3], along = 0;
        for (int k = 0; k < 3; k++) a[k] = (double)device->pose[4 * k + axis], along += a[k] * v[k];
        for (int k = 0; k < 3; k++) {
            const int m = (k + 1) % 3, n = (k + 2) % 3;
            const double cross = v[m] * a[n] - v[n] * a[m];
            device->pose[4 * k + axis] = (real)(cos(angle) * a[k] + s * cross + c * along * v[k]);
        }
    }
    for (int k = 0; k < 3; k++) device->pose[4 * k + 3] += (real)moved[k];
}
