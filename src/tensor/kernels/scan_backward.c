// State-space duality scan, backward (network.md 3.3). X = dt x; g = gradient of the state leaving a chunk.
#include "tensor/kernels/kernels.h"

#include <tgmath.h>
#include "tensor/kernels/fastmath.h"
#include "tensor/kernels/scan_parts.h"

typedef struct Backward {
    const FfpScanGradient *grad;
    const FfpScanShape *shape;
    const FfpScanInput *in;
    const real *y, *dy;
    FfpScanLayout layout;
} Backward;

// In double also where real is float: the terms of dcs cancel,
// and a_log's gradient sums what is left of them.
static double dot(const real *a, const real *b, size_t count) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; i++) sum += (double)a[i] * (double)b[i];
    return sum;
}

// state_grads[chunk] = sum_t exp(cs_t) dy_t (outer) C_t, the
// chunk's own part of the gradient of the state entering it.
static void chunk_state_grad(const Backward *pass, const FfpScanChunk *chunk) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const size_t start = (size_t)chunk->row * layout->width;
    for (int t = 0; t < chunk->rows; t++) {
        for (int head = 0; head < shape->heads; head++) {
            const real grow = layout->grow[(size_t)head * shape->rows + chunk->row + t];
            const size_t first = start + (size_t)t * layout->width + (size_t)head * shape->head_dim;
            for (int p = 0; p < shape->head_dim; p++)
                layout->scaled_dy[first + p] = grow * pass->dy[first + p];
        }
    }
    ffp_gemm(true, false, layout->width, shape->state, chunk->rows, 1, layout->scaled_dy + start,
             layout->width, in->c + (size_t)chunk->row * in->ld, in->ld, 0,
             layout->state_grads + (size_t)chunk->index * layout->state_size, shape->state);
}

// decays[t,s] = exp(cs_t - cs_s) and mixed[t,s] = (C_t . B_s) decays[t,s] where t sees s, 0 elsewhere
static void decay_chunk(const Backward *pass, const FfpScanChunk *chunk, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const real *cs = layout->cs + (size_t)head * shape->rows + chunk->row;
    for (int t = 0; t < chunk->rows; t++) {
        const size_t row = (size_t)(chunk->row + t) * shape->chunk;
        real *decays = layout->decays + row, *mixed = layout->mixed + row;
        const real *products = layout->products + row, here = cs[t];
        const int first = ffp_scan_first_seen(shape, t), last = ffp_scan_last_seen(shape, chunk, t);
        for (int s = 0; s < first; s++) decays[s] = mixed[s] = 0;
#pragma omp simd
        for (int s = first; s <= last; s++) {
            decays[s] = ffp_exp(here - cs[s] < 0 ? here - cs[s] : 0);
            mixed[s] = products[s] * decays[s];
        }
        for (int s = last + 1; s < chunk->rows; s++) decays[s] = mixed[s] = 0;
    }
}

// dX of one head into grad->x, which holds g B on entry: dX_s = fade_s g B_s + sum_t mixed[t,s] dy_t
static void head_x_grad(const Backward *pass, const FfpScanChunk *chunk, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const int first = head * shape->head_dim;
    real *dx = pass->grad->x + (size_t)chunk->row * in->ld + first;
    for (int t = 0; t < chunk->rows; t++) {
        const real fade = layout->fade[(size_t)head * shape->rows + chunk->row + t];
        for (int p = 0; p < shape->head_dim; p++) dx[(size_t)t * in->ld + p] *= fade;
    }
    ffp_gemm(true, false, chunk->rows, shape->head_dim, chunk->rows, 1,
             layout->mixed + (size_t)chunk->row * shape->chunk, shape->chunk,
             pass->dy + (size_t)chunk->row * layout->width + first, layout->width, 1, dx, in->ld);
}

// pairs += M of one head, M_ts = (dy_t . X_s) exp(cs_t - cs_s); `mixed` serves as the place for dy . x.
static void add_pairs(const Backward *pass, const FfpScanChunk *chunk, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const size_t square = (size_t)chunk->row * shape->chunk;
    const int first = head * shape->head_dim;
    const real *dt = layout->dt + (size_t)head * shape->rows + chunk->row;
    ffp_gemm(false, true, chunk->rows, chunk->rows, shape->head_dim, 1,
             pass->dy + (size_t)chunk->row * layout->width + first, layout->width,
             in->x + (size_t)chunk->row * in->ld + first, in->ld, 0, layout->mixed + square, shape->chunk);
    for (int t = 0; t < chunk->rows; t++) {
        const size_t row = square + (size_t)t * shape->chunk;
        const real *decays = layout->decays + row, *dots = layout->mixed + row;
        real *pairs = layout->pairs + row;
        for (int s = 0; s < chunk->rows; s++) {
            const real m = dots[s] * decays[s] * dt[s];
            pairs[s] = head == 0 ? m : pairs[s] + m;
        }
    }
}

