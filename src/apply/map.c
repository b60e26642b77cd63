// Correspondence maps and what the projector lights, as files.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "apply/choose.h"
#include "apply/stage.h"
#include "apply/surface.h"
#include "base/file.h"
#include "base/log.h"

typedef struct Writer {
    const char *folder, *view;
    int written;
} Writer;

static bool write_map(Writer *writer, const FfpImage *image, const char *what, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s_%s", writer->folder, writer->view, what) >= FFP_PATH_MAX)
        return ffp_fail(err, writer->folder, "the path of %s_%s is too long", writer->view, what);
    writer->written++;
    if (strstr(what, ".exr")) return ffp_image_write_exr(image, path, err);
    return image->channels == 4 ? ffp_image_write_png16(image, path, err)
                                : ffp_image_write_png(image, path, err);
}

// Writes a correspondence map [.,3] (x, y, third; x < 0: none) as it is, and as 16-bit PNG: x and y as shares
// of the other device's size, the third as it stands, alpha 0 where there is nothing.
static bool write_correspondence(Writer *writer, const FfpImage *map, const FfpCamera *to, const char *name,
                                 FfpError *err) {
    char what[64];
    FfpImage picture = ffp_image_new(map->width, map->height, 4);
    for (int p = 0; p < map->width * map->height; p++) {
        const real *from = map->data + 3 * p;
        if (from[0] < 0) continue;
        const real pixel[4] = {from[0] / (real)to->width, from[1] / (real)to->height, from[2], 1};
        memcpy(picture.data + 4 * p, pixel, sizeof pixel);
    }
    snprintf(what, sizeof what, "%s.exr", name);
    bool ok = write_map(writer, map, what, err);
    snprintf(what, sizeof what, "%s.png", name);
    ok = ok && write_map(writer, &picture, what, err);
    ffp_image_free(&picture);
    return ok;
}

// u, v and the share of the light that comes through; -1 -1 0 without a surface inside the pattern.
static FfpImage forward_map(const FfpStage *stage) {
    const FfpSight *sight = &stage->sights[0];
    const FfpMapping *mapping = &stage->links[0].mapping;
    const FfpCamera *projector = &stage->beams[0].view->projector;
    FfpImage map = ffp_image_new(mapping->width, mapping->height, 3);
    for (int p = 0; p < map.width * map.height; p++) {
        const real *uv = mapping->uv + 2 * p;
        const bool there = sight->depth.data[p] > 0 && uv[0] > 0 && uv[1] > 0 &&
                           uv[0] < (real)projector->width && uv[1] < (real)projector->height;
        const real pixel[3] = {there ? uv[0] : -1, there ? uv[1] : -1, there ? mapping->visibility[p] : 0};
        memcpy(map.data + 3 * p, pixel, sizeof pixel);
    }
    return map;
}

static bool write_correspondences(Writer *writer, const FfpStage *stage, FfpMapStory *story, FfpError *err) {
    const FfpView *view = stage->sights[0].view;
    FfpImage forward = forward_map(stage), inverse = ffp_stage_inverse(stage, 0, 0);
    const FfpRoundTrip trip = ffp_stage_round_trip(stage, 0, 0, &inverse);
    story->lit_pixels = trip.pixels, story->lost_pixels = trip.lost;
    story->within_half = trip.within_half, story->median = trip.median, story->most = trip.most;
    for (int p = 0; p < inverse.width * inverse.height; p++)
        inverse.data[3 * p + 2] = inverse.data[3 * p] >= 0;
    const bool ok = write_correspondence(writer, &forward, &view->projector, "camera_to_projector", err) &&
                    write_correspondence(writer, &inverse, &view->camera, "projector_to_camera", err);
    ffp_image_free(&forward);
    ffp_image_free(&inverse);
    return ok;
}

