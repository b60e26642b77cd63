// State-space duality scan, forward: the chunked form (network.md 3.2) and the plain recurrence.
#include "tensor/tensor.h"

#include <tgmath.h>
#include "tensor/fastmath.h"
#include "tensor/scan_parts.h"

// One state entry at a time: slow, needs no memory, and follows the definition word by word.
void ffp_scan_forward_reference(real *y, const FfpScanShape *shape, const FfpScanInput *in) {
    const int width = shape->heads * shape->head_dim;
#pragma omp parallel for schedule(static)
    for (int column = 0; column < width; column++) {
        const int head = column / shape->head_dim;
        const real rate = -exp(in->a_log[head]);
        for (int t = 0; t < shape->rows; t++)
            y[(size_t)t * width + column] = in->d[head] * in->x[(size_t)t * in->ld + column];
        for (int n = 0; n < shape->state; n++) {
            real state = 0;
            for (int i = 0; i < shape->rows; i++) {
                const int t = shape->reverse ? shape->rows - 1 - i : i;
                const size_t row = (size_t)t * in->ld;
                const real raw = in->dt_raw[(size_t)t * in->lddt + head] + in->dt_bias[head];
                const real dt = raw > 20 ? raw : log1p(exp(raw));
                state = exp(dt * rate) * state + dt * in->x[row + column] * in->b[row + n];
                y[(size_t)t * width + column] += state * in->c[row + n];
            }
        }
    }
}

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
    ffp_scan_products(layout, shape, in, chunk);
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
void ffp_scan_forward(real *y, const FfpScanShape *shape, const FfpScanInput *in, real *scratch) {
    const FfpScanLayout layout = ffp_scan_layout(shape, scratch);
    ffp_scan_decays(&layout, shape, in);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = ffp_scan_chunk(shape, index);
        ffp_scan_chunk_state(&layout, shape, in, &chunk);
    }
    ffp_scan_carry(layout.states, &layout, shape, false);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout.chunks; index++) {
        const FfpScanChunk chunk = ffp_scan_chunk(shape, index);
        chunk_output(y, &layout, shape, in, &chunk);
    }
}
