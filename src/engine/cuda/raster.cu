// Rasterising put together, and which splats each tile has to draw, near to far.
#include "engine/cuda/launch.h"
#include "engine/cuda/memory.h"
#include "engine/cuda/raster.h"
#include "engine/cuda/render.h"
extern "C" {
#include "core/base/alloc.h"
}

FfpDeviceRaster *ffp_cuda_raster_new() {
    return (FfpDeviceRaster *)ffp_alloc(1, sizeof(FfpDeviceRaster));
}

void ffp_cuda_raster_free(void *thing) {
    FfpDeviceRaster *raster = (FfpDeviceRaster *)thing;
    FfpTiling *t = &raster->tiling;
    void *blocks[] = {t->splats, t->boxes, t->counts,      t->first,      t->owners, t->places,
                      t->order,  t->keys,  t->sorted_keys, t->tile_first, t->slots,  t->touched};
    for (void *block : blocks) ffp_cuda_release(block);
    ffp_cuda_release(raster->scratch.block);
    ffp_free(raster);
}

// Makes *block hold at least `count`, and a quarter more when it has to grow: views differ a little.
template <typename T> static void reserve(T **block, size_t *held, size_t count) {
    if (count * sizeof(T) > *held) ffp_cuda_grow(block, held, (count + count / 4) * sizeof(T));
}

static void fit_to(FfpDeviceRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                   const FfpRenderSettings *settings) {
    FfpTiling *t = &raster->tiling;
    const size_t n = (size_t)gaussians->count;
    t->width = camera->width;
    t->height = camera->height;
    t->tiles_x = (camera->width + FFP_TILE - 1) / FFP_TILE;
    t->tiles_y = (camera->height + FFP_TILE - 1) / FFP_TILE;
    t->firmness = settings->firmness;
    t->gaussians = gaussians->count;
    reserve(&t->splats, &raster->splats_size, n + 1);
    reserve(&t->boxes, &raster->boxes_size, n + 1);
    reserve(&t->counts, &raster->counts_size, n + 1);
    reserve(&t->first, &raster->first_size, n + 1);
    reserve(&t->tile_first, &raster->tile_first_size, (size_t)t->tiles_x * (size_t)t->tiles_y + 1);
}

static void reserve_pairs(FfpDeviceRaster *raster) {
    FfpTiling *t = &raster->tiling;
    const size_t pairs = (size_t)t->pairs;
    const size_t a_pair = sizeof *t->owners + sizeof *t->places + sizeof *t->order + 2 * sizeof *t->keys;
    if (pairs >= UINT32_MAX) ffp_no_memory(pairs * a_pair); // places have 32 bits
    reserve(&t->owners, &raster->owners_size, pairs + 1);
    reserve(&t->places, &raster->places_size, pairs + 1);
    reserve(&t->order, &raster->order_size, pairs + 1);
    reserve(&t->keys, &raster->keys_size, pairs + 1);
    reserve(&t->sorted_keys, &raster->sorted_keys_size, pairs + 1);
}

// One thread a pair: whose it is, by bisection, and which of its tiles.
static __global__ void fill_pairs(size_t pairs, FfpTiling t) {
    const size_t i = ffp_thread();
    if (i >= pairs) return;
    int64_t low = 0, high = t.gaussians; // first[low] <= i < first[high]
    while (high - low > 1) {
        const int64_t middle = (low + high) / 2;
        if (t.first[middle] <= (int64_t)i)
            low = middle;
        else
            high = middle;
    }
    const int4 tiles = ffp_box_tiles(t.boxes[low]);
    const int k = (int)((int64_t)i - t.first[low]), across = tiles.z - tiles.x;
    const unsigned tile = (unsigned)((tiles.y + k / across) * t.tiles_x + tiles.x + k % across);
    t.owners[i] = (uint32_t)low;
    t.places[i] = (uint32_t)i;
    t.keys[i] = (uint64_t)tile << 32 | __float_as_uint(t.splats[low].value[FFP_CHANNEL_DEPTH - 1]);
}

// One thread a tile, and one for the end: the first pair that is not earlier tile's.
static __global__ void find_tiles(size_t count, FfpTiling t) {
    const size_t tile = ffp_thread();
    if (tile >= count) return;
    int64_t low = 0, high = t.pairs;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (t.sorted_keys[middle] >> 32 < tile)
            low = middle + 1;
        else
            high = middle;
    }
    t.tile_first[tile] = low;
}

static void bin_splats(FfpDeviceRaster *raster) {
    FfpTiling *t = &raster->tiling;
    const size_t tiles = (size_t)t->tiles_x * (size_t)t->tiles_y;
    int bits = 32;
    while ((tiles - 1) >> (bits - 32)) bits++;
    ffp_cuda_sums_before(t->counts, t->first, (size_t)t->gaussians + 1, &raster->scratch);
    ffp_cuda_download(&t->pairs, t->first + t->gaussians, sizeof t->pairs);
    reserve_pairs(raster);
    ffp_launch_each((size_t)t->pairs, fill_pairs, *t);
    if (t->pairs)
        ffp_cuda_sort_pairs(t->keys, t->sorted_keys, t->places, t->order, (size_t)t->pairs, bits,
                            &raster->scratch);
    ffp_launch_each(tiles + 1, find_tiles, *t);
}

void ffp_cuda_rasterise(FfpDeviceRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings, FfpGbuffer *out) {
    const FfpDeviceView view = {*camera, settings->blur, settings->firmness, settings->compensation};
    fit_to(raster, gaussians, camera, settings);
    ffp_cuda_project(&raster->tiling, gaussians, &view);
    bin_splats(raster);
    ffp_cuda_blend(&raster->tiling, out);
}

void ffp_cuda_rasterise_backward(FfpDeviceRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 const FfpGbuffer *out, const FfpGbuffer *grad_out, FfpGaussians *grad) {
    const FfpDeviceView view = {*camera, settings->blur, settings->firmness, settings->compensation};
    FfpTiling *t = &raster->tiling;
    reserve(&t->slots, &raster->slots_size, (size_t)t->pairs + 1);
    reserve(&t->touched, &raster->touched_size, (size_t)t->pairs + 1);
    ffp_cuda_zero(t->touched, (size_t)t->pairs + 1);
    ffp_cuda_blend_backward(t, out, grad_out);
    ffp_cuda_project_backward(t, gaussians, &view, grad);
}