// The object from the projector's place, in its own white light.
static bool write_projector_view(Writer *writer, const FfpLitSurface *surface, const FfpCapture *capture,
                                 const FfpCamera *projector, FfpError *err) {
    FfpMapping mapping = ffp_mapping_new(projector->width, projector->height);
    FfpImage picture = ffp_image_new(projector->width, projector->height, 3);
    FfpSummed white = ffp_summed_new(&capture->patterns[capture->white].image);
    for (int p = 0; p < mapping.width * mapping.height; p++) {
        mapping.visibility[p] = 1;
        mapping.extent[2 * p] = mapping.extent[2 * p + 1] = 1;
    }
    ffp_shade(&surface->gbuffer, &mapping, projector, projector, capture->intensity, &white, &picture);
    ffp_image_to_srgb(&picture);
    const bool ok = write_map(writer, &picture, "projector_sees.png", err);
    ffp_summed_free(&white);
    ffp_image_free(&picture);
    ffp_mapping_free(&mapping);
    return ok;
}

static bool write_light(Writer *writer, const FfpLitSurface *surface, const FfpView *view, FfpMapStory *story,
                        FfpError *err) {
    const int width = surface->depth.width, height = surface->depth.height;
    FfpImage lit = ffp_image_new(width, height, 1), angle = ffp_image_new(width, height, 1);
    FfpImage density = ffp_image_new(width, height, 1);
    int count = 0;
    for (int p = 0; p < width * height; p++) {
        lit.data[p] = surface->cosine.data[p] > 0;
        angle.data[p] = lit.data[p] > 0 ? acos(surface->cosine.data[p]) * 57.2957795F : -1;
        count += lit.data[p] > 0;
    }
    story->lit_share = (double)count / ((double)width * height);
    ffp_lit_surface_density(surface, &view->projector, &view->camera, &density);
    const bool ok = write_map(writer, &lit, "lit.png", err) &&
                    write_map(writer, &angle, "incidence.exr", err) &&
                    write_map(writer, &density, "density.exr", err) &&
                    write_map(writer, &surface->resolution, "resolution.exr", err) &&
                    write_map(writer, &surface->illuminance, "illuminance.exr", err) &&
                    write_map(writer, &surface->illuminance, "illuminance.png", err);
    ffp_image_free(&lit);
    ffp_image_free(&angle);
    ffp_image_free(&density);
    return ok;
}

static bool map_view(Writer *writer, const FfpGaussians *gaussians, const FfpCapture *capture,
                     const FfpView *view, const FfpRenderSettings *settings, FfpMapStory *story,
                     FfpError *err) {
    FfpStage stage = ffp_stage_new(gaussians, capture, &view, 1, settings, false);
    writer->view = view->id;
    bool ok = write_correspondences(writer, &stage, story, err);
    ffp_stage_free(&stage);
    if (!ok) return false;
    FfpLitSurface surface = ffp_lit_surface_new(gaussians, &view->projector, settings);
    ok = write_projector_view(writer, &surface, capture, &view->projector, err) &&
         write_light(writer, &surface, view, story, err);
    ffp_lit_surface_free(&surface);
    snprintf(story->view, sizeof story->view, "%s", view->id);
    return ok;
}

static bool check_names(const FfpChosen *chosen, const char *folder, FfpError *err) {
    for (int v = 0; v < chosen->n_views; v++) {
        const char *id = chosen->views[v]->id;
        if (!*id || *id == '.' || strchr(id, '/'))
            return ffp_fail(err, folder, "view %s is no name for files", id);
    }
    return true;
}

int ffp_write_maps(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpMaps *options,
                   FfpMapStory *stories, FfpError *err) {
    FfpChosen chosen;
    Writer writer = {.folder = options->folder};
    const FfpRenderSettings settings = ffp_render_settings(options->drawing);
    bool ok = ffp_choose_views(&chosen, capture, options->poses, options->views, options->n_views, err) &&
              check_names(&chosen, options->folder, err) && ffp_make_folders(options->folder, err);
    for (int v = 0; ok && v < chosen.n_views; v++) {
        FfpMapStory story = {0};
        ok = map_view(&writer, gaussians, capture, chosen.views[v], &settings, &story, err);
        if (ok && stories) stories[v] = story;
    }
    ffp_chosen_free(&chosen);
    return ok ? writer.written : -1;
}
