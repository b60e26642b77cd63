// The paper's loss terms (Sec. 3.6 there), each with its backward; SSIM; perceptual networks.
// Every *_loss returns the loss's value times `weight` and ADDS weight * gradient to the grad argument, which
// may be NULL. On a device (core/base/device.h) all pictures and maps are in its memory; values are returned
// to the host, at the cost of waiting for them.
#ifndef FFP_LOSS_LOSS_H
#define FFP_LOSS_LOSS_H

#include <stdbool.h>
#include "core/base/error.h"
#include "core/base/real.h"
#include "core/image/image.h"

// mean |prediction - target| over all values; images of equal shape.
real ffp_l1_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
// mean (prediction - target)^2, likewise.
real ffp_square_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
// 1 - mean SSIM: 11x11 Gaussian, sigma 1.5, C1 = 1e-4, C2 = 9e-4, zero padding (as GS-ProCams), mean over
// pixels, channels.
real ffp_ssim_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
real ffp_ssim(const FfpImage *a, const FfpImage *b); // the metric of the reports: same window, same padding

// Binary cross-entropy of opacity [pixels] (clamped to [1e-6, 1-1e-6]) against the mask in [0,1]; mean over
// pixels.
real ffp_mask_loss(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity);
// Mean over pixels with truth > 0 and opacity > 0.5 of (depth_sum / opacity - truth)^2; gradients to
// depth_sum, opacity. 0 without such pixels.
real ffp_depth_loss(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                    real *grad_depth_sum, real *grad_opacity);
// Mean over pixels of the rasteriser's distortion map.
real ffp_distortion_loss(const real *distortion, int pixels, real weight, real *grad_distortion);
// Mean over the values of foreground pixels (coverage > 0.5) of |sum - opacity truth|, opacity a constant: a
// G-buffer against the generator's map [height,width,channels].
double ffp_truth_loss(const real *sum, const real *opacity, const FfpImage *truth, const FfpImage *coverage,
                      real weight, real *grad);
// Mean over elements of truth > 0 of |t - truth|; OVERWRITES grad [count]. An absolute error, because
// matching's errors are outliers.
double ffp_distance_loss(const real *t, const real *truth, int64_t count, real weight, real *grad);
// Mean |grad N|_1 over neighbouring foreground pixels (mask > 0.5 on both), N normalised inside; grad to the
// raw sums [height,width,3]. Neighbours: right and below; |.|_1 sums the components. Sums shorter than 0.1
// are left out.
real ffp_normal_smooth_loss(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad);
// Mean |grad R|_1 exp(-|grad A|_1) with R, A divided by opacity; A [height,width,3] is a constant.
// Neighbouring foreground pixels as above (|grad A|_1 sums the channels); pixels of opacity up to 0.1 are
// left out.
real ffp_roughness_loss(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity);

// On a device each value costs a wait for all work before it. Between ffp_losses_defer and ffp_losses_collect
// the thread does not wait: the values returned by the functions here (except ffp_ssim) and by ffp_psnr may
// then only be passed to ffp_loss_add, which adds weight * value to *sum at the collection: one wait for all
// of them. Pairs may be nested. On the CPU ffp_loss_add adds at once.
void ffp_losses_defer(void);
void ffp_loss_add(double *sum, double weight, double value);
void ffp_losses_collect(void);

// Perceptual networks, read from safetensors (docs/reference/formats/weights.md): LPIPS with AlexNet or
// SqueezeNet, VGG16 up to relu2_2.
typedef struct FfpPerceptual FfpPerceptual;
// `kind` is given by the file's tensor names. Errors: missing file, missing or misshapen tensor.
FfpPerceptual *ffp_perceptual_read(const char *path, FfpError *err);
void ffp_perceptual_free(FfpPerceptual *net);
bool ffp_perceptual_is_lpips(const FfpPerceptual *net);
// LPIPS distance of two encoded RGB images in [0,1] (v0.1, inputs scaled to [-1,1]); or for VGG16 the mean
// squared feature distance at relu1_2 and relu2_2 (sum of the two means). `weight` and grad as above; grad
// may be NULL. A fourth channel is ignored. A picture with a side below ffp_perceptual_least_side has no
// distance: 0, and no gradient.
real ffp_perceptual_loss(const FfpPerceptual *net, const FfpImage *prediction, const FfpImage *target,
                         real weight, FfpImage *grad);
int ffp_perceptual_least_side(const FfpPerceptual *net); // in pixels: 31 AlexNet, 17 SqueezeNet, 2 VGG16

#endif
