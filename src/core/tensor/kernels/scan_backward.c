// State-space duality scan, backward: the chunked form of scan.c differentiated. X = dt x; G = gradient of
// the state leaving a chunk, H = the state entering it, both [state, width]. Within a chunk, for a row t that
// sees s:
//   M_ts = (dy_t . X_s) 2^(cs_t - cs_s),  dB_s += M_ts C_t,  dC_t += M_ts B_s,
//   dX_s += (B_s . C_t) 2^(cs_t - cs_s) dy_t.
// The gradient of the step's exponent a_i = dt_i A is the flow through it: what of the output reaches rows at
// or behind i from rows before i. It is summed from the same numbers M_ts (B_s . C_t) on both sides, so that
// with rounded operands, too, the large terms t = s cancel to the last bits.
#include <string.h>
#include <tgmath.h>
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/narrow.h"
#include "core/tensor/kernels/scan_parts.h"

typedef struct Backward {
    const FfpScanGradient *grad;
    const FfpScanShape *shape;
    const FfpScanInput *in;
    const real *dy;
    FfpScanLayout layout;
} Backward;

// A chunk on its way: packed operands and squares of its own.
typedef struct Work {
    FfpScanChunk chunk;
    const real *entering, *leaving_grad; // H, G
    FfpPacked *b_rows, *c_across;        // B as rows; C^T as columns
    FfpPacked *g_columns;                // G as columns
    FfpPacked *x_rows, *x_across, *dy_across, *dy_columns, *state_rows,
        *mixed;                          // of one head; across: transposed
    FfpPacked *pair_rows, *deep_columns; // for the sums over heads
    real *products, *dots, *pairs;
    real *b_turned, *c_turned, *db_turned, *dc_turned, *part; // [state, rows], row stride chunk
} Work;

static Work make_work(const Backward *pass, int index) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const size_t turned = (size_t)shape->state * (size_t)shape->chunk;
    Work w = {.chunk = FFP_K(scan_chunk)(shape, index)};
    const int rows = w.chunk.rows, state = shape->state, dim = shape->head_dim;
    FfpPacked *next = layout->packed + (size_t)w.chunk.desk * layout->pack_size;
    w.entering = layout->states + (size_t)index * layout->state_size;
    w.leaving_grad = layout->state_grads + (size_t)index * layout->state_size;
    w.b_rows = ffp_scan_take(&next, rows, state);
    w.c_across = ffp_scan_take(&next, rows, state);
    w.g_columns = ffp_scan_take(&next, layout->width, state);
    w.x_rows = ffp_scan_take(&next, rows, dim);
    w.x_across = ffp_scan_take(&next, rows, dim);
    w.dy_across = ffp_scan_take(&next, rows, dim);
    w.dy_columns = ffp_scan_take(&next, dim, rows);
    w.state_rows = ffp_scan_take(&next, state, dim);
    w.mixed = ffp_scan_take(&next, rows, rows);
    w.pair_rows = ffp_scan_take(&next, rows, rows);
    w.deep_columns = ffp_scan_take(&next, state, rows);
    w.products = ffp_scan_square(layout->products, shape, &w.chunk);
    w.dots = ffp_scan_square(layout->dots, shape, &w.chunk);
    w.pairs = ffp_scan_square(layout->pairs, shape, &w.chunk);
    w.b_turned = layout->turned + (size_t)w.chunk.desk * 5 * turned;
    w.c_turned = w.b_turned + turned;
    w.db_turned = w.c_turned + turned;
    w.dc_turned = w.db_turned + turned;
    w.part = w.dc_turned + turned;
    return w;
}

// `scaled` of a chunk's rows: 2^cs dy.
static void scale_dy(const Backward *pass, const FfpScanChunk *chunk) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    real *scaled = ffp_scan_scaled(layout, shape, chunk);
    for (int t = 0; t < chunk->rows; t++) {
        const real *dy = pass->dy + (size_t)(chunk->row + t) * layout->width;
        real *out = scaled + (size_t)t * layout->width;
        for (int head = 0; head < shape->heads; head++) {
            const real grow = layout->grow[(size_t)head * shape->rows + chunk->row + t];
            for (int p = head * shape->head_dim; p < (head + 1) * shape->head_dim; p++) out[p] = grow * dy[p];
        }
    }
}

