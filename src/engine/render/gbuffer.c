#include "core/base/device.h"
#include "engine/render/render.h"
#include "engine/render/table.h"

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

void ffp_gbuffer_add_scattered(FfpGbuffer *g) {
    if (!g->scattered) g->scattered = ffp_memory_new((size_t)g->width * (size_t)g->height, 3 * sizeof(real));
}

void ffp_gbuffer_clear(FfpGbuffer *g) {
    if (ffp_render_table()) {
        ffp_render_table()->gbuffer_clear(g);
        return;
    }
    const size_t plane = (size_t)g->width * (size_t)g->height * sizeof(real);
    ffp_memory_zero(g->opacity, plane);
    ffp_memory_zero(g->depth, plane);
    ffp_memory_zero(g->normal, 3 * plane);
    ffp_memory_zero(g->albedo, 3 * plane);
    ffp_memory_zero(g->roughness, plane);
    ffp_memory_zero(g->ambient, 3 * plane);
    if (g->scattered) ffp_memory_zero(g->scattered, 3 * plane);
    ffp_memory_zero(g->distortion, plane);
}

void ffp_gbuffer_free(FfpGbuffer *g) {
    ffp_memory_free(g->opacity);
    ffp_memory_free(g->depth);
    ffp_memory_free(g->normal);
    ffp_memory_free(g->albedo);
    ffp_memory_free(g->roughness);
    ffp_memory_free(g->ambient);
    ffp_memory_free(g->scattered);
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
