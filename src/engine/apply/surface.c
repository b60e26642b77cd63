#include "engine/apply/surface.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"

#define FEATHER_SHARE 20  // a feather is the projector's longer side divided by this wide
#define FEATHER_MIN 0.01F // so that a place that only one projector reaches is still lit by it

// Per projector pixel: pixels per unit area are fx fy cos(incidence) / (z^2 cos(off axis)), because a pixel's
// solid angle is cos^3(off axis) / (fx fy) and its distance z / cos(off axis).
static void measure(FfpLitSurface *s, const FfpCamera *projector, int x, int y) {
    const FfpGbuffer *g = &s->gbuffer;
    const int p = y * g->width + x;
    const real opacity = g->opacity[p];
    if (!(opacity >= 0.5F)) return;
    const real z = g->depth[p] / opacity;
    if (!(z > 0)) return;
    real ray[3], normal[3];
    const real off_axis = ffp_pixel_ray(projector, (real)x + 0.5F, (real)y + 0.5F, ray);
    memcpy(normal, g->normal + 3 * p, sizeof normal);
    ffp_normalise3(normal);
    const real cosine = fmin(fmax(-ffp_dot3(normal, ray), (real)0), (real)1), distance = z / off_axis;
    s->depth.data[p] = z;
    s->cosine.data[p] = cosine;
    s->illuminance.data[p] = cosine / (distance * distance);
    s->resolution.data[p] = sqrt(projector->fx * projector->fy * cosine / (z * z * off_axis));
}

FfpLitSurface ffp_lit_surface_new(const FfpGaussians *gaussians, const FfpCamera *projector,
                                  const FfpRenderSettings *settings) {
    const int width = projector->width, height = projector->height, pixels = width * height;
    FfpLitSurface s = {.gbuffer = ffp_gbuffer_new(width, height),
                       .depth = ffp_image_new(width, height, 1),
                       .cosine = ffp_image_new(width, height, 1),
                       .illuminance = ffp_image_new(width, height, 1),
                       .resolution = ffp_image_new(width, height, 1)};
    FfpRaster *raster = ffp_raster_new();
    ffp_rasterise(raster, gaussians, projector, settings, &s.gbuffer);
    ffp_raster_free(raster);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) measure(&s, projector, x, y);
    real most = 0;
    for (int p = 0; p < pixels; p++) most = fmax(most, s.illuminance.data[p]);
    for (int p = 0; most > 0 && p < pixels; p++) s.illuminance.data[p] /= most;
    return s;
}

void ffp_lit_surface_free(FfpLitSurface *s) {
    ffp_gbuffer_free(&s->gbuffer);
    ffp_image_free(&s->depth);
    ffp_image_free(&s->cosine);
    ffp_image_free(&s->illuminance);
    ffp_image_free(&s->resolution);
}

// Camera position of the tangent plane's point in the direction of projector position (x, y); false when the
// ray misses the plane or the camera has the point behind it.
static bool through_plane(const FfpCamera *projector, const FfpCamera *camera, const real point[3],
                          const real normal[3], real x, real y, real out[2]) {
    real ray[3], to[3], at[3];
    ffp_pixel_ray(projector, x, y, ray);
    for (int k = 0; k < 3; k++) to[k] = point[k] - projector->pose[4 * k + 3];
    const real across = ffp_dot3(normal, ray);
    if (!(across < 0)) return false;
    const real t = ffp_dot3(normal, to) / across;
    if (!(t > 0)) return false;
    for (int k = 0; k < 3; k++) at[k] = projector->pose[4 * k + 3] + t * ray[k];
    return ffp_project(camera, at, &out[0], &out[1]) > 0;
}

