// Matrix products with packed operands: B is packed whole by all threads, A block by block by the thread that
// owns its rows of C.
#include "core/tensor/kernels/mixed.h"
#include <string.h>
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/product.h"

#ifdef FFP_OWN_PRODUCTS
#include <omp.h>
#include "core/base/integer.h"
#include "core/tensor/workspace.h"

// A block of A takes up to 224 KB, a run of B's panels of one depth 32 or 64 KB: with what passes of C they
// stay in a second-level cache of 512 KB. The more rows, the fewer times all of B passes.
enum { BLOCK_DEPTH = 512, BLOCK_NUMBERS = 224 * 1024 / (int)sizeof(FfpPacked) };
enum { PIECE = 64 }; // no thread gets fewer rows or columns than this

// C is cut into `down` times `across` rectangles, one a thread; k into runs of `depth`.
typedef struct Plan {
    int down, across, depth;
    int rows; // of a block
    FfpPacked *b;
    size_t b_depth;
    FfpPacked *a; // rows x depth, one behind the other for every thread
    size_t a_size;
} Plan;

static Plan make_plan(const FfpMixed *mixed) {
    Plan plan;
    const int m = mixed->a.rows, n = mixed->b.columns, k = mixed->a.columns;
    const int threads = omp_in_parallel() ? 1 : omp_get_max_threads();
    plan.down = ffp_larger(1, ffp_smaller(m / PIECE, threads));
    plan.across = ffp_larger(1, ffp_smaller(n / PIECE, threads / plan.down));
    const int runs = ffp_larger(1, (k + BLOCK_DEPTH - 1) / BLOCK_DEPTH);
    plan.depth = ffp_larger(1, (int)ffp_packed_depth((k + runs - 1) / runs));
    plan.b_depth = ffp_packed_depth(k);
    plan.rows = ffp_larger(1, BLOCK_NUMBERS / plan.depth / FFP_PRODUCT_ROWS) * FFP_PRODUCT_ROWS;
    plan.a_size = ffp_packed_size(plan.rows, plan.depth);
    const size_t b_size = ffp_packed_size(n, k);
    plan.b =
        ffp_workspace((b_size + plan.a_size * (size_t)plan.down * (size_t)plan.across) * sizeof(FfpPacked));
    plan.a = plan.b + b_size;
    return plan;
}

// Where part `index` of `parts` begins, when `size` is cut into whole units.
static int part_begin(int size, int unit, int index, int parts) {
    const int units = (size + unit - 1) / unit;
    return ffp_smaller(size, (int)((long)units * index / parts) * unit);
}

// A thread's share of B's panels.
static void pack_share_of_b(const Plan *plan, const FfpMixed *mixed, int thread, int threads) {
    const int n = mixed->b.columns, k = mixed->b.rows;
    const int begin = part_begin(n, FFP_PACK_LINES, thread, threads);
    const int end = part_begin(n, FFP_PACK_LINES, thread + 1, threads);
    const FfpFactor from = ffp_factor_part(mixed->b, 0, begin, k, end - begin);
    if (begin == end) return;
    FFP_K(pack_columns)
    (plan->b + (size_t)begin * plan->b_depth, from.transposed, k, end - begin, from.data, from.stride);
}

typedef struct Rectangle {
    int row, row_end, column, column_end;
} Rectangle;

// The block's part of C as it is before the product; returns the product's beta.
static real start_block(const FfpMixed *mixed, const Rectangle *at) {
    if (!mixed->start) return mixed->beta;
    const size_t bytes = sizeof(real) * (size_t)(at->column_end - at->column);
    for (int row = at->row; row < at->row_end; row++) {
        real *c = mixed->c + (size_t)row * mixed->ldc + at->column;
        const real *start = mixed->start + (size_t)row * mixed->start_stride + at->column;
        if (c != start) memcpy(c, start, bytes);
    }
    return 1;
}

// Some rows of A as an operand: where they are, if that is how a packed operand has them, otherwise packed
// into `to`.
static FfpOperand rows_of_a(FfpPacked *to, FfpFactor a) {
#ifndef FFP_BF16
    if (!a.transposed) return (FfpOperand){a.data, (size_t)a.stride};
#endif
    FFP_K(pack_rows)(to, a.transposed, a.rows, a.columns, a.data, a.stride);
    return (FfpOperand){to, ffp_packed_depth(a.columns)};
}

static void multiply_block(const Plan *plan, const FfpMixed *mixed, FfpPacked *to, const Rectangle *at) {
    const int rows = at->row_end - at->row, columns = at->column_end - at->column;
    real *c = mixed->c + (size_t)at->row * mixed->ldc + at->column;
    real beta = start_block(mixed, at);
    for (int k = 0; k == 0 || k < mixed->a.columns; k += plan->depth) {
        const int depth = ffp_smaller(plan->depth, mixed->a.columns - k);
        const FfpOperand a = rows_of_a(to, ffp_factor_part(mixed->a, at->row, k, rows, depth));
        const FfpOperand b = {ffp_packed_column(plan->b, at->column, k, plan->b_depth), plan->b_depth};
        ffp_product(rows, columns, depth, mixed->alpha, a, b, beta, c, mixed->ldc);
        beta = 1;
    }
}

static void multiply_share(const Plan *plan, const FfpMixed *mixed, int thread) {
    const int down = thread / plan->across, across = thread % plan->across;
    const int m = mixed->a.rows, n = mixed->b.columns;
    const int end = part_begin(m, FFP_PRODUCT_ROWS, down + 1, plan->down);
    Rectangle at = {.row = part_begin(m, FFP_PRODUCT_ROWS, down, plan->down),
                    .column = part_begin(n, 2 * FFP_PACK_LINES, across, plan->across),
                    .column_end = part_begin(n, 2 * FFP_PACK_LINES, across + 1, plan->across)};
    for (; at.row < end; at.row = at.row_end) {
        at.row_end = ffp_smaller(end, at.row + plan->rows);
        multiply_block(plan, mixed, plan->a + plan->a_size * (size_t)thread, &at);
    }
}

void FFP_K(mixed)(const FfpMixed *mixed) {
    if (mixed->a.rows <= 0 || mixed->b.columns <= 0) return;
    const Plan plan = make_plan(mixed);
    const int shares = plan.down * plan.across;
    // never fewer threads than usual: OpenMP would end the others and start them again later
#pragma omp parallel if (shares > 1)
    {
#pragma omp for schedule(static)
        for (int share = 0; share < shares; share++) pack_share_of_b(&plan, mixed, share, shares);
#pragma omp for schedule(static)
        for (int share = 0; share < shares; share++) multiply_share(&plan, mixed, share);
    }
}

#else
void FFP_K(mixed)(const FfpMixed *mixed) {
    for (int row = 0; mixed->start && row < mixed->a.rows; row++) {
        real *c = mixed->c + (size_t)row * mixed->ldc;
        const real *start = mixed->start + (size_t)row * mixed->start_stride;
        if (c != start) memcpy(c, start, sizeof(real) * (size_t)mixed->b.columns);
    }
    ffp_blas_gemm(mixed->alpha, mixed->a, mixed->b, mixed->start ? 1 : mixed->beta, mixed->c, mixed->ldc);
}
#endif

void FFP_K(gemm_mixed)(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    const FfpMixed mixed = {.alpha = alpha, .a = a, .b = b, .beta = beta, .c = c, .ldc = ldc};
    FFP_K(mixed)(&mixed);
}
