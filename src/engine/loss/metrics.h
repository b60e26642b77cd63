// Figures that compare a picture with the truth: in this room because training reports them as evaluation
// does. SSIM for the reports is ffp_ssim (engine/loss/loss.h: 11x11 Gaussian window, zero padding at the
// borders as GS-ProCams), LPIPS is ffp_perceptual_loss. On a device too.
#ifndef FFP_LOSS_METRICS_H
#define FFP_LOSS_METRICS_H

#include "core/image/image.h"

#define FFP_PSNR_CAP 100.0 // dB; identical pictures have no finite PSNR, and JSON no infinity

// Peak signal-to-noise ratio in dB of two pictures of equal shape, encoded in [0,1]: 10 log10(1 / MSE), the
// mean taken over all pixels and channels. At most FFP_PSNR_CAP; NaN when a picture holds a NaN.
double ffp_psnr(const FfpImage *a, const FfpImage *b);
// The same over the pixels where mask (one channel, same size) is above 0.5; NaN when there are none.
double ffp_psnr_masked(const FfpImage *a, const FfpImage *b, const FfpImage *mask);

#endif
