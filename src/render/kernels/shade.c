// Rows of pixels through the model of light (shade_pixel.h), and back.
#include "render/kernels/kernels.h"

void FFP_K(light_row)(const FfpLitView *view, int y, FfpTransport *out) {
    for (int x = 0; x < view->gbuffer->width; x++) ffp_light_pixel(view, x, y, out);
}

void FFP_K(light_row_backward)(const FfpLitView *view, int y, const FfpTransport *grad,
                               FfpGbuffer *grad_gbuffer) {
    for (int x = 0; x < view->gbuffer->width; x++) ffp_light_pixel_backward(view, x, y, grad, grad_gbuffer);
}

void FFP_K(shade_row)(const FfpPatternLight *light, int y, const real *ambient, FfpImage *out) {
    for (int x = 0; x < out->width; x++) {
        const int p = y * out->width + x;
        ffp_shade_pixel(light, p, ambient, out->data + 3 * p);
    }
}

void FFP_K(shade_row_backward)(const FfpPatternLight *light, int y, const FfpShadeGrad *grad,
                               real grad_intensity[3]) {
    for (int x = 0; x < grad->image->width; x++) {
        const int p = y * grad->image->width + x;
        const real *uv = light->transport->uv + 2 * p, *extent = light->extent + 2 * p;
        real d_texture[3];
        ffp_shade_pixel_backward(light, p, grad->image->data + 3 * p, grad->ambient, grad->transport,
                                 grad_intensity, d_texture);
        if (grad->pattern && ffp_pixel_lit(light, p))
            ffp_lookup_backward_pattern(grad->pattern, uv[0], uv[1], extent[0], extent[1], d_texture);
    }
}
