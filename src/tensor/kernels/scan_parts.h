// What the scan's two passes share: the layout of the scratch,
// decays, chunk states. Inside the tensor room only.
//
// Within a chunk everything keeps the rows' order in memory; a reversed scan only turns the cumulative sums,
// the mask and the order of the chunks. "Begin" and "end" of a chunk are meant along the scan.
#ifndef FFP_TENSOR_SCAN_PARTS_H
#define FFP_TENSOR_SCAN_PARTS_H

#include "tensor/kernels/kernels.h"

typedef struct FfpScanLayout {
    int chunks, width; // width = heads * head_dim
    size_t state_size; // width * state
    real *dt, *cs; // [heads, T]: step; cumulative sum of dt A from the chunk's begin, the row's own included
    real *grow, *fade;      // [heads, T]: exp(cs), exp(cs at the chunk's end - cs)
    real *states;           // [chunks, width, state]: H entering a chunk
    real *scaled_x;         // [T, width]: fade dt x, then only per chunk
    real *products, *mixed; // [T, chunk]: C B^T of each chunk, and the same times a head's decays
    // from here on for the backward pass only
    real *state_grads;                 // as states: gradient of the state leaving a chunk
    real *scaled_dy;                   // [T, width]: exp(cs) dy
    real *decays, *pairs;              // [T, chunk]: exp(cs_t - cs_s), sum over the heads of M
    real *dcs, *x_grad_dot, *x_dy_dot; // [heads, T]
} FfpScanLayout;

typedef struct FfpScanChunk {
    int index, row, rows; // first row in memory and count
    int end;              // the last row along the scan, counted from `row`
} FfpScanChunk;

FfpScanLayout FFP_K(scan_layout)(const FfpScanShape *shape, real *scratch);
FfpScanChunk FFP_K(scan_chunk)(const FfpScanShape *shape, int index);
// The chunk that comes `step`-th along the scan.
int FFP_K(scan_nth_chunk)(const FfpScanShape *shape, const FfpScanLayout *layout, int step);

// dt, cs, grow, fade of all heads and rows.
void FFP_K(scan_decays)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in);

// states[chunk] = what the chunk's own rows leave in the
// state, sum_s fade_s dt_s x_s (outer) B_s; fills scaled_x.
void FFP_K(scan_chunk_state)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                             const FfpScanChunk *chunk);

// Turns each chunk's own state into the sum of all states before it along the scan (behind it when
// `backward`), decayed: out[next] = decay(chunk) out[chunk] + own[chunk], in place.
void FFP_K(scan_carry)(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, bool backward);

// products[t,s] = C_t . B_s within the chunk
void FFP_K(scan_products)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                          const FfpScanChunk *chunk);

// Columns that row t of a chunk sees: itself and those before it along the scan.
static inline int ffp_scan_first_seen(const FfpScanShape *shape, int t) {
    return shape->reverse ? t : 0;
}
static inline int ffp_scan_last_seen(const FfpScanShape *shape, const FfpScanChunk *chunk, int t) {
    return shape->reverse ? chunk->rows - 1 : t;
}

#endif
