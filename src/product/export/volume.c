#include "product/export/volume.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/capture/project.h"

#define TRUNCATION 4 // cells
#define MARGIN 2     // cells around the object
#define SOLID 0.5F   // opacity of a pixel that shows a surface
#define FACING_MIN 0.1F
#define SMOOTHINGS 2
#define LOOK_SIDE_MAX 2048
#define LOOK_SCALE_MAX 8

// --- Looks. ---

FfpDepthView ffp_depth_view(const FfpDepthSource *source, int view, real cell) {
    const FfpCapture *capture = source->capture;
    FfpDepthView seen = {.camera = capture->views[view].camera};
    FfpCamera *c = &seen.camera;
    real square = 0;
    for (int k = 0; k < 3; k++) {
        const real d = c->pose[4 * k + 3] - capture->centre[k];
        square += d * d;
    }
    const int longer = c->width > c->height ? c->width : c->height;
    const real most = (real)LOOK_SIDE_MAX / (real)longer; // of larger pictures the cells have no use
    real scale = sqrt(square) / (cell * c->fx);
    scale = fmin(fmax(scale, (real)1), fmin((real)LOOK_SCALE_MAX, most));
    const int width = (int)ceil((real)c->width * scale), height = (int)ceil((real)c->height * scale);
    const real across = (real)width / (real)c->width, down = (real)height / (real)c->height;
    c->fx *= across;
    c->cx *= across;
    c->fy *= down;
    c->cy *= down;
    c->width = width;
    c->height = height;
    seen.gbuffer = ffp_gbuffer_new(width, height);
    ffp_rasterise(source->raster, source->gaussians, c, source->settings, &seen.gbuffer);
    return seen;
}

void ffp_depth_view_free(FfpDepthView *seen) {
    ffp_gbuffer_free(&seen->gbuffer);
}

int ffp_depth_view_pixel(const FfpDepthView *seen, const real point[3], real *depth) {
    real u, v;
    *depth = ffp_project(&seen->camera, point, &u, &v);
    if (!(*depth > 0) || !(u >= 0 && v >= 0 && u < (real)seen->camera.width && v < (real)seen->camera.height))
        return -1;
    return (int)v * seen->camera.width + (int)u;
}

real ffp_depth_view_facing(const FfpDepthView *seen, int pixel, const real point[3]) {
    const real *n = seen->gbuffer.normal + 3 * (size_t)pixel;
    real to[3], along = 0, square = 0;
    for (int k = 0; k < 3; k++) to[k] = seen->camera.pose[4 * k + 3] - point[k];
    ffp_normalise3(to);
    for (int k = 0; k < 3; k++) {
        along += n[k] * to[k];
        square += n[k] * n[k];
    }
    return square > 0 ? fmax(along / sqrt(square), (real)0) : 0;
}

// --- The grid. ---

// The box of the Gaussians that are not nearly transparent, within the object's sphere.
static FfpVolume place_grid(const FfpDepthSource *source, int resolution) {
    const FfpGaussians *g = source->gaussians;
    const FfpCapture *capture = source->capture;
    FfpVolume volume = {0};
    real high[3], longest = 0;
    for (int k = 0; k < 3; k++) {
        const real least = capture->centre[k] - capture->radius, most = capture->centre[k] + capture->radius;
        volume.low[k] = most;
        high[k] = least;
        for (int64_t i = 0; i < g->count; i++) {
            if (g->opacity[i] < SOLID) continue;
            const real x = fmin(fmax(g->centre[3 * i + k], least), most);
            volume.low[k] = fmin(volume.low[k], x);
            high[k] = fmax(high[k], x);
        }
        longest = fmax(longest, high[k] - volume.low[k]);
    }
    volume.cell = fmax(longest, capture->radius * 1e-3F) / (real)resolution;
    volume.truncation = TRUNCATION * volume.cell;
    for (int k = 0; k < 3; k++) {
        const real side = fmax(high[k] - volume.low[k], (real)0);
        volume.low[k] -= (TRUNCATION + MARGIN) * volume.cell;
        volume.size[k] = (int)ceil(side / volume.cell) + 2 * (TRUNCATION + MARGIN) + 1;
    }
    return volume;
}

static size_t points_of(const FfpVolume *volume) {
    return (size_t)volume->size[0] * (size_t)volume->size[1] * (size_t)volume->size[2];
}

