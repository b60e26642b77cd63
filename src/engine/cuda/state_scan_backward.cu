// State-space duality scan, backward. With X = dt x, G the gradient of the state leaving a chunk and H the
// state entering it, both [state, head_dim]; for a row t that sees s:
//   M_ts = (dy_t . X_s) 2^(cs_t - cs_s)
//   dx_s = feed_s B_s G + sum_t (B_s . C_t) 2^(cs_t - cs_s) dt_s dy_t + D dy_s
//   dB_s = feed_s G x_s + sum_t M_ts C_t,  dC_t = grow_t H dy_t + sum_s M_ts B_s
// and the gradient of the step's exponent a_i = dt_i A is the flow from rows before i to rows at or behind
// it.
#include "engine/cuda/columns.h"
#include "engine/cuda/state_scan.h"
#include "engine/cuda/warp.h"

enum { THREADS_OF_SUMS = 3 * 32 }; // a warp for each of FFP_SCAN_SUMS

// One chunk of one head.
typedef struct Tiles {
    float *x, *dy, *b, *c, *state, *square; // state: G, then H
} Tiles;

// Sums over rows or columns of products, of each row of the chunk.
typedef struct Sums {
    float pairs[FFP_TILE_SIDE];    // sum over t of M_ts (B_s . C_t), without dt_s
    float seen[8][FFP_TILE_SIDE];  // the same over s with dt_s, a part for each warp
    float inflow[FFP_TILE_SIDE];   // B_s . G x_s
    float outflow[FFP_TILE_SIDE];  // C_t . H dy_t
    float diagonal[FFP_TILE_SIDE]; // x_t . dy_t
    float through[8];              // sum of G H, a part for each warp
} Sums;

static __device__ void load_slice(const Tiles *at, const FfpScanPlan *plan, const FfpScanRows *rows,
                                  int chunk, int head, int slice) {
    const int count = ffp_scan_slice(plan, slice);
    const size_t ld = (size_t)plan->in.ld, start = rows->first * ld + (size_t)slice * FFP_TILE_SIDE;
    ffp_tile_load(at->b, plan->in.b + start, ld, rows->count, count, NULL);
    ffp_tile_load(at->c, plan->in.c + start, ld, rows->count, count, NULL);
    ffp_tile_load(at->state, plan->state_grads + ffp_scan_state_at(plan, chunk, head, slice), FFP_TILE_SIDE,
                  count, FFP_TILE_SIDE, NULL);
    __syncthreads();
}

// From products = (B_s . C_t) and dots = (x_s . dy_t), rows s and columns t: the square becomes (B_s . C_t)
// 2^(cs_t - cs_s) dt_s, dots become M_ts.
static __device__ void weigh_pairs(float *square, float dots[4][4], const float products[4][4], Sums *sums,
                                   const FfpScanPlan *plan, const FfpScanRows *rows) {
    float over_t[4] = {}, over_s[4] = {};
    for (int i = 0; i < 4; i++) {
        const int s = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++) {
            const int t = ffp_tile_column() + 16 * j;
            const bool seen = plan->shape.reverse ? s >= t : s <= t;
            const float decay = seen ? ffp_scan_power(rows->cs[t] - rows->cs[s]) : 0;
            const float m = dots[i][j] * decay;
            if (s == t) sums->diagonal[s] = dots[i][j];
            square[s * FFP_TILE_LD + t] = products[i][j] * decay * rows->dt[s];
            over_t[i] += m * products[i][j];
            dots[i][j] = m * rows->dt[s];
            over_s[j] += dots[i][j] * products[i][j];
        }
    }
    ffp_tile_row_sums(sums->pairs, over_t);
    ffp_tile_column_sums(sums->seen[0], over_s);
}

// Products of the chunk and dx; the square holds M_ts on return.
static __device__ void x_gradient(const FfpScanGradient *grad, const Tiles *at, Sums *sums,
                                  const FfpScanPlan *plan, const FfpScanRows *rows, int chunk, int head) {
    float products[4][4] = {}, dots[4][4] = {}, dx[4][4] = {};
    for (int slice = 0; slice < plan->slices; slice++) {
        if (slice > 0) __syncthreads();
        load_slice(at, plan, rows, chunk, head, slice);
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_INSIDE>(products, at->b, at->c);
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_CONTIGUOUS_K_OUTSIDE>(dx, at->b, at->state);
    }
    ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_INSIDE>(dots, at->x, at->dy);
    weigh_pairs(at->square, dots, products, sums, plan, rows);
    __syncthreads();
    const int p = 4 * ffp_tile_column(), dim = plan->shape.head_dim;
    for (int i = 0; i < 4; i++) {
        const int s = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++)
            dx[i][j] = rows->feed[s] * dx[i][j] + plan->in.d[head] * at->dy[s * FFP_TILE_LD + p + j];
    }
    ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_CONTIGUOUS_K_OUTSIDE>(dx, at->square, at->dy);
    for (int i = 0; i < 4; i++) {
        const int s = 4 * ffp_tile_row() + i;
        if (s < rows->count)
            ffp_tile_store_four(grad->x + (size_t)(rows->first + s) * plan->in.ld + head * dim + p, dx[i],
                                dim - p);
    }
    __syncthreads();
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            at->square[(4 * ffp_tile_row() + i) * FFP_TILE_LD + ffp_tile_column() + 16 * j] = dots[i][j];
    __syncthreads();
}

