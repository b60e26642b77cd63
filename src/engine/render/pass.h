// One view of a set of Gaussians, from splats to the picture that a camera takes and back: rasterised and
// mapped to the projector once, shaded under any number of patterns. Owns the buffers of the view.
//
// Every pixel has samples x samples samples (FfpRenderSettings.samples). Its value in the picture is that of
// a display with straight alpha: with L the mean of the premultiplied linear radiance and O that of the
// opacity, O enc(L / O), where enc is the sRGB curve; or enc(L) if there is hardly any surface, and with one
// sample, where O is the opacity of a splat and not the share of the pixel that it covers.
//
// A pass belongs to the device that the thread works on when it is made (core/base/device.h): Gaussians,
// patterns, pictures and gradients are then arrays of that device's memory.
#ifndef FFP_RENDER_PASS_H
#define FFP_RENDER_PASS_H

#include "engine/render/aim.h"
#include "engine/render/render.h"

typedef struct FfpViewPass FfpViewPass;
FfpViewPass *ffp_view_pass_new(const FfpRenderSettings *settings); // reusable between views and steps
void ffp_view_pass_free(FfpViewPass *pass);                        // NULL is allowed
// For callers that need the gradients of most pictures: shading keeps its pattern lookups. Before the first
// draw.
void ffp_view_pass_expect_gradients(FfpViewPass *pass);

// Rasterises the Gaussians for the camera and maps them to the projector. The Gaussians must live until the
// backward pass; camera and projector are copied.
void ffp_view_pass_draw(FfpViewPass *pass, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpCamera *projector);
// The next draws see light by this shadow map, as it was drawn for the same projector before; if its size is
// 0, the next draw fills it (the caller's to free by ffp_gbuffer_free). NULL: every draw makes its own.
void ffp_view_pass_keep_shadow(FfpViewPass *pass, FfpGbuffer *shadow);
// The drawn maps, [height,width] of the camera: means over each pixel's samples of the raw sums.
const FfpGbuffer *ffp_view_pass_gbuffer(FfpViewPass *pass);
FfpImage ffp_view_pass_picture_new(const FfpViewPass *pass); // black, of the size of the view drawn last
// The picture under a pattern (NULL: black): sRGB-encoded, in [0,1], [height,width,3].
void ffp_view_pass_shade(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern, FfpImage *out);

// Its two halves, for callers that keep several pictures until their gradients come: the linear radiance,
// unclamped, premultiplied, and from there to the picture.
void ffp_view_pass_radiance(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                            FfpImage *linear);
void ffp_view_pass_resolve(FfpViewPass *pass, const FfpImage *linear, FfpImage *out);

// Moves the places of the pattern from which the samples of the view drawn last have their light, by pixels
// of it, until the next draw. On the CPU alone.
void ffp_view_pass_shift(FfpViewPass *pass, real x, real y);

// Gradient of the loss with respect to ffp_view_pass_gbuffer, zero after each draw: terms that look at
// G-buffers add theirs.
FfpGbuffer *ffp_view_pass_grad_gbuffer(FfpViewPass *pass);
// From the gradient of the picture shaded last to the samples; ADDS to the intensity and to the pattern's
// summed-area adjoint where they are not NULL (on a device they must be). Intensity and pattern are those of
// that picture.
void ffp_view_pass_shade_backward(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                                  const FfpImage *grad_picture, real grad_intensity[3],
                                  FfpSummed *grad_pattern);
// The first half of it backwards, of a picture drawn as `linear`, and the second: the gradient of radiance.
void ffp_view_pass_resolve_backward(FfpViewPass *pass, const FfpImage *linear, const FfpImage *grad_picture,
                                    FfpImage *grad_linear);
void ffp_view_pass_radiance_backward(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern,
                                     const FfpImage *grad_linear, real grad_intensity[3],
                                     FfpSummed *grad_pattern);
// ffp_hold_places (hold.h) of the view drawn last, which has been shaded under a pattern. Its gradient is
// gathered like a picture's. On the CPU alone.
real ffp_view_pass_hold(FfpViewPass *pass, const FfpImage *positions, real scale, real weight);
// All that was gathered since the draw, ADDED to grad (as many as the Gaussians drawn). Once a draw, or once
// for each time that the gathered gradients are forgotten.
void ffp_view_pass_backward(FfpViewPass *pass, FfpGaussians *grad);
void ffp_view_pass_forget_gradients(FfpViewPass *pass);
// After that, where `grad` was 0 before it: ADDS the gradients of both devices. On the CPU alone.
void ffp_view_pass_backward_aim(FfpViewPass *pass, const FfpGaussians *grad, FfpAimGradient *aim);

// The samples themselves, [samples height, samples width]; callers that change them must call
// samples_changed.
FfpGbuffer *ffp_view_pass_samples(FfpViewPass *pass);
void ffp_view_pass_samples_changed(FfpViewPass *pass);            // maps and averages again
const FfpMapping *ffp_view_pass_mapping(const FfpViewPass *pass); // of the samples

// One picture and nothing else: the caller's to free.
FfpImage ffp_render_view(const FfpGaussians *gaussians, const FfpCamera *camera, const FfpCamera *projector,
                         const real intensity[3], const FfpSummed *pattern,
                         const FfpRenderSettings *settings);

#endif
