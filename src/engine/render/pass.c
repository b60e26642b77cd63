#include "engine/render/pass.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "engine/render/hold.h"
#include "engine/render/outline.h"
#include "engine/render/resolve.h"

struct FfpViewPass {
    FfpRenderSettings settings;
    FfpRaster *raster, *shadow_raster;
    const FfpGaussians *gaussians; // drawn last,
    FfpCamera camera, projector;   // by a camera that has a pixel for each sample
    FfpMapping mapping;            // of the samples
    real outline;                  // deviation in pixels of the picture (outline.h), 0: as it is
    FfpGbuffer *kept_shadow;       // the caller's
    FfpGbuffer samples, mean;      // the same memory when there is one sample a pixel; means of opacity,
    bool averaged;                 // ambient and scattered colour are always there, the others once they are
                                   // asked for
    FfpTransport transport;
    bool keeps_look;         // the transport keeps what shading sees
    bool lit;                // the transport is this view's
    const FfpSummed *looked; // the pattern that is kept
    FfpImage linear;         // radiance of the picture shaded last
    // Made by the first backward pass of a size:
    FfpGbuffer grad_samples, grad_mean; // the same memory likewise
    FfpTransport grad_transport;
    FfpImage grad_linear;
    bool grad_clear, grad_lit; // since the last draw grad_mean and grad_transport have nothing in them but
                               // what was added; whether that is so of the latter
};

FfpViewPass *ffp_view_pass_new(const FfpRenderSettings *settings) {
    FfpViewPass *pass = ffp_alloc(1, sizeof *pass);
    *pass =
        (FfpViewPass){.settings = *settings, .raster = ffp_raster_new(), .shadow_raster = ffp_raster_new()};
    return pass;
}

void ffp_view_pass_expect_gradients(FfpViewPass *pass) {
    pass->keeps_look = !ffp_device();
}

static void free_buffers(FfpViewPass *pass) {
    if (pass->settings.samples > 1) {
        ffp_gbuffer_free(&pass->mean);
        ffp_gbuffer_free(&pass->grad_mean);
    }
    ffp_gbuffer_free(&pass->samples);
    ffp_gbuffer_free(&pass->grad_samples);
    ffp_mapping_free(&pass->mapping);
    ffp_transport_free(&pass->transport);
    ffp_transport_free(&pass->grad_transport);
    ffp_image_free(&pass->linear);
    ffp_image_free(&pass->grad_linear);
}

void ffp_view_pass_free(FfpViewPass *pass) {
    if (!pass) return;
    free_buffers(pass);
    ffp_raster_free(pass->raster);
    ffp_raster_free(pass->shadow_raster);
    ffp_free(pass);
}

// Light that is scattered has planes from the first draw of Gaussians that scatter any.
static void fit_scattered(FfpGbuffer *samples, FfpGbuffer *mean, int side) {
    ffp_gbuffer_add_scattered(samples);
    if (side == 1)
        mean->scattered = samples->scattered;
    else
        ffp_gbuffer_add_scattered(mean);
}

// Buffers for pictures of width x height.
static void fit_buffers(FfpViewPass *pass, int width, int height) {
    const int side = pass->settings.samples;
    if (pass->linear.width == width && pass->linear.height == height) return;
    free_buffers(pass);
    pass->samples = ffp_gbuffer_new(side * width, side * height);
    pass->mean = side > 1 ? ffp_gbuffer_new(width, height) : pass->samples;
    pass->mapping = ffp_mapping_new(side * width, side * height);
    pass->transport = ffp_transport_new(side * width, side * height);
    if (pass->keeps_look)
        pass->transport.look =
            ffp_memory_new((size_t)(side * width) * (size_t)(side * height), 9 * sizeof(real));
    pass->linear = ffp_image_new(width, height, 3);
    pass->grad_mean = pass->grad_samples = (FfpGbuffer){0};
}

static void fit_grad_buffers(FfpViewPass *pass) {
    const int side = pass->settings.samples;
    if (!pass->grad_linear.data) {
        pass->grad_samples = ffp_gbuffer_new(pass->samples.width, pass->samples.height);
        pass->grad_mean =
            side > 1 ? ffp_gbuffer_new(pass->mean.width, pass->mean.height) : pass->grad_samples;
        pass->grad_linear = ffp_image_new(pass->linear.width, pass->linear.height, 3);
        pass->grad_transport = ffp_transport_new(pass->samples.width, pass->samples.height);
    } else if (!pass->grad_clear) {
        ffp_gbuffer_clear(&pass->grad_mean);
        if (pass->grad_lit) ffp_transport_clear(&pass->grad_transport);
    }
    if (pass->samples.scattered) fit_scattered(&pass->grad_samples, &pass->grad_mean, side);
    pass->grad_clear = true;
    pass->grad_lit = false;
}

