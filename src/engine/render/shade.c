// All pixels of a view through the model of light (shade_pixel.h), and back.
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/image/lookup.h"
#include "engine/render/kernels/kernels.h"
#include "engine/render/table.h"

FfpTransport ffp_transport_new(int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    return (FfpTransport){.width = width,
                          .height = height,
                          .factor = ffp_memory_new(pixels, 3 * sizeof(real)),
                          .uv = ffp_memory_new(pixels, 2 * sizeof(real))};
}

void ffp_transport_clear(FfpTransport *t) {
    const size_t pixels = (size_t)t->width * (size_t)t->height;
    ffp_memory_zero(t->factor, pixels * 3 * sizeof(real));
    ffp_memory_zero(t->uv, pixels * 2 * sizeof(real));
}

void ffp_transport_free(FfpTransport *t) {
    ffp_memory_free(t->factor);
    ffp_memory_free(t->uv);
    ffp_memory_free(t->look);
    *t = (FfpTransport){0};
}

void ffp_light(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
               const FfpCamera *projector, FfpTransport *out) {
    if (ffp_render_table()) {
        ffp_render_table()->light(gbuffer, mapping, camera, projector, out);
        return;
    }
    const FfpLitScene scene = {gbuffer, mapping, {camera, projector, mapping->even}};
    FfpLightRow *light = ffp_render_kernels()->light_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++) light(&scene, y, out);
}

void ffp_light_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                        const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer) {
    if (ffp_render_table()) {
        ffp_render_table()->light_backward(gbuffer, mapping, camera, projector, grad, grad_gbuffer);
        return;
    }
    const FfpLitScene scene = {gbuffer, mapping, {camera, projector, mapping->even}};
    FfpLightRowBackward *backward = ffp_render_kernels()->light_row_backward;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++) backward(&scene, y, grad, grad_gbuffer);
}

void ffp_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
               const real intensity[3], const FfpSummed *pattern, FfpImage *out) {
    if (ffp_render_table()) {
        ffp_render_table()->shade(gbuffer, mapping, transport, intensity, pattern, out);
        return;
    }
    const int side = transport->width / out->width;
    FfpPatternLight light = {transport, mapping->extent, intensity, pattern, side, {0}};
    ffp_pattern_level(pattern, mapping->lit, light.level);
    FfpShadeRow *shade = ffp_render_kernels()->shade_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < out->height; y++) shade(&light, y, gbuffer, out);
}

void ffp_shade_once(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern,
                    FfpImage *out) {
    FfpTransport transport = ffp_transport_new(gbuffer->width, gbuffer->height);
    ffp_light(gbuffer, mapping, camera, projector, &transport);
    ffp_shade(gbuffer, mapping, &transport, intensity, pattern, out);
    ffp_transport_free(&transport);
}

void ffp_shade_backward(const FfpMapping *mapping, const FfpTransport *transport, const real intensity[3],
                        const FfpSummed *pattern, const FfpImage *grad_image, FfpGbuffer *grad_gbuffer,
                        FfpTransport *grad_transport, real grad_intensity[3], FfpSummed *grad_pattern) {
    if (ffp_render_table()) {
        ffp_render_table()->shade_backward(mapping, transport, intensity, pattern, grad_image, grad_gbuffer,
                                           grad_transport, grad_intensity, grad_pattern);
        return;
    }
    const int side = transport->width / grad_image->width, height = grad_image->height;
    FfpPatternLight light = {transport, mapping->extent, intensity, pattern, side, {0}};
    ffp_pattern_level(pattern, mapping->lit, light.level);
    const FfpShadeGrad grad = {grad_image, grad_gbuffer->ambient, grad_gbuffer->scattered, grad_transport,
                               grad_pattern};
    // Rows keep their share of the intensity's gradient, added up in order: the same bits whoever is first.
    real *rows = ffp_alloc((size_t)height, 3 * sizeof(real));
    FfpShadeRowBackward *backward = ffp_render_kernels()->shade_row_backward;
    // Pixels meet in the pattern: one thread then.
#pragma omp parallel for schedule(static) if (!grad_pattern)
    for (int y = 0; y < height; y++) backward(&light, y, &grad, rows + 3 * y);
    for (int i = 0; grad_intensity && i < 3 * height; i++) grad_intensity[i % 3] += rows[i];
    ffp_free(rows);
}

void ffp_shade_backward_level(const FfpGbuffer *gbuffer, const FfpMapping *mapping,
                              const FfpImage *grad_image, FfpSummed *grad_pattern) {
    const ptrdiff_t values = 3 * (ptrdiff_t)gbuffer->width * gbuffer->height;
    double sum[3] = {0};
    for (ptrdiff_t i = 0; gbuffer->scattered && i < values; i++)
        sum[i % 3] += (double)(grad_image->data[i] * gbuffer->scattered[i]);
    const real level[3] = {(real)sum[0], (real)sum[1], (real)sum[2]}, *lit = mapping->lit;
    if (gbuffer->scattered) ffp_lookup_backward_pattern(grad_pattern, lit[0], lit[1], lit[2], lit[3], level);
}