// From dX: dx = dt dX + D dy, and the dot products that the gradients of cs, dt and D are made of:
// dcs_t = dy_t.(y_t - D x_t) - X_t.dX_t, plus at the chunk's end <g, state leaving the chunk>.
static void finish_head(const Backward *pass, const FfpScanChunk *chunk, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const size_t width = (size_t)shape->head_dim, per_head = width * (size_t)shape->state;
    const real skip = in->d[head];
    for (int t = 0; t < chunk->rows; t++) {
        const size_t at = (size_t)head * shape->rows + chunk->row + t;
        const size_t row = (size_t)(chunk->row + t) * in->ld + (size_t)head * width;
        const size_t out = (size_t)(chunk->row + t) * layout->width + (size_t)head * width;
        const real *x = in->x + row, *dy_row = pass->dy + out, dt = layout->dt[at];
        real *dx = pass->grad->x + row;
        const double x_grad = dot(x, dx, width), x_dy = dot(x, dy_row, width);
        layout->x_grad_dot[at] = (real)x_grad;
        layout->x_dy_dot[at] = (real)x_dy;
        layout->dcs[at] =
            (real)(dot(pass->y + out, dy_row, width) - (double)skip * x_dy - (double)dt * x_grad);
        for (int p = 0; p < shape->head_dim; p++) dx[p] = dt * dx[p] + skip * dy_row[p];
    }
    const int next = chunk->index + (shape->reverse ? -1 : 1);
    if (next < 0 || next >= layout->chunks) return; // nothing reads the last state
    const size_t offset = (size_t)head * per_head;
    layout->dcs[(size_t)head * shape->rows + chunk->row + chunk->end] +=
        (real)dot(layout->state_grads + (size_t)chunk->index * layout->state_size + offset,
                  layout->states + (size_t)next * layout->state_size + offset, per_head);
}

static void chunk_backward(const Backward *pass, const FfpScanChunk *chunk) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const int rows = chunk->rows, width = layout->width, state = shape->state;
    const size_t start = (size_t)chunk->row * in->ld, wide = (size_t)chunk->row * width;
    const real *leaving_grad = layout->state_grads + (size_t)chunk->index * layout->state_size;
    const real *entering = layout->states + (size_t)chunk->index * layout->state_size;
    const real *pairs = layout->pairs + (size_t)chunk->row * shape->chunk;
    FFP_K(scan_products)(layout, shape, in, chunk);
    ffp_gemm(false, true, rows, width, state, 1, in->b + start, in->ld, leaving_grad, state, 0,
             pass->grad->x + start, in->ld);
    for (int head = 0; head < shape->heads; head++) {
        decay_chunk(pass, chunk, head);
        head_x_grad(pass, chunk, head);
        add_pairs(pass, chunk, head);
        finish_head(pass, chunk, head);
    }
    // dC_t = sum_h exp(cs_t) H^T dy_t + sum_s M_ts B_s;  dB_s = sum_h fade_s dt_s g^T x_s + sum_t M_ts C_t
    ffp_gemm(false, false, rows, state, width, 1, layout->scaled_dy + wide, width, entering, state, 0,
             pass->grad->c + start, in->ld);
    ffp_gemm(false, false, rows, state, rows, 1, pairs, shape->chunk, in->b + start, in->ld, 1,
             pass->grad->c + start, in->ld);
    ffp_gemm(false, false, rows, state, width, 1, layout->scaled_x + wide, width, leaving_grad, state, 0,
             pass->grad->b + start, in->ld);
    ffp_gemm(true, false, rows, state, rows, 1, pairs, shape->chunk, in->c + start, in->ld, 1,
             pass->grad->b + start, in->ld);
}

// da = reverse cumulative sum of dcs in each chunk; d(dt) = A
// da + x.dX; dA = sum dt da; then through exp and softplus.
static void head_parameters(const Backward *pass, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const real rate = -exp(in->a_log[head]);
    real da_sum = 0, bias_sum = 0, skip_sum = 0;
    for (int index = 0; index < layout->chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        real da = 0;
        for (int i = 0; i < chunk.rows; i++) {
            const int row = chunk.row + (shape->reverse ? i : chunk.rows - 1 - i);
            const size_t at = (size_t)head * shape->rows + row;
            da += layout->dcs[at];
            const real raw = in->dt_raw[(size_t)row * in->lddt + head] + in->dt_bias[head];
            const real slope = 1 / (1 + exp(-raw)), draw = (rate * da + layout->x_grad_dot[at]) * slope;
            pass->grad->dt_raw[(size_t)row * in->lddt + head] += draw;
            bias_sum += draw;
            da_sum += layout->dt[at] * da;
            skip_sum += layout->x_dy_dot[at];
        }
    }
    pass->grad->dt_bias[head] += bias_sum;
    pass->grad->a_log[head] += rate * da_sum;
    pass->grad->d[head] += skip_sum;
}

// The forward's states are computed anew; then every chunk by
// itself, the heads in order, so that dB and dC have one owner.
void FFP_K(scan_backward)(const FfpScanGradient *grad, const FfpScanShape *shape, const FfpScanInput *in,
                          const real *y, const real *dy, real *scratch) {
    const Backward pass = {grad, shape, in, y, dy, FFP_K(scan_layout)(shape, scratch)};
    const FfpScanLayout *layout = &pass.layout;
    FFP_K(scan_decays)(layout, shape, in);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout->chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        FFP_K(scan_chunk_state)(layout, shape, in, &chunk);
        chunk_state_grad(&pass, &chunk);
    }
    FFP_K(scan_carry)(layout->states, layout, shape, false);
    FFP_K(scan_carry)(layout->state_grads, layout, shape, true);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout->chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        chunk_backward(&pass, &chunk);
    }
#pragma omp parallel for schedule(static)
    for (int head = 0; head < shape->heads; head++) head_parameters(&pass, head);
}
