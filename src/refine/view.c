// A view under black, white and the patterns, against its photographs.
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/vec.h"
#include "loss/loss.h"
#include "loss/metrics.h"
#include "refine/fit.h"

struct FfpViewer {
    const FfpCapture *capture;
    const FfpRefineSettings *settings;
    int n_patterns;
    const int *patterns;
    FfpSummed *light;  // [n_patterns]
    FfpImage *targets; // [n_views,n_patterns] encoded
    FfpRaster *raster, *shadow_raster;
    // of one view, remade when the picture's size changes:
    FfpGbuffer gbuffer, grad_gbuffer;
    FfpMapping mapping;
    FfpImage linear, encoded, grad;
};

FfpViewer *ffp_viewer_new(const FfpCapture *capture, const int *patterns, int n_patterns,
                          const FfpRefineSettings *settings) {
    FfpViewer *v = ffp_alloc(1, sizeof *v);
    *v = (FfpViewer){.capture = capture,
                     .settings = settings,
                     .n_patterns = n_patterns,
                     .patterns = patterns,
                     .light = ffp_alloc((size_t)n_patterns, sizeof *v->light),
                     .targets = ffp_alloc((size_t)capture->n_views * n_patterns, sizeof *v->targets),
                     .raster = ffp_raster_new(),
                     .shadow_raster = ffp_raster_new()};
    for (int p = 0; p < n_patterns; p++) v->light[p] = ffp_summed_new(&capture->patterns[patterns[p]].image);
    for (int i = 0; i < capture->n_views * n_patterns; i++) {
        v->targets[i] = ffp_image_copy(&capture->views[i / n_patterns].images[patterns[i % n_patterns]]);
        ffp_image_to_srgb(&v->targets[i]);
    }
    return v;
}

static void free_view_buffers(FfpViewer *v) {
    ffp_gbuffer_free(&v->gbuffer);
    ffp_gbuffer_free(&v->grad_gbuffer);
    ffp_mapping_free(&v->mapping);
    ffp_image_free(&v->linear);
    ffp_image_free(&v->encoded);
    ffp_image_free(&v->grad);
}

void ffp_viewer_free(FfpViewer *v) {
    if (!v) return;
    for (int p = 0; p < v->n_patterns; p++) ffp_summed_free(&v->light[p]);
    for (int i = 0; i < v->capture->n_views * v->n_patterns; i++) ffp_image_free(&v->targets[i]);
    free(v->light);
    free(v->targets);
    free_view_buffers(v);
    ffp_raster_free(v->raster);
    ffp_raster_free(v->shadow_raster);
    free(v);
}

static void fit_view_buffers(FfpViewer *v, int width, int height) {
    if (v->gbuffer.width == width && v->gbuffer.height == height) return;
    free_view_buffers(v);
    v->gbuffer = ffp_gbuffer_new(width, height);
    v->grad_gbuffer = ffp_gbuffer_new(width, height);
    v->mapping = ffp_mapping_new(width, height);
    v->linear = ffp_image_new(width, height, 3);
    v->encoded = ffp_image_new(width, height, 3);
    v->grad = ffp_image_new(width, height, 3);
}

// Shades the view in the buffers under pattern p; adds the picture's terms, and their gradient to the
// G-buffer's.
static void compare(FfpViewer *v, const FfpView *view, int p, const FfpImage *target, FfpFitLoss *loss) {
    const FfpRefineSettings *s = v->settings;
    const real share = 1 / (real)v->n_patterns;
    const FfpSummed *light = v->patterns[p] == v->capture->black ? NULL : &v->light[p];
    const size_t size = sizeof(real) * (size_t)v->linear.width * v->linear.height * 3;
    ffp_shade(&v->gbuffer, &v->mapping, &view->camera, &view->projector, v->capture->intensity, light,
              &v->linear);
    memcpy(v->encoded.data, v->linear.data, size);
    ffp_image_to_srgb(&v->encoded);
    memset(v->grad.data, 0, size);
    loss->total += ffp_l1_loss(&v->encoded, target, share * s->l1, &v->grad);
    loss->total += ffp_ssim_loss(&v->encoded, target, share * s->ssim, &v->grad);
    loss->psnr += ffp_psnr(&v->encoded, target) * (double)share;
    ffp_srgb_encode_backward(&v->linear, &v->grad);
    ffp_shade_backward(&v->gbuffer, &v->mapping, &view->camera, &view->projector, v->capture->intensity,
                       light, &v->grad, &v->grad_gbuffer, NULL, NULL);
}

// The terms that look at G-buffers.
static double regularise(FfpViewer *v, const FfpView *view, int64_t step) {
    const FfpRefineSettings *s = v->settings;
    const FfpGbuffer *g = &v->gbuffer;
    FfpGbuffer *d = &v->grad_gbuffer;
    const int pixels = g->width * g->height;
    const real *mask = view->coverage.data;
    double total = ffp_mask_loss(g->opacity, mask, pixels, s->mask, d->opacity);
    if (s->roughness_smooth > 0)
        total += ffp_roughness_loss(g->roughness, g->albedo, g->opacity, mask, g->width, g->height,
                                    s->roughness_smooth, d->roughness, d->opacity);
    if (s->normal_smooth > 0)
        total += ffp_normal_smooth_loss(g->normal, mask, g->width, g->height, s->normal_smooth, d->normal);
    if (s->distortion > 0 && step >= s->distortion_from)
        total += ffp_distortion_loss(g->distortion, pixels, s->distortion, d->distortion);
    return total;
}

FfpFitLoss ffp_viewer_look(FfpViewer *v, const FfpGaussians *gaussians, int view_index, int64_t step,
                           FfpGaussians *grad) {
    const FfpView *view = &v->capture->views[view_index];
    const FfpRenderSettings *render = &v->settings->render;
    FfpFitLoss loss = {0};
    fit_view_buffers(v, view->camera.width, view->camera.height);
    ffp_rasterise(v->raster, gaussians, &view->camera, render, &v->gbuffer);
    ffp_map_to_projector(v->shadow_raster, gaussians, &v->gbuffer, &view->camera, &view->projector, render,
                         &v->mapping);
    ffp_gbuffer_clear(&v->grad_gbuffer);
    for (int p = 0; p < v->n_patterns; p++)
        compare(v, view, p, &v->targets[view_index * v->n_patterns + p], &loss);
    loss.total += regularise(v, view, step);
    if (grad)
        ffp_rasterise_backward(v->raster, gaussians, &view->camera, render, &v->gbuffer, &v->grad_gbuffer,
                               grad);
    return loss;
}
