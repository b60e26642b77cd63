#include "core/tensor/kernels/scan_parts.h"
#include <omp.h>
#include <tgmath.h>
#include "core/tensor/kernels/exp2.h"

// Everything but the pointers into the scratch. A chunk needs most packed operands in the second half of the
// backward pass (scan_backward.c).
static FfpScanLayout make_layout(const FfpScanShape *shape) {
    FfpScanLayout layout = {.width = shape->heads * shape->head_dim};
    const int chunk = shape->chunk, state = shape->state, dim = shape->head_dim;
    layout.chunks = (shape->rows + chunk - 1) / chunk;
    layout.state_size = (size_t)layout.width * (size_t)state;
    layout.pack_size = 2 * ffp_packed_size(chunk, state) + 2 * ffp_packed_size(state, chunk) +
                       2 * ffp_packed_size(layout.width, state) + ffp_packed_size(layout.width, chunk) +
                       3 * ffp_packed_size(chunk, dim) + ffp_packed_size(dim, chunk) +
                       2 * ffp_packed_size(state, dim) + 3 * ffp_packed_size(chunk, chunk);
    return layout;
}

// Sizes in reals, in the order of FfpScanLayout; the packed operands, whose numbers are not reals, come last.
enum { PARTS = 18 };
static void part_sizes(size_t sizes[PARTS], const FfpScanLayout *layout, const FfpScanShape *shape) {
    const size_t per_head = (size_t)shape->rows * (size_t)shape->heads, chunk = (size_t)shape->chunk;
    const size_t chunks = (size_t)layout->chunks, states = chunks * layout->state_size,
                 square = chunks * chunk * chunk;
    const size_t packed = (chunks * layout->pack_size * sizeof(FfpPacked) + sizeof(real) - 1) / sizeof(real);
    const size_t parts[PARTS] = {per_head,
                                 per_head,
                                 per_head,
                                 per_head,
                                 per_head,
                                 states,
                                 layout->state_size,
                                 chunks * chunk * (size_t)layout->width,
                                 square,
                                 square,
                                 square,
                                 5 * chunks * (size_t)shape->state * chunk,
                                 states,
                                 per_head,
                                 per_head,
                                 per_head,
                                 per_head,
                                 packed};
    for (int i = 0; i < PARTS; i++) sizes[i] = (parts[i] + 15) / 16 * 16; // every part starts a cache line
}

size_t FFP_K(scan_scratch)(const FfpScanShape *shape) {
    const FfpScanLayout layout = make_layout(shape);
    size_t sizes[PARTS], sum = 0;
    part_sizes(sizes, &layout, shape);
    for (int i = 0; i < PARTS; i++) sum += sizes[i];
    return sum;
}

FfpScanLayout FFP_K(scan_layout)(const FfpScanShape *shape, real *scratch) {
    FfpScanLayout layout = make_layout(shape);
    real **parts[PARTS - 1] = {&layout.dt,          &layout.cs,     &layout.grow,       &layout.fade,
                               &layout.feed,        &layout.states, &layout.carried,    &layout.scaled,
                               &layout.products,    &layout.dots,   &layout.pairs,      &layout.turned,
                               &layout.state_grads, &layout.da,     &layout.x_grad_dot, &layout.inflow,
                               &layout.x_dy_dot};
    size_t sizes[PARTS];
    part_sizes(sizes, &layout, shape);
    for (int i = 0; i < PARTS - 1; i++) {
        *parts[i] = scratch;
        scratch += sizes[i];
    }
    layout.packed = (FfpPacked *)scratch;
    return layout;
}

FfpScanChunk FFP_K(scan_chunk)(const FfpScanShape *shape, int index) {
    FfpScanChunk chunk = {.index = index, .row = index * shape->chunk};
    const int left = shape->rows - chunk.row;
    chunk.rows = left < shape->chunk ? left : shape->chunk;
    chunk.end = shape->reverse ? 0 : chunk.rows - 1;
    chunk.desk = omp_get_thread_num();
    return chunk;
}

// log(1 + e^x), as x itself where they agree to the last bit
static real softplus(real x) {
    return x > 20 ? x : log1p(exp(x));
}

