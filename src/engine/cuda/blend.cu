// Front-to-back blending: a block a tile, a thread a pixel. The block takes splats into shared memory in
// batches; each warp asks 32 of them at a time which touch its pixels, and blends those alone.
#include "engine/cuda/launch.h"
#include "engine/cuda/tile.h"

enum { BATCH = FFP_TILE_PIXELS };

// A batch of the tile's splats.
typedef struct Batch {
    FfpDeviceSplat splat[BATCH];
    int4 box[BATCH];
    bool open[FFP_TILE_WARPS]; // warps that have not come to their end
} Batch;

static __device__ inline void fetch_splat(const FfpTiling *t, int64_t place, int at, Batch *batch) {
    const uint32_t splat = t->owners[t->order[place]];
    const float4 *from = (const float4 *)&t->splats[splat];
    float4 *to = (float4 *)&batch->splat[at];
    for (int q = 0; q < FFP_SPLAT_QUADS; q++) to[q] = from[q];
    batch->box[at] = t->boxes[splat];
}

// Called by all of the block: true if there is a warp left to draw.
static __device__ inline bool any_open(const Batch *batch) {
    __syncthreads();
    bool any = false;
    for (int w = 0; w < FFP_TILE_WARPS; w++) any = any || batch->open[w];
    return any;
}

// A pixel while it is blended.
typedef struct Sums {
    float transmittance, distortion, value[FFP_CHANNELS];
} Sums;

// Distortion: each splat's pairs with those in front of it, twice: 2 w (z sum w_j - sum w_j z_j).
template <int CHANNELS>
static __device__ inline void blend_splat(const FfpDeviceSplat *splat, float x, float y, float firmness,
                                          Sums *s) {
    const FfpCover c = ffp_cover_pixel(splat, x, y, firmness, &s->transmittance);
    if (!(c.alpha > 0)) return;
    const float w = c.alpha * c.before;
    if (CHANNELS > FFP_SHADOW_CHANNELS)
        s->distortion += 2 * w * (splat->value[FFP_CHANNEL_DEPTH - 1] * s->value[0] - s->value[1]);
    s->value[0] += w;
    for (int k = 1; k < CHANNELS; k++) s->value[k] += splat->value[k - 1] * w;
}

// One warp's share of a batch; false: all its pixels have come to their end.
template <int CHANNELS>
static __device__ inline bool blend_batch(const Batch *batch, int count, const FfpTilePixel *pixel,
                                          float firmness, Sums *sums) {
    const int lane = (int)threadIdx.x % FFP_WARP;
    const float x = (float)pixel->x + 0.5F, y = (float)pixel->y + 0.5F;
    for (int group = 0; group < count; group += FFP_WARP) {
        const int mine = group + lane;
        const bool meets = mine < count && ffp_boxes_meet(batch->box[mine], pixel->warp);
        for (unsigned left = __ballot_sync(FFP_ALL_LANES, meets); left; left &= left - 1)
            blend_splat<CHANNELS>(&batch->splat[group + __ffs((int)left) - 1], x, y, firmness, sums);
        if (!__any_sync(FFP_ALL_LANES, sums->transmittance > 0)) return false;
    }
    return true;
}

template <int CHANNELS>
static __global__ void __launch_bounds__(FFP_TILE_PIXELS) blend_tiles(FfpTiling t, FfpGbuffer out) {
    __shared__ Batch batch;
    const FfpTilePixel pixel = ffp_tile_pixel(&t);
    const int64_t end = t.tile_first[blockIdx.x + 1];
    const int thread = (int)threadIdx.x, warp = thread / FFP_WARP;
    Sums sums;
    sums.transmittance = pixel.index < 0 ? 0 : 1;
    sums.distortion = 0;
    for (int k = 0; k < CHANNELS; k++) sums.value[k] = 0;
    bool open = __any_sync(FFP_ALL_LANES, pixel.index >= 0);
    for (int64_t first = t.tile_first[blockIdx.x]; first < end; first += BATCH) {
        const int count = end - first < BATCH ? (int)(end - first) : BATCH;
        if (thread % FFP_WARP == 0) batch.open[warp] = open;
        if (!any_open(&batch)) break;
        if (thread < count) fetch_splat(&t, first + thread, thread, &batch);
        __syncthreads();
        if (open) open = blend_batch<CHANNELS>(&batch, count, &pixel, t.firmness, &sums);
    }
    if (pixel.index < 0) return;
    for (int k = 0; k < CHANNELS; k++) *ffp_channel(&out, k, pixel.index) = sums.value[k];
    if (CHANNELS > FFP_SHADOW_CHANNELS) out.distortion[pixel.index] = sums.distortion;
}

void ffp_cuda_blend(const FfpTiling *tiling, FfpGbuffer *out) {
    const dim3 tiles((unsigned)(tiling->tiles_x * tiling->tiles_y));
    if (out->normal && !out->scattered)
        ffp_launch_blocks(blend_tiles<FFP_DIRECT_CHANNELS>, tiles, dim3(FFP_TILE_PIXELS), 0, *tiling, *out);
    else if (out->normal)
        ffp_launch_blocks(blend_tiles<FFP_CHANNELS>, tiles, dim3(FFP_TILE_PIXELS), 0, *tiling, *out);
    else
        ffp_launch_blocks(blend_tiles<FFP_SHADOW_CHANNELS>, tiles, dim3(FFP_TILE_PIXELS), 0, *tiling, *out);
}
