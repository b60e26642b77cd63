// The Gaussians' numbers, out of the library and into it.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"
#include "product/api/arguments.h"

FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians) {
    return (FfpGaussianArrays){gaussians->count,     gaussians->centre,  gaussians->scale,
                               gaussians->rotation,  gaussians->opacity, gaussians->albedo,
                               gaussians->roughness, gaussians->ambient};
}

// What the caller's numbers may be, and where they are.
typedef struct Range {
    const float *from;
    double low, high;
} Range;

static bool copy_attribute(FfpGaussians *to, int attribute, const Range *range, FfpError *err) {
    const char *name = ffp_attributes[attribute].name;
    const FfpAttribute into = ffp_attribute(to, attribute);
    if (!range->from) return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "the array is missing");
    for (int64_t i = 0; i < to->count * into.width; i++) {
        const double value = (double)range->from[i];
        if (!(value >= range->low && value <= range->high))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "row %lld: %g is not in %g to %g",
                            (long long)(i / into.width), value, range->low, range->high);
        into.data[i] = range->from[i];
    }
    return true;
}

static bool normalise_rotations(FfpGaussians *gaussians, FfpError *err) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        float *q = gaussians->rotation + 4 * i, square = 0;
        for (int c = 0; c < 4; c++) square += q[c] * q[c];
        if (!(square > 1e-12F))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "rotation", "row %lld: the quaternion is 0",
                            (long long)i);
        if (fabsf(square - 1) < 1e-6F) continue; // what came from here goes back bit by bit
        for (int c = 0; c < 4; c++) q[c] /= sqrtf(square);
    }
    return true;
}

static FfpGaussians *copy_arrays(const FfpGaussianArrays *a, FfpError *err) {
    if (a->count < 1 || a->count > FFP_GAUSSIANS_MAX) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "%lld Gaussians are not in 1 to %d", (long long)a->count,
                 FFP_GAUSSIANS_MAX);
        return NULL;
    }
    FfpGaussians *g = ffp_alloc(1, sizeof *g);
    *g = ffp_gaussians_new(a->count);
    const Range ranges[FFP_ATTRIBUTES] = {
        [FFP_CENTRE] = {a->centre, -1e9, 1e9},     [FFP_SCALE] = {a->scale, 1e-20, 1e9},
        [FFP_ROTATION] = {a->rotation, -1e3, 1e3}, [FFP_OPACITY] = {a->opacity, 0, 1},
        [FFP_ALBEDO] = {a->albedo, 0, 1e6},        [FFP_ROUGHNESS] = {a->roughness, 0, 1},
        [FFP_AMBIENT] = {a->ambient, 0, 1e6},
    };
    bool ok = true;
    for (int i = 0; ok && i < FFP_ATTRIBUTES; i++) ok = copy_attribute(g, i, &ranges[i], err);
    if (ok && normalise_rotations(g, err)) return g;
    ffp_gaussians_free(g);
    ffp_free(g);
    return NULL;
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