// The same camera with `side` x `side` pixels for each.
static FfpCamera sample_camera(const FfpCamera *camera, int side) {
    FfpCamera c = *camera;
    const real s = (real)side;
    c.width *= side;
    c.height *= side;
    c.fx *= s;
    c.fy *= s;
    c.cx *= s;
    c.cy *= s;
    return c;
}

void ffp_view_pass_keep_shadow(FfpViewPass *pass, FfpGbuffer *shadow) {
    pass->kept_shadow = shadow;
}

static void copy_shadow(const FfpGbuffer *from, FfpGbuffer *to) {
    const size_t pixels = (size_t)from->width * (size_t)from->height;
    *to = (FfpGbuffer){.width = from->width,
                       .height = from->height,
                       .opacity = ffp_memory_new(pixels, sizeof(real)),
                       .depth = ffp_memory_new(pixels, sizeof(real))};
    ffp_memory_copy(to->opacity, from->opacity, pixels * sizeof(real));
    ffp_memory_copy(to->depth, from->depth, pixels * sizeof(real));
}

static FfpGbuffer find_shadow(FfpViewPass *pass) {
    if (pass->kept_shadow && pass->kept_shadow->width) return *pass->kept_shadow;
    const FfpGbuffer shadow =
        ffp_shadow_map(pass->shadow_raster, pass->gaussians, &pass->projector, &pass->settings);
    if (pass->kept_shadow && shadow.width) copy_shadow(&shadow, pass->kept_shadow); // else shadows are off
    return shadow;
}

void ffp_view_pass_samples_changed(FfpViewPass *pass) {
    const FfpGbuffer shadow = find_shadow(pass);
    ffp_map_with_shadow(&shadow, &pass->samples, &pass->camera, &pass->projector, &pass->settings,
                        &pass->mapping);
    const int side = pass->settings.samples;
    pass->lit = false;
    pass->looked = NULL;
    pass->averaged = side == 1;
    if (side == 1) return;
    const FfpGbuffer *mean = &pass->mean;
    ffp_average_plane(pass->samples.opacity, side, mean->width, mean->height, 1, mean->opacity);
    ffp_average_plane(pass->samples.ambient, side, mean->width, mean->height, 3, mean->ambient);
    if (mean->scattered)
        ffp_average_plane(pass->samples.scattered, side, mean->width, mean->height, 3, mean->scattered);
}

void ffp_view_pass_draw(FfpViewPass *pass, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpCamera *projector) {
    ffp_cancel_point();
    fit_buffers(pass, camera->width, camera->height);
    if (gaussians->scatters) fit_scattered(&pass->samples, &pass->mean, pass->settings.samples);
    pass->gaussians = gaussians;
    pass->camera = sample_camera(camera, pass->settings.samples);
    pass->projector = *projector;
    pass->outline =
        pass->settings.smooth && pass->settings.samples > 1 ? ffp_outline_deviation(gaussians, camera) : 0;
    pass->grad_clear = false;
    pass->mapping.even = ffp_even_light(gaussians, projector, &pass->settings);
    ffp_lit_box(gaussians, projector, pass->mapping.lit);
    ffp_rasterise(pass->raster, gaussians, &pass->camera, &pass->settings, &pass->samples);
    ffp_view_pass_samples_changed(pass);
}

const FfpGbuffer *ffp_view_pass_gbuffer(FfpViewPass *pass) {
    if (!pass->averaged) ffp_average_gbuffer(&pass->samples, pass->settings.samples, &pass->mean);
    pass->averaged = true;
    return &pass->mean;
}

FfpGbuffer *ffp_view_pass_samples(FfpViewPass *pass) {
    return &pass->samples;
}

const FfpMapping *ffp_view_pass_mapping(const FfpViewPass *pass) {
    return &pass->mapping;
}

FfpImage ffp_view_pass_picture_new(const FfpViewPass *pass) {
    return ffp_image_new(pass->linear.width, pass->linear.height, 3);
}

static void light(FfpViewPass *pass) {
    if (pass->lit) return;
    ffp_light(&pass->samples, &pass->mapping, &pass->camera, &pass->projector, &pass->transport);
    pass->lit = true;
}

void ffp_view_pass_shift(FfpViewPass *pass, real x, real y) {
    const ptrdiff_t samples = (ptrdiff_t)pass->transport.width * pass->transport.height;
    light(pass);
    for (ptrdiff_t i = 0; i < samples; i++) {
        pass->transport.uv[2 * i] += x;
        pass->transport.uv[2 * i + 1] += y;
    }
}

void ffp_view_pass_radiance(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                            FfpImage *linear) {
    if (pattern) light(pass);
    if (pattern && !pattern->plain) pass->looked = pattern;
    ffp_shade(&pass->mean, &pass->mapping, &pass->transport, intensity, pattern, linear);
}

void ffp_view_pass_resolve(FfpViewPass *pass, const FfpImage *linear, FfpImage *out) {
    ffp_resolve(linear, pass->mean.opacity, pass->settings.samples, out);
}

