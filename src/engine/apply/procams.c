// Cameras, projectors and light: rasterises each camera once, maps it to every projector, and takes the
// response to white.
#include "engine/apply/procams.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/apply/surface.h"
#include "engine/render/pass.h"
#include "engine/render/shade_pixel.h"
#include "engine/render/strip.h"

#define WHITE_MIN 0.05F // a white pattern that is darker than this over a footprint tells no response

typedef struct Builder {
    FfpProCams *procams;
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpRenderSettings *settings;
    FfpSummed white;
    FfpRaster *raster;
    bool photographs;
} Builder;

FfpLink *ffp_procams_link(const FfpProCams *procams, int camera_view, int projection) {
    return &procams->links[camera_view * procams->n_projections + projection];
}

// ffp_same_device is of captures in which the object's radius is 1.
static FfpCamera in_radii(const FfpCamera *device, real radius) {
    FfpCamera out = *device;
    for (int k = 0; radius > 0 && k < 3; k++) out.pose[4 * k + 3] /= radius;
    return out;
}

static bool same_projector(const FfpCapture *capture, const FfpCamera *a, const FfpCamera *b) {
    const FfpCamera one = in_radii(a, capture->radius), other = in_radii(b, capture->radius);
    return ffp_same_device(&one, &other);
}

static void find_projections(FfpProCams *procams, const FfpCapture *capture, const FfpView *const *views) {
    for (int v = 0; v < procams->n_camera_views; v++) {
        int known = 0;
        while (known < procams->n_projections &&
               !same_projector(capture, &procams->projections[known].view->projector, &views[v]->projector))
            known++;
        if (known == procams->n_projections) procams->projections[procams->n_projections++].view = views[v];
    }
}

static bool photographed(const Builder *b, const FfpView *view) {
    return b->photographs && view->images && view->images[b->capture->black].data &&
           view->images[b->capture->white].data;
}

static void new_camera_view(const Builder *b, FfpCameraView *camera_view) {
    const FfpView *view = camera_view->view;
    const int width = view->camera.width, height = view->camera.height;
    camera_view->depth = ffp_image_new(width, height, 1);
    camera_view->facing = ffp_image_new(width, height, 1);
    if (b->gaussians->scatters) camera_view->scattered = ffp_image_new(width, height, 3);
    if (photographed(b, view)) {
        camera_view->weight = ffp_image_copy(&view->coverage);
        camera_view->ambient = ffp_image_copy(&view->images[b->capture->black]);
    } else {
        camera_view->weight = ffp_image_new(width, height, 1);
        camera_view->ambient = ffp_image_new(width, height, 3);
    }
}

// A strip of a view, drawn: its camera, and the first of its pixels in the view's arrays.
typedef struct Strip {
    const FfpGbuffer *g;
    FfpCamera camera;
    size_t first;
} Strip;

static void fill_row(const FfpCameraView *camera_view, const Strip *strip, bool has_pictures, int y) {
    const FfpGbuffer *g = strip->g;
    for (int x = 0; x < g->width; x++) {
        const size_t i = (size_t)y * (size_t)g->width + (size_t)x, p = strip->first + i;
        const real opacity = g->opacity[i];
        if (g->scattered) memcpy(camera_view->scattered.data + 3 * p, g->scattered + 3 * i, 3 * sizeof(real));
        if (!has_pictures) {
            camera_view->weight.data[p] = fmin(opacity, 1);
            memcpy(camera_view->ambient.data + 3 * p, g->ambient + 3 * i, 3 * sizeof(real));
        }
        if (!(opacity >= 0.5F)) continue;
        real ray[3], normal[3];
        memcpy(normal, g->normal + 3 * i, sizeof normal);
        ffp_normalise3(normal);
        ffp_pixel_ray(&strip->camera, (real)x + 0.5F, (real)y + 0.5F, ray);
        camera_view->depth.data[p] = g->depth[i] / opacity;
        camera_view->facing.data[p] = fmin(fabs(ffp_dot3(normal, ray)), 1);
    }
}