static real pixel_density(const FfpLitSurface *s, const FfpCamera *projector, const FfpCamera *camera, int x,
                          int y) {
    const int p = y * s->depth.width + x;
    const real px = (real)x + 0.5F, py = (real)y + 0.5F;
    if (!(s->cosine.data[p] > 0)) return 0;
    real ray[3], point[3], normal[3], to_camera[3], right[2], left[2], low[2], high[2];
    const real off_axis = ffp_pixel_ray(projector, px, py, ray);
    for (int k = 0; k < 3; k++) {
        point[k] = projector->pose[4 * k + 3] + s->depth.data[p] / off_axis * ray[k];
        to_camera[k] = camera->pose[4 * k + 3] - point[k];
        normal[k] = s->gbuffer.normal[3 * p + k];
    }
    if (!(ffp_dot3(normal, to_camera) > 0)) return 0;
    if (!through_plane(projector, camera, point, normal, px + 0.5F, py, right) ||
        !through_plane(projector, camera, point, normal, px - 0.5F, py, left) ||
        !through_plane(projector, camera, point, normal, px, py + 0.5F, low) ||
        !through_plane(projector, camera, point, normal, px, py - 0.5F, high))
        return 0;
    return fabs((right[0] - left[0]) * (low[1] - high[1]) - (right[1] - left[1]) * (low[0] - high[0]));
}

void ffp_lit_surface_density(const FfpLitSurface *surface, const FfpCamera *projector,
                             const FfpCamera *camera, FfpImage *density) {
#pragma omp parallel for schedule(static)
    for (int y = 0; y < density->height; y++)
        for (int x = 0; x < density->width; x++)
            density->data[y * density->width + x] = pixel_density(surface, projector, camera, x, y);
}

// True if the surface ends between a pixel and its neighbour.
static bool ends(const FfpLitSurface *s, const FfpCamera *projector, int x, int y, int nx, int ny) {
    const int width = s->depth.width;
    if (nx < 0 || ny < 0 || nx >= width || ny >= s->depth.height) return true;
    const real z = s->depth.data[y * width + x], other = s->depth.data[ny * width + nx];
    return !(other > 0) || fabs(z - other) > ffp_depth_jump(projector, z);
}

static real at_edge(const FfpLitSurface *s, const FfpCamera *projector, int x, int y) {
    if (!(s->depth.data[y * s->depth.width + x] > 0)) return 0;
    const bool edge = ends(s, projector, x, y, x + 1, y) || ends(s, projector, x, y, x - 1, y) ||
                      ends(s, projector, x, y, x, y + 1) || ends(s, projector, x, y, x, y - 1);
    return edge ? 0 : INFINITY;
}

static void shorten(FfpImage *distance, int x, int y, int dx, int dy) {
    const int nx = x + dx, ny = y + dy, width = distance->width;
    if (nx < 0 || ny < 0 || nx >= width || ny >= distance->height) return;
    const real step = dx && dy ? 1.41421356F : 1;
    real *here = &distance->data[y * width + x];
    *here = fmin(*here, distance->data[ny * width + nx] + step);
}

void ffp_distances(FfpImage *distance) {
    static const int before[4][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    const int width = distance->width, height = distance->height;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int k = 0; k < 4; k++) shorten(distance, x, y, before[k][0], before[k][1]);
    for (int y = height - 1; y >= 0; y--)
        for (int x = width - 1; x >= 0; x--)
            for (int k = 0; k < 4; k++) shorten(distance, x, y, -before[k][0], -before[k][1]);
}

void ffp_lit_surface_feather(const FfpLitSurface *surface, const FfpCamera *projector, FfpImage *feather) {
    const int width = feather->width, height = feather->height;
    const int longer = width > height ? width : height;
    const real reach = fmax((real)longer / FEATHER_SHARE, (real)1);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) feather->data[y * width + x] = at_edge(surface, projector, x, y);
    ffp_distances(feather);
    for (int p = 0; p < width * height; p++) {
        const real t = fmin(feather->data[p] / reach, (real)1);
        feather->data[p] = fmax(t * t * (3 - 2 * t) * surface->cosine.data[p], (real)FEATHER_MIN);
    }
}
