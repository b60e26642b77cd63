// The forms of rendering, and rasterising put together.
#include "engine/render/render.h"
#include "engine/render/raster.h"
#include "engine/render/table.h"

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

static void fit_to(FfpRaster *raster, const FfpCamera *camera, const FfpRenderSettings *settings) {
    raster->width = camera->width;
    raster->height = camera->height;
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
    raster->channels = !out->normal     ? FFP_SHADOW_CHANNELS
                       : out->scattered ? FFP_CHANNELS
                                        : FFP_DIRECT_CHANNELS;
    ffp_blend(raster, raster->channels, out);
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