// Pixels without light keep a position in the pattern: a photograph may know better than the shadow map.
static bool in_pattern(const FfpMapping *mapping, const FfpCamera *projector, size_t p) {
    const real *uv = mapping->uv + 2 * p;
    return uv[0] > 0 && uv[1] > 0 && uv[0] < (real)projector->width && uv[1] < (real)projector->height;
}

// Radiance under white less the ambient and the scattered one, divided by the white pattern over the
// footprint: of a strip's mapping into its response. `lit` and `dark` are linear pictures; scattered: of the
// strip, or NULL.
static void divide_white(const Builder *b, const FfpMapping *mapping, const FfpCamera *projector,
                         const real *lit, const real *dark, const real *scattered, bool believe_shadows,
                         real *response) {
    const size_t pixels = (size_t)mapping->width * (size_t)mapping->height;
    real level[3];
    ffp_pattern_level(&b->white, mapping->lit, level);
    for (size_t p = 0; p < pixels; p++) {
        const real *uv = mapping->uv + 2 * p, *extent = mapping->extent + 2 * p;
        real white[3];
        if (!in_pattern(mapping, projector, p) || (believe_shadows && !(mapping->visibility[p] > 0)))
            continue;
        ffp_lookup(&b->white, uv[0], uv[1], extent[0], extent[1], white);
        for (int c = 0; c < 3; c++) {
            const real other = dark[3 * p + c] + (scattered ? level[c] * scattered[3 * p + c] : 0);
            if (white[c] > WHITE_MIN)
                response[3 * p + c] = fmax((lit[3 * p + c] - other) / white[c], (real)0);
        }
    }
}

static FfpMapping rows_of(const FfpMapping *whole, const Strip *strip) {
    return (FfpMapping){.width = strip->g->width,
                        .height = strip->g->height,
                        .uv = whole->uv + 2 * strip->first,
                        .extent = whole->extent + 2 * strip->first,
                        .visibility = whole->visibility + strip->first};
}

static void fill_link(const Builder *b, const FfpView *view, const FfpProjection *projection,
                      const Strip *strip, FfpLink *link) {
    const FfpGbuffer *g = strip->g;
    const FfpCamera *projector = &projection->view->projector;
    real *response = link->response.data + 3 * strip->first;
    FfpMapping part = rows_of(&link->mapping, strip);
    ffp_map_to_projector(b->raster, b->gaussians, g, &strip->camera, projector, b->settings, &part);
    link->mapping.even = part.even;
    memcpy(link->mapping.lit, part.lit, sizeof part.lit);
    if (photographed(b, view) && same_projector(b->capture, &view->projector, projector)) {
        divide_white(b, &part, projector, view->images[b->capture->white].data + 3 * strip->first,
                     view->images[b->capture->black].data + 3 * strip->first, g->scattered, false, response);
        return;
    }
    FfpImage lit = ffp_image_new(g->width, g->height, 3);
    ffp_shade_once(g, &part, &strip->camera, projector, b->capture->intensity, &b->white, &lit);
    divide_white(b, &part, projector, lit.data, g->ambient, g->scattered, true, response);
    ffp_image_free(&lit);
}

static void fill_strip(const Builder *b, int s, const Strip *strip) {
    FfpCameraView *camera_view = &b->procams->camera_views[s];
    const bool has_pictures = photographed(b, camera_view->view);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < strip->g->height; y++) fill_row(camera_view, strip, has_pictures, y);
    for (int k = 0; k < b->procams->n_projections; k++)
        fill_link(b, camera_view->view, &b->procams->projections[k], strip,
                  ffp_procams_link(b->procams, s, k));
}

