// State-space duality scan, forward: the chunked form (network.md 3.2).
#include "tensor/kernels/kernels.h"

#include <tgmath.h>
#include "tensor/kernels/fastmath.h"
#include "tensor/kernels/scan_parts.h"

// mixed[t,s] = (C_t . B_s) exp(cs_t - cs_s) dt_s for the rows s that t sees, 0 elsewhere
static void mix_chunk(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanChunk *chunk,
                      int head) {
    const size_t start = (size_t)head * shape->rows + chunk->row, square = (size_t)chunk->row * shape->chunk;
    const real *cs = layout->cs + start, *dt = layout->dt + start;
    for (int t = 0; t < chunk->rows; t++) {
        const real *products = layout->products + square + (size_t)t * shape->chunk, here = cs[t];
        real *mixed = layout->mixed + square + (size_t)t * shape->chunk;
        const int first = ffp_scan_first_seen(shape, t), last = ffp_scan_last_seen(shape, chunk, t);
        for (int s = 0; s < first; s++) mixed[s] = 0;
#pragma omp simd
        for (int s = first; s <= last; s++)
            mixed[s] = products[s] * dt[s] * ffp_exp(here - cs[s] < 0 ? here - cs[s] : 0);
        for (int s = last + 1; s < chunk->rows; s++) mixed[s] = 0;
    }
}

// y holds H C on entry: y = exp(cs) y + D x
static void scale_and_skip(real *y, const FfpScanLayout *layout, const FfpScanShape *shape,
                           const FfpScanInput *in, const FfpScanChunk *chunk, int head) {
    const int first = head * shape->head_dim;
    for (int t = 0; t < chunk->rows; t++) {
        const real grow = layout->grow[(size_t)head * shape->rows + chunk->row + t];
        const real *x = in->x + (size_t)(chunk->row + t) * in->ld + first;
        real *out = y + (size_t)t * layout->width + first;
        for (int p = 0; p < shape->head_dim; p++) out[p] = grow * out[p] + in->d[head] * x[p];
    }
}

static void chunk_output(real *y, const FfpScanLayout *layout, const FfpScanShape *shape,
                         const FfpScanInput *in, const FfpScanChunk *chunk) {
    const size_t start = (size_t)chunk->row * in->ld;
    const real *mixed = layout->mixed + (size_t)chunk->row * shape->chunk;
    y += (size_t)chunk->row * layout->width;
    FFP_K(scan_products)(layout, shape, in, chunk);
    ffp_gemm(false, true, chunk->rows, layout->width, shape->state, 1, in->c + start, in->ld,
             layout->states + (size_t)chunk->index * layout->state_size, shape->state, 0, y, layout->width);
    for (int head = 0; head < shape->heads; head++) {
        const int first = head * shape->head_dim;
        scale_and_skip(y, layout, shape, in, chunk, head);
        mix_chunk(layout, shape, chunk, head);
        ffp_gemm(false, false, chunk->rows, shape->head_dim, chunk->rows, 1, mixed, shape->chunk,
                 in->x + start + first, in->ld, 1, y + first, layout->width);
    }
}

// Three sweeps: the state each chunk adds, its carry from chunk to chunk, and the outputs. Chunks are
// independent but for the carry, so the products run one chunk a thread.
void FFP_K(scan_forward)(real *y, const FfpScanShape *shape, const FfpScanInput *in, real *scratch) {
    const FfpScanLayout layout = FFP_K(scan_layout)(shape, scratch);
    FFP_K(scan_decays)(&layout, shape, in);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        FFP_K(scan_chunk_state)(&layout, shape, in, &chunk);
    }
    FFP_K(scan_carry)(layout.states, &layout, shape, false);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        chunk_output(y, &layout, shape, in, &chunk);
    }
}
