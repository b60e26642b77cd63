// The two routines of LAPACK that the engine calls (core/numerics/least_squares.c, engine/denoise/stack.c),
// for pages, which have no OpenBLAS. Matrices are small. Golub and Van Loan, Matrix Computations, 4th
// edition: Cholesky's factor 4.2, Jacobi's rotations 8.5.
#include <math.h>
#include <stdbool.h>
#include <string.h>

void dposv_(const char *half, const int *n, const int *columns, double *a, const int *lda, double *b,
            const int *ldb, int *info);
void dsyev_(const char *job, const char *half, const int *n, double *a, const int *lda, double *values,
            double *work, const int *work_size, int *info);

// Row i of the factor L of A = L L^T in place of A's; false where A is not positive.
static bool factor_row(double *a, int i, int lda) {
    for (int j = 0; j <= i; j++) {
        double sum = a[i * lda + j];
        for (int k = 0; k < j; k++) sum -= a[i * lda + k] * a[j * lda + k];
        if (i == j && !(sum > 0)) return false;
        a[i * lda + j] = i == j ? sqrt(sum) : sum / a[j * lda + j];
    }
    return true;
}

// Solves A x = b for a symmetric positive A, of which the rows' lower halves are read. As it is called here:
// one column, "U" in Fortran's order of numbers.
void dposv_(const char *half, const int *n, const int *columns, double *a, const int *lda, double *b,
            const int *ldb, int *info) {
    (void)half, (void)columns, (void)ldb;
    for (int i = 0; i < *n; i++) {
        if (!factor_row(a, i, *lda)) {
            *info = i + 1;
            return;
        }
    }
    for (int i = 0; i < *n; i++) {
        for (int k = 0; k < i; k++) b[i] -= a[i * *lda + k] * b[k];
        b[i] /= a[i * *lda + i];
    }
    for (int i = *n - 1; i >= 0; i--) {
        for (int k = i + 1; k < *n; k++) b[i] -= a[k * *lda + i] * b[k];
        b[i] /= a[i * *lda + i];
    }
    *info = 0;
}

enum { SIDE_MAX = 64, SWEEPS = 30 };
#define ENDED 1e-30 // of the sum of all squares

typedef struct Rotation {
    double c, s;
} Rotation;

// The rotation that brings a[p][q] to 0.
static Rotation rotation_of(const double *a, int n, int p, int q) {
    const double off = a[p * n + q];
    if (off == 0) return (Rotation){1, 0};
    const double tau = (a[q * n + q] - a[p * n + p]) / (2 * off);
    const double t = (tau >= 0 ? 1 : -1) / (fabs(tau) + sqrt(1 + tau * tau)), c = 1 / sqrt(1 + t * t);
    return (Rotation){c, t * c};
}

// J^T A J, and the vectors' rows with it.
static void rotate(double *a, double *vectors, int n, int p, int q, Rotation r) {
    for (int k = 0; k < n; k++) {
        const double x = a[k * n + p], y = a[k * n + q];
        a[k * n + p] = r.c * x - r.s * y;
        a[k * n + q] = r.s * x + r.c * y;
    }
    for (int k = 0; k < n; k++) {
        const double x = a[p * n + k], y = a[q * n + k], u = vectors[p * n + k], v = vectors[q * n + k];
        a[p * n + k] = r.c * x - r.s * y;
        a[q * n + k] = r.s * x + r.c * y;
        vectors[p * n + k] = r.c * u - r.s * v;
        vectors[q * n + k] = r.s * u + r.c * v;
    }
}

static bool is_diagonal(const double *a, int n) {
    double off = 0, all = 0;
    for (int p = 0; p < n; p++) {
        for (int q = 0; q < n; q++) {
            all += a[p * n + q] * a[p * n + q];
            off += p == q ? 0 : a[p * n + q] * a[p * n + q];
        }
    }
    return off <= ENDED * all;
}

// Rows and values in rising order of the values.
static void sort(double *vectors, double *values, int n) {
    for (int i = 1; i < n; i++) {
        for (int j = i; j > 0 && values[j] < values[j - 1]; j--) {
            const double value = values[j];
            values[j] = values[j - 1];
            values[j - 1] = value;
            for (int k = 0; k < n; k++) {
                const double number = vectors[j * n + k];
                vectors[j * n + k] = vectors[(j - 1) * n + k];
                vectors[(j - 1) * n + k] = number;
            }
        }
    }
}

// Eigenvalues in rising order, and the vectors as rows in place of A, which is what "V" in Fortran's order of
// numbers gives.
void dsyev_(const char *job, const char *half, const int *n, double *a, const int *lda, double *values,
            double *work, const int *work_size, int *info) {
    double vectors[SIDE_MAX * SIDE_MAX] = {0};
    const int size = *n;
    (void)job, (void)half, (void)lda, (void)work, (void)work_size;
    *info = size > SIDE_MAX ? -3 : 0;
    if (*info) return;
    for (int i = 0; i < size; i++) {
        vectors[i * size + i] = 1;
        for (int j = i + 1; j < size; j++) a[i * size + j] = a[j * size + i];
    }
    for (int sweep = 0; sweep < SWEEPS && !is_diagonal(a, size); sweep++)
        for (int p = 0; p < size; p++)
            for (int q = p + 1; q < size; q++) rotate(a, vectors, size, p, q, rotation_of(a, size, p, q));
    for (int i = 0; i < size; i++) values[i] = a[i * size + i];
    sort(vectors, values, size);
    memcpy(a, vectors, (size_t)size * (size_t)size * sizeof *a);
}