// z holds rows of states times x or dy: adds its products with `factor` to `along`, and weighs its rows.
static __device__ void take_along(float along[4], float z[4][4], const float *factor, const float *weight) {
    for (int i = 0; i < 4; i++) {
        const int row = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++) {
            along[i] += factor[row * FFP_TILE_LD + ffp_tile_column() + 16 * j] * z[i][j];
            z[i][j] *= weight[row];
        }
    }
}

static __device__ void store_share(float *to, const float z[4][4], const FfpScanPlan *plan,
                                   const FfpScanRows *rows, int head, int slice) {
    const int count = ffp_scan_slice(plan, slice);
    to += ((size_t)head * plan->shape.rows + rows->first) * plan->shape.state + (size_t)slice * FFP_TILE_SIDE;
    for (int i = 0; i < 4; i++) {
        const int row = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++) {
            const int n = ffp_tile_column() + 16 * j;
            if (row < rows->count && n < count) to[(size_t)row * plan->shape.state + n] = z[i][j];
        }
    }
}

// H takes G's place; returns the thread's part of the sum of G H.
static __device__ float swap_states(float *tile, const float *entering, int count) {
    float sum = 0;
    for (int i = (int)threadIdx.x; i < FFP_TILE_SIDE * FFP_TILE_SIDE; i += FFP_TILE_THREADS) {
        const int n = i / FFP_TILE_SIDE, at = n * FFP_TILE_LD + i % FFP_TILE_SIDE;
        const float h = n < count ? entering[i] : 0;
        sum += tile[at] * h;
        tile[at] = h;
    }
    return sum;
}

// This head's share of dB and dC.
static __device__ void factor_gradients(const Tiles *at, Sums *sums, const FfpScanPlan *plan,
                                        const FfpScanRows *rows, int chunk, int head) {
    float inflow[4] = {}, outflow[4] = {}, through = 0;
    for (int slice = 0; slice < plan->slices; slice++) {
        if (plan->slices > 1) load_slice(at, plan, rows, chunk, head, slice);
        float z[4][4] = {};
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_INSIDE>(z, at->x, at->state);
        take_along(inflow, z, at->b, rows->feed);
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_OUTSIDE>(z, at->square, at->c);
        store_share(plan->db, z, plan, rows, head, slice);
        __syncthreads();
        through += swap_states(at->state, plan->states + ffp_scan_state_at(plan, chunk, head, slice),
                               ffp_scan_slice(plan, slice));
        __syncthreads();
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) z[i][j] = 0;
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_INSIDE>(z, at->dy, at->state);
        take_along(outflow, z, at->c, rows->grow);
        ffp_tile_multiply<FFP_ROWS_K_OUTSIDE, FFP_STRIDED_K_OUTSIDE>(z, at->square, at->b);
        store_share(plan->dc, z, plan, rows, head, slice);
        __syncthreads();
    }
    ffp_tile_row_sums(sums->inflow, inflow);
    ffp_tile_row_sums(sums->outflow, outflow);
    through = ffp_warp_sum(through);
    if (ffp_lane() == 0) sums->through[threadIdx.x / FFP_WARP] = through;
    __syncthreads();
}

// Gradients of the steps by one warp, a lane for two rows. da_i = the flow from before row i to behind it:
// what passes through the whole chunk, what all rows give to later chunks, and of the rows at or behind i
// along the scan what they take less what they give to each other.
static __device__ void step_gradients(const FfpScanGradient *grad, const Sums *sums, const FfpScanPlan *plan,
                                      const FfpScanRows *rows, int chunk, int head) {
    const int lane = ffp_lane();
    float flow[2], x_grad_dot[2], leaving = 0, through = 0;
    for (int j = 0; j < 2; j++) {
        const int t = ffp_scan_place(plan, rows, 2 * lane + j);
        float seen = 0;
        for (int warp = 0; warp < 8; warp++) seen += sums->seen[warp][t];
        x_grad_dot[j] = sums->pairs[t] + rows->fade[t] * sums->inflow[t];
        leaving += rows->feed[t] * sums->inflow[t];
        flow[j] = rows->grow[t] * sums->outflow[t] + seen - x_grad_dot[j] * rows->dt[t];
    }
    for (int warp = 0; warp < 8; warp++) through += sums->through[warp];
    const float base = through * rows->grow[rows->end] + ffp_warp_sum(leaving);
    float behind = flow[0] + flow[1]; // sum over this lane and those behind
    for (int by = 1; by < FFP_WARP; by *= 2) {
        const float next = __shfl_down_sync(0xffffffffu, behind, by);
        if (lane + by < FFP_WARP) behind += next;
    }
    const float rate = -expf(plan->in.a_log[head]);
    float own[FFP_SCAN_SUMS] = {};
    for (int j = 0; j < 2; j++) {
        const int i = 2 * lane + j, t = ffp_scan_place(plan, rows, i);
        if (i >= rows->count) continue;
        const float da = base + behind - (j ? flow[0] : 0);
        const float draw = (rate * da + x_grad_dot[j]) * ffp_logistic(rows->raw[t]);
        grad->dt_raw[(size_t)(rows->first + t) * plan->in.lddt + head] += draw;
        own[0] += draw, own[1] += rate * rows->dt[t] * da, own[2] += sums->diagonal[t];
    }
    for (int k = 0; k < FFP_SCAN_SUMS; k++) {
        const float sum = ffp_warp_sum(own[k]);
        if (lane == 0) plan->sums[((size_t)chunk * plan->shape.heads + head) * FFP_SCAN_SUMS + k] = sum;
    }
}

