#include "engine/pipeline/correspondence.h"
#include <stdio.h>
#include "core/base/memory.h"
#include "engine/apply/view_maps.h"
#include "engine/pipeline/need.h"
#include "engine/pipeline/relight.h"

FfpImages *ffp_warps_draw(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                          FfpDrawing drawing, FfpWarpStats *stats) {
    const FfpRenderSettings settings = ffp_drawing_settings(drawing, NULL);
    FfpViewMapStats found = {.lit_share = 0};
    FfpImages *images = ffp_view_maps(gaussians, capture, view, &settings, &found);
    *stats = (FfpWarpStats){.lit_pixels = found.trip.pixels,
                            .lost_pixels = found.trip.lost,
                            .within_half = found.trip.within_half,
                            .median = found.trip.median,
                            .most = found.trip.most,
                            .lit_share = found.lit_share};
    snprintf(stats->view, sizeof stats->view, "%s", view->id);
    return images;
}

bool ffp_warps_fit(const FfpGaussians *gaussians, const FfpView *view, FfpDrawing drawing, FfpError *err) {
    const int samples = ffp_drawing_settings(drawing, NULL).samples;
    return ffp_memory_suffices(ffp_warps_bytes((double)gaussians->count, view, samples), "maps of this size",
                               "use a smaller camera picture or pattern", view->id, err);
}

FfpImages *ffp_warps_of_view(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                             FfpDrawing drawing, FfpWarpStats *stats, FfpError *err) {
    FfpWarpStats found;
    const FfpImage *white = &capture->patterns[capture->white].image;
    const FfpCamera *projector = &view->projector;
    if (white->width != projector->width || white->height != projector->height) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "%d x %d pixels are not the capture's %d x %d",
                 projector->width, projector->height, white->width, white->height);
        return NULL;
    }
    if (!ffp_warps_fit(gaussians, view, drawing, err)) return NULL;
    FfpImages *images = ffp_warps_draw(gaussians, capture, view, drawing, &found);
    if (stats) *stats = found;
    return images;
}