void ffp_view_pass_shade(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                         FfpImage *out) {
    ffp_view_pass_radiance(pass, intensity, pattern, &pass->linear);
    if (pass->outline > 0)
        ffp_resolve_smoothly(&pass->linear, pass->mean.opacity, pass->settings.samples, pass->outline, out);
    else
        ffp_view_pass_resolve(pass, &pass->linear, out);
}

FfpGbuffer *ffp_view_pass_grad_gbuffer(FfpViewPass *pass) {
    if (!pass->grad_clear) fit_grad_buffers(pass);
    return &pass->grad_mean;
}

void ffp_view_pass_resolve_backward(FfpViewPass *pass, const FfpImage *linear, const FfpImage *grad_picture,
                                    FfpImage *grad_linear) {
    FfpGbuffer *grad_mean = ffp_view_pass_grad_gbuffer(pass);
    ffp_resolve_backward(linear, pass->mean.opacity, pass->settings.samples, grad_picture, grad_linear,
                         grad_mean->opacity);
}

void ffp_view_pass_radiance_backward(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                                     const FfpImage *grad_linear, real grad_intensity[3],
                                     FfpSummed *grad_pattern) {
    FfpGbuffer *grad_mean = ffp_view_pass_grad_gbuffer(pass);
    FfpTransport seen = pass->transport;
    if (pattern != pass->looked) seen.look = NULL; // what is kept there is another pattern's
    ffp_shade_backward(&pass->mapping, &seen, intensity, pattern, grad_linear, grad_mean,
                       &pass->grad_transport, grad_intensity, grad_pattern);
    if (grad_pattern) ffp_shade_backward_level(&pass->mean, &pass->mapping, grad_linear, grad_pattern);
    if (pattern) pass->grad_lit = true;
}

void ffp_view_pass_shade_backward(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                                  const FfpImage *grad_picture, real grad_intensity[3],
                                  FfpSummed *grad_pattern) {
    ffp_view_pass_grad_gbuffer(pass); // makes grad_linear
    ffp_view_pass_resolve_backward(pass, &pass->linear, grad_picture, &pass->grad_linear);
    ffp_view_pass_radiance_backward(pass, intensity, pattern, &pass->grad_linear, grad_intensity,
                                    grad_pattern);
}

real ffp_view_pass_hold(FfpViewPass *pass, const FfpImage *positions, real scale, real weight) {
    ffp_view_pass_grad_gbuffer(pass); // makes grad_transport
    pass->grad_lit = true;
    return ffp_hold_places(&pass->transport, pass->settings.samples, positions, scale, weight,
                           &pass->grad_transport);
}

void ffp_view_pass_backward(FfpViewPass *pass, FfpGaussians *grad) {
    const FfpGbuffer *grad_mean = ffp_view_pass_grad_gbuffer(pass);
    if (pass->settings.samples > 1)
        ffp_average_gbuffer_backward(grad_mean, pass->settings.samples, &pass->grad_samples);
    if (pass->grad_lit)
        ffp_light_backward(&pass->samples, &pass->mapping, &pass->camera, &pass->projector,
                           &pass->grad_transport, &pass->grad_samples);
    ffp_rasterise_backward(pass->raster, pass->gaussians, &pass->camera, &pass->settings, &pass->samples,
                           &pass->grad_samples, grad);
}

void ffp_view_pass_forget_gradients(FfpViewPass *pass) {
    pass->grad_clear = false;
}

void ffp_view_pass_backward_aim(FfpViewPass *pass, const FfpGaussians *grad, FfpAimGradient *aim) {
    FfpAimGradient of_samples = {0};
    if (pass->grad_lit)
        ffp_light_backward_aim(&pass->samples, &pass->mapping, &pass->camera, &pass->projector,
                               &pass->grad_transport, &of_samples);
    ffp_rasterise_backward_aim(pass->raster, pass->gaussians, &pass->camera, &pass->settings, &pass->samples,
                               &pass->grad_samples, grad, &of_samples);
    for (int k = 0; k < 6; k++) aim->camera[k] += of_samples.camera[k];
    for (int k = 0; k < 6; k++) aim->projector[k] += of_samples.projector[k];
    for (int k = 0; k < 2; k++) { // the samples' camera is `samples` times as long
        aim->camera_focal[k] += pass->settings.samples * of_samples.camera_focal[k];
        aim->projector_focal[k] += of_samples.projector_focal[k];
    }
}

FfpImage ffp_render_view(const FfpGaussians *gaussians, const FfpCamera *camera, const FfpCamera *projector,
                         const real intensity[3], const FfpSummed *pattern,
                         const FfpRenderSettings *settings) {
    FfpViewPass *pass = ffp_view_pass_new(settings);
    ffp_view_pass_draw(pass, gaussians, camera, projector);
    FfpImage picture = ffp_view_pass_picture_new(pass);
    ffp_view_pass_shade(pass, intensity, pattern, &picture);
    ffp_view_pass_free(pass);
    return picture;
}
