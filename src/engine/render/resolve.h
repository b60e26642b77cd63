// Inside the render room: the samples of each pixel into one, and back.
#ifndef FFP_RENDER_RESOLVE_H
#define FFP_RENDER_RESOLVE_H

#include "engine/render/render.h"

// Mean of a plane over side x side samples. samples: [side height, side width, channels], out: [height,
// width, channels].
void ffp_average_plane(const real *samples, int side, int width, int height, int channels, real *out);
// The same of every plane of a G-buffer.
void ffp_average_gbuffer(const FfpGbuffer *samples, int side, FfpGbuffer *out);
// SETS the gradients of the samples: each pixel's, shared out evenly.
void ffp_average_gbuffer_backward(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples);

// Premultiplied linear radiance L, the mean of side x side samples a pixel, into the picture (pass.h) over
// black. opacity: O, [height,width].
void ffp_resolve(const FfpImage *mean, const real *opacity, int side, FfpImage *picture);
// Sets grad_mean, and ADDS to grad_opacity. With c = L / O: dL = g enc'(c), and
// dO = sum_k g_k (enc(c_k) - c_k enc'(c_k)).
void ffp_resolve_backward(const FfpImage *mean, const real *opacity, int side, const FfpImage *grad_picture,
                          FfpImage *grad_mean, real *grad_opacity);

#endif
