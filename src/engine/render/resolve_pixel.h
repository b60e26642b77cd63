// Inside the render room: the samples of one pixel into its picture, and back; one text for the CPU and the
// GPU.
#ifndef FFP_RENDER_RESOLVE_PIXEL_H
#define FFP_RENDER_RESOLVE_PIXEL_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/real.h"
#include "core/image/srgb_formula.h"
#include "engine/render/formula.h"

// Mean of side x side samples, the first of them at *first; rows lie `stride` numbers apart, samples
// `channels`.
FFP_FORMULA real ffp_sample_mean(const real *first, ptrdiff_t stride, int channels, int side) {
    real sum = 0;
    for (int v = 0; v < side; v++)
        for (int u = 0; u < side; u++) sum += first[v * stride + u * channels];
    return 1 / (real)(side * side) * sum;
}

// True if the opacity says how much of the pixel is covered.
FFP_FORMULA bool ffp_tells_coverage(real opacity, int side) {
    return (side > 1) & (opacity >= FFP_OPACITY_MIN);
}

// From the mean radiance to the picture.
FFP_FORMULA void ffp_resolve_pixel(const real mean[3], real opacity, int side, real picture[3]) {
    const real covered = ffp_tells_coverage(opacity, side) ? opacity : 1;
    for (int k = 0; k < 3; k++) {
        real slope;
        picture[k] = covered * ffp_srgb_encode_with_slope(mean[k] / covered, &slope);
    }
}

// From one pixel's picture to its mean radiance and, ADDED, its opacity.
FFP_FORMULA void ffp_resolve_pixel_backward(const real mean[3], real opacity, int side, const real grad[3],
                                            real grad_mean[3], real *grad_opacity) {
    const bool tells = ffp_tells_coverage(opacity, side);
    real sum = 0;
    for (int k = 0; k < 3; k++) {
        const real c = mean[k] / (tells ? opacity : 1);
        real slope;
        const real encoded = ffp_srgb_encode_with_slope(c, &slope);
        grad_mean[k] = grad[k] * slope;
        sum += grad[k] * (encoded - c * slope);
    }
    *grad_opacity += tells ? sum : 0;
}

#endif