static void fill_view(const Builder *b, FfpViewPass *pass, int s) {
    FfpCameraView *camera_view = &b->procams->camera_views[s];
    const FfpCamera *camera = &camera_view->view->camera;
    const int rows = ffp_strip_rows(camera);
    FfpGbuffer shadow = {0};
    new_camera_view(b, camera_view);
    for (int k = 0; k < b->procams->n_projections; k++)
        *ffp_procams_link(b->procams, s, k) =
            (FfpLink){.mapping = ffp_mapping_new(camera->width, camera->height),
                      .response = ffp_image_new(camera->width, camera->height, 3)};
    ffp_view_pass_keep_shadow(pass, &shadow);
    for (int top = 0; top < camera->height; top += rows) {
        Strip strip = {.camera = ffp_strip_of(camera, top, rows),
                       .first = (size_t)top * (size_t)camera->width};
        ffp_view_pass_draw(pass, b->gaussians, &strip.camera, &camera_view->view->projector);
        strip.g = ffp_view_pass_gbuffer(pass);
        fill_strip(b, s, &strip);
    }
    ffp_view_pass_keep_shadow(pass, NULL);
    ffp_gbuffer_free(&shadow);
}

static void fill_views(const Builder *b) {
    FfpViewPass *pass = ffp_view_pass_new(b->settings);
    for (int s = 0; s < b->procams->n_camera_views; s++) fill_view(b, pass, s);
    ffp_view_pass_free(pass);
}

static void fill_projections(const Builder *b) {
    for (int k = 0; k < b->procams->n_projections; k++) {
        FfpProjection *projection = &b->procams->projections[k];
        const FfpCamera *projector = &projection->view->projector;
        projection->pattern = ffp_image_new(projector->width, projector->height, 3);
        projection->feather = ffp_image_new(projector->width, projector->height, 1);
        const int pixels = projector->width * projector->height;
        projection->lit = ffp_image_new(projector->width, projector->height, 1);
        FfpLitSurface surface = ffp_lit_surface_new(b->gaussians, projector, b->settings);
        for (int p = 0; p < pixels; p++) {
            projection->feather.data[p] = 1;
            projection->lit.data[p] = surface.depth.data[p] > 0;
        }
        if (b->procams->n_projections > 1) ffp_lit_surface_feather(&surface, projector, &projection->feather);
        ffp_lit_surface_free(&surface);
    }
}

FfpProCams ffp_procams_new(const FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpView *const *views, int n_views, const FfpRenderSettings *settings,
                           bool photographs) {
    FfpProCams procams = {.n_camera_views = n_views, .spread_reach = capture->panel.spread_reach};
    memcpy(procams.spread, capture->panel.spread, sizeof procams.spread);
    procams.camera_views = ffp_alloc((size_t)n_views, sizeof *procams.camera_views);
    procams.projections = ffp_alloc((size_t)n_views, sizeof *procams.projections);
    for (int v = 0; v < n_views; v++) procams.camera_views[v].view = views[v];
    find_projections(&procams, capture, views);
    procams.links = ffp_alloc((size_t)n_views * (size_t)procams.n_projections, sizeof *procams.links);
    Builder builder = {.procams = &procams,
                       .gaussians = gaussians,
                       .capture = capture,
                       .settings = settings,
                       .white = ffp_summed_new(&capture->patterns[capture->white].image),
                       .raster = ffp_raster_new(),
                       .photographs = photographs};
    fill_views(&builder);
    fill_projections(&builder);
    ffp_summed_free(&builder.white);
    ffp_raster_free(builder.raster);
    return procams;
}

void ffp_procams_free(FfpProCams *procams) {
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpCameraView *camera_view = &procams->camera_views[s];
        FfpImage *images[] = {&camera_view->depth,  &camera_view->facing, &camera_view->ambient,
                              &camera_view->target, &camera_view->weight, &camera_view->scattered};
        for (size_t i = 0; i < sizeof images / sizeof *images; i++) ffp_image_free(images[i]);
    }
    for (int k = 0; k < procams->n_projections; k++) {
        ffp_image_free(&procams->projections[k].feather);
        ffp_image_free(&procams->projections[k].lit);
        ffp_image_free(&procams->projections[k].pattern);
    }
    for (int l = 0; l < procams->n_camera_views * procams->n_projections; l++) {
        ffp_mapping_free(&procams->links[l].mapping);
        ffp_image_free(&procams->links[l].response);
    }
    ffp_free(procams->camera_views);
    ffp_free(procams->projections);
    ffp_free(procams->links);
    *procams = (FfpProCams){0};
}

