// The render room's structs, and rasterising put together.
#include "render/render.h"
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/call.h"
#include "render/raster.h"
#include "render/table.h"

FfpRenderSettings ffp_render_defaults(void) {
    return (FfpRenderSettings){.samples = 2,
                               .blur = 0.002F,
                               .firmness = 1,
                               .footprint = true,
                               .shadows = true,
                               .shadow_side = 160,
                               .shadow_bias = 0.05F};
}

FfpRenderSettings ffp_render_paper(void) {
    return (FfpRenderSettings){.samples = 1, .blur = 0.3F, .shadow_side = 160, .shadow_bias = 0.02F};
}

FfpRenderSettings ffp_render_gs_procams(void) {
    FfpRenderSettings settings = ffp_render_paper();
    settings.even_light = true;
    return settings;
}

FfpRenderSettings ffp_render_settings(bool paper, int samples) {
    FfpRenderSettings settings = paper ? ffp_render_paper() : ffp_render_defaults();
    if (samples > 0) settings.samples = samples;
    return settings;
}

FfpGbuffer ffp_gbuffer_new(int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    return (FfpGbuffer){.width = width,
                        .height = height,
                        .opacity = ffp_memory_new(pixels, sizeof(real)),
                        .depth = ffp_memory_new(pixels, sizeof(real)),
                        .normal = ffp_memory_new(pixels, 3 * sizeof(real)),
                        .albedo = ffp_memory_new(pixels, 3 * sizeof(real)),
                        .roughness = ffp_memory_new(pixels, sizeof(real)),
                        .ambient = ffp_memory_new(pixels, 3 * sizeof(real)),
                        .distortion = ffp_memory_new(pixels, sizeof(real))};
}

void ffp_gbuffer_clear(FfpGbuffer *g) {
    if (ffp_render_table()) {
        ffp_render_table()->gbuffer_clear(g);
        return;
    }
    const size_t plane = (size_t)g->width * (size_t)g->height * sizeof(real);
    memset(g->opacity, 0, plane);
    memset(g->depth, 0, plane);
    memset(g->normal, 0, 3 * plane);
    memset(g->albedo, 0, 3 * plane);
    memset(g->roughness, 0, plane);
    memset(g->ambient, 0, 3 * plane);
    memset(g->distortion, 0, plane);
}

void ffp_gbuffer_free(FfpGbuffer *g) {
    ffp_memory_free(g->opacity);
    ffp_memory_free(g->depth);
    ffp_memory_free(g->normal);
    ffp_memory_free(g->albedo);
    ffp_memory_free(g->roughness);
    ffp_memory_free(g->ambient);
    ffp_memory_free(g->distortion);
    *g = (FfpGbuffer){0};
}

FfpMapping ffp_mapping_new(int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    return (FfpMapping){.width = width,
                        .height = height,
                        .uv = ffp_memory_new(pixels, 2 * sizeof(real)),
                        .extent = ffp_memory_new(pixels, 2 * sizeof(real)),
                        .visibility = ffp_memory_new(pixels, sizeof(real))};
}

void ffp_mapping_free(FfpMapping *mapping) {
    ffp_memory_free(mapping->uv);
    ffp_memory_free(mapping->extent);
    ffp_memory_free(mapping->visibility);
    *mapping = (FfpMapping){0};
}

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
    *block = NULL, *held = 0;
    const size_t roomy = count + count / 4; // views differ a little: do not allocate anew for each
    *block = ffp_alloc(roomy, size);
    *held = roomy * size;
}

static void fit_to(FfpRaster *raster, const FfpCamera *camera, const FfpRenderSettings *settings) {
    raster->width = camera->width, raster->height = camera->height;
    raster->firmness = settings->firmness;
    raster->tiles_x = (camera->width + FFP_TILE - 1) / FFP_TILE;
    raster->tiles_y = (camera->height + FFP_TILE - 1) / FFP_TILE;
}

void ffp_rasterise(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                   const FfpRenderSettings *settings, FfpGbuffer *out) {
    if (raster->device) {
        ffp_render_table()->rasterise(raster->device, gaussians, camera, settings, out);
        return;
    }
    fit_to(raster, camera, settings);
    ffp_project_splats(raster, gaussians, camera, settings);
    ffp_bin_splats(raster);
    ffp_blend(raster, out->normal ? FFP_CHANNELS : FFP_SHADOW_CHANNELS, out);
}

void ffp_rasterise_backward(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                            const FfpRenderSettings *settings, const FfpGbuffer *out,
                            const FfpGbuffer *grad_out, FfpGaussians *grad) {
    if (raster->device) {
        ffp_render_table()->rasterise_backward(raster->device, gaussians, camera, settings, out, grad_out,
                                               grad);
        return;
    }
    ffp_blend_backward(raster, out, grad_out);
    ffp_project_splats_backward(raster, gaussians, camera, settings, grad);
}