static __global__ void __launch_bounds__(FFP_TILE_THREADS, 2)
    chunk_backward(FfpScanGradient grad, FfpScanPlan plan, const float *dy) {
    FFP_DYNAMIC_SHARED(float, memory);
    __shared__ FfpScanRows rows;
    __shared__ Sums sums;
    const Tiles at = {memory,
                      memory + FFP_TILE_SIZE,
                      memory + 2 * FFP_TILE_SIZE,
                      memory + 3 * FFP_TILE_SIZE,
                      memory + 4 * FFP_TILE_SIZE,
                      memory + 5 * FFP_TILE_SIZE};
    const int chunk = (int)blockIdx.x, head = (int)blockIdx.y, dim = plan.shape.head_dim;
    const size_t ld = (size_t)plan.in.ld, width = (size_t)plan.shape.heads * dim;
    ffp_scan_rows(&rows, &plan, chunk, head);
    ffp_tile_load(at.x, plan.in.x + rows.first * ld + head * dim, ld, rows.count, dim, NULL);
    ffp_tile_load(at.dy, dy + rows.first * width + head * dim, width, rows.count, dim, NULL);
    x_gradient(&grad, &at, &sums, &plan, &rows, chunk, head);
    factor_gradients(&at, &sums, &plan, &rows, chunk, head);
    if (threadIdx.x < FFP_WARP) step_gradients(&grad, &sums, &plan, &rows, chunk, head);
}

// dB and dC (the grid's second layer): sums over the heads.
static __global__ void sum_heads(size_t count, FfpScanGradient grad, FfpScanPlan plan) {
    const size_t i = ffp_thread();
    if (i >= count) return;
    const float *share = (blockIdx.y ? plan.dc : plan.db) + i;
    float sum = 0;
#pragma unroll 4
    for (int head = 0; head < plan.shape.heads; head++) sum += share[head * count];
    float *to = blockIdx.y ? grad.c : grad.b;
    to[i / plan.shape.state * plan.in.ld + i % plan.shape.state] = sum;
}

// One warp for each sum of each head, over the chunks.
static __global__ void sum_chunks(FfpScanGradient grad, FfpScanPlan plan) {
    const int head = (int)blockIdx.x, k = (int)threadIdx.x / FFP_WARP;
    float *const to[FFP_SCAN_SUMS] = {grad.dt_bias, grad.a_log, grad.d};
    float sum = 0;
    for (int chunk = ffp_lane(); chunk < plan.chunks; chunk += FFP_WARP)
        sum += plan.sums[((size_t)chunk * plan.shape.heads + head) * FFP_SCAN_SUMS + k];
    sum = ffp_warp_sum(sum);
    if (ffp_lane() == 0) to[k][head] += sum;
}

void ffp_cuda_scan_backward(const FfpScanGradient *grad, const FfpScanShape *shape, const FfpScanInput *in,
                            const float *dy, float *scratch) {
    if (shape->rows <= 0) return;
    const FfpScanPlan plan = ffp_cuda_scan_plan(shape, in, scratch);
    const size_t count = (size_t)shape->rows * shape->state;
    ffp_cuda_scan_states(&plan, dy);
    ffp_launch_blocks(chunk_backward, dim3((unsigned)plan.chunks, (unsigned)shape->heads),
                      dim3(FFP_TILE_THREADS), 6 * FFP_TILE_SIZE * sizeof(float), *grad, plan, dy);
    ffp_launch(sum_heads, dim3(ffp_blocks(count, 256), 2), dim3(256), count, *grad, plan);
    ffp_launch_blocks(sum_chunks, dim3((unsigned)shape->heads), dim3(THREADS_OF_SUMS), 0, *grad, plan);
}
