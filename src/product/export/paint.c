// Textures by a tile of their own for every quad. A tile's outermost texels lie on the quad's edges, so that
// neighbours hold the same colours there, and bilinear filtering never leaves the tile: there are no seams.
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "product/export/volume.h"

#define FACING_MIN 0.05F
#define CHANNELS 4 // albedo, roughness

static void texel_point(const FfpSurface *mesh, size_t quad, int i, int j, real point[3]) {
    const uint32_t *corners = mesh->quads + 4 * quad;
    const real s = (real)i / (FFP_TILE_TEXELS - 1), t = (real)j / (FFP_TILE_TEXELS - 1);
    const real share[4] = {(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t};
    for (int k = 0; k < 3; k++) {
        point[k] = 0;
        for (int c = 0; c < 4; c++) point[k] += share[c] * mesh->position[3 * (size_t)corners[c] + (size_t)k];
    }
}

static size_t texel_index(const FfpSurface *mesh, size_t quad, int i, int j) {
    const size_t across = (size_t)mesh->tiles_across, width = across * FFP_TILE_TEXELS;
    return (quad / across * FFP_TILE_TEXELS + (size_t)j) * width + quad % across * FFP_TILE_TEXELS +
           (size_t)i;
}

// Adds what a view sees at a point of the surface, unless something lies in the way.
static void add_look(const FfpDepthView *seen, const real point[3], real slack, real sum[CHANNELS + 1]) {
    const FfpGbuffer *g = &seen->gbuffer;
    real depth;
    const int pixel = ffp_depth_view_pixel(seen, point, &depth);
    if (pixel < 0 || !(g->opacity[pixel] > 0.5F)) return;
    const real opacity = g->opacity[pixel], facing = ffp_depth_view_facing(seen, pixel, point);
    if (fabs(g->depth[pixel] / opacity - depth) > slack || facing < FACING_MIN) return;
    const real weight = facing * facing;
    for (int k = 0; k < 3; k++) sum[k] += weight * g->albedo[3 * (size_t)pixel + (size_t)k] / opacity;
    sum[3] += weight * g->roughness[pixel] / opacity;
    sum[CHANNELS] += weight;
}

static void paint_quad(const FfpSurface *mesh, size_t quad, const FfpDepthView *seen, real slack,
                       real *sums) {
    for (int j = 0; j < FFP_TILE_TEXELS; j++)
        for (int i = 0; i < FFP_TILE_TEXELS; i++) {
            real point[3];
            texel_point(mesh, quad, i, j, point);
            add_look(seen, point, slack, sums + (CHANNELS + 1) * texel_index(mesh, quad, i, j));
        }
}

// Means; texels that no camera saw get the mean of all others.
static void settle(FfpSurface *mesh, const real *sums, size_t texels) {
    double mean[CHANNELS + 1] = {0};
    for (size_t i = 0; i < texels; i++) {
        const real *s = sums + (CHANNELS + 1) * i;
        for (int k = 0; k < CHANNELS && s[CHANNELS] > 0; k++) mean[k] += (double)(s[k] / s[CHANNELS]);
        mean[CHANNELS] += s[CHANNELS] > 0;
    }
    for (size_t i = 0; i < texels; i++) {
        const real *s = sums + (CHANNELS + 1) * i;
        real value[CHANNELS];
        for (int k = 0; k < CHANNELS; k++)
            value[k] = s[CHANNELS] > 0      ? s[k] / s[CHANNELS]
                       : mean[CHANNELS] > 0 ? (real)(mean[k] / mean[CHANNELS])
                                            : 0.5F;
        for (size_t k = 0; k < 3; k++) mesh->albedo.data[3 * i + k] = value[k];
        mesh->roughness.data[i] = value[3];
    }
}

void ffp_surface_paint(FfpSurface *mesh, const FfpDepthSource *source, const FfpVolume *volume) {
    mesh->tiles_across = (int)ceil(sqrt((double)mesh->n_quads));
    const int down = (int)((mesh->n_quads + (uint32_t)mesh->tiles_across - 1) / (uint32_t)mesh->tiles_across);
    mesh->albedo = ffp_image_new(mesh->tiles_across * FFP_TILE_TEXELS, down * FFP_TILE_TEXELS, 3);
    mesh->roughness = ffp_image_new(mesh->albedo.width, mesh->albedo.height, 1);
    const size_t texels = (size_t)mesh->albedo.width * (size_t)mesh->albedo.height;
    real *sums = ffp_alloc(texels, (CHANNELS + 1) * sizeof *sums);
    FfpTask progress = ffp_task("painting", source->capture->n_views);
    for (int v = 0; v < source->capture->n_views; v++) {
        FfpDepthView seen = ffp_depth_view(source, v, volume->cell);
#pragma omp parallel for schedule(static)
        for (size_t q = 0; q < mesh->n_quads; q++) paint_quad(mesh, q, &seen, volume->truncation, sums);
        ffp_depth_view_free(&seen);
        ffp_task_step(&progress, v + 1, source->capture->views[v].id);
    }
    ffp_task_end(&progress);
    settle(mesh, sums, texels);
    ffp_free(sums);
}
