#include "engine/network/pixels.h"
#include <tgmath.h>
#include "core/base/device.h"
#include "core/base/vec.h"
#include "engine/network/inputs.h"
#include "engine/network/table.h"

#define NEAREST_MIN 0.1F // a plain splat's footprint is taken no closer to the camera than this

void ffp_pixel_base(FfpPixelBase *base, const FfpInputSource *source, int64_t pixel, bool residual) {
    const FfpCamera *first = &source->capture->views[0].camera;
    const int64_t row = pixel / first->width;
    const FfpCamera *camera = &source->capture->views[row / first->height].camera;
    for (int i = 0; i < 3; i++) base->origin[i] = camera->pose[4 * i + 3];
    ffp_pixel_ray(camera, (real)(pixel % first->width) + 0.5F, (real)(row % first->height) + 0.5F,
                  base->direction);
    base->nearest = -ffp_dot3(base->origin, base->direction);
    base->footprint = fmax(base->nearest, NEAREST_MIN) / camera->fx;
    if (residual) ffp_residual_base(base, source->start, pixel);
}

int64_t ffp_pixels_all(const FfpInputSource *source) {
    const FfpCamera *camera = &source->capture->views[0].camera;
    return (int64_t)source->views * camera->width * camera->height;
}

int64_t ffp_pixels_select(int64_t *pixel, const FfpModelConfig *config, const FfpInputSource *source) {
    const int64_t all = ffp_pixels_all(source);
    const real *coverage = config->residual ? source->start->coverage : NULL;
    int64_t count = 0;
    for (int64_t p = 0; p < all; p++)
        if (!coverage || coverage[p] > 0) pixel[count++] = p;
    return count;
}

void ffp_pixels_list(FfpPixels *pixels, FfpRun *run, const FfpModelConfig *config,
                     const FfpInputSource *source) {
    run->pixel = ffp_arena_take(run->arena, (size_t)ffp_pixels_all(source) + 1, sizeof *run->pixel);
    const int64_t count = ffp_pixels_select(run->pixel, config, source);
    pixels->count = count;
    pixels->base = ffp_arena_take(run->arena, (size_t)count + 1, sizeof *pixels->base);
    pixels->raw = ffp_arena_take(run->arena, (size_t)(count + 1) * ffp_head_numbers(config), sizeof(real));
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < count; g++)
        ffp_pixel_base(&pixels->base[g], source, run->pixel[g], config->residual);
}

static void allocate_gaussians(FfpRun *run, int64_t count) {
    const size_t n = (size_t)count + 1;
    run->gaussians = (FfpGaussians){.count = count,
                                    .centre = ffp_arena_take(run->arena, n * 3, sizeof(real)),
                                    .scale = ffp_arena_take(run->arena, n * 3, sizeof(real)),
                                    .rotation = ffp_arena_take(run->arena, n * 4, sizeof(real)),
                                    .opacity = ffp_arena_take(run->arena, n, sizeof(real)),
                                    .albedo = ffp_arena_take(run->arena, n * 3, sizeof(real)),
                                    .roughness = ffp_arena_take(run->arena, n, sizeof(real)),
                                    .ambient = ffp_arena_take(run->arena, n * 3, sizeof(real))};
    run->t = ffp_arena_take(run->arena, n, sizeof(real));
}

bool ffp_pixels_splat(const FfpPixels *pixels, FfpRun *run, const FfpModelConfig *config) {
    const int numbers = ffp_head_numbers(config);
    allocate_gaussians(run, pixels->count);
    if (ffp_device())
        return ffp_device()->network->splat(&run->gaussians, run->t, pixels->base, pixels->raw, pixels->count,
                                            config->residual);
    bool bad = false;
#pragma omp parallel for schedule(static) reduction(|| : bad)
    for (int64_t g = 0; g < pixels->count; g++) {
        const real *raw = pixels->raw + g * numbers;
        real sum = 0;
        for (int i = 0; i < numbers; i++) sum += raw[i];
        bad = bad || !isfinite(sum);
        FfpPixelSplat splat;
        if (config->residual)
            ffp_residual_splat(&splat, &pixels->base[g], raw);
        else
            ffp_plain_splat(&splat, &pixels->base[g], raw);
        run->t[g] = splat.t;
        ffp_splat_store(&run->gaussians, g, &splat, &pixels->base[g]);
    }
    return !bad;
}

void ffp_pixels_splat_backward(real *draw, const FfpPixels *pixels, int64_t first, int count,
                               const FfpModelConfig *config, const FfpGaussians *grad, const real *grad_t) {
    const int numbers = ffp_head_numbers(config);
    if (ffp_device()) {
        ffp_device()->network->splat_backward(draw, pixels->base, pixels->raw, first, count, config->residual,
                                              grad, grad_t);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++) {
        const int64_t g = first + i;
        const FfpPixelBase *base = &pixels->base[g];
        FfpPixelSplat d = {.t = ffp_dot3(grad->centre + 3 * g, base->direction) + (grad_t ? grad_t[g] : 0),
                           .opacity = grad->opacity[g],
                           .roughness = grad->roughness[g]};
        for (int k = 0; k < 3; k++) {
            d.scale[k] = grad->scale[3 * g + k];
            d.albedo[k] = grad->albedo[3 * g + k];
            d.ambient[k] = grad->ambient[3 * g + k];
        }
        for (int k = 0; k < 4; k++) d.rotation[k] = grad->rotation[4 * g + k];
        if (config->residual)
            ffp_residual_splat_backward(draw + (size_t)i * numbers, &d, base, pixels->raw + g * numbers);
        else
            ffp_plain_splat_backward(draw + (size_t)i * numbers, &d, base, pixels->raw + g * numbers);
    }
}