static void point_at(const FfpVolume *volume, size_t i, real point[3]) {
    const size_t nx = (size_t)volume->size[0], ny = (size_t)volume->size[1];
    const size_t at[3] = {i % nx, i / nx % ny, i / nx / ny};
    for (int k = 0; k < 3; k++) point[k] = volume->low[k] + (real)at[k] * volume->cell;
}

// The evidence of the looks so far on a point.
typedef struct Fused {
    real sum, weight; // of how far before the surface it lies, in truncations
    int held;         // pictures that hold the point
} Fused;

// Adds what one view says: at most a truncation, and nothing of what is hidden behind.
static void fuse_point(const FfpVolume *volume, const FfpDepthView *seen, size_t i, Fused *fused) {
    real point[3], depth;
    point_at(volume, i, point);
    const int pixel = ffp_depth_view_pixel(seen, point, &depth);
    if (pixel < 0) return;
    fused->held++;
    const real opacity = seen->gbuffer.opacity[pixel];
    if (!(opacity > SOLID)) {
        fused->sum += 1;
        fused->weight += 1;
        return;
    }
    const real before = (seen->gbuffer.depth[pixel] / opacity - depth) / volume->truncation;
    if (before < -1) return;
    const real share = fmax(ffp_depth_view_facing(seen, pixel, point), FACING_MIN);
    fused->sum += share * fmin(before, (real)1);
    fused->weight += share;
}

// A point hidden from all views is inside if it lies within at least three quarters of the pictures;
// elsewhere the object would have been cut off by their edges.
static real settle(const Fused *fused, int views) {
    if (fused->weight > 0) return fused->sum / fused->weight;
    return 4 * fused->held < 3 * views ? 1 : -1;
}

// The grid's two outermost layers, which are outside whatever the looks say: so that the surface closes
// there.
static bool at_edge(const FfpVolume *volume, size_t i) {
    const size_t nx = (size_t)volume->size[0], ny = (size_t)volume->size[1], nz = (size_t)volume->size[2];
    const size_t x = i % nx, y = i / nx % ny, z = i / nx / ny;
    return x < 2 || y < 2 || z < 2 || x + 2 >= nx || y + 2 >= ny || z + 2 >= nz;
}

// Means by 1 2 1 along an axis, whose points lie `step` apart: the terraces that pixels leave in the distance
// go.
static void smooth_along(const FfpVolume *volume, size_t step, const real *from, real *to) {
    const size_t points = points_of(volume);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < points; i++)
        to[i] = at_edge(volume, i) ? 1 : (from[i - step] + 2 * from[i] + from[i + step]) / 4;
}

static void smooth(FfpVolume *volume) {
    const size_t row = (size_t)volume->size[0], plane = row * (size_t)volume->size[1];
    real *other = ffp_alloc(points_of(volume), sizeof *other);
    for (int k = 0; k < SMOOTHINGS; k++) {
        smooth_along(volume, 1, volume->distance, other);
        smooth_along(volume, row, other, volume->distance);
        smooth_along(volume, plane, volume->distance, other);
        real *swap = volume->distance;
        volume->distance = other;
        other = swap;
    }
    ffp_free(other);
}

FfpVolume ffp_volume_fuse(const FfpDepthSource *source, int resolution) {
    FfpVolume volume = place_grid(source, resolution);
    const size_t points = points_of(&volume);
    const int views = source->capture->n_views;
    Fused *fused = ffp_alloc(points, sizeof *fused);
    FfpTask progress = ffp_task("fusing", views);
    for (int v = 0; v < views; v++) {
        FfpDepthView seen = ffp_depth_view(source, v, volume.cell);
#pragma omp parallel for schedule(static)
        for (size_t i = 0; i < points; i++) fuse_point(&volume, &seen, i, &fused[i]);
        ffp_depth_view_free(&seen);
        ffp_task_step(&progress, v + 1, source->capture->views[v].id);
    }
    ffp_task_end(&progress);
    volume.distance = ffp_alloc(points, sizeof *volume.distance);
    for (size_t i = 0; i < points; i++)
        volume.distance[i] = at_edge(&volume, i) ? 1 : settle(&fused[i], views);
    ffp_free(fused);
    smooth(&volume);
    return volume;
}

void ffp_volume_free(FfpVolume *volume) {
    ffp_free(volume->distance);
    *volume = (FfpVolume){0};
}
