// Rows of pixels through the model of light (shade_pixel.h), and back.
#include "render/kernels/kernels.h"

void FFP_K(shade_row)(const FfpShader *shader, int y, FfpImage *out) {
    const int width = shader->gbuffer->width;
    for (int x = 0; x < width; x++) ffp_shade_pixel(shader, x, y, out->data + 3 * (y * width + x));
}

static void shade_pixel_backward(const FfpShader *sh, int x, int y, const FfpImage *grad_image,
                                 FfpGbuffer *grad_gbuffer, real grad_intensity[3], FfpSummed *grad_pattern) {
    const int p = y * sh->gbuffer->width + x;
    const real *extent = sh->mapping->extent + 2 * p;
    FfpLit s;
    FfpLitGrad d;
    const bool lit =
        ffp_shade_pixel_backward(sh, x, y, grad_image->data + 3 * p, grad_gbuffer, grad_intensity, &s, &d);
    if (lit && grad_pattern)
        ffp_lookup_backward_pattern(grad_pattern, s.u, s.v_at, extent[0], extent[1], d.texture);
}

void FFP_K(shade_row_backward)(const FfpShader *shader, int y, const FfpImage *grad_image,
                               FfpGbuffer *grad_gbuffer, real grad_intensity[3], FfpSummed *grad_pattern) {
    for (int x = 0; x < shader->gbuffer->width; x++)
        shade_pixel_backward(shader, x, y, grad_image, grad_gbuffer, grad_intensity, grad_pattern);
}