void ffp_procams_aim(FfpProCams *procams, int camera_view, const FfpImage *target, const FfpImage *alpha) {
    FfpCameraView *s = &procams->camera_views[camera_view];
    ffp_image_free(&s->target);
    s->target = ffp_image_copy(target);
    const ptrdiff_t pixels = (ptrdiff_t)target->width * target->height;
    for (ptrdiff_t p = 0; alpha && p < pixels; p++) s->weight.data[p] *= alpha->data[p];
}

void ffp_procams_scale(FfpProCams *procams, real gain) {
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpImage *target = &procams->camera_views[s].target;
        const ptrdiff_t count = (ptrdiff_t)target->width * target->height * 3;
        for (ptrdiff_t i = 0; i < count; i++) target->data[i] *= gain;
    }
}

void ffp_procams_black_level(FfpProCams *procams, real black) {
    procams->black = black;
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpImage *ambient = &procams->camera_views[s].ambient;
        const ptrdiff_t count = (ptrdiff_t)ambient->width * ambient->height * 3;
        for (int k = 0; k < procams->n_projections; k++) {
            real *response = ffp_procams_link(procams, s, k)->response.data;
            for (ptrdiff_t i = 0; i < count; i++) {
                ambient->data[i] += black * response[i];
                response[i] *= 1 - black;
            }
        }
    }
}

static bool reaches(const FfpLink *link, ptrdiff_t p) {
    const real *response = link->response.data + 3 * p;
    return response[0] > 0 || response[1] > 0 || response[2] > 0;
}

// The most projections that light one place, among those that at least a hundredth of the lit pixels share.
static int most_at_once(const FfpProCams *procams) {
    int64_t *pixels = ffp_alloc((size_t)procams->n_projections + 1, sizeof *pixels), lit = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        const FfpImage *weight = &procams->camera_views[s].weight;
        for (ptrdiff_t p = 0; p < (ptrdiff_t)weight->width * weight->height; p++) {
            int count = 0;
            for (int k = 0; k < procams->n_projections; k++)
                count += reaches(ffp_procams_link(procams, s, k), p);
            pixels[count] += weight->data[p] > 0.5F;
            lit += count > 0 && weight->data[p] > 0.5F;
        }
    }
    int most = procams->n_projections;
    while (most > 1 && 100 * pixels[most] < lit) most--;
    ffp_free(pixels);
    return most;
}

// The mean of what the projectors' whites show alone, weighted by their feathers: radiance beside the
// ambient.
static void shared_white(const FfpProCams *procams, int s, ptrdiff_t p, real out[3]) {
    real sum = 0;
    memset(out, 0, 3 * sizeof *out);
    for (int k = 0; k < procams->n_projections; k++) {
        const FfpLink *link = ffp_procams_link(procams, s, k);
        const real *uv = link->mapping.uv + 2 * p;
        real feather;
        if (!reaches(link, p)) continue;
        ffp_image_sample(&procams->projections[k].feather, uv[0], uv[1], &feather);
        sum += feather;
        for (int c = 0; c < 3; c++) out[c] += feather * link->response.data[3 * p + c] / (1 - procams->black);
    }
    const real *scattered = procams->camera_views[s].scattered.data;
    for (int c = 0; c < 3 && sum > 0; c++) out[c] = out[c] / sum + (scattered ? scattered[3 * p + c] : 0);
}

