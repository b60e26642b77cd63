#include "engine/apply/view_maps.h"
#include <string.h>
#include <tgmath.h>
#include "engine/apply/surface.h"

// u, v and the share of the light that comes through; -1 -1 0 without a surface inside the pattern.
static FfpImage forward_map(const FfpStage *stage) {
    const FfpCameraView *camera_view = &stage->camera_views[0];
    const FfpMapping *mapping = &stage->links[0].mapping;
    const FfpCamera *projector = &stage->projections[0].view->projector;
    FfpImage map = ffp_image_new(mapping->width, mapping->height, 3);
    for (int p = 0; p < map.width * map.height; p++) {
        const real *uv = mapping->uv + 2 * p;
        const bool there = camera_view->depth.data[p] > 0 && uv[0] > 0 && uv[1] > 0 &&
                           uv[0] < (real)projector->width && uv[1] < (real)projector->height;
        const real pixel[3] = {there ? uv[0] : -1, there ? uv[1] : -1, there ? mapping->visibility[p] : 0};
        memcpy(map.data + 3 * p, pixel, sizeof pixel);
    }
    return map;
}

static void add_correspondences(FfpImages *images, const FfpStage *stage, FfpViewMapStats *stats) {
    FfpImage inverse = ffp_stage_inverse(stage, 0, 0);
    stats->trip = ffp_stage_round_trip(stage, 0, 0, &inverse);
    for (int p = 0; p < inverse.width * inverse.height; p++)
        inverse.data[3 * p + 2] = inverse.data[3 * p] >= 0;
    ffp_images_add(images, forward_map(stage), "camera_to_projector", NULL);
    ffp_images_add(images, inverse, "projector_to_camera", NULL);
}

// The object from the projector's place, in its own white light.
static FfpImage projector_sees(const FfpLitSurface *surface, const FfpGaussians *gaussians,
                               const FfpCapture *capture, const FfpCamera *projector,
                               const FfpRenderSettings *settings) {
    FfpMapping mapping = ffp_mapping_new(projector->width, projector->height);
    FfpImage picture = ffp_image_new(projector->width, projector->height, 3);
    FfpSummed white = ffp_summed_new(&capture->patterns[capture->white].image);
    mapping.even = ffp_even_light(gaussians, projector, settings);
    for (int p = 0; p < mapping.width * mapping.height; p++) {
        mapping.visibility[p] = 1;
        mapping.extent[2 * p] = mapping.extent[2 * p + 1] = 1;
    }
    ffp_shade_once(&surface->gbuffer, &mapping, projector, projector, capture->intensity, &white, &picture);
    ffp_summed_free(&white);
    ffp_mapping_free(&mapping);
    return picture;
}

static void add_light(FfpImages *images, const FfpLitSurface *surface, const FfpView *view,
                      FfpViewMapStats *stats) {
    const int width = surface->depth.width, height = surface->depth.height;
    FfpImage lit = ffp_image_new(width, height, 1);
    FfpImage angle = ffp_image_new(width, height, 1);
    FfpImage density = ffp_image_new(width, height, 1);
    int count = 0;
    for (int p = 0; p < width * height; p++) {
        lit.data[p] = surface->cosine.data[p] > 0;
        angle.data[p] = lit.data[p] > 0 ? acos(surface->cosine.data[p]) * 57.2957795F : -1;
        count += lit.data[p] > 0;
    }
    stats->lit_share = (double)count / ((double)width * height);
    ffp_lit_surface_density(surface, &view->projector, &view->camera, &density);
    ffp_images_add(images, lit, "lit", NULL);
    ffp_images_add(images, angle, "incidence", NULL);
    ffp_images_add(images, density, "density", NULL);
    ffp_images_add(images, ffp_image_copy(&surface->resolution), "resolution", NULL);
    ffp_images_add(images, ffp_image_copy(&surface->illuminance), "illuminance", NULL);
}

FfpImages *ffp_view_maps(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                         const FfpRenderSettings *settings, FfpViewMapStats *stats) {
    FfpImages *images = ffp_images_new();
    FfpStage stage = ffp_stage_new(gaussians, capture, &view, 1, settings, false);
    add_correspondences(images, &stage, stats);
    ffp_stage_free(&stage);
    FfpLitSurface surface = ffp_lit_surface_new(gaussians, &view->projector, settings);
    ffp_images_add(images, projector_sees(&surface, gaussians, capture, &view->projector, settings),
                   "projector_sees", NULL);
    add_light(images, &surface, view, stats);
    ffp_lit_surface_free(&surface);
    return images;
}