static void head_decays(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                        const FfpScanChunk *chunk, int head) {
    const size_t start = (size_t)head * shape->rows + chunk->row;
    real *dt = layout->dt + start, *cs = layout->cs + start, *grow = layout->grow + start,
         *fade = layout->fade + start, *feed = layout->feed + start;
    const real rate = -exp(in->a_log[head]) * (real)FFP_LOG2_E;
    real sum = 0;
    for (int i = 0; i < chunk->rows; i++) {
        const int t = shape->reverse ? chunk->rows - 1 - i : i;
        dt[t] = softplus(in->dt_raw[(size_t)(chunk->row + t) * in->lddt + head] + in->dt_bias[head]);
        sum += dt[t] * rate;
        cs[t] = sum;
    }
    // Rounding can make a difference of sums positive, and its power infinite: hence the minimum.
#pragma omp simd
    for (int t = 0; t < chunk->rows; t++) {
        grow[t] = ffp_exp2(cs[t] < 0 ? cs[t] : 0);
        fade[t] = ffp_exp2(sum - cs[t] < 0 ? sum - cs[t] : 0);
        feed[t] = fade[t] * dt[t];
    }
}

void FFP_K(scan_decays)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                        const FfpScanChunk *chunk) {
    for (int head = 0; head < shape->heads; head++) head_decays(layout, shape, in, chunk, head);
}

void FFP_K(scan_scale_x)(const FfpScanLayout *layout, const FfpScanShape *shape, const FfpScanInput *in,
                         const FfpScanChunk *chunk) {
    real *scaled = ffp_scan_scaled(layout, shape, chunk);
    for (int t = 0; t < chunk->rows; t++) {
        const real *x = in->x + (size_t)(chunk->row + t) * in->ld;
        real *out = scaled + (size_t)t * layout->width;
        for (int head = 0; head < shape->heads; head++) {
            const real feed = layout->feed[(size_t)head * shape->rows + chunk->row + t];
            for (int p = head * shape->head_dim; p < (head + 1) * shape->head_dim; p++) out[p] = feed * x[p];
        }
    }
}

void FFP_K(scan_outer)(real *state, const FfpScanLayout *layout, const FfpScanShape *shape, const real *b,
                       int ld, const FfpScanChunk *chunk) {
    FfpPacked *next = layout->packed + (size_t)chunk->desk * layout->pack_size;
    FfpPacked *rows = ffp_scan_take(&next, shape->state, chunk->rows);
    FfpPacked *columns = ffp_scan_take(&next, layout->width, chunk->rows);
    FFP_K(pack_rows)(rows, true, shape->state, chunk->rows, b + (size_t)chunk->row * ld, ld);
    FFP_K(pack_columns)
    (columns, false, chunk->rows, layout->width, ffp_scan_scaled(layout, shape, chunk), layout->width);
    ffp_product(shape->state, layout->width, chunk->rows, 1, ffp_operand(rows, chunk->rows),
                ffp_operand(columns, chunk->rows), 0, state, layout->width);
}

// One row of all states, one chunk after another along the scan (against it when `backward`).
static void carry_row(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, int row,
                      bool backward) {
    real *carried = layout->carried + (size_t)row * layout->width;
    for (int i = 0; i < layout->width; i++) carried[i] = 0;
    for (int step = 0; step < layout->chunks; step++) {
        const int index = shape->reverse != backward ? layout->chunks - 1 - step : step;
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        real *state = states + (size_t)index * layout->state_size + (size_t)row * layout->width;
        for (int head = 0; head < shape->heads; head++) {
            const real decay = layout->grow[(size_t)head * shape->rows + chunk.row + chunk.end];
#pragma omp simd
            for (int i = head * shape->head_dim; i < (head + 1) * shape->head_dim; i++) {
                const real own = state[i];
                state[i] = carried[i];
                carried[i] = decay * carried[i] + own;
            }
        }
    }
}

void FFP_K(scan_carry)(real *states, const FfpScanLayout *layout, const FfpScanShape *shape, bool backward) {
#pragma omp parallel for schedule(static)
    for (int row = 0; row < shape->state; row++) carry_row(states, layout, shape, row, backward);
}
