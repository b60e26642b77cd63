// Inside the render room: the samples of each pixel into one, and back.
#ifndef FFP_RENDER_RESOLVE_H
#define FFP_RENDER_RESOLVE_H

#include "render/render.h"

// Mean of a plane over side x side samples. samples: [side height, side width, channels], out: [height,
// width, channels].
void ffp_average_plane(const real *samples, int side, int width, int height, int channels, real *out);
// The same of every plane of a G-buffer.
void ffp_average_gbuffer(const FfpGbuffer *samples, int side, FfpGbuffer *out);
// ADDS each pixel's gradient, shared out evenly, to those of its samples.
void ffp_average_gbuffer_backward(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples);

// Premultiplied linear radiance of the samples into its mean L and into the picture (pass.h) over black.
// opacity: O, [height,width].
void ffp_resolve(const FfpImage *samples, const real *opacity, int side, FfpImage *mean, FfpImage *picture);
// Sets grad_samples, and ADDS to grad_opacity. With c = L / O: dL = g enc'(c), shared out evenly, and
// dO = sum_k g_k (enc(c_k) - c_k enc'(c_k)).
void ffp_resolve_backward(const FfpImage *mean, const real *opacity, int side, const FfpImage *grad_picture,
                          FfpImage *grad_samples, real *grad_opacity);

#endif
