// The gradient of blending, splat by splat, front to back as forward: the transmittance is then what it was,
// and the sum over the splats behind is the whole less those in front. A block a tile, a thread a pixel; a
// splat's sums over the tile's pixels are taken within each warp and then over the warps, in a fixed order.
#include "engine/cuda/launch.h"
#include "engine/cuda/tile.h"

enum { BATCH = FFP_WARP, TRANSPOSED = 16 };
static_assert((int)FFP_SPLAT_SUMS >= (int)TRANSPOSED && (int)FFP_SPLAT_SUMS <= (int)FFP_WARP,
              "a warp's transposed sum takes sixteen numbers, the others go by themselves");

// A batch of the tile's splats, and what the warps have made of it.
typedef struct Batch {
    FfpDeviceSplat splat[BATCH];
    int4 box[BATCH];
    uint32_t pair[BATCH];
    bool open[FFP_TILE_WARPS];        // warps that have not come to their end
    unsigned touched[FFP_TILE_WARPS]; // bit i: some of the warp's pixels see splat i
    float sums[FFP_TILE_WARPS][BATCH][FFP_SPLAT_SUMS];
} Batch;

// The state of a pixel.
typedef struct Pixel {
    float x, y;                         // its centre
    float grad[FFP_CHANNELS], spread;   // of the loss; spread: twice that of the distortion
    float opacity, depth;               // whole sums over the splats: A_tot, E_tot
    float opacity_so_far, depth_so_far; // sums over the splats in front: A, E
    float rest;                         // sum of w_j dL/dw_j over the splats behind
    float transmittance;
} Pixel;

static __device__ inline void load_pixel(const FfpTilePixel *at, const FfpGbuffer *out,
                                         const FfpGbuffer *grad, Pixel *p) {
    const bool inside = at->index >= 0;
    const int i = inside ? at->index : 0;
    p->x = (float)at->x + 0.5F;
    p->y = (float)at->y + 0.5F;
    p->transmittance = inside ? 1 : 0;
    p->spread = 2 * grad->distortion[i];
    // The distortion is of second degree in w, the rest of first: sum w dL/dw, by Euler.
    p->rest = p->spread * out->distortion[i];
    for (int k = 0; k < FFP_CHANNELS; k++) {
        p->grad[k] = 0;
        if (k >= FFP_DIRECT_CHANNELS && !grad->scattered) continue;
        p->grad[k] = *ffp_channel(grad, k, i);
        p->rest += p->grad[k] * *ffp_channel(out, k, i);
    }
    p->opacity = out->opacity[i];
    p->depth = out->depth[i];
    p->opacity_so_far = p->depth_so_far = 0;
}

// Called by all of the block: 160 threads fetch a quarter of a splat each, others boxes and pairs.
static __device__ inline void fetch_batch(const FfpTiling *t, int64_t first, int count, Batch *batch) {
    const int thread = (int)threadIdx.x, quads = (int)BATCH * FFP_SPLAT_QUADS;
    const int at = thread < quads ? thread / FFP_SPLAT_QUADS : thread - quads;
    if (at >= count || thread >= quads + BATCH) return;
    const uint32_t pair = t->order[first + at], splat = t->owners[pair];
    if (thread < quads) {
        const int q = thread % FFP_SPLAT_QUADS;
        ((float4 *)&batch->splat[at])[q] = ((const float4 *)&t->splats[splat])[q];
    } else {
        batch->box[at] = t->boxes[splat];
        batch->pair[at] = pair;
    }
}

// A splat's numbers at a pixel in the order of FfpDeviceSplatGrad.
// dL/dalpha_i = T_i dL/dw_i - sum_{j>i} w_j dL/dw_j / (1 - alpha_i).
static __device__ inline void pixel_backward(const FfpDeviceSplat *s, const FfpCover *c, float firmness,
                                             Pixel *p, float d[FFP_SPLAT_SUMS]) {
    const float z = s->value[FFP_CHANNEL_DEPTH - 1], w = c->alpha * c->before;
    float slope = p->grad[0];
    for (int k = 1; k < FFP_CHANNELS; k++) slope += s->value[k - 1] * p->grad[k];
    // weight in front less weight behind
    const float balance = 2 * p->opacity_so_far + w - p->opacity;
    const float dw = slope + p->spread * (z * (balance - w) + p->depth - 2 * p->depth_so_far);
    p->rest -= w * dw;
    p->opacity_so_far += w;
    p->depth_so_far += z * w;
    const float d_alpha = c->before * dw - p->rest / (1 - c->alpha);
    const float steepness = 1 + firmness * (1 - 2 * c->density);
    const float g = c->covered <= FFP_ALPHA_MAX ? -c->density * steepness * d_alpha : 0;
    d[0] = g, d[1] = g * c->dx, d[2] = g * c->dy;
    d[3] = d[1] * c->dx, d[4] = d[1] * c->dy, d[5] = d[2] * c->dy;
    for (int k = 1; k < FFP_CHANNELS; k++) d[5 + k] = w * p->grad[k];
    d[5 + FFP_CHANNEL_DEPTH] += w * p->spread * balance;
}