// out [columns, rows] = in [rows, columns] transposed
static void turn(real *out, int out_stride, const real *in, int in_stride, int rows, int columns) {
    for (int j = 0; j < columns; j++)
        for (int i = 0; i < rows; i++) out[(size_t)j * out_stride + i] = in[(size_t)i * in_stride + j];
}

// For row s of the chunk and all t that see it: the row of (C_t . B_s) 2^(cs_t - cs_s) dt_s, and this head's
// share of M and of the sums of M_ts (B_s . C_t), over s into da, over t returned (there without dt_s).
static real pair_row(const Backward *pass, const Work *w, int head, int s) {
    const FfpScanShape *shape = pass->shape;
    const int rows = w->chunk.rows, first = shape->reverse ? 0 : s, last = shape->reverse ? s : rows - 1;
    const size_t start = (size_t)head * shape->rows + w->chunk.row, row = (size_t)s * shape->chunk;
    const real *cs = pass->layout.cs + start, *products = w->products + row, *dots = w->dots + row;
    real *pairs = w->pairs + row, *da = pass->layout.da + start, sum = 0;
    FfpPacked *mixed = w->mixed + (size_t)s * ffp_packed_depth(rows);
    const real here = cs[s], dt = pass->layout.dt[start + s];
    const int begin = first / FFP_PACK_LINES * FFP_PACK_LINES, end = ffp_scan_line_end(last + 1, rows);
    for (int t = 0; t < begin; t++) mixed[t] = 0;
#pragma omp simd reduction(+ : sum)
    for (int t = begin; t < end; t++) {
        const real power = ffp_exp2_packed(cs[t] - here < 0 ? cs[t] - here : 0);
        const real decay = t >= first && t <= last ? power : 0, m = dots[t] * decay;
        mixed[t] = ffp_narrow(products[t] * decay * dt);
        pairs[t] += m * dt;
        da[t] += m * dt * products[t];
        sum += m * products[t];
    }
    for (size_t t = (size_t)end; t < ffp_packed_depth(rows); t++) mixed[t] = 0;
    return sum;
}

// One head's share through a state S (H or G) in total [state, rows], by v = dy or x:
//   total[n,t] += weight_t Z_nt,  along_t = sum_n factor[n,t] Z_nt,  Z = S v^T.
static void state_share(const Backward *pass, const Work *w, int head, const real *states,
                        const FfpPacked *across, const real *factor, const real *weight, real *total,
                        real *along) {
    const FfpScanShape *shape = pass->shape;
    const int rows = w->chunk.rows, state = shape->state, dim = shape->head_dim, width = pass->layout.width;
    FFP_K(pack_rows)(w->state_rows, false, state, dim, states + (size_t)head * dim, width);
    ffp_product(state, rows, dim, 1, ffp_operand(w->state_rows, dim), ffp_operand(across, dim), 0, w->part,
                shape->chunk);
    for (int t = 0; t < rows; t++) along[t] = 0;
    for (int n = 0; n < state; n++) {
        const size_t row = (size_t)n * shape->chunk;
#pragma omp simd
        for (int t = 0; t < rows; t++) {
            total[row + t] += weight[t] * w->part[row + t];
            along[t] += factor[row + t] * w->part[row + t];
        }
    }
}

// dx of one head into grad->x, which holds B G on entry: dx_s = feed_s G B_s + sum_t mixed[s,t] dy_t + D dy_s
static void head_x_grad(const Backward *pass, const Work *w, int head) {
    const FfpScanShape *shape = pass->shape;
    const int rows = w->chunk.rows, dim = shape->head_dim, width = pass->layout.width, ld = pass->in->ld;
    const real *dy = pass->dy + (size_t)w->chunk.row * width + (size_t)head * dim;
    const real *feed = pass->layout.feed + (size_t)head * shape->rows + w->chunk.row,
               skip = pass->in->d[head];
    real *dx = pass->grad->x + (size_t)w->chunk.row * ld + (size_t)head * dim;
    for (int t = 0; t < rows; t++)
        for (int p = 0; p < dim; p++)
            dx[(size_t)t * ld + p] = feed[t] * dx[(size_t)t * ld + p] + skip * dy[(size_t)t * width + p];
    ffp_product(rows, dim, rows, 1, ffp_operand(w->mixed, rows), ffp_operand(w->dy_columns, rows), 1, dx, ld);
}

