#include "lab/bench/raster_times.h"
#include <stdlib.h>
#include "core/base/real.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/render/raster.h"
#include "lab/bench/bench.h"

#define BALL 0.6F // radius; the ground touches it from below
#define VIEWS 8

// A device at `azimuth` (in eighths of a turn) and `elevation`, looking at the origin, z up.
static FfpCamera device_at(int side, real focal_share, real radius, real azimuth, real elevation) {
    const real a = azimuth * (2 * FFP_PI / VIEWS), half = 0.5F * (real)side, focal = focal_share * (real)side;
    const real out[3] = {cos(elevation) * cos(a), cos(elevation) * sin(a), sin(elevation)};
    const real right[3] = {-sin(a), cos(a), 0};
    FfpCamera c = {side, side, focal, focal, half, half, {0}};
    real down[3];
    ffp_cross3(right, out, down);
    for (int i = 0; i < 3; i++) {
        c.pose[4 * i] = right[i];
        c.pose[4 * i + 1] = down[i];
        c.pose[4 * i + 2] = -out[i];
        c.pose[4 * i + 3] = radius * out[i];
    }
    c.pose[15] = 1;
    return c;
}

static FfpCamera camera_at(int side, real azimuth) {
    return device_at(side, 1.375F, 3, azimuth, FFP_PI / 4); // 40 degrees wide
}

FfpCamera ffp_bench_camera(int side) {
    return camera_at(side, 0.5F);
}

// Where the ray from `eye` along `d` meets ball or ground: camera depth and normal.
static real meet(const real eye[3], const real d[3], real normal[3]) {
    const real a = ffp_dot3(d, d), b = ffp_dot3(eye, d), c = ffp_dot3(eye, eye) - BALL * BALL;
    const real root = b * b - a * c, ground = (-BALL - eye[2]) / d[2];
    real z = ground;
    normal[0] = normal[1] = 0, normal[2] = 1;
    if (root <= 0) return z;
    z = (-b - sqrt(root)) / a;
    for (int k = 0; k < 3; k++) normal[k] = (eye[k] + z * d[k]) / BALL;
    return z;
}

// The rotation that takes z to the normal (which looks up, or down but not straight).
static void normal_rotation(const real n[3], real q[4]) {
    real length = 0;
    q[0] = 1 + n[2], q[1] = -n[1], q[2] = n[0], q[3] = 0;
    for (int k = 0; k < 4; k++) length += q[k] * q[k];
    for (int k = 0; k < 4; k++) q[k] /= sqrt(length);
}

