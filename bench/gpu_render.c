// Times of drawing on the GPU: the functions of the render room's table, whole views and a training step's
// views, at training's sizes. With an argument, or on the emulation, at tiny ones.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "bench/gpu_timing.h"
#include "engine/render/pass.h"
#include "engine/render/table.h"
#include "tests/ball.h"

enum { VIEWS = 5, PATTERNS = 3 };

struct Bench {
    bool tiny; // every function once
    FfpRenderSettings settings;
    FfpCamera camera[VIEWS], projector[VIEWS], fine; // fine: the first with a pixel for each sample
    FfpGaussians gaussians, grad;                    // on the device, as all arrays
    FfpSummed light;
    FfpImage linear, grad_linear, picture, grad_picture;
    FfpRaster *raster, *shadow_raster;
    FfpGbuffer samples, grad_samples, averaged, grad_averaged, shadow;
    FfpMapping mapping;
    FfpTransport transport, grad_transport;
    FfpViewPass *pass;
};

static const real intensity[3] = {4, 4, 4};

static void rasterise(Bench *b) {
    ffp_rasterise(b->raster, &b->gaussians, &b->fine, &b->settings, &b->samples);
}
static void rasterise_backward(Bench *b) {
    ffp_rasterise_backward(b->raster, &b->gaussians, &b->fine, &b->settings, &b->samples, &b->grad_samples,
                           &b->grad);
}
static void shadow_map(Bench *b) {
    b->shadow = ffp_shadow_map(b->shadow_raster, &b->gaussians, &b->projector[0], &b->settings);
}
static void map(Bench *b) {
    ffp_map_with_shadow(&b->shadow, &b->samples, &b->fine, &b->projector[0], &b->settings, &b->mapping);
}
static void light(Bench *b) {
    ffp_light(&b->samples, &b->mapping, &b->fine, &b->projector[0], &b->transport);
}
static void light_backward(Bench *b) {
    ffp_light_backward(&b->samples, &b->mapping, &b->fine, &b->projector[0], &b->grad_transport,
                       &b->grad_samples);
}
static void shade(Bench *b) {
    ffp_shade(&b->averaged, &b->mapping, &b->transport, intensity, &b->light, &b->linear);
}
static void shade_backward(Bench *b) {
    ffp_shade_backward(&b->mapping, &b->transport, intensity, &b->light, &b->grad_linear, &b->grad_averaged,
                       &b->grad_transport, NULL, NULL);
}
static void average(Bench *b) {
    ffp_average_gbuffer(&b->samples, b->settings.samples, &b->averaged);
}
static void average_backward(Bench *b) {
    ffp_average_gbuffer_backward(&b->grad_averaged, b->settings.samples, &b->grad_samples);
}
static void resolve(Bench *b) {
    ffp_resolve(&b->linear, b->averaged.opacity, b->settings.samples, &b->picture);
}
static void resolve_backward(Bench *b) {
    ffp_resolve_backward(&b->linear, b->averaged.opacity, b->settings.samples, &b->grad_picture,
                         &b->grad_linear, b->grad_averaged.opacity);
}
static void clear(Bench *b) {
    ffp_gbuffer_clear(&b->grad_averaged);
}

static void view_forward(Bench *b, int v) {
    ffp_view_pass_draw(b->pass, &b->gaussians, &b->camera[v], &b->projector[v]);
    ffp_view_pass_gbuffer(b->pass);
    for (int p = 0; p < PATTERNS; p++)
        ffp_view_pass_shade(b->pass, intensity, p ? &b->light : NULL, &b->picture);
}
static void draw(Bench *b) {
    ffp_view_pass_draw(b->pass, &b->gaussians, &b->camera[0], &b->projector[0]);
}
static void forward(Bench *b) {
    view_forward(b, 0);
}
static void step(Bench *b) {
    for (int v = 0; v < VIEWS; v++) {
        view_forward(b, v);
        for (int p = 0; p < PATTERNS; p++)
            ffp_view_pass_shade_backward(b->pass, intensity, p ? &b->light : NULL, &b->grad_picture, NULL,
                                         NULL);
        ffp_view_pass_backward(b->pass, &b->grad);
    }
}