// da of one head: the flow from before a step to behind it, one step of the scan after another from the end.
// da holds what leaves for later rows, x_grad_dot what a row adds for them.
static void head_flow(const Backward *pass, const Work *w, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const int rows = w->chunk.rows, dim = shape->head_dim;
    const size_t start = (size_t)head * shape->rows + w->chunk.row;
    real *da = layout->da + start, *x_grad_dot = layout->x_grad_dot + start, through = 0;
    for (int n = 0; n < shape->state; n++) {
        const size_t first = (size_t)n * layout->width + (size_t)head * dim;
#pragma omp simd reduction(+ : through)
        for (int p = 0; p < dim; p++) through += w->leaving_grad[first + p] * w->entering[first + p];
    }
    real flow = through * layout->grow[start + w->chunk.end];
    for (int t = 0; t < rows; t++) flow += layout->inflow[start + t];
    for (int i = rows - 1; i >= 0; i--) {
        const int t = shape->reverse ? rows - 1 - i : i;
        flow += da[t] - x_grad_dot[t] * layout->dt[start + t];
        da[t] = flow;
    }
}

static void head_backward(const Backward *pass, const Work *w, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const int rows = w->chunk.rows, dim = shape->head_dim, width = layout->width, ld = pass->in->ld;
    const size_t start = (size_t)head * shape->rows + w->chunk.row;
    const real *x = pass->in->x + (size_t)w->chunk.row * ld + (size_t)head * dim;
    const real *dy = pass->dy + (size_t)w->chunk.row * width + (size_t)head * dim;
    real *da = layout->da + start, *x_grad_dot = layout->x_grad_dot + start, *inflow = layout->inflow + start;
    FFP_K(pack_rows)(w->x_rows, false, rows, dim, x, ld);
    FFP_K(pack_columns)(w->x_across, true, dim, rows, x, ld);
    FFP_K(pack_columns)(w->dy_across, true, dim, rows, dy, width);
    FFP_K(pack_columns)(w->dy_columns, false, rows, dim, dy, width);
    ffp_product(rows, rows, dim, 1, ffp_operand(w->x_rows, dim), ffp_operand(w->dy_across, dim), 0, w->dots,
                shape->chunk);
    state_share(pass, w, head, w->entering, w->dy_across, w->c_turned, layout->grow + start, w->dc_turned,
                da);
    state_share(pass, w, head, w->leaving_grad, w->x_across, w->b_turned, layout->feed + start, w->db_turned,
                inflow);
    for (int t = 0; t < rows; t++) da[t] *= layout->grow[start + t];
    for (int s = 0; s < rows; s++) {
        x_grad_dot[s] = pair_row(pass, w, head, s) + layout->fade[start + s] * inflow[s];
        layout->x_dy_dot[start + s] = w->dots[(size_t)s * shape->chunk + s];
        inflow[s] *= layout->feed[start + s];
    }
    head_flow(pass, w, head);
    head_x_grad(pass, w, head);
}

// total [rows, state] (row stride ld) = what the heads gathered, turned back, + pairs factor
static void finish_operand(const Backward *pass, const Work *w, real *total, const real *turned,
                           bool transpose_pairs, const real *factor) {
    const FfpScanShape *shape = pass->shape;
    const int rows = w->chunk.rows, state = shape->state, ld = pass->in->ld;
    turn(total, ld, turned, shape->chunk, state, rows);
    FFP_K(pack_rows)(w->pair_rows, transpose_pairs, rows, rows, w->pairs, shape->chunk);
    FFP_K(pack_columns)(w->deep_columns, false, rows, state, factor, ld);
    ffp_product(rows, state, rows, 1, ffp_operand(w->pair_rows, rows), ffp_operand(w->deep_columns, rows), 1,
                total, ld);
}