static void lay_splat(FfpGaussians *g, int64_t i, const FfpCamera *camera, int x, int y, real size,
                      FfpRng *rng) {
    const real eye[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    const real ray[3] = {((real)x + 0.5F - camera->cx) / camera->fx,
                         ((real)y + 0.5F - camera->cy) / camera->fy, 1};
    real d[3], normal[3];
    ffp_rotate(camera->pose, ray, d);
    const real z = meet(eye, d, normal) * ffp_rng_range(rng, 0.998F, 1.002F);
    normal_rotation(normal, g->rotation + 4 * i);
    for (int k = 0; k < 3; k++) {
        g->centre[3 * i + k] = eye[k] + z * d[k];
        g->scale[3 * i + k] = (k < 2 ? 0.5F : 0.05F) * size * z / camera->fx;
        g->albedo[3 * i + k] = ffp_rng_range(rng, 0.1F, 0.9F);
        g->ambient[3 * i + k] = ffp_rng_range(rng, 0.0F, 0.3F);
    }
    g->roughness[i] = ffp_rng_range(rng, 0.2F, 0.9F);
}

FfpGaussians ffp_bench_splats(int side, real opacity, real size) {
    const int64_t pixels = (int64_t)side * side;
    FfpGaussians g = ffp_gaussians_new(VIEWS * pixels);
    FfpRng rng = ffp_rng(61, 1);
    for (int v = 0; v < VIEWS; v++) {
        const FfpCamera camera = camera_at(side, (real)v);
        for (int64_t p = 0; p < pixels; p++) {
            g.opacity[v * pixels + p] = opacity;
            lay_splat(&g, v * pixels + p, &camera, (int)(p % side), (int)(p / side), size, &rng);
        }
    }
    return g;
}

// Inputs and outputs of a view's passes.
typedef struct Bench {
    const FfpGaussians *gaussians;
    FfpGaussians grad;
    const FfpCamera *camera;
    FfpCamera projector;
    FfpRenderSettings settings;
    FfpRaster *raster, *shadows;
    FfpGbuffer out, weights, grad_out;
    FfpMapping mapping;
    FfpTransport transport, grad_transport;
    FfpImage image;
    FfpSummed pattern;
} Bench;

static Bench bench_new(const FfpGaussians *gaussians, const FfpCamera *camera) {
    const int width = camera->width, height = camera->height;
    FfpImage white = ffp_image_new(800, 800, 3);
    for (int i = 0; i < 3 * 800 * 800; i++) white.data[i] = 1;
    Bench b = {gaussians,
               ffp_gaussians_new(gaussians->count),
               camera,
               device_at(800, 0.96F, 2, 0.5F, 1.1F),
               ffp_render_defaults(),
               ffp_raster_new(),
               ffp_raster_new(),
               ffp_gbuffer_new(width, height),
               ffp_gbuffer_new(width, height),
               ffp_gbuffer_new(width, height),
               ffp_mapping_new(width, height),
               ffp_transport_new(width, height),
               ffp_transport_new(width, height),
               ffp_image_new(width, height, 3),
               ffp_summed_new(&white)};
    ffp_image_free(&white);
    real *const planes[] = {b.weights.opacity, b.weights.depth,     b.weights.normal,    b.weights.albedo,
                            b.weights.ambient, b.weights.roughness, b.weights.distortion};
    const int channels[] = {1, 1, 3, 3, 3, 1, 1};
    FfpRng rng = ffp_rng(3, 2);
    for (int k = 0; k < 7; k++)
        for (int i = 0; i < channels[k] * width * height; i++) planes[k][i] = ffp_rng_range(&rng, -1, 1);
    return b;
}

static void bench_free(Bench *b) {
    ffp_gaussians_free(&b->grad);
    ffp_raster_free(b->raster);
    ffp_raster_free(b->shadows);
    ffp_gbuffer_free(&b->out);
    ffp_gbuffer_free(&b->weights);
    ffp_gbuffer_free(&b->grad_out);
    ffp_mapping_free(&b->mapping);
    ffp_transport_free(&b->transport);
    ffp_transport_free(&b->grad_transport);
    ffp_image_free(&b->image);
    ffp_summed_free(&b->pattern);
}

// Adds a lap to the least time so far.
static void lap(double *least, double *clock) {
    const double now = ffp_bench_clock.now(), ms = 1e3 * (now - *clock);
    if (!(*least <= ms)) *least = ms;
    *clock = now;
}

static void time_whole(Bench *b, FfpRasterTimes *t) {
    const real intensity[3] = {8, 8, 8};
    double clock = ffp_bench_clock.now();
    ffp_rasterise(b->raster, b->gaussians, b->camera, &b->settings, &b->out);
    lap(&t->rasterise, &clock);
    ffp_map_to_projector(b->shadows, b->gaussians, &b->out, b->camera, &b->projector, &b->settings,
                         &b->mapping);
    lap(&t->map, &clock);
    ffp_light(&b->out, &b->mapping, b->camera, &b->projector, &b->transport);
    ffp_shade(&b->out, &b->mapping, &b->transport, intensity, &b->pattern, &b->image);
    lap(&t->shade, &clock);
    ffp_shade_backward(&b->mapping, &b->transport, intensity, &b->pattern, &b->image, &b->grad_out,
                       &b->grad_transport, NULL, NULL);
    ffp_light_backward(&b->out, &b->mapping, b->camera, &b->projector, &b->grad_transport, &b->grad_out);
    lap(&t->shade_backward, &clock);
    ffp_rasterise_backward(b->raster, b->gaussians, b->camera, &b->settings, &b->out, &b->weights, &b->grad);
    lap(&t->rasterise_backward, &clock);
}

// The same work as ffp_rasterise and its backward pass, in parts.
static void time_parts(Bench *b, FfpRasterTimes *t) {
    FfpRaster *r = b->raster;
    double clock = ffp_bench_clock.now();
    ffp_project_splats(r, b->gaussians, b->camera, &b->settings);
    lap(&t->project, &clock);
    ffp_bin_splats(r);
    lap(&t->bin, &clock);
    ffp_blend(r, FFP_CHANNELS, &b->out);
    lap(&t->blend, &clock);
    ffp_blend_backward(r, &b->out, &b->weights);
    lap(&t->blend_backward, &clock);
    ffp_project_splats_backward(r, b->gaussians, b->camera, &b->settings, &b->grad);
    lap(&t->project_backward, &clock);
    t->splats = r->n_splats;
    t->instances = r->instances;
}

FfpRasterTimes ffp_time_raster(const FfpGaussians *gaussians, const FfpCamera *camera, int repeats) {
    const double none = INFINITY;
    FfpRasterTimes t = {none, none, none, none, none, none, none, none, none, none, 0, 0};
    Bench b = bench_new(gaussians, camera);
    for (int i = 0; i < repeats; i++) {
        time_whole(&b, &t);
        time_parts(&b, &t);
    }
    bench_free(&b);
    return t;
}
