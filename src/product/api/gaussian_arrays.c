// The Gaussians' numbers, out of the library and into it.
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians) {
    return (FfpGaussianArrays){.count = gaussians->count,
                               .centre = gaussians->centre,
                               .scale = gaussians->scale,
                               .rotation = gaussians->rotation,
                               .opacity = gaussians->opacity,
                               .albedo = gaussians->albedo,
                               .roughness = gaussians->roughness,
                               .ambient = gaussians->ambient,
                               .scattered = gaussians->scattered};
}

// The range of the caller's numbers, and their place.
typedef struct Range {
    const float *from;
    double low, high;
} Range;

// Without a branch, so that a vector is looked at at a time: this is done before every step of a fit.
static bool all_within(const Range *range, int64_t count) {
    const float low = (float)range->low, high = (float)range->high;
    unsigned outside = 0;
    for (int64_t i = 0; i < count; i++) outside |= !((range->from[i] >= low) & (range->from[i] <= high));
    return !outside;
}

static bool check_attribute(int64_t count, int attribute, const Range *range, FfpError *err) {
    const char *name = ffp_attributes[attribute].name;
    const int width = ffp_attributes[attribute].width;
    if (!range->from && attribute == FFP_SCATTERED) return true; // none
    if (!range->from) return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "the array is missing");
    if (all_within(range, count * width)) return true;
    for (int64_t i = 0; i < count * width; i++) {
        const double value = (double)range->from[i];
        if (!isfinite(value))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "row %lld: %g is not finite",
                            (long long)(i / width), value);
        if (!(value >= range->low && value <= range->high))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "row %lld: %g is not in %g to %g",
                            (long long)(i / width), value, range->low, range->high);
    }
    return true;
}

static float square_of(const float q[4]) {
    return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

static bool check_rotations(int64_t count, const float *rotation, FfpError *err) {
    for (int64_t i = 0; i < count; i++)
        if (!(square_of(rotation + 4 * i) > 1e-12F))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "rotation", "row %lld: the quaternion is 0",
                            (long long)i);
    return true;
}

bool ffp_check_arrays(const FfpGaussianArrays *a, FfpError *err) {
    if (a->count < 1 || a->count > FFP_GAUSSIANS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "%lld Gaussians are not in 1 to %d",
                        (long long)a->count, FFP_GAUSSIANS_MAX);
    const Range ranges[FFP_ATTRIBUTES] = {
        [FFP_CENTRE] = {a->centre, -1e9, 1e9},     [FFP_SCALE] = {a->scale, 1e-20, 1e9},
        [FFP_ROTATION] = {a->rotation, -1e3, 1e3}, [FFP_OPACITY] = {a->opacity, 0, 1},
        [FFP_ALBEDO] = {a->albedo, 0, 1e6},        [FFP_ROUGHNESS] = {a->roughness, 0, 1},
        [FFP_AMBIENT] = {a->ambient, 0, 1e6},      [FFP_SCATTERED] = {a->scattered, 0, 1e6},
    };
    bool ok = true;
    for (int i = 0; ok && i < FFP_ATTRIBUTES; i++) ok = check_attribute(a->count, i, &ranges[i], err);
    return ok && check_rotations(a->count, a->rotation, err);
}

bool ffp_need_gaussians(const FfpGaussians *g, FfpError *err) {
    if (!ffp_need(g, "gaussians", err)) return false;
    const Range any = {NULL, -(double)FLT_MAX, (double)FLT_MAX}, share = {NULL, 0, 1};
    bool ok = true;
    for (int i = 0; ok && i < FFP_ATTRIBUTES; i++) {
        Range range = i == FFP_OPACITY ? share : any;
        range.from = ffp_attribute(g, i).data;
        if (i == FFP_SCALE) range.low = (double)FLT_MIN;
        ok = check_attribute(g->count, i, &range, err);
    }
    return ok && check_rotations(g->count, g->rotation, err);
}

static bool any_above_zero(const float *numbers, int64_t count) {
    unsigned any = 0;
    for (int64_t i = 0; numbers && i < count; i++) any |= numbers[i] > 0;
    return any != 0;
}

FfpGaussians ffp_gaussians_of(const FfpGaussianArrays *a) {
    return (FfpGaussians){.count = a->count,
                          .centre = a->centre,
                          .scale = a->scale,
                          .rotation = a->rotation,
                          .opacity = a->opacity,
                          .albedo = a->albedo,
                          .roughness = a->roughness,
                          .ambient = a->ambient,
                          .scattered = a->scattered,
                          .scatters = any_above_zero(a->scattered, 3 * a->count)};
}

static void normalise_rotations(FfpGaussians *gaussians) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        float *q = gaussians->rotation + 4 * i;
        const float square = square_of(q);
        if (fabsf(square - 1) < 1e-6F) continue; // what came from here goes back bit by bit
        for (int c = 0; c < 4; c++) q[c] /= sqrtf(square);
    }
}

static FfpGaussians *copy_arrays(const FfpGaussianArrays *a, FfpError *err) {
    if (!ffp_check_arrays(a, err)) return NULL;
    const FfpGaussians given = ffp_gaussians_of(a);
    FfpGaussians *g = ffp_alloc(1, sizeof *g);
    *g = ffp_gaussians_copy(&given);
    normalise_rotations(g);
    return g;
}

typedef struct Call {
    const FfpGaussianArrays *arrays;
    FfpGaussians *gaussians;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->gaussians = copy_arrays(call->arrays, err);
    return call->gaussians != NULL;
}

FfpGaussians *ffp_gaussians_from_arrays(FfpContext *context, const FfpGaussianArrays *arrays, FfpError *err) {
    Call call = {arrays, NULL};
    if (!ffp_need(arrays, "arrays", err)) return NULL;
    return ffp_call_run(context, work, &call, err) ? call.gaussians : NULL;
}
