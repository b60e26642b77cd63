#include "engine/refine/parameters.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "engine/refine/kernels/kernels.h"
#include "engine/refine/maps.h"
#include "engine/refine/table.h"

#define GROWTH_MOST 3

FfpParameters ffp_parameters_new(const FfpGaussians *gaussians, bool local, bool flat) {
    const size_t count = (size_t)gaussians->count;
    FfpParameters p = {.numbers = ffp_gaussians_new(gaussians->count),
                       .origin = ffp_memory_new(count + 1, 3 * sizeof(real)),
                       .frame = ffp_memory_new(count + 1, 4 * sizeof(real)),
                       .unit = ffp_memory_new(count + 1, sizeof(real)),
                       .flat = flat,
                       .most = local ? GROWTH_MOST : INFINITY};
    if (ffp_device())
        ffp_device()->refine->encode(gaussians, local, &p);
    else
        for (int64_t i = 0; i < gaussians->count; i++) ffp_encode(gaussians, i, local, &p);
    return p;
}

void ffp_parameters_free(FfpParameters *parameters) {
    ffp_gaussians_free(&parameters->numbers);
    ffp_memory_free(parameters->origin);
    ffp_memory_free(parameters->frame);
    ffp_memory_free(parameters->unit);
    *parameters = (FfpParameters){0};
}

enum { PART = 512 }; // splats at a time: their numbers stay in the nearest caches

static int64_t part_from(int64_t begin, int64_t count) {
    return count - begin < PART ? count - begin : PART;
}

void ffp_parameters_decode(const FfpParameters *parameters, FfpGaussians *out) {
    if (ffp_device()) {
        ffp_device()->refine->decode(parameters, out);
        return;
    }
    FfpDecode *decode = ffp_refine_kernels()->decode;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < out->count; i += PART) decode(parameters, i, part_from(i, out->count), out);
}

void ffp_parameters_pull_back(const FfpParameters *parameters, const FfpGaussians *decoded,
                              FfpGaussians *grad) {
    if (ffp_device()) {
        ffp_device()->refine->pull_back(parameters, decoded, grad);
        return;
    }
    FfpPullBack *pull_back = ffp_refine_kernels()->pull_back;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < grad->count; i += PART)
        pull_back(parameters, decoded, i, part_from(i, grad->count), grad);
}

void ffp_parameters_average(const FfpParameters *parameters, real share, FfpGaussians *mean) {
    if (ffp_device()) {
        ffp_device()->refine->average(&parameters->numbers, share, mean);
        return;
    }
#pragma omp parallel
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(&parameters->numbers, a), to = ffp_attribute(mean, a);
        const int64_t count = mean->count * to.width;
#pragma omp for simd schedule(static) nowait
        for (int64_t i = 0; i < count; i++) ffp_average(from.data[i], share, &to.data[i]);
    }
}

// Rows of `width` numbers.
static void gather_rows(const real *data, int width, const int64_t *from, int64_t count, real *out) {
    for (int64_t i = 0; i < count; i++)
        memcpy(out + i * width, data + from[i] * width, (size_t)width * sizeof(real));
}

static void gather(real **data, int width, const int64_t *from, int64_t count) {
    real *out = ffp_alloc((size_t)count + 1, (size_t)width * sizeof(real));
    gather_rows(*data, width, from, count, out);
    ffp_free(*data);
    *data = out;
}

void ffp_gaussians_gather(FfpGaussians *gaussians, const int64_t *from, int64_t count) {
    FfpGaussians out = ffp_gaussians_new(count);
    ffp_gaussians_take_notes(&out, gaussians);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute old = ffp_attribute(gaussians, a);
        gather_rows(old.data, old.width, from, count, ffp_attribute(&out, a).data);
    }
    ffp_gaussians_free(gaussians);
    *gaussians = out;
}

void ffp_parameters_gather(FfpParameters *parameters, const int64_t *from, int64_t count) {
    ffp_gaussians_gather(&parameters->numbers, from, count);
    gather(&parameters->origin, 3, from, count);
    gather(&parameters->frame, 4, from, count);
    gather(&parameters->unit, 1, from, count);
}
