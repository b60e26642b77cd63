// The rasteriser's memory, kept from view to view.
#include "engine/render/raster.h"
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/render/table.h"

FfpRaster *ffp_raster_new(void) {
    FfpRaster *raster = ffp_alloc(1, sizeof *raster);
    if (!ffp_render_table()) return raster;
    raster->device = ffp_render_table()->raster_new();
    ffp_own(raster->device, ffp_render_table()->raster_free);
    return raster;
}

void ffp_raster_free(FfpRaster *raster) {
    if (!raster) return;
    ffp_disown(raster->device);
    if (raster->device) ffp_render_table()->raster_free(raster->device);
    ffp_free(raster->splats);
    ffp_free(raster->first);
    ffp_free(raster->counts);
    ffp_free(raster->tile_first);
    ffp_free(raster->keys);
    ffp_free(raster->swap);
    ffp_free(raster->order);
    ffp_free(raster->slots);
    ffp_free(raster->touched);
    ffp_gbuffer_free(&raster->shadow);
    ffp_free(raster);
}

void ffp_raster_reserve(void **block, size_t *held, size_t count, size_t size) {
    if (count <= *held / size) return;
    ffp_free(*block);
    *block = NULL;
    *held = 0;
    const size_t roomy = count + count / 4; // views differ a little: do not reallocate for each
    *block = ffp_take(roomy, size);
    *held = roomy * size;
}
