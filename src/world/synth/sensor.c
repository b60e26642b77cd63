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
    return true;
}

bool ffp_sensor_changes_light(const FfpSensor *s) {
    return s->gamma != 0 || s->black_level > 0 || s->defocus > 0;
}

FfpImage ffp_sensor_emit(const FfpImage *pattern, const FfpSensor *s) {
    FfpImage out = ffp_image_copy(pattern);
    const size_t values = (size_t)out.width * (size_t)out.height * (size_t)out.channels;
    for (size_t i = 0; i < values; i++) {
        const float value = (float)out.data[i], bent = s->gamma != 0 ? powf(value, 1 + s->gamma) : value;
        out.data[i] = (real)(s->black_level + (1 - s->black_level) * bent);
    }
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