static void chunk_backward(const Backward *pass, int index) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanInput *in = pass->in;
    const Work w = make_work(pass, index);
    const int rows = w.chunk.rows, state = shape->state, width = pass->layout.width, chunk = shape->chunk;
    const size_t start = (size_t)w.chunk.row * in->ld;
    const FfpOperand b_rows = ffp_operand(w.b_rows, state);
    FFP_K(pack_rows)(w.b_rows, false, rows, state, in->b + start, in->ld);
    FFP_K(pack_columns)(w.c_across, true, state, rows, in->c + start, in->ld);
    FFP_K(pack_columns)(w.g_columns, false, state, width, w.leaving_grad, width);
    ffp_product(rows, rows, state, 1, b_rows, ffp_operand(w.c_across, state), 0, w.products, chunk);
    ffp_product(rows, width, state, 1, b_rows, ffp_operand(w.g_columns, state), 0, pass->grad->x + start,
                in->ld);
    turn(w.b_turned, chunk, in->b + start, in->ld, rows, state);
    turn(w.c_turned, chunk, in->c + start, in->ld, rows, state);
    memset(w.db_turned, 0, 2 * (size_t)state * (size_t)chunk * sizeof(real)); // dc_turned lies behind it
    memset(w.pairs, 0, (size_t)rows * (size_t)chunk * sizeof(real));
    for (int head = 0; head < shape->heads; head++) head_backward(pass, &w, head);
    finish_operand(pass, &w, pass->grad->b + start, w.db_turned, false, in->c + start);
    finish_operand(pass, &w, pass->grad->c + start, w.dc_turned, true, in->b + start);
}

// d(dt) = A da + x.dX; dA = sum dt da; then through exp and softplus.
static void head_parameters(const Backward *pass, int head) {
    const FfpScanShape *shape = pass->shape;
    const FfpScanLayout *layout = &pass->layout;
    const FfpScanInput *in = pass->in;
    const real rate = -exp(in->a_log[head]);
    real da_sum = 0, bias_sum = 0, skip_sum = 0;
    for (int row = 0; row < shape->rows; row++) {
        const size_t at = (size_t)head * shape->rows + row;
        const real raw = in->dt_raw[(size_t)row * in->lddt + head] + in->dt_bias[head];
        const real slope = 1 / (1 + exp(-raw)),
                   draw = (rate * layout->da[at] + layout->x_grad_dot[at]) * slope;
        pass->grad->dt_raw[(size_t)row * in->lddt + head] += draw;
        bias_sum += draw;
        da_sum += layout->dt[at] * layout->da[at];
        skip_sum += layout->x_dy_dot[at];
    }
    pass->grad->dt_bias[head] += bias_sum;
    pass->grad->a_log[head] += rate * da_sum;
    pass->grad->d[head] += skip_sum;
}

// The forward's states are computed again; then every chunk on its own, the heads in order, so that dB and dC
// have one owner.
void FFP_K(scan_backward)(const FfpScanGradient *grad, const FfpScanShape *shape, const FfpScanInput *in,
                          const real *dy, real *scratch) {
    const Backward pass = {grad, shape, in, dy, FFP_K(scan_layout)(shape, scratch)};
    const FfpScanLayout *layout = &pass.layout;
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout->chunks; index++) {
        const FfpScanChunk chunk = FFP_K(scan_chunk)(shape, index);
        const size_t state = (size_t)index * layout->state_size;
        FFP_K(scan_decays)(layout, shape, in, &chunk);
        FFP_K(scan_scale_x)(layout, shape, in, &chunk);
        FFP_K(scan_outer)(layout->states + state, layout, shape, in->b, in->ld, &chunk);
        scale_dy(&pass, &chunk);
        FFP_K(scan_outer)(layout->state_grads + state, layout, shape, in->c, in->ld, &chunk);
    }
    FFP_K(scan_carry)(layout->states, layout, shape, false);
    FFP_K(scan_carry)(layout->state_grads, layout, shape, true);
#pragma omp parallel for schedule(static)
    for (int index = 0; index < layout->chunks; index++) chunk_backward(&pass, index);
#pragma omp parallel for schedule(static)
    for (int head = 0; head < shape->heads; head++) head_parameters(&pass, head);
}
