// The Gaussians' numbers, out of the library and into it.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "ffprocams.h"
#include "base/arena.h"
#include "base/call.h"
#include "gaussians/gaussians.h"

FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians) {
    return (FfpGaussianArrays){gaussians->count,     gaussians->centre,  gaussians->scale,
                               gaussians->rotation,  gaussians->opacity, gaussians->albedo,
                               gaussians->roughness, gaussians->ambient};
}

typedef struct Attribute {
    const char *name;
    const float *from;
    float *to;
    int width; // numbers a Gaussian
    double low, high;
} Attribute;

static bool copy_attribute(const Attribute *a, int64_t count, FfpError *err) {
    if (!a->from && count > 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, a->name, "the array is missing");
    for (int64_t i = 0; i < count * a->width; i++) {
        const double value = (double)a->from[i];
        if (!(value >= a->low && value <= a->high))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, a->name, "row %lld: %g is not in %g to %g",
                            (long long)(i / a->width), value, a->low, a->high);
        a->to[i] = a->from[i];
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
    const Attribute attributes[] = {
        {"centre", a->centre, g->centre, 3, -1e9, 1e9},
        {"scale", a->scale, g->scale, 3, 1e-20, 1e9},
        {"rotation", a->rotation, g->rotation, 4, -1e3, 1e3},
        {"opacity", a->opacity, g->opacity, 1, 0, 1},
        {"albedo", a->albedo, g->albedo, 3, 0, 1e6},
        {"roughness", a->roughness, g->roughness, 1, 0, 1},
        {"ambient", a->ambient, g->ambient, 3, 0, 1e6},
    };
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof attributes / sizeof *attributes; i++)
        ok = copy_attribute(&attributes[i], a->count, err);
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
    return ffp_call_run(context, work, &call, err) ? call.gaussians : NULL;
}
