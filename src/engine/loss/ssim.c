// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) with an 11x11 Gaussian window, sigma 1.5, and
// zero padding at the borders, as GS-ProCams takes it. The window is separable, and symmetric, hence its own
// adjoint: the gradient is the same blur applied to the slopes of the index with respect to the five local
// moments E[a], E[b], E[a a], E[b b], E[a b].
#include <assert.h>
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "engine/loss/deferred.h"
#include "engine/loss/kernels/kernels.h"
#include "engine/loss/loss.h"
#include "engine/loss/table.h"

static FfpSsimWindow window_for(const FfpImage *image) {
    FfpSsimWindow window = {.height = image->height,
                            .edge = FFP_SSIM_RADIUS * image->channels,
                            .row = image->width * image->channels,
                            .channels = image->channels};
    real sum = 0;
    for (int k = 0; k < FFP_SSIM_TAPS; k++) {
        const real x = (real)(k - FFP_SSIM_RADIUS) / 1.5F;
        sum += window.taps[k] = exp(-0.5F * x * x);
    }
    for (int k = 0; k < FFP_SSIM_TAPS; k++) window.taps[k] /= sum;
    return window;
}

// Mean SSIM; adds scale * (gradient of the SUM of the index by a) to grad unless that is NULL.
static double mean_ssim(const FfpImage *a, const FfpImage *b, real scale, FfpImage *grad) {
    assert(a->width == b->width && a->height == b->height && a->channels == b->channels);
    const FfpSsimWindow window = window_for(a);
    const size_t map = (size_t)window.row * window.height;
    if (map == 0) return 1;
    if (ffp_device()) return ffp_device()->loss->ssim(a, b, scale, grad);
    const FfpLossKernels *ssim = ffp_loss_kernels();
    real *moments = ffp_take((FFP_SSIM_MOMENTS + (grad ? FFP_SSIM_SLOPES : 0)) * map, sizeof *moments);
    real *slopes = grad ? moments + FFP_SSIM_MOMENTS * map : NULL;
    double *row_sums = ffp_take(window.height, sizeof *row_sums), sum = 0;
    ssim->blur_moments(&window, moments, a, b);
    ssim->compare(&window, row_sums, slopes, moments);
    for (int y = 0; y < window.height; y++) sum += row_sums[y];
    if (grad) ssim->add_gradient(&window, slopes, a, b, scale, grad);
    ffp_free(row_sums);
    ffp_free(moments);
    return sum / (double)map;
}

real ffp_ssim_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    const real count = (real)prediction->width * prediction->height * prediction->channels;
    const double mean = mean_ssim(prediction, target, -weight / count, grad);
    return ffp_loss_deferred_as(FFP_DEFERRED_SIMILARITY, weight) ? 0 : weight * (real)(1 - mean);
}

real ffp_ssim(const FfpImage *a, const FfpImage *b) {
    return (real)mean_ssim(a, b, 0, NULL);
}
