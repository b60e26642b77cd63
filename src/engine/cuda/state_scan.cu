// State-space duality scan, forward: the states that chunks add, their carry from chunk to chunk, the
// outputs.
#include "engine/cuda/state_scan.h"

// Reals of each part of the scratch, in FfpScanPlan's order.
enum { PARTS = 6 };
static void part_sizes(size_t sizes[PARTS], const FfpScanShape *shape) {
    const size_t chunks = ((size_t)shape->rows + FFP_TILE_SIDE - 1) / FFP_TILE_SIDE,
                 heads = (size_t)shape->heads;
    const size_t states = chunks * heads * (size_t)shape->state * FFP_TILE_SIDE;
    const size_t shares = heads * (size_t)shape->rows * (size_t)shape->state;
    const size_t parts[PARTS] = {states, chunks * heads, states,
                                 shares, shares,         chunks * heads * FFP_SCAN_SUMS};
    for (int i = 0; i < PARTS; i++) sizes[i] = (parts[i] + 63) / 64 * 64;
}

size_t ffp_cuda_scan_scratch(const FfpScanShape *shape) {
    size_t sizes[PARTS], sum = 0;
    part_sizes(sizes, shape);
    for (int i = 0; i < PARTS; i++) sum += sizes[i];
    return sum;
}

FfpScanPlan ffp_cuda_scan_plan(const FfpScanShape *shape, const FfpScanInput *in, float *scratch) {
    if (shape->head_dim > FFP_TILE_SIDE) {
        fprintf(stderr, "ffprocams: error: GPU: scan heads of %d, at most %d\n", shape->head_dim,
                FFP_TILE_SIDE);
        abort();
    }
    FfpScanPlan plan = {};
    plan.shape = *shape;
    plan.in = *in;
    plan.chunks = (shape->rows + FFP_TILE_SIDE - 1) / FFP_TILE_SIDE;
    plan.slices = (shape->state + FFP_TILE_SIDE - 1) / FFP_TILE_SIDE;
    float **parts[PARTS] = {&plan.states, &plan.decays, &plan.state_grads, &plan.db, &plan.dc, &plan.sums};
    size_t sizes[PARTS];
    part_sizes(sizes, shape);
    for (int i = 0; i < PARTS; i++) {
        *parts[i] = scratch;
        scratch += sizes[i];
    }
    return plan;
}

// A chunk's own state [state, head_dim]: sum over its rows of B_t (outer) feed_t x_t; in the grid's second
// layer its own share of G: sum of C_t (outer) grow_t dy_t.
static __global__ void __launch_bounds__(FFP_TILE_THREADS) own_states(FfpScanPlan plan, const float *dy) {
    FFP_DYNAMIC_SHARED(float, deep);
    float *wide = deep + FFP_TILE_SIZE;
    __shared__ FfpScanRows rows;
    const int chunk = (int)blockIdx.x, head = (int)blockIdx.y, dim = plan.shape.head_dim;
    const bool backward = blockIdx.z == 1;
    const size_t ld = (size_t)plan.in.ld, width = (size_t)plan.shape.heads * dim;
    const float *factor = backward ? plan.in.c : plan.in.b;
    float *states = backward ? plan.state_grads : plan.states;
    ffp_scan_rows(&rows, &plan, chunk, head);
    if (backward)
        ffp_tile_load(wide, dy + rows.first * width + head * dim, width, rows.count, dim, rows.grow);
    else
        ffp_tile_load(wide, plan.in.x + rows.first * ld + head * dim, ld, rows.count, dim, rows.feed);
    for (int slice = 0; slice < plan.slices; slice++) {
        const int count = ffp_scan_slice(&plan, slice);
        ffp_tile_load(deep, factor + rows.first * ld + slice * FFP_TILE_SIDE, ld, rows.count, count, NULL);
        __syncthreads();
        float sum[4][4] = {};
        ffp_tile_multiply<FFP_ROWS_K_OUTSIDE, FFP_CONTIGUOUS_K_OUTSIDE>(sum, deep, wide);
        float *to = states + ffp_scan_state_at(&plan, chunk, head, slice) + 4 * ffp_tile_column();
        for (int i = 0; i < 4; i++) {
            const int n = 4 * ffp_tile_row() + i;
            if (n < count) ffp_tile_store_four(to + n * FFP_TILE_SIDE, sum[i], 4);
        }
        __syncthreads();
    }
    if (threadIdx.x == 0 && !backward) plan.decays[chunk * plan.shape.heads + head] = rows.grow[rows.end];
}

