// Correspondence maps and what the projector lights.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "api/arguments.h"
#include "api/images.h"
#include "api/memory.h"
#include "api/relight.h"
#include "apply/choose.h"
#include "apply/stage.h"
#include "apply/surface.h"
#include "base/file.h"
#include "base/log.h"
#include "base/call.h"

FfpMaps ffp_maps_defaults(void) {
    return (FfpMaps){.n_views = 0};
}

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

static void add_correspondences(FfpImages *images, const FfpStage *stage, FfpMapStats *stats) {
    FfpImage inverse = ffp_stage_inverse(stage, 0, 0);
    const FfpRoundTrip trip = ffp_stage_round_trip(stage, 0, 0, &inverse);
    stats->lit_pixels = trip.pixels, stats->lost_pixels = trip.lost;
    stats->within_half = trip.within_half, stats->median = trip.median, stats->most = trip.most;
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
                      FfpMapStats *stats) {
    const int width = surface->depth.width, height = surface->depth.height;
    FfpImage lit = ffp_image_new(width, height, 1), angle = ffp_image_new(width, height, 1);
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

static FfpImages *map_view(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                           FfpDrawing drawing, FfpMapStats *stats) {
    const FfpRenderSettings settings = ffp_drawing_settings(drawing, NULL);
    FfpImages *images = ffp_images_new();
    FfpStage stage = ffp_stage_new(gaussians, capture, &view, 1, &settings, false);
    add_correspondences(images, &stage, stats);
    ffp_stage_free(&stage);
    FfpLitSurface surface = ffp_lit_surface_new(gaussians, &view->projector, &settings);
    ffp_images_add(images, projector_sees(&surface, gaussians, capture, &view->projector, &settings),
                   "projector_sees", NULL);
    add_light(images, &surface, view, stats);
    ffp_lit_surface_free(&surface);
    snprintf(stats->view, sizeof stats->view, "%s", view->id);
    return images;
}

static FfpImages *map_devices(const FfpGaussians *gaussians, const FfpCapture *capture,
                              const FfpPinhole *camera, const FfpPinhole *projector, FfpDrawing drawing,
                              FfpMapStats *stats, FfpError *err) {
    FfpView view = {.id = "view"};
    FfpMapStats found = {0};
    const FfpImage *white = &capture->patterns[capture->white].image;
    if (!ffp_camera_of(&view.camera, camera, 1, "camera", err) ||
        !ffp_camera_of(&view.projector, projector, 1, "projector", err))
        return NULL;
    if (white->width != projector->width || white->height != projector->height) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "%d x %d pixels are not the capture's %d x %d",
                 projector->width, projector->height, white->width, white->height);
        return NULL;
    }
    FfpImages *images = map_view(gaussians, capture, &view, drawing, &found);
    if (stats) *stats = found;
    return images;
}

// --- Files. ---

typedef struct Writer {
    FfpOutput folder;
    const char *view;
    int written;
} Writer;

static bool write_map(Writer *writer, const FfpImage *image, const char *name, const char *ending,
                      FfpError *err) {
    char path[FFP_PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s_%s%s", writer->folder.temporary, writer->view, name, ending) >=
        FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, writer->folder.path, "the path of %s_%s is too long",
                        writer->view, name);
    writer->written++;
    if (strcmp(ending, ".exr") == 0) return ffp_image_write_exr(image, path, err);
    return image->channels == 4 ? ffp_image_write_png16(image, path, err)
                                : ffp_image_write_png(image, path, err);
}

// A correspondence map [.,3] (x, y, third; x < 0: none) as a 16-bit PNG: x and y as shares of the other
// device's size, the third as it stands, alpha 0 where there is nothing.
static bool write_shares(Writer *writer, const FfpImage *map, const FfpCamera *to, const char *name,
                         FfpError *err) {
    FfpImage picture = ffp_image_new(map->width, map->height, 4);
    for (int p = 0; p < map->width * map->height; p++) {
        const real *from = map->data + 3 * p;
        if (from[0] < 0) continue;
        const real pixel[4] = {from[0] / (real)to->width, from[1] / (real)to->height, from[2], 1};
        memcpy(picture.data + 4 * p, pixel, sizeof pixel);
    }
    const bool ok = write_map(writer, &picture, name, ".png", err);
    ffp_image_free(&picture);
    return ok;
}

