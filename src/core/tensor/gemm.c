// Matrix products over OpenBLAS.
#include <cblas.h>
#include <omp.h>
#include "core/base/integer.h"
#include "core/tensor/kernels/kernels.h"

enum { PIECE = 64 }; // no thread gets fewer rows or columns than this

// Rows or columns a piece has when `size` is cut for `pieces` threads: a multiple of 16, the kernels' width.
static int piece_size(int size, int pieces) {
    return ffp_larger(1, ((size + pieces - 1) / pieces + 15) / 16 * 16);
}

static void product(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    _Generic(alpha, float
             : cblas_sgemm, double
             : cblas_dgemm)(CblasRowMajor, a.transposed ? CblasTrans : CblasNoTrans,
                            b.transposed ? CblasTrans : CblasNoTrans, a.rows, b.columns, a.columns, alpha,
                            a.data, a.stride, b.data, b.stride, beta, c, ldc);
}

// Outside a parallel region C is cut into one rectangle a thread, each a
// single-threaded product: with few threads that is up to a quarter faster
// than OpenBLAS's own threading. Inside one, the caller's thread does it all.
void ffp_blas_gemm(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    const int m = a.rows, n = b.columns, k = a.columns;
    if (m <= 0 || n <= 0) return;
    const int threads = omp_in_parallel() ? 1 : omp_get_max_threads();
    const int down = ffp_larger(1, ffp_smaller(m / PIECE, threads));
    const int across = ffp_larger(1, ffp_smaller(n / PIECE, threads / down));
    if (down * across == 1) {
        product(alpha, a, b, beta, c, ldc);
        return;
    }
    const int height = piece_size(m, down), width = piece_size(n, across);
#pragma omp parallel for collapse(2) schedule(static)
    for (int row = 0; row < m; row += height) {
        for (int column = 0; column < n; column += width) {
            const FfpFactor rows = ffp_factor_part(a, row, 0, ffp_smaller(height, m - row), k);
            const FfpFactor columns = ffp_factor_part(b, 0, column, k, ffp_smaller(width, n - column));
            product(alpha, rows, columns, beta, c + (size_t)row * ldc + column, ldc);
        }
    }
}
