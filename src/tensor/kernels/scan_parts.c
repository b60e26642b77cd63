#include "tensor/kernels/scan_parts.h"

#include <tgmath.h>
#include "tensor/kernels/fastmath.h"

static int chunk_count(const FfpScanShape *shape) {
    return (shape->rows + shape->chunk - 1) / shape->chunk;
}

// Sizes in reals, in the order of FfpScanLayout.
enum { PARTS = 15 };
static void part_sizes(size_t sizes[PARTS], const FfpScanShape *shape) {
    const size_t rows = (size_t)shape->rows, per_head = rows * (size_t)shape->heads;
    const size_t wide = per_head * (size_t)shape->head_dim, square = rows * (size_t)shape->chunk;
    const size_t states =
        (size_t)chunk_count(shape) * (size_t)shape->heads * (size_t)shape->head_dim * (size_t)shape->state;
    const size_t parts[PARTS] = {per_head, per_head, per_head, per_head, states,   wide,     square,  square,
                                 states,   wide,     square,   square,   per_head, per_head, per_head};
    for (int i = 0; i < PARTS; i++) sizes[i] = (parts[i] + 15) / 16 * 16; // every part starts a cache line
}

size_t FFP_K(scan_scratch)(const FfpScanShape *shape) {
    size_t sizes[PARTS], sum = 0;
    part_sizes(sizes, shape);
    for (int i = 0; i < PARTS; i++) sum += sizes[i];
    return sum;
}

FfpScanLayout FFP_K(scan_layout)(const FfpScanShape *shape, real *scratch) {
    FfpScanLayout layout = {.chunks = chunk_count(shape), .width = shape->heads * shape->head_dim};
    layout.state_size = (size_t)layout.width * (size_t)shape->state;
    real **parts[PARTS] = {&layout.dt,          &layout.cs,         &layout.grow,     &layout.fade,
                           &layout.states,      &layout.scaled_x,   &layout.products, &layout.mixed,
                           &layout.state_grads, &layout.scaled_dy,  &layout.decays,   &layout.pairs,
                           &layout.dcs,         &layout.x_grad_dot, &layout.x_dy_dot};
    size_t sizes[PARTS];
    part_sizes(sizes, shape);
    for (int i = 0; i < PARTS; i++) {
        *parts[i] = scratch;
        scratch += sizes[i];
    }
    return layout;
}

FfpScanChunk FFP_K(scan_chunk)(const FfpScanShape *shape, int index) {
    FfpScanChunk chunk = {.index = index, .row = index * shape->chunk};
    const int left = shape->rows - chunk.row;
    chunk.rows = left < shape->chunk ? left : shape->chunk;
    chunk.end = shape->reverse ? 0 : chunk.rows - 1;
    return chunk;
}

int FFP_K(scan_nth_chunk)(const FfpScanShape *shape, const FfpScanLayout *layout, int step) {
    return shape->reverse ? layout->chunks - 1 - step : step;
}

// log(1 + e^x), as x itself where they agree to the last bit
static real softplus(real x) {
    return x > 20 ? x : log1p(exp(x));
}

static void chunk_decays(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                         const FfpScanChunk *chunk, int head) {
    const size_t start = (size_t)head * shape->rows + chunk->row;
    real *dt = layout->dt + start, *cs = layout->cs + start, *grow = layout->grow + start,
         *fade = layout->fade + start;
    const real rate = -exp(in->a_log[head]);
    real sum = 0;
    for (int i = 0; i < chunk->rows; i++) {
        const int t = shape->reverse ? chunk->rows - 1 - i : i;
        dt[t] = softplus(in->dt_raw[(size_t)(chunk->row + t) * in->lddt + head] + in->dt_bias[head]);
        sum += dt[t] * rate;
        cs[t] = sum;
    }
    // Rounding can make a difference of sums positive, and its
    // exponential infinite: hence the minimum (network.md 3.6).
#pragma omp simd
    for (int t = 0; t < chunk->rows; t++) {
        grow[t] = ffp_exp(cs[t] < 0 ? cs[t] : 0);
        fade[t] = ffp_exp(sum - cs[t] < 0 ? sum - cs[t] : 0);
    }
}

void FFP_K(scan_decays)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in) {
#pragma omp parallel for collapse(2) schedule(static)
    for (int index = 0; index < layout->chunks; index++) {
        for (int head = 0; head < shape->heads; head++) {
            const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
            chunk_decays(layout, shape, in, &chunk, head);
        }
    }
}

void FFP_K(scan_chunk_state)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                             const FfpScanChunk *chunk) {
    real *scaled = layout->scaled_x + (size_t)chunk->row * layout->width;
    for (int t = 0; t < chunk->rows; t++) {
        const real *x = in->x + (size_t)(chunk->row + t) * in->ld;
        for (int head = 0; head < shape->heads; head++) {
            const size_t at = (size_t)head * shape->rows + chunk->row + t;
            const real weight = layout->fade[at] * layout->dt[at];
            const int first = head * shape->head_dim;
            real *out = scaled + (size_t)t * layout->width + first;
            for (int p = 0; p < shape->head_dim; p++) out[p] = weight * x[first + p];
        }
    }
    ffp_gemm(true, false, layout->width, shape->state, chunk->rows, 1, scaled, layout->width,
             in->b + (size_t)chunk->row * in->ld, in->ld, 0,
             layout->states + (size_t)chunk->index * layout->state_size, shape->state);
}

enum { STATE_BLOCK = 256 }; // elements of a state carried at once on the stack

static void carry_block(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, int head,
                        int first, int count, bool backward) {
    real carried[STATE_BLOCK] = {0};
    const size_t offset = (size_t)head * shape->head_dim * shape->state + first;
    for (int step = 0; step < layout->chunks; step++) {
        const int index = FFP_K(scan_nth_chunk)(shape, layout, backward ? layout->chunks - 1 - step : step);
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        const real decay = layout->grow[(size_t)head * shape->rows + chunk.row + chunk.end];
        real *state = states + (size_t)index * layout->state_size + offset;
#pragma omp simd
        for (int i = 0; i < count; i++) {
            const real own = state[i];
            state[i] = carried[i];
            carried[i] = decay * carried[i] + own;
        }
    }
}

void FFP_K(scan_carry)(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, bool backward) {
    const int size = shape->head_dim * shape->state;
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < shape->heads; head++) {
        for (int first = 0; first < size; first += STATE_BLOCK)
            carry_block(states, layout, shape, head, first,
                        size - first < STATE_BLOCK ? size - first : STATE_BLOCK, backward);
    }
}

void FFP_K(scan_products)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                          const FfpScanChunk *chunk) {
    const size_t start = (size_t)chunk->row * in->ld;
    ffp_gemm(false, true, chunk->rows, chunk->rows, shape->state, 1, in->c + start, in->ld, in->b + start,
             in->ld, 0, layout->products + (size_t)chunk->row * shape->chunk, shape->chunk);
}