static void run(Bench *b) {
    const double pixels = (double)b->fine.width * b->fine.height, gbuffer = pixels * 13 * sizeof(real);
    const double small = gbuffer / (b->settings.samples * b->settings.samples);
    gpu_report_run("rasterise", b, rasterise, 20, 0);
    gpu_report_run("rasterise backward", b, rasterise_backward, 20, 0);
    gpu_report_run("shadow map", b, shadow_map, 20, 0);
    gpu_report_run("map", b, map, 20, 0);
    gpu_report_run("light", b, light, 20, gbuffer + pixels * 10 * sizeof(real));
    gpu_report_run("shade", b, shade, 20, pixels * 13 * sizeof(real));
    gpu_report_run("shade backward", b, shade_backward, 20, pixels * 24 * sizeof(real));
    gpu_report_run("light backward", b, light_backward, 20, 3 * gbuffer + pixels * 10 * sizeof(real));
    gpu_report_run("average", b, average, 20, gbuffer + small);
    gpu_report_run("average backward", b, average_backward, 20, 2 * gbuffer + small);
    gpu_report_run("resolve", b, resolve, 20, 0);
    gpu_report_run("resolve backward", b, resolve_backward, 20, 0);
    gpu_report_run("clear", b, clear, 20, small);
    gpu_report_run("a view drawn", b, draw, 10, 0);
    gpu_report_run("a view and its pictures", b, forward, 10, 0);
    gpu_report_run("a step's views, there and back", b, step, 3, 0);
}

static FfpImage stripes(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < 3 * width * height; i++) image.data[i] = (real)(i / 3 / 4 % 2);
    return image;
}

static void make_devices(Bench *b, int side, int pattern) {
    for (int v = 0; v < VIEWS; v++) {
        const real azimuth = (real)v * 6.2831853F / VIEWS;
        b->camera[v] = ball_device(azimuth, 0.3F, 2.5F, side, side);
        b->projector[v] = ball_device(azimuth + 0.2F, 1, 2, pattern, pattern);
    }
    b->fine = ball_device(0, 0.3F, 2.5F, b->settings.samples * side, b->settings.samples * side);
}

static void make_buffers(Bench *b, int side) {
    const int fine = b->fine.width;
    b->grad = ffp_gaussians_new(b->gaussians.count);
    b->linear = ffp_image_new(side, side, 3);
    b->grad_linear = ffp_image_new(side, side, 3);
    b->picture = ffp_image_new(side, side, 3);
    b->raster = ffp_raster_new();
    b->shadow_raster = ffp_raster_new();
    b->samples = ffp_gbuffer_new(fine, fine);
    b->grad_samples = ffp_gbuffer_new(fine, fine);
    b->averaged = ffp_gbuffer_new(side, side);
    b->grad_averaged = ffp_gbuffer_new(side, side);
    b->mapping = ffp_mapping_new(fine, fine);
    b->transport = ffp_transport_new(fine, fine);
    b->grad_transport = ffp_transport_new(fine, fine);
    b->pass = ffp_view_pass_new(&b->settings);
}

int main(int argc, char **argv) {
    const FfpDevice *device = gpu_open();
    if (!device) return 1;
    (void)argv;
    const bool tiny = argc > 1 || gpu_emulated();
    const int64_t count = tiny ? 300 : 45000;
    const int side = tiny ? 11 : 128, pattern = tiny ? 32 : 256;
    Bench b = {.tiny = tiny, .settings = ffp_render_defaults()};
    if (tiny) b.settings.shadow_side = 20;
    ffp_device_use(NULL); // the scene is made by the CPU
    make_devices(&b, side, pattern);
    FfpGaussians ball = ball_disturbed(count);
    FfpImage image = stripes(pattern, pattern), grad = stripes(side, side);
    FfpSummed light = ffp_summed_new(&image);
    ffp_device_use(device);
    b.gaussians = ffp_gaussians_uploaded(&ball);
    b.light = ffp_summed_uploaded(&light);
    b.grad_picture = grad;
    b.grad_picture.data = ffp_memory_uploaded(grad.data, 3 * (size_t)(side * side), sizeof(real));
    make_buffers(&b, side);
    printf("%s\n%lld splats, views of %dx%d with %dx%d samples, shadow map %d\n", ffp_cuda_describe(),
           (long long)count, side, side, b.settings.samples, b.settings.samples, b.settings.shadow_side);
    run(&b);
    return 0;
}