// Of 2 HALF numbers, half go to the lane across, for half of what it has. A template, so that the loop
// unrolls and the numbers stay in registers.
template <int HALF> static __device__ inline void fold(float d[2 * HALF], int lane) {
    const bool upper = lane & HALF;
#pragma unroll
    for (int i = 0; i < HALF; i++) {
        const float low = d[i], high = d[i + HALF];
        d[i] = (upper ? high : low) + __shfl_xor_sync(FFP_ALL_LANES, upper ? low : high, HALF);
    }
}

// Lane l gets the warp's sum of d[l % 16].
static __device__ inline float sum_transposed(float d[16], int lane) {
    fold<8>(d, lane);
    fold<4>(d, lane);
    fold<2>(d, lane);
    fold<1>(d, lane);
    return d[0] + __shfl_xor_sync(FFP_ALL_LANES, d[0], 16);
}

static __device__ inline float sum_lanes(float d) {
#pragma unroll
    for (int step = 0; step < 5; step++) d += __shfl_xor_sync(FFP_ALL_LANES, d, 16 >> step);
    return d;
}

// One splat at a warp's pixels, into the warp's sums; false where none of them sees it.
static __device__ inline bool splat_backward(const FfpDeviceSplat *splat, float firmness, Pixel *pixel,
                                             float sums[FFP_SPLAT_SUMS]) {
    const int lane = (int)threadIdx.x % FFP_WARP;
    const FfpCover c = ffp_cover_pixel(splat, pixel->x, pixel->y, firmness, &pixel->transmittance);
    if (!__any_sync(FFP_ALL_LANES, c.alpha > 0)) return false;
    float d[FFP_SPLAT_SUMS];
    for (int k = 0; k < FFP_SPLAT_SUMS; k++) d[k] = 0;
    if (c.alpha > 0) pixel_backward(splat, &c, firmness, pixel, d);
    const float first = sum_transposed(d, lane);
    if (lane < TRANSPOSED) sums[lane] = first;
    for (int k = TRANSPOSED; k < FFP_SPLAT_SUMS; k++) {
        const float sum = sum_lanes(d[k]);
        if (lane == k) sums[k] = sum;
    }
    return true;
}

// One warp's share of a batch; returns the splats that its pixels see.
static __device__ inline unsigned batch_backward(Batch *batch, int count, int4 warp_box, float firmness,
                                                 Pixel *pixel) {
    const int lane = (int)threadIdx.x % FFP_WARP, warp = (int)threadIdx.x / FFP_WARP;
    const bool meets = lane < count && ffp_boxes_meet(batch->box[lane], warp_box);
    unsigned touched = 0;
    for (unsigned left = __ballot_sync(FFP_ALL_LANES, meets); left; left &= left - 1) {
        const int i = __ffs((int)left) - 1;
        if (splat_backward(&batch->splat[i], firmness, pixel, batch->sums[warp][i])) touched |= 1u << i;
    }
    return touched;
}

// Sums over the warps into the slots of the batch's pairs.
static __device__ inline void fill_slots(const FfpTiling *t, const Batch *batch, int count) {
    const int row = 4 * FFP_SPLAT_QUADS;
    for (int e = (int)threadIdx.x; e < count * row; e += FFP_TILE_PIXELS) {
        const int i = e / row, k = e % row;
        float sum = 0;
        bool any = false;
        for (int w = 0; w < FFP_TILE_WARPS; w++) {
            if (!(batch->touched[w] >> i & 1)) continue;
            any = true;
            if (k < FFP_SPLAT_SUMS) sum += batch->sums[w][i][k];
        }
        if (!any) continue;
        const size_t pair = batch->pair[i];
        ((float *)&t->slots[pair])[k] = sum;
        if (k == 0) t->touched[pair] = 1;
    }
}

static __global__ void __launch_bounds__(FFP_TILE_PIXELS)
    blend_tiles_backward(FfpTiling t, FfpGbuffer out, FfpGbuffer grad) {
    __shared__ Batch batch;
    const FfpTilePixel at = ffp_tile_pixel(&t);
    const int64_t begin = t.tile_first[blockIdx.x], end = t.tile_first[blockIdx.x + 1];
    const int lane = (int)threadIdx.x % FFP_WARP, warp = (int)threadIdx.x / FFP_WARP;
    if (begin == end) return;
    Pixel pixel;
    load_pixel(&at, &out, &grad, &pixel);
    for (int64_t first = begin; first < end; first += BATCH) {
        const int count = end - first < BATCH ? (int)(end - first) : BATCH;
        const bool open = __any_sync(FFP_ALL_LANES, pixel.transmittance > 0);
        if (lane == 0) batch.open[warp] = open;
        __syncthreads();
        bool any = false;
        for (int w = 0; w < FFP_TILE_WARPS; w++) any = any || batch.open[w];
        if (!any) break;
        fetch_batch(&t, first, count, &batch);
        __syncthreads();
        const unsigned touched = open ? batch_backward(&batch, count, at.warp, t.firmness, &pixel) : 0;
        if (lane == 0) batch.touched[warp] = touched;
        __syncthreads();
        fill_slots(&t, &batch, count);
    }
}

void ffp_cuda_blend_backward(const FfpTiling *tiling, const FfpGbuffer *out, const FfpGbuffer *grad_out) {
    const dim3 tiles((unsigned)(tiling->tiles_x * tiling->tiles_y));
    ffp_launch_blocks(blend_tiles_backward, tiles, dim3(FFP_TILE_PIXELS), 0, *tiling, *out, *grad_out);
}