// One thread for each number of a state, over the chunks along the scan (against it for G, the grid's second
// layer): out[next] = decay out[this] + own[this], in place. Some chunks are read ahead.
static __global__ void carry_states(size_t count, FfpScanPlan plan) {
    enum { AHEAD = 8 };
    const size_t i = ffp_thread();
    if (i >= count) return;
    const bool backward = blockIdx.y == 1, from_end = plan.shape.reverse != backward;
    float *state = (backward ? plan.state_grads : plan.states) + i, carried = 0;
    const float *decay = plan.decays + i / ((size_t)plan.shape.state * FFP_TILE_SIDE);
    for (int begin = 0; begin < plan.chunks; begin += AHEAD) {
        float own[AHEAD], keep[AHEAD];
#pragma unroll
        for (int a = 0; a < AHEAD; a++) {
            const int step = min(begin + a, plan.chunks - 1),
                      chunk = from_end ? plan.chunks - 1 - step : step;
            own[a] = state[chunk * count];
            keep[a] = decay[(size_t)chunk * plan.shape.heads];
        }
#pragma unroll
        for (int a = 0; a < AHEAD; a++) {
            const int step = begin + a, chunk = from_end ? plan.chunks - 1 - step : step;
            if (step >= plan.chunks) break;
            state[chunk * count] = carried;
            carried = keep[a] * carried + own[a];
        }
    }
}

void ffp_cuda_scan_states(const FfpScanPlan *plan, const float *dy) {
    const unsigned layers = dy ? 2 : 1;
    const size_t count = (size_t)plan->shape.heads * plan->shape.state * FFP_TILE_SIDE;
    ffp_launch_blocks(own_states, dim3((unsigned)plan->chunks, (unsigned)plan->shape.heads, layers),
                      dim3(FFP_TILE_THREADS), 2 * FFP_TILE_SIZE * sizeof(float), *plan, dy);
    ffp_launch(carry_states, dim3(ffp_blocks(count, 128), layers), dim3(128), count, *plan);
}

// y_t = 2^cs_t C_t H + sum over the rows s that t sees of (C_t . B_s) 2^(cs_t - cs_s) dt_s x_s + D x_t
static __global__ void __launch_bounds__(FFP_TILE_THREADS) chunk_outputs(float *y, FfpScanPlan plan) {
    FFP_DYNAMIC_SHARED(float, c);
    float *b = c + FFP_TILE_SIZE, *entering = b + FFP_TILE_SIZE, *x = entering + FFP_TILE_SIZE, *mixed = b;
    __shared__ FfpScanRows rows;
    const int chunk = (int)blockIdx.x, head = (int)blockIdx.y, dim = plan.shape.head_dim;
    const size_t ld = (size_t)plan.in.ld, width = (size_t)plan.shape.heads * dim;
    ffp_scan_rows(&rows, &plan, chunk, head);
    const size_t start = rows.first * ld;
    float products[4][4] = {}, sum[4][4] = {};
    ffp_tile_load(x, plan.in.x + start + head * dim, ld, rows.count, dim, NULL);
    for (int slice = 0; slice < plan.slices; slice++) {
        const int count = ffp_scan_slice(&plan, slice);
        ffp_tile_load(c, plan.in.c + start + slice * FFP_TILE_SIDE, ld, rows.count, count, NULL);
        ffp_tile_load(b, plan.in.b + start + slice * FFP_TILE_SIDE, ld, rows.count, count, NULL);
        ffp_tile_load(entering, plan.states + ffp_scan_state_at(&plan, chunk, head, slice), FFP_TILE_SIDE,
                      count, FFP_TILE_SIDE, NULL);
        __syncthreads();
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_STRIDED_K_INSIDE>(products, c, b);
        ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_CONTIGUOUS_K_OUTSIDE>(sum, c, entering);
        __syncthreads();
    }
    for (int i = 0; i < 4; i++) {
        const int t = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++) {
            const int s = ffp_tile_column() + 16 * j;
            const bool seen = plan.shape.reverse ? s >= t : s <= t;
            mixed[t * FFP_TILE_LD + s] =
                seen ? products[i][j] * rows.dt[s] * ffp_scan_power(rows.cs[t] - rows.cs[s]) : 0;
            sum[i][j] *= rows.grow[t];
        }
    }
    __syncthreads();
    ffp_tile_multiply<FFP_ROWS_K_INSIDE, FFP_CONTIGUOUS_K_OUTSIDE>(sum, mixed, x);
    const int p = 4 * ffp_tile_column();
    const float skip = plan.in.d[head];
    for (int i = 0; i < 4; i++) {
        const int t = 4 * ffp_tile_row() + i;
        for (int j = 0; j < 4; j++) sum[i][j] += skip * x[t * FFP_TILE_LD + p + j];
        if (t < rows.count)
            ffp_tile_store_four(y + (rows.first + t) * width + head * dim + p, sum[i], dim - p);
    }
}

void ffp_cuda_scan_forward(float *y, const FfpScanShape *shape, const FfpScanInput *in, float *scratch) {
    if (shape->rows <= 0) return;
    const FfpScanPlan plan = ffp_cuda_scan_plan(shape, in, scratch);
    ffp_cuda_scan_states(&plan, NULL);
    ffp_launch_blocks(chunk_outputs, dim3((unsigned)plan.chunks, (unsigned)shape->heads),
                      dim3(FFP_TILE_THREADS), 4 * FFP_TILE_SIZE * sizeof(float), y, plan);
}
