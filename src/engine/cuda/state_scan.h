// Common parts of the passes of the state-space scan: chunks of 64 rows, of which a block of threads has one
// of one head. Names are those of core/tensor/kernels/scan.c and scan_backward.c. "Begin" and "end" of a
// chunk are meant along the scan; rows keep their order in memory.
#ifndef FFP_CUDA_STATE_SCAN_H
#define FFP_CUDA_STATE_SCAN_H

#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}
#include "engine/cuda/tensor_tile.h"

#define FFP_SCAN_LOG2_E 1.44269504088896340736f
enum { FFP_SCAN_SUMS = 3 }; // of a chunk, for dt_bias, a_log and d

typedef struct FfpScanPlan {
    FfpScanShape shape; // its chunk is not looked at: the result is the same for any
    FfpScanInput in;
    int chunks, slices; // slices of 64 of the state
    float *states;      // [chunks, heads, state, 64]: what a chunk adds, then H entering it
    float *decays;      // [chunks, heads]: over the whole chunk
    // from here on for the backward pass only
    float *state_grads; // as states: G leaving a chunk
    float *db, *dc;     // [heads, T, state]: each head's share
    float *sums;        // [chunks, heads, FFP_SCAN_SUMS]
} FfpScanPlan;

// The rows of one chunk and head. Rows that do not exist have dt = 0.
typedef struct FfpScanRows {
    int first, count, end;     // in memory; `end`: the last along the scan, counted from first
    float raw[FFP_TILE_SIDE];  // dt before the softplus
    float dt[FFP_TILE_SIDE];   // the step
    float cs[FFP_TILE_SIDE];   // sum of dt A log2(e) from the chunk's begin, the row's own included
    float grow[FFP_TILE_SIDE]; // 2^cs
    float fade[FFP_TILE_SIDE]; // 2^(cs at the end - cs)
    float feed[FFP_TILE_SIDE]; // fade dt
} FfpScanRows;

// Ends the program with a message when a head is wider than a tile.
FfpScanPlan ffp_cuda_scan_plan(const FfpScanShape *shape, const FfpScanInput *in, float *scratch);

// States of all chunks, H, and with dy also G, as they stand before (behind) each chunk.
void ffp_cuda_scan_states(const FfpScanPlan *plan, const float *dy);

// Rounding can make a difference of sums positive, and its power infinite: hence the minimum.
static __device__ inline float ffp_scan_power(float exponent) {
    return exp2f(fminf(exponent, 0));
}

// Place in memory of the i-th row along the scan.
static __device__ inline int ffp_scan_place(const FfpScanPlan *plan, const FfpScanRows *rows, int i) {
    return i >= rows->count || !plan->shape.reverse ? i : rows->count - 1 - i;
}

static __device__ inline size_t ffp_scan_state_at(const FfpScanPlan *plan, int chunk, int head, int slice) {
    return (((size_t)chunk * plan->shape.heads + head) * plan->shape.state + (size_t)slice * FFP_TILE_SIDE) *
           FFP_TILE_SIDE;
}

// Numbers of the state in a slice.
static __device__ inline int ffp_scan_slice(const FfpScanPlan *plan, int slice) {
    return min((int)FFP_TILE_SIDE, plan->shape.state - slice * FFP_TILE_SIDE);
}

// Fills `rows`, which is shared; good for the whole block on return. A lane has two rows; one lane adds up
// their steps in order, so that rows without a decay between them have the very same sum, however large it
// is.
static __device__ inline void ffp_scan_rows(FfpScanRows *rows, const FfpScanPlan *plan, int chunk, int head) {
    if (threadIdx.x == 0) {
        rows->first = chunk * FFP_TILE_SIDE;
        rows->count = min((int)FFP_TILE_SIDE, plan->shape.rows - rows->first);
        rows->end = plan->shape.reverse ? 0 : rows->count - 1;
    }
    __syncthreads();
    if (threadIdx.x < FFP_WARP) {
        const float rate = -expf(plan->in.a_log[head]) * FFP_SCAN_LOG2_E, bias = plan->in.dt_bias[head];
        float *steps = rows->fade; // in the scan's order
        for (int i = (int)threadIdx.x; i < FFP_TILE_SIDE; i += FFP_WARP) {
            const int t = ffp_scan_place(plan, rows, i);
            const bool exists = i < rows->count;
            const float raw =
                exists ? plan->in.dt_raw[(size_t)(rows->first + t) * plan->in.lddt + head] + bias : 0;
            rows->raw[t] = raw;
            rows->dt[t] = !exists ? 0 : raw > 20 ? raw : log1pf(expf(raw));
            steps[i] = rows->dt[t] * rate;
        }
        __syncwarp();
        if (threadIdx.x == 0) {
            float sum = 0;
#pragma unroll 16
            for (int i = 0; i < FFP_TILE_SIDE; i++) steps[i] = sum += steps[i];
        }
        __syncwarp();
        const float total = steps[FFP_TILE_SIDE - 1], first = steps[threadIdx.x],
                    second = steps[threadIdx.x + FFP_WARP];
        __syncwarp();
        for (int j = 0; j < 2; j++) {
            const int t = ffp_scan_place(plan, rows, (int)threadIdx.x + j * FFP_WARP);
            const float sum = j ? second : first;
            rows->cs[t] = sum;
            rows->grow[t] = ffp_scan_power(sum);
            rows->fade[t] = ffp_scan_power(total - sum);
            rows->feed[t] = rows->fade[t] * rows->dt[t];
        }
    }
    __syncthreads();
}

#endif