// Every target becomes its floor and (paint) that share of the way up, or (otherwise) at least its floor.
static void raise_targets(FfpProCams *procams, bool paint) {
    const real least = fmin(procams->black * (real)most_at_once(procams), (real)1);
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpCameraView *camera_view = &procams->camera_views[s];
        for (ptrdiff_t p = 0; p < (ptrdiff_t)camera_view->target.width * camera_view->target.height; p++) {
            real white[3];
            shared_white(procams, s, p, white);
            for (int c = 0; c < 3; c++) {
                real *target = &camera_view->target.data[3 * p + c],
                     dark = camera_view->ambient.data[3 * p + c];
                for (int k = 0; k < procams->n_projections; k++)
                    dark -= procams->black / (1 - procams->black) *
                            ffp_procams_link(procams, s, k)->response.data[3 * p + c];
                dark += least * white[c];
                *target =
                    paint ? dark + (1 - least) * white[c] * fmin(*target, (real)1) : fmax(*target, dark);
            }
        }
    }
}

void ffp_procams_lift(FfpProCams *procams) {
    if (procams->black > 0) raise_targets(procams, false);
}

void ffp_procams_paint(FfpProCams *procams) {
    raise_targets(procams, true);
}

FfpImage ffp_procams_light(const FfpProCams *procams, int projection) {
    FfpImage light = ffp_image_copy(&procams->projections[projection].pattern);
    ffp_image_blur(&light, procams->blur);
    ffp_image_spread(&light, procams->spread, procams->spread_reach);
    return light;
}

// Adds what a projection's light scatters.
static void add_scattered(const FfpCameraView *camera_view, const FfpSummed *light, const real lit[4],
                          FfpImage *picture) {
    const ptrdiff_t values = (ptrdiff_t)picture->width * picture->height * 3;
    real level[3];
    ffp_pattern_level(light, lit, level);
    for (ptrdiff_t i = 0; camera_view->scattered.data && i < values; i++)
        picture->data[i] += level[i % 3] * camera_view->scattered.data[i];
}

FfpImage ffp_procams_floor(const FfpProCams *procams, int camera_view) {
    FfpImage floor = ffp_image_copy(&procams->camera_views[camera_view].ambient);
    for (int k = 0; procams->camera_views[camera_view].scattered.data && k < procams->n_projections; k++) {
        FfpImage light = ffp_procams_light(procams, k);
        FfpSummed summed = ffp_summed_new(&light);
        add_scattered(&procams->camera_views[camera_view], &summed,
                      ffp_procams_link(procams, camera_view, k)->mapping.lit, &floor);
        ffp_summed_free(&summed);
        ffp_image_free(&light);
    }
    return floor;
}

FfpImage ffp_procams_picture(const FfpProCams *procams, int camera_view) {
    FfpImage picture = ffp_image_copy(&procams->camera_views[camera_view].ambient);
    const ptrdiff_t pixels = (ptrdiff_t)picture.width * picture.height;
    for (int k = 0; k < procams->n_projections; k++) {
        const FfpLink *link = ffp_procams_link(procams, camera_view, k);
        FfpImage light = ffp_procams_light(procams, k);
        FfpSummed summed = ffp_summed_new(&light);
        ffp_image_free(&light);
        add_scattered(&procams->camera_views[camera_view], &summed, link->mapping.lit, &picture);
#pragma omp parallel for schedule(static)
        for (ptrdiff_t p = 0; p < pixels; p++) {
            const real *uv = link->mapping.uv + 2 * p, *extent = link->mapping.extent + 2 * p;
            const real *response = link->response.data + 3 * p;
            real rgb[3];
            if (!(response[0] > 0 || response[1] > 0 || response[2] > 0)) continue;
            ffp_lookup(&summed, uv[0], uv[1], extent[0], extent[1], rgb);
            for (int c = 0; c < 3; c++) picture.data[3 * p + c] += response[c] * rgb[c];
        }
        ffp_summed_free(&summed);
    }
    return picture;
}
