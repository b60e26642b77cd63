// LayerNorm (Ba et al. 2016), RMSNorm (Zhang & Sennrich 2019)
// and Mamba2's gated RMSNorm, over the rows of a matrix.
#include <tgmath.h>
#include "core/tensor/kernels/columns.h"
#include "core/tensor/kernels/fastmath.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/silu.h"

#define EPSILON 1e-5F

static real mean_of(const real *x, int dim) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < dim; i++) sum += x[i];
    return sum / (real)dim;
}

static real mean_square(const real *x, real centre, int dim) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < dim; i++) sum += (x[i] - centre) * (x[i] - centre);
    return sum / (real)dim;
}

void FFP_K(layernorm_forward)(real *y, real *mean, real *rstd, const real *x, const real *gain, int rows,
                              int dim) {
#pragma omp parallel for schedule(static)
    for (int t = 0; t < rows; t++) {
        const real *x_row = x + (size_t)t * dim;
        real *y_row = y + (size_t)t * dim;
        const real centre = mean_of(x_row, dim), scale = 1 / sqrt(mean_square(x_row, centre, dim) + EPSILON);
        for (int i = 0; i < dim; i++) y_row[i] = (x_row[i] - centre) * scale * gain[i];
        mean[t] = centre;
        rstd[t] = scale;
    }
}

// With n = (x - mean) rstd and g = dy gain: dx = rstd (g - mean(g) - n mean(g n)); dgain += sum of dy n.
void FFP_K(layernorm_backward)(real *dx, real *dgain, const real *dy, const real *x, const real *mean,
                               const real *rstd, const real *gain, int rows, int dim) {
#pragma omp parallel for schedule(static)
    for (int t = 0; t < rows; t++) {
        const real *x_row = x + (size_t)t * dim, *dy_row = dy + (size_t)t * dim;
        real *dx_row = dx + (size_t)t * dim;
        const real centre = mean[t], scale = rstd[t];
        real sum = 0, sum_n = 0;
#pragma omp simd reduction(+ : sum, sum_n)
        for (int i = 0; i < dim; i++) {
            const real g = dy_row[i] * gain[i];
            sum += g;
            sum_n += g * (x_row[i] - centre);
        }
        const real along_one = sum / (real)dim, along_n = sum_n * scale * scale / (real)dim;
        for (int i = 0; i < dim; i++)
            dx_row[i] = scale * (dy_row[i] * gain[i] - along_one - (x_row[i] - centre) * along_n);
    }
    FFP_K(add_column_sums)(dgain, dy, x, mean, rstd, rows, dim);
}

void FFP_K(rmsnorm_forward)(real *y, real *rstd, const real *x, const real *gain, int rows, int dim) {
#pragma omp parallel for schedule(static)
    for (int t = 0; t < rows; t++) {
        const real *x_row = x + (size_t)t * dim;
        real *y_row = y + (size_t)t * dim;
        const real scale = 1 / sqrt(mean_square(x_row, 0, dim) + EPSILON);
        for (int i = 0; i < dim; i++) y_row[i] = x_row[i] * scale * gain[i];
        rstd[t] = scale;
    }
}

// As LayerNorm's without the mean: dx = rstd (g - n mean(g n)).
void FFP_K(rmsnorm_backward)(real *dx, real *dgain, const real *dy, const real *x, const real *rstd,
                             const real *gain, int rows, int dim) {
#pragma omp parallel for schedule(static)
    for (int t = 0; t < rows; t++) {
        const real *x_row = x + (size_t)t * dim, *dy_row = dy + (size_t)t * dim;
        real *dx_row = dx + (size_t)t * dim;
        const real scale = rstd[t];
        real sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int i = 0; i < dim; i++) sum += dy_row[i] * gain[i] * x_row[i];
        const real along = sum * scale * scale / (real)dim;
        for (int i = 0; i < dim; i++) dx_row[i] = scale * (dy_row[i] * gain[i] - x_row[i] * along);
    }
    FFP_K(add_column_sums)(dgain, dy, x, NULL, rstd, rows, dim);
}

// out = x silu(z); returns the mean of its squares.
static real gate_row(real *out, const real *x, const real *z, int dim) {
    FfpVector sum = {0};
    for (int i = 0; i < dim; i += FFP_LANES) {
        const FfpVector gated =
            ffp_load_masked(x + i, dim - i) * ffp_silu_vector(ffp_load_masked(z + i, dim - i));
        ffp_store_masked(out + i, gated, dim - i);
        sum += gated * gated;
    }
    real all = 0;
    for (int lane = 0; lane < FFP_LANES; lane++) all += sum[lane];
    return all / (real)dim;
}

void FFP_K(gated_norm_forward)(real *y, real *rstd, const FfpGatedNorm *in) {
    const int dim = in->dim;
#pragma omp parallel for schedule(static)
    for (int t = 0; t < in->rows; t++) {
        real *y_row = y + (size_t)t * dim;
        const real square = gate_row(y_row, in->x + (size_t)t * dim, in->z + (size_t)t * in->ldz, dim);
        const real scale = 1 / sqrt(square + EPSILON);
        for (int i = 0; i < dim; i++) y_row[i] *= scale * in->gain[i];
        rstd[t] = scale;
    }
}

// One row: on entry dx holds the gated u = x silu(z), on return the gradient of x; dz is added to.
static void gated_row_backward(real *dx, real *dz, const real *dy, const real *x, const real *z, real scale,
                               const real *gain, int dim) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < dim; i++) sum += dy[i] * gain[i] * dx[i];
    const real along = sum * scale * scale / (real)dim;
    for (int i = 0; i < dim; i += FFP_LANES) {
        const int left = dim - i;
        const FfpVector gate = ffp_load_masked(z + i, left), gated = ffp_load_masked(dx + i, left);
        const FfpVector du =
            scale * (ffp_load_masked(dy + i, left) * ffp_load_masked(gain + i, left) - gated * along);
        const FfpVector open = ffp_sigmoid_vector(gate); // silu = z open, silu' = open (1 + z (1 - open))
        const FfpVector slope = open * (1 + gate * (1 - open));
        ffp_store_masked(dx + i, du * gate * open, left);
        ffp_store_masked(dz + i, ffp_load_masked(dz + i, left) + du * ffp_load_masked(x + i, left) * slope,
                         left);
    }
}

void FFP_K(gated_norm_backward)(const FfpGatedNormGradient *grad, const FfpGatedNorm *in, const real *dy,
                                const real *rstd) {
    const int dim = in->dim;
#pragma omp parallel for schedule(static)
    for (int t = 0; t < in->rows; t++)
        gate_row(grad->x + (size_t)t * dim, in->x + (size_t)t * dim, in->z + (size_t)t * in->ldz, dim);
    FFP_K(add_column_sums)(grad->gain, dy, grad->x, NULL, rstd, in->rows, dim);
#pragma omp parallel for schedule(static)
    for (int t = 0; t < in->rows; t++) {
        const size_t row = (size_t)t * dim;
        gated_row_backward(grad->x + row, grad->z + (size_t)t * grad->ldz, dy + row, in->x + row,
                           in->z + (size_t)t * in->ldz, rstd[t], in->gain, dim);
    }
}