static bool write_encoded(Writer *writer, const FfpImage *linear, const char *name, FfpError *err) {
    FfpImage picture = ffp_image_copy(linear);
    ffp_image_to_srgb(&picture);
    const bool ok = write_map(writer, &picture, name, ".png", err);
    ffp_image_free(&picture);
    return ok;
}

// Numbers go into EXR files; what people look at, into PNG files.
static bool write_image(Writer *writer, const FfpNamedImage *named, const FfpView *view, FfpError *err) {
    const FfpImage image = {named->width, named->height, named->channels, (real *)named->data};
    const char *name = named->name;
    if (strcmp(name, "projector_sees") == 0) return write_encoded(writer, &image, name, err);
    if (strcmp(name, "lit") == 0) return write_map(writer, &image, name, ".png", err);
    if (!write_map(writer, &image, name, ".exr", err)) return false;
    if (strcmp(name, "illuminance") == 0) return write_map(writer, &image, name, ".png", err);
    if (strcmp(name, "camera_to_projector") == 0)
        return write_shares(writer, &image, &view->projector, name, err);
    if (strcmp(name, "projector_to_camera") == 0)
        return write_shares(writer, &image, &view->camera, name, err);
    return true;
}

static bool check_names(const FfpChosen *chosen, const char *folder, FfpError *err) {
    for (int v = 0; v < chosen->n_views; v++) {
        const char *id = chosen->views[v]->id;
        if (!*id || *id == '.' || strchr(id, '/'))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "view %s is no name for files", id);
    }
    return true;
}

static int write_maps(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpMaps *options,
                      FfpMapStats *stats, FfpError *err) {
    FfpChosen chosen;
    Writer writer = {.written = 0};
    bool ok = ffp_choose_views(&chosen, capture, options->poses, options->views, options->n_views, err) &&
              check_names(&chosen, options->folder, err) &&
              ffp_output_open_folder(&writer.folder, options->folder, false, err);
    for (int v = 0; ok && v < chosen.n_views; v++) {
        FfpMapStats found = {0};
        FfpImages *images = map_view(gaussians, capture, chosen.views[v], options->drawing, &found);
        writer.view = chosen.views[v]->id;
        for (int i = 0; ok && i < ffp_images_count(images); i++) {
            const FfpNamedImage image = ffp_images_at(images, i);
            ok = write_image(&writer, &image, chosen.views[v], err);
        }
        ffp_images_close(images);
        if (ok && stats) stats[v] = found;
    }
    ok = ok && ffp_output_commit(&writer.folder, err);
    ffp_output_abort(&writer.folder);
    ffp_chosen_free(&chosen);
    return ok ? writer.written : -1;
}

typedef struct MemoryCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPinhole *camera, *projector;
    FfpDrawing drawing;
    FfpMapStats *stats;
    FfpImages *images;
} MemoryCall;

static bool into_memory(void *argument, FfpError *err) {
    MemoryCall *call = argument;
    call->images = map_devices(call->gaussians, call->capture, call->camera, call->projector, call->drawing,
                               call->stats, err);
    return call->images != NULL;
}

FfpImages *ffp_map_images(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                          const FfpPinhole *camera, const FfpPinhole *projector, FfpDrawing drawing,
                          FfpMapStats *stats, FfpError *err) {
    MemoryCall call = {gaussians, capture, camera, projector, drawing, stats, NULL};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(capture, "capture", err) ||
        !ffp_need(camera, "camera", err) || !ffp_need(projector, "projector", err) ||
        !ffp_check_drawing(drawing, err))
        return NULL;
    return ffp_call_run(context, into_memory, &call, err) ? call.images : NULL;
}

typedef struct FilesCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpMaps *options;
    FfpMapStats *stats;
    int written;
} FilesCall;

static bool into_files(void *argument, FfpError *err) {
    FilesCall *call = argument;
    call->written = write_maps(call->gaussians, call->capture, call->options, call->stats, err);
    return call->written >= 0;
}

int ffp_write_maps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                   const FfpMaps *options, FfpMapStats *stats, FfpError *err) {
    FilesCall call = {gaussians, capture, options, stats, 0};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(capture, "capture", err) ||
        !ffp_need(options, "options", err) || !ffp_need(options->folder, "folder", err) ||
        !ffp_need_texts(options->views, options->n_views, "views", err) ||
        !ffp_check_drawing(options->drawing, err))
        return -1;
    return ffp_call_run(context, into_files, &call, err) ? call.written : -1;
}
