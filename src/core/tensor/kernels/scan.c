// State-space duality scan, forward: the chunked form (Dao & Gu 2024, Sec. 6, Listing 1). With a_t = dt_t A,
// cs its running sum within a chunk of Q rows, X = dt x and H the state that enters the chunk:
//   y_t = sum_{s<=t} (C_t . B_s) exp(cs_t - cs_s) X_s + exp(cs_t) H C_t + d x_t,
//   H' = exp(cs_Q) H + sum_s exp(cs_Q - cs_s) X_s (outer) B_s.
// The code keeps cs times log2(e) and takes powers of two.
#include <tgmath.h>
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/narrow.h"
#include "core/tensor/kernels/scan_parts.h"

// A chunk's packed operands.
typedef struct Operands {
    FfpPacked *c_rows;    // C [rows, state]
    FfpPacked *b_columns; // B^T [state, rows]
    FfpPacked *entering;  // H [state, width] as columns
    FfpPacked *x_columns; // x of one head [rows, head_dim]
    FfpPacked *mixed;     // of one head [rows, rows] as rows
} Operands;

static Operands take_operands(const FfpScanLayout *layout, const FfpScanShape *shape,
                              const FfpScanChunk *chunk) {
    const int rows = chunk->rows;
    FfpPacked *next = layout->packed + (size_t)chunk->desk * layout->pack_size;
    Operands o;
    o.c_rows = ffp_scan_take(&next, rows, shape->state);
    o.b_columns = ffp_scan_take(&next, rows, shape->state);
    o.entering = ffp_scan_take(&next, layout->width, shape->state);
    o.x_columns = ffp_scan_take(&next, shape->head_dim, rows);
    o.mixed = ffp_scan_take(&next, rows, rows);
    return o;
}

// mixed[t,s] = (C_t . B_s) 2^(cs_t - cs_s) dt_s for the rows s that t sees, 0 elsewhere
static void mix_chunk(FfpPacked *mixed, const FfpScanLayout *layout, const FfpScanShape *shape,
                      const FfpScanChunk *chunk, int head) {
    const size_t start = (size_t)head * shape->rows + chunk->row, depth = ffp_packed_depth(chunk->rows);
    const real *cs = layout->cs + start, *dt = layout->dt + start;
    for (int t = 0; t < chunk->rows; t++) {
        const real *products = ffp_scan_square(layout->products, shape, chunk) + (size_t)t * shape->chunk,
                   here = cs[t];
        const int first = ffp_scan_first_visible(shape, t), last = ffp_scan_last_visible(shape, chunk, t);
        const int begin = first / FFP_PACK_LINES * FFP_PACK_LINES;
        const int end = ffp_scan_line_end(last + 1, chunk->rows);
        FfpPacked *row = mixed + (size_t)t * depth;
        for (int s = 0; s < begin; s++) row[s] = 0;
#pragma omp simd
        for (int s = begin; s < end; s++) {
            const real decay = ffp_exp2_packed(here - cs[s] < 0 ? here - cs[s] : 0);
            row[s] = ffp_narrow(s >= first && s <= last ? products[s] * dt[s] * decay : 0);
        }
        for (size_t s = (size_t)end; s < depth; s++) row[s] = 0;
    }
}

// y holds C H on entry: y = 2^cs y + D x
static void scale_and_skip(real *y, const FfpScanLayout *layout, const FfpScanShape *shape,
                           const FfpScanInput *in, const FfpScanChunk *chunk) {
    for (int t = 0; t < chunk->rows; t++) {
        const real *x = in->x + (size_t)(chunk->row + t) * in->ld;
        real *out = y + (size_t)t * layout->width;
        for (int head = 0; head < shape->heads; head++) {
            const real grow = layout->grow[(size_t)head * shape->rows + chunk->row + t], skip = in->d[head];
            for (int p = head * shape->head_dim; p < (head + 1) * shape->head_dim; p++)
                out[p] = grow * out[p] + skip * x[p];
        }
    }
}

static void chunk_output(real *y, const FfpScanLayout *layout, const FfpScanShape *shape,
                         const FfpScanInput *in, const FfpScanChunk *chunk) {
    const int rows = chunk->rows, width = layout->width, state = shape->state, dim = shape->head_dim;
    const size_t start = (size_t)chunk->row * in->ld;
    const Operands o = take_operands(layout, shape, chunk);
    const FfpOperand c_rows = ffp_operand(o.c_rows, state);
    y += (size_t)chunk->row * width;
    FFP_K(pack_rows)(o.c_rows, false, rows, state, in->c + start, in->ld);
    FFP_K(pack_columns)(o.b_columns, true, state, rows, in->b + start, in->ld);
    FFP_K(pack_columns)
    (o.entering, false, state, width, layout->states + (size_t)chunk->index * layout->state_size, width);
    ffp_product(rows, rows, state, 1, c_rows, ffp_operand(o.b_columns, state), 0,
                ffp_scan_square(layout->products, shape, chunk), shape->chunk);
    ffp_product(rows, width, state, 1, c_rows, ffp_operand(o.entering, state), 0, y, width);
    scale_and_skip(y, layout, shape, in, chunk);
    for (int head = 0; head < shape->heads; head++) {
        FFP_K(pack_columns)(o.x_columns, false, rows, dim, in->x + start + (size_t)head * dim, in->ld);
        mix_chunk(o.mixed, layout, shape, chunk, head);
        ffp_product(rows, dim, rows, 1, ffp_operand(o.mixed, rows), ffp_operand(o.x_columns, rows), 1,
                    y + (size_t)head * dim, width);
    }
}

// Three sweeps: the state each chunk adds, its carry from chunk to chunk, and the outputs. Chunks are
// independent but for the carry, so the products run one chunk a thread.
void FFP_K(scan_forward)(real *y, const FfpScanShape *shape, const FfpScanInput *in, real *scratch) {
    const FfpScanLayout layout = FFP_K(scan_layout)(shape, scratch);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        FFP_K(scan_decays)(&layout, shape, in, &chunk);
        FFP_K(scan_scale_x)(&layout, shape, in, &chunk);
        FFP_K(scan_outer)
        (layout.states + (size_t)index * layout.state_size, &layout, shape, in->b, in->ld, &chunk);
    }
    FFP_K(scan_carry)(layout.states, &layout, shape, false);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        chunk_output(y, &layout, shape, in, &chunk);
    }
}
