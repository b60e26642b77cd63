// The render room's structs, and rasterising put together.
#include "render/render.h"
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "render/raster.h"

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

FfpRenderSettings ffp_render_settings(FfpDrawing drawing) {
    FfpRenderSettings settings = drawing.form == FFP_FORM_PAPER ? ffp_render_paper() : ffp_render_defaults();
    if (drawing.samples > 0) settings.samples = drawing.samples;
    return settings;
}

FfpGbuffer ffp_gbuffer_new(int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    return (FfpGbuffer){.width = width,
                        .height = height,
                        .opacity = ffp_alloc(pixels, sizeof(real)),
                        .depth = ffp_alloc(pixels, sizeof(real)),
                        .normal = ffp_alloc(pixels, 3 * sizeof(real)),
                        .albedo = ffp_alloc(pixels, 3 * sizeof(real)),
                        .roughness = ffp_alloc(pixels, sizeof(real)),
                        .ambient = ffp_alloc(pixels, 3 * sizeof(real)),
                        .distortion = ffp_alloc(pixels, sizeof(real))};
}

void ffp_gbuffer_clear(FfpGbuffer *g) {
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
    free(g->opacity);
    free(g->depth);
    free(g->normal);
    free(g->albedo);
    free(g->roughness);
    free(g->ambient);
    free(g->distortion);
    *g = (FfpGbuffer){0};
}

FfpMapping ffp_mapping_new(int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    return (FfpMapping){.width = width,
                        .height = height,
                        .uv = ffp_alloc(pixels, 2 * sizeof(real)),
                        .extent = ffp_alloc(pixels, 2 * sizeof(real)),
                        .visibility = ffp_alloc(pixels, sizeof(real))};
}

void ffp_mapping_free(FfpMapping *mapping) {
    free(mapping->uv);
    free(mapping->extent);
    free(mapping->visibility);
    *mapping = (FfpMapping){0};
}

FfpRaster *ffp_raster_new(void) {
    return ffp_alloc(1, sizeof(FfpRaster));
}

void ffp_raster_free(FfpRaster *raster) {
    if (!raster) return;
    free(raster->splats);
    free(raster->first);
    free(raster->counts);
    free(raster->tile_first);
    free(raster->keys);
    free(raster->swap);
    free(raster->order);
    free(raster->slots);
    free(raster->touched);
    ffp_gbuffer_free(&raster->shadow);
    free(raster);
}

void ffp_raster_reserve(void **block, size_t *held, size_t count, size_t size) {
    if (count <= *held / size) return;
    free(*block);
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
    fit_to(raster, camera, settings);
    ffp_project_splats(raster, gaussians, camera, settings);
    ffp_bin_splats(raster);
    ffp_blend(raster, out->normal ? FFP_CHANNELS : FFP_SHADOW_CHANNELS, out);
}

void ffp_rasterise_backward(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                            const FfpRenderSettings *settings, const FfpGbuffer *out,
                            const FfpGbuffer *grad_out, FfpGaussians *grad) {
    ffp_blend_backward(raster, out, grad_out);
    ffp_project_splats_backward(raster, gaussians, camera, settings, grad);
}
