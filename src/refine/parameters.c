#include "refine/parameters.h"

#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/vec.h"

static const real least = 1e-4F;           // sigmoids start this far from their ends at least
static const real roughness_floor = 0.05F; // as the network's heads have it
static const real flatness = 0.05F;

FfpAttribute ffp_attribute(const FfpGaussians *gaussians, int attribute) {
    const FfpAttribute all[FFP_ATTRIBUTES] = {
        [FFP_CENTRE] = {gaussians->centre, 3},     [FFP_SCALE] = {gaussians->scale, 3},
        [FFP_ROTATION] = {gaussians->rotation, 4}, [FFP_OPACITY] = {gaussians->opacity, 1},
        [FFP_ALBEDO] = {gaussians->albedo, 3},     [FFP_ROUGHNESS] = {gaussians->roughness, 1},
        [FFP_AMBIENT] = {gaussians->ambient, 3},
    };
    return all[attribute];
}

void ffp_quaternion_matrix(const real q[4], real m[9]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    m[0] = 1 - 2 * (y * y + z * z), m[1] = 2 * (x * y - w * z), m[2] = 2 * (x * z + w * y);
    m[3] = 2 * (x * y + w * z), m[4] = 1 - 2 * (x * x + z * z), m[5] = 2 * (y * z - w * x);
    m[6] = 2 * (x * z - w * y), m[7] = 2 * (y * z + w * x), m[8] = 1 - 2 * (x * x + y * y);
}

static real sigmoid(real x) {
    return 1 / (1 + exp(-x));
}

static real logit(real p) {
    const real inside = fmin(fmax(p, least), 1 - least);
    return log(inside / (1 - inside));
}

static void unit_quaternion(const real q[4], real out[4]) {
    const real length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++) out[k] = length > 0 ? q[k] / length : k == 0;
}

static void encode(FfpParameters *p, const FfpGaussians *g, int64_t i, bool local) {
    FfpGaussians *n = &p->numbers;
    unit_quaternion(g->rotation + 4 * i, n->rotation + 4 * i);
    p->unit[i] = 1;
    p->frame[4 * i] = 1;
    for (int k = 0; k < 3; k++) {
        n->centre[3 * i + k] = local ? 0 : g->centre[3 * i + k];
        n->scale[3 * i + k] = log(fmax(g->scale[3 * i + k], 1e-12F));
        n->albedo[3 * i + k] = logit(g->albedo[3 * i + k]);
        n->ambient[3 * i + k] = logit(g->ambient[3 * i + k]);
    }
    n->opacity[i] = logit(g->opacity[i]);
    n->roughness[i] = logit((g->roughness[i] - roughness_floor) / (1 - roughness_floor));
    if (!local) return;
    memcpy(p->origin + 3 * i, g->centre + 3 * i, 3 * sizeof(real));
    memcpy(p->frame + 4 * i, n->rotation + 4 * i, 4 * sizeof(real));
    p->unit[i] = fmax(fmax(g->scale[3 * i], g->scale[3 * i + 1]), g->scale[3 * i + 2]);
}

FfpParameters ffp_parameters_new(const FfpGaussians *gaussians, bool local, bool flat) {
    const size_t count = (size_t)gaussians->count;
    FfpParameters p = {.numbers = ffp_gaussians_new(gaussians->count),
                       .origin = ffp_alloc(count + 1, 3 * sizeof(real)),
                       .frame = ffp_alloc(count + 1, 4 * sizeof(real)),
                       .unit = ffp_alloc(count + 1, sizeof(real)),
                       .flat = flat};
    for (int64_t i = 0; i < gaussians->count; i++) encode(&p, gaussians, i, local);
    return p;
}

void ffp_parameters_free(FfpParameters *parameters) {
    ffp_gaussians_free(&parameters->numbers);
    free(parameters->origin);
    free(parameters->frame);
    free(parameters->unit);
    *parameters = (FfpParameters){0};
}

static void decode(const FfpParameters *p, int64_t i, FfpGaussians *out) {
    const FfpGaussians *n = &p->numbers;
    real m[9];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    for (int k = 0; k < 3; k++) {
        const int64_t at = 3 * i + k;
        out->centre[at] = p->origin[at] + p->unit[i] * ffp_dot3(m + 3 * k, n->centre + 3 * i);
        out->scale[at] = exp(n->scale[at]);
        out->albedo[at] = sigmoid(n->albedo[at]);
        out->ambient[at] = sigmoid(n->ambient[at]);
    }
    if (p->flat) out->scale[3 * i + 2] = flatness * fmin(out->scale[3 * i], out->scale[3 * i + 1]);
    unit_quaternion(n->rotation + 4 * i, out->rotation + 4 * i);
    out->opacity[i] = sigmoid(n->opacity[i]);
    out->roughness[i] = roughness_floor + (1 - roughness_floor) * sigmoid(n->roughness[i]);
}

void ffp_parameters_decode(const FfpParameters *parameters, FfpGaussians *out) {
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < out->count; i++) decode(parameters, i, out);
}

// g / |q| less its part along q / |q|: through the normalisation.
static void pull_back_rotation(const real *number, const real *unit, real *grad) {
    const real length =
        sqrt(number[0] * number[0] + number[1] * number[1] + number[2] * number[2] + number[3] * number[3]);
    real along = 0;
    for (int k = 0; k < 4; k++) along += grad[k] * unit[k];
    for (int k = 0; k < 4; k++) grad[k] = length > 0 ? (grad[k] - along * unit[k]) / length : 0;
}

static void pull_back(const FfpParameters *p, const FfpGaussians *d, int64_t i, FfpGaussians *grad) {
    real m[9], world[3];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    memcpy(world, grad->centre + 3 * i, sizeof world);
    for (int k = 0; k < 3; k++) {
        const int64_t at = 3 * i + k;
        grad->centre[at] = p->unit[i] * (m[k] * world[0] + m[3 + k] * world[1] + m[6 + k] * world[2]);
        grad->scale[at] *= d->scale[at];
        grad->albedo[at] *= d->albedo[at] * (1 - d->albedo[at]);
        grad->ambient[at] *= d->ambient[at] * (1 - d->ambient[at]);
    }
    if (p->flat) grad->scale[3 * i + 2] = 0;
    pull_back_rotation(p->numbers.rotation + 4 * i, d->rotation + 4 * i, grad->rotation + 4 * i);
    grad->opacity[i] *= d->opacity[i] * (1 - d->opacity[i]);
    const real s = (d->roughness[i] - roughness_floor) / (1 - roughness_floor);
    grad->roughness[i] *= (1 - roughness_floor) * s * (1 - s);
}

void ffp_parameters_pull_back(const FfpParameters *parameters, const FfpGaussians *decoded,
                              FfpGaussians *grad) {
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < grad->count; i++) pull_back(parameters, decoded, i, grad);
}

// Rows of `width` numbers.
static void gather_rows(const real *data, int width, const int64_t *from, int64_t count, real *out) {
    for (int64_t i = 0; i < count; i++)
        memcpy(out + i * width, data + from[i] * width, (size_t)width * sizeof(real));
}

static void gather(real **data, int width, const int64_t *from, int64_t count) {
    real *out = ffp_alloc((size_t)count + 1, (size_t)width * sizeof(real));
    gather_rows(*data, width, from, count, out);
    free(*data);
    *data = out;
}

void ffp_gaussians_gather(FfpGaussians *gaussians, const int64_t *from, int64_t count) {
    FfpGaussians out = ffp_gaussians_new(count);
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
