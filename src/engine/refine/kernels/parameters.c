// Numbers into attributes and gradients back (engine/refine/maps.h), attribute by attribute: loops that gcc
// vectorises; and the table of one CPU level.
#include "engine/refine/kernels/kernels.h"
#include "engine/refine/maps.h"

static void sigmoids(const real *restrict number, real *restrict out, int64_t count) {
    for (int64_t i = 0; i < count; i++) out[i] = ffp_number_sigmoid(number[i]);
}

static void sigmoids_backward(const real *restrict out, real *restrict grad, int64_t count) {
    for (int64_t i = 0; i < count; i++) grad[i] *= ffp_number_sigmoid_slope(out[i]);
}

static void squares(const real *restrict number, real *restrict out, int64_t count) {
    for (int64_t i = 0; i < count; i++) out[i] = number[i] * number[i];
}

static void squares_backward(const real *restrict number, real *restrict grad, int64_t count) {
    for (int64_t i = 0; i < count; i++) grad[i] *= 2 * number[i];
}

void FFP_K(decode)(const FfpParameters *p, int64_t begin, int64_t count, const FfpGaussians *out) {
    const FfpGaussians *n = &p->numbers;
    const int64_t colours = 3 * begin;
    const real *restrict log_scale = n->scale + colours, *restrict rough = n->roughness + begin;
    real *restrict scale = out->scale + colours, *restrict roughness = out->roughness + begin;
    for (int64_t i = 0; i < count; i++)
        for (int64_t at = 3 * i; at < 3 * i + 3; at++)
            scale[at] = ffp_deviation_of(log_scale[at], p->most * p->unit[begin + i]);
    for (int64_t i = 0; i < count; i++) roughness[i] = ffp_roughness_of(rough[i]);
    sigmoids(n->albedo + colours, out->albedo + colours, 3 * count);
    sigmoids(n->ambient + colours, out->ambient + colours, 3 * count);
    squares(n->scattered + colours, out->scattered + colours, 3 * count);
    sigmoids(n->opacity + begin, out->opacity + begin, count);
    for (int64_t i = begin; i < begin + count; i++) ffp_decode_frame(p, i, out);
}

void FFP_K(pull_back)(const FfpParameters *p, const FfpGaussians *decoded, int64_t begin, int64_t count,
                      const FfpGaussians *grad) {
    const int64_t colours = 3 * begin;
    const real *restrict scale = decoded->scale + colours, *restrict roughness = decoded->roughness + begin;
    real *restrict d_scale = grad->scale + colours, *restrict d_roughness = grad->roughness + begin;
    for (int64_t i = 0; i < 3 * count; i++) d_scale[i] *= scale[i];
    for (int64_t i = 0; i < count; i++) d_roughness[i] *= ffp_roughness_slope(roughness[i]);
    sigmoids_backward(decoded->albedo + colours, grad->albedo + colours, 3 * count);
    sigmoids_backward(decoded->ambient + colours, grad->ambient + colours, 3 * count);
    squares_backward(p->numbers.scattered + colours, grad->scattered + colours, 3 * count);
    sigmoids_backward(decoded->opacity + begin, grad->opacity + begin, count);
    for (int64_t i = begin; i < begin + count; i++) ffp_pull_back_frame(p, decoded, i, grad);
}

enum { COLUMNS = 16 }; // splats, number by number: a loop that gcc vectorises

typedef struct Columns {
    real grad[3][COLUMNS], x[3][COLUMNS], mean[3][COLUMNS], square[3][COLUMNS], cross[3][COLUMNS];
} Columns;

static void move_columns(const FfpAdamStep *s, Columns *c) {
#pragma GCC ivdep
    for (int i = 0; i < COLUMNS; i++) {
        const real g[3] = {c->grad[0][i], c->grad[1][i], c->grad[2][i]};
        real x[3] = {c->x[0][i], c->x[1][i], c->x[2][i]};
        real mean[3] = {c->mean[0][i], c->mean[1][i], c->mean[2][i]};
        real square[3] = {c->square[0][i], c->square[1][i], c->square[2][i]};
        real cross[3] = {c->cross[0][i], c->cross[1][i], c->cross[2][i]};
        ffp_adam_coupled(s, g, x, mean, square, cross);
        c->x[0][i] = x[0], c->x[1][i] = x[1], c->x[2][i] = x[2];
        c->mean[0][i] = mean[0], c->mean[1][i] = mean[1], c->mean[2][i] = mean[2];
        c->square[0][i] = square[0], c->square[1][i] = square[1], c->square[2][i] = square[2];
        c->cross[0][i] = cross[0], c->cross[1][i] = cross[1], c->cross[2][i] = cross[2];
    }
}

static void load_columns(const real *rows, int64_t count, real columns[3][COLUMNS]) {
    for (int64_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) columns[k][i] = rows[3 * i + k];
}

static void store_columns(const real columns[3][COLUMNS], int64_t count, real *rows) {
    for (int64_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) rows[3 * i + k] = columns[k][i];
}

void FFP_K(move_coupled)(const FfpAdamArray *a, real *cross, int64_t begin, int64_t count) {
    const FfpAdamStep s = a->step;
    Columns c = {0};
    for (int64_t i = begin; i < begin + count; i += COLUMNS) {
        const int64_t n = begin + count - i < COLUMNS ? begin + count - i : COLUMNS;
        load_columns(a->grad + 3 * i, n, c.grad);
        load_columns(a->x + 3 * i, n, c.x);
        load_columns(a->mean + 3 * i, n, c.mean);
        load_columns(a->square + 3 * i, n, c.square);
        load_columns(cross + 3 * i, n, c.cross);
        move_columns(&s, &c);
        store_columns(c.x, n, a->x + 3 * i);
        store_columns(c.mean, n, a->mean + 3 * i);
        store_columns(c.square, n, a->square + 3 * i);
        store_columns(c.cross, n, cross + 3 * i);
    }
    for (int64_t i = 3 * begin; a->start && i < 3 * (begin + count); i++)
        a->x[i] = ffp_adam_pulled(&s, a->x[i], a->start[i]);
}

const FfpRefineKernels FFP_K(refine) = {
    .decode = FFP_K(decode), .pull_back = FFP_K(pull_back), .move_coupled = FFP_K(move_coupled)};
