#include "engine/apply/view_maps.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/log.h"
#include "engine/apply/surface.h"
#include "engine/render/strip.h"

// u, v and the share of the light that comes through; -1 -1 0 without a surface inside the pattern. Of the
// pair's first rows, into `map` [rows, width, 3].
static void forward_map(const FfpProCams *procams, int rows, real *map) {
    const FfpCameraView *camera_view = &procams->camera_views[0];
    const FfpMapping *mapping = &procams->links[0].mapping;
    const FfpCamera *projector = &procams->projections[0].view->projector;
    const size_t pixels = (size_t)mapping->width * (size_t)rows;
    for (size_t p = 0; p < pixels; p++) {
        const real *uv = mapping->uv + 2 * p;
        const bool there = camera_view->depth.data[p] > 0 && uv[0] > 0 && uv[1] > 0 &&
                           uv[0] < (real)projector->width && uv[1] < (real)projector->height;
        const real pixel[3] = {there ? uv[0] : -1, there ? uv[1] : -1, there ? mapping->visibility[p] : 0};
        memcpy(map + 3 * p, pixel, sizeof pixel);
    }
}

typedef struct Correspondences {
    FfpImage forward, inverse, lit; // lit: depths of the camera's lit pixels
} Correspondences;

// Rows from `top` on: what they add to the maps. One more is drawn, for the cells between them and the next.
static void add_strip(Correspondences *maps, const FfpGaussians *gaussians, const FfpCapture *capture,
                      const FfpView *view, const FfpRenderSettings *settings, int top) {
    const FfpCamera *camera = &view->camera;
    const size_t width = (size_t)camera->width, first = (size_t)top * width;
    const int rows = ffp_strip_of(camera, top, ffp_strip_rows(camera)).height;
    FfpView part = {.camera = ffp_strip_of(camera, top, rows + 1), .projector = view->projector};
    const FfpView *parts = &part;
    FfpProCams procams = ffp_procams_new(gaussians, capture, &parts, 1, settings, false);
    FfpImage lit = ffp_procams_lit_depth(&procams, 0, 0);
    forward_map(&procams, rows, maps->forward.data + 3 * first);
    ffp_inverse_draw(&maps->inverse, &lit, &part.camera, &part.projector, top);
    memcpy(maps->lit.data + first, lit.data, (size_t)rows * width * sizeof *lit.data);
    ffp_image_free(&lit);
    ffp_procams_free(&procams);
}

static void add_correspondences(FfpImages *images, const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpView *view, const FfpRenderSettings *settings,
                                FfpViewMapStats *stats) {
    const FfpCamera *camera = &view->camera;
    const int rows = ffp_strip_rows(camera);
    Correspondences maps = {.forward = ffp_image_new(camera->width, camera->height, 3),
                            .inverse = ffp_inverse_new(&view->projector),
                            .lit = ffp_image_new(camera->width, camera->height, 1)};
    const FfpTask task = ffp_task("mapping", camera->height);
    for (int top = 0; top < camera->height; top += rows) {
        add_strip(&maps, gaussians, capture, view, settings, top);
        ffp_task_step(&task, top + rows < camera->height ? top + rows : camera->height, NULL);
    }
    ffp_task_end(&task);
    stats->trip = ffp_round_trip(camera, &view->projector, &maps.lit, &maps.inverse);
    ffp_image_free(&maps.lit);
    const size_t pixels = (size_t)maps.inverse.width * (size_t)maps.inverse.height;
    for (size_t p = 0; p < pixels; p++) maps.inverse.data[3 * p + 2] = maps.inverse.data[3 * p] >= 0;
    ffp_images_add(images, maps.forward, "camera_to_projector", NULL);
    ffp_images_add(images, maps.inverse, "projector_to_camera", NULL);
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
    add_correspondences(images, gaussians, capture, view, settings, stats);
    FfpLitSurface surface = ffp_lit_surface_new(gaussians, &view->projector, settings);
    ffp_images_add(images, projector_sees(&surface, gaussians, capture, &view->projector, settings),
                   "projector_sees", NULL);
    add_light(images, &surface, view, stats);
    ffp_lit_surface_free(&surface);
    return images;
}
