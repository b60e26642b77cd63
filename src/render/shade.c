// All pixels of a G-buffer through the model of light (shade_pixel.h), and back.
#include <stdlib.h>
#include "base/arena.h"
#include "render/kernels/kernels.h"
#include "render/table.h"

void ffp_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
               const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern, FfpImage *out) {
    if (ffp_render_table()) {
        ffp_render_table()->shade(gbuffer, mapping, camera, projector, intensity, pattern, out);
        return;
    }
    const FfpShader shader = {gbuffer, mapping, camera, projector, intensity, pattern};
    FfpShadeRow *shade = ffp_render_kernels()->shade_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++) shade(&shader, y, out);
}

void ffp_shade_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                        const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern,
                        const FfpImage *grad_image, FfpGbuffer *grad_gbuffer, real grad_intensity[3],
                        FfpSummed *grad_pattern) {
    if (ffp_render_table()) {
        ffp_render_table()->shade_backward(gbuffer, mapping, camera, projector, intensity, pattern,
                                           grad_image, grad_gbuffer, grad_intensity, grad_pattern);
        return;
    }
    const FfpShader shader = {gbuffer, mapping, camera, projector, intensity, pattern};
    // Rows keep their share of the intensity's gradient, added up in order: the same bits whoever is first.
    real *rows = ffp_alloc((size_t)gbuffer->height, 3 * sizeof(real));
    FfpShadeRowBackward *backward = ffp_render_kernels()->shade_row_backward;
    // Pixels meet in the pattern: one thread then.
#pragma omp parallel for schedule(static) if (!grad_pattern)
    for (int y = 0; y < gbuffer->height; y++)
        backward(&shader, y, grad_image, grad_gbuffer, rows + 3 * y, grad_pattern);
    for (int i = 0; grad_intensity && i < 3 * gbuffer->height; i++) grad_intensity[i % 3] += rows[i];
    ffp_free(rows);
}
