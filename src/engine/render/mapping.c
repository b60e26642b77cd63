// All pixels of a G-buffer to the projector (map_pixel.h), and the shadow map.
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/capture/project.h"
#include "engine/render/kernels/kernels.h"
#include "engine/render/table.h"

// The projector as a camera whose longer side has `side` pixels.
static FfpCamera shadow_camera(const FfpCamera *projector, int side) {
    FfpCamera c = *projector;
    const int longer = c.width > c.height ? c.width : c.height;
    c.width = c.width * side / longer;
    c.height = c.height * side / longer;
    c.width = c.width > 0 ? c.width : 1;
    c.height = c.height > 0 ? c.height : 1;
    const real sx = (real)c.width / (real)projector->width, sy = (real)c.height / (real)projector->height;
    c.fx *= sx;
    c.cx *= sx;
    c.fy *= sy;
    c.cy *= sy;
    return c;
}

FfpGbuffer ffp_shadow_map(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *projector,
                          const FfpRenderSettings *settings) {
    if (!settings->shadows || ffp_shadows_are_baked(gaussians, projector->pose)) return (FfpGbuffer){0};
    const FfpCamera camera = shadow_camera(projector, settings->shadow_side > 0 ? settings->shadow_side : 1);
    FfpGbuffer *shadow = &raster->shadow;
    if (shadow->width != camera.width || shadow->height != camera.height) {
        ffp_gbuffer_free(shadow);
        const size_t pixels = (size_t)camera.width * (size_t)camera.height;
        shadow->width = camera.width;
        shadow->height = camera.height;
        shadow->opacity = ffp_memory_new(pixels, sizeof(real));
        shadow->depth = ffp_memory_new(pixels, sizeof(real));
    }
    ffp_rasterise(raster, gaussians, &camera, settings, shadow);
    return *shadow;
}

// Centres on the CPU; *owned: to be freed, or NULL.
static const real *centres_here(const FfpGaussians *gaussians, real **owned) {
    const size_t numbers = 3 * (size_t)gaussians->count;
    *owned = NULL;
    if (!ffp_device()) return gaussians->centre;
    *owned = ffp_alloc(numbers, sizeof **owned);
    ffp_memory_download(*owned, gaussians->centre, numbers * sizeof **owned);
    return *owned;
}

// How far the projector is from the mean of the centres.
static real distance_to_middle(const FfpGaussians *gaussians, const FfpCamera *projector) {
    const size_t count = (size_t)gaussians->count;
    real *host, square = 0;
    const real *centre = centres_here(gaussians, &host);
    for (int k = 0; k < 3; k++) {
        double sum = 0;
        for (size_t i = 0; i < count; i++) sum += (double)centre[3 * i + (size_t)k];
        const real off = projector->pose[4 * k + 3] - (real)(sum / (double)(count ? count : 1));
        square += off * off;
    }
    ffp_free(host);
    return sqrt(square);
}

real ffp_even_light(const FfpGaussians *gaussians, const FfpCamera *projector,
                    const FfpRenderSettings *settings) {
    return settings->even_light ? distance_to_middle(gaussians, projector) : 0;
}

void ffp_lit_box(const FfpGaussians *gaussians, const FfpCamera *projector, real lit[4]) {
    const real width = (real)projector->width, height = (real)projector->height;
    real low[2] = {width, height}, high[2] = {0, 0}, *host = NULL;
    const real *centre = gaussians->scatters ? centres_here(gaussians, &host) : NULL;
    for (int64_t i = 0; centre && i < gaussians->count; i++) {
        real at[2];
        if (!(ffp_project(projector, centre + 3 * i, &at[0], &at[1]) > 0)) continue;
        for (int k = 0; k < 2; k++) low[k] = fmin(low[k], at[k]), high[k] = fmax(high[k], at[k]);
    }
    ffp_free(host);
    low[0] = fmax(low[0], (real)0), low[1] = fmax(low[1], (real)0);
    high[0] = fmin(high[0], width), high[1] = fmin(high[1], height);
    const bool none = !(high[0] > low[0] && high[1] > low[1]);
    lit[0] = none ? width / 2 : (low[0] + high[0]) / 2, lit[1] = none ? height / 2 : (low[1] + high[1]) / 2;
    lit[2] = none ? width : high[0] - low[0], lit[3] = none ? height : high[1] - low[1];
}

void ffp_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                         const FfpCamera *projector, const FfpRenderSettings *settings, FfpMapping *out) {
    if (ffp_render_table()) {
        ffp_render_table()->map_with_shadow(shadow, gbuffer, camera, projector, settings, out);
        return;
    }
    const FfpMapper m = {gbuffer, camera, projector, settings, *shadow};
    FfpMapRow *map = ffp_render_kernels()->map_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++) map(&m, y, out);
}

void ffp_map_to_projector(FfpRaster *raster, const FfpGaussians *gaussians, const FfpGbuffer *gbuffer,
                          const FfpCamera *camera, const FfpCamera *projector,
                          const FfpRenderSettings *settings, FfpMapping *out) {
    const FfpGbuffer shadow = ffp_shadow_map(raster, gaussians, projector, settings);
    out->even = ffp_even_light(gaussians, projector, settings);
    ffp_lit_box(gaussians, projector, out->lit);
    ffp_map_with_shadow(&shadow, gbuffer, camera, projector, settings, out);
}
