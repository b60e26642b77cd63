// Common parts of the scan's two passes: the layout of the scratch, decays, chunk states. Inside the kernels
// folder only.
//
// Within a chunk everything keeps the rows' order in memory; a reversed scan only turns the cumulative sums,
// the mask and the order of the chunks. "Begin" and "end" of a chunk are meant along the scan. A state H is
// kept transposed, [state, width]: then no packed operand of a chunk needs x or dy turned.
#ifndef FFP_TENSOR_SCAN_PARTS_H
#define FFP_TENSOR_SCAN_PARTS_H

#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/product.h"

typedef struct FfpScanLayout {
    int chunks, width; // width = heads * head_dim
    size_t state_size; // state * width
    size_t pack_size;  // numbers in `packed` for each desk
    real *dt, *cs;     // [heads, T]: step; sum of dt A log2(e) from the chunk's begin, the row's own included
    real *grow, *fade; // [heads, T]: 2^cs, 2^(cs at the chunk's end - cs)
    real *feed;        // [heads, T]: fade dt, what a row's x counts for in the state at the chunk's end
    real *states;      // [chunks, state, width]: H entering a chunk
    real *carried;     // [state, width]
    // Desks: each thread works at its own, [chunks] of them (no more threads than chunks have work).
    real *scaled;      // [chunk, width]: x or dy times a factor a row and head
    real *products;    // [chunk, chunk]: C B^T, in the backward pass B C^T
    FfpPacked *packed; // [pack_size]: packed operands
    // from here on for the backward pass only
    real *dots, *pairs; // desks [chunk, chunk]: x dy^T of one head, sum over the heads of M^T
    real *turned;       // desks [5, state, chunk]: B^T, C^T, dB^T, dC^T, and one head's part of the latter
    real *state_grads;  // as states: gradient of the state leaving a chunk
    real *da, *x_grad_dot, *inflow, *x_dy_dot; // [heads, T]: see scan_backward.c
} FfpScanLayout;

typedef struct FfpScanChunk {
    int index, row, rows; // first row in memory and count
    int end;              // the last row along the scan, counted from `row`
    int desk;             // the calling thread's
} FfpScanChunk;

FfpScanLayout FFP_K(scan_layout)(const FfpScanShape *shape, real *scratch);
// In a parallel loop over the chunks with a static schedule: the desk is the thread's.
FfpScanChunk FFP_K(scan_chunk)(const FfpScanShape *shape, int index);

// dt, cs, grow, fade of all heads for the rows of a chunk.
void FFP_K(scan_decays)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                        const FfpScanChunk *chunk);

// `scaled` of a chunk's rows: feed x.
void FFP_K(scan_scale_x)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                         const FfpScanChunk *chunk);

// state [state, width] = sum over the chunk's rows of B_t (outer) scaled_t; b has row stride ld.
void FFP_K(scan_outer)(real *state, const FfpScanLayout *layout, const FfpScanShape *shape, const real *b,
                       int ld, const FfpScanChunk *chunk);

// Turns each chunk's own state into the sum of all states before it along the scan (behind it when
// `backward`), decayed: out[next] = decay(chunk) out[chunk] + own[chunk], in place.
void FFP_K(scan_carry)(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, bool backward);

// Takes the place of an operand of `lines` lines and depth k from *next.
static inline FfpPacked *ffp_scan_take(FfpPacked **next, int lines, int k) {
    FfpPacked *taken = *next;
    *next += ffp_packed_size(lines, k);
    return taken;
}

static inline real *ffp_scan_scaled(const FfpScanLayout *layout, const FfpScanShape *shape,
                                    const FfpScanChunk *chunk) {
    return layout->scaled + (size_t)chunk->desk * shape->chunk * layout->width;
}
// Where a chunk's square [chunk, chunk] of `squares` lies.
static inline real *ffp_scan_square(real *squares, const FfpScanShape *shape, const FfpScanChunk *chunk) {
    return squares + (size_t)chunk->desk * shape->chunk * shape->chunk;
}

// `end` rounded up to a whole vector's worth, within `rows`: loops over what a row sees run in whole vectors.
static inline int ffp_scan_line_end(int end, int rows) {
    const int whole = (end + FFP_PACK_LINES - 1) / FFP_PACK_LINES * FFP_PACK_LINES;
    return whole < rows ? whole : rows;
}

// Columns that row t of a chunk sees: itself and those before it along the scan.
static inline int ffp_scan_first_visible(const FfpScanShape *shape, int t) {
    return shape->reverse ? t : 0;
}
static inline int ffp_scan_last_visible(const FfpScanShape *shape, const FfpScanChunk *chunk, int t) {
    return shape->reverse ? chunk->rows - 1 : t;
}

#endif
