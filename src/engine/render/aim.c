// Sums over rows of samples and chunks of Gaussians, in a fixed order.
#include "engine/render/aim.h"
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "engine/render/kernels/kernels.h"

void ffp_light_backward_aim(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                            const FfpCamera *projector, const FfpTransport *grad, FfpAimGradient *out) {
    const FfpLitScene scene = {gbuffer, mapping, {camera, projector, mapping->even}};
    FfpAimGradient *rows = ffp_alloc((size_t)gbuffer->height, sizeof *rows);
    FfpAimRow *aim = ffp_render_kernels()->aim_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++) aim(&scene, y, grad, &rows[y]);
    for (int y = 0; y < gbuffer->height; y++) {
        for (int k = 0; k < 6; k++) out->camera[k] += rows[y].camera[k];
        for (int k = 0; k < 6; k++) out->projector[k] += rows[y].projector[k];
        for (int k = 0; k < 2; k++) out->camera_focal[k] += rows[y].camera_focal[k];
        for (int k = 0; k < 2; k++) out->projector_focal[k] += rows[y].projector_focal[k];
    }
    ffp_free(rows);
}

// out += sign p x g
static void add_moment(const real p[3], const real g[3], double sign, double out[3]) {
    real cross[3];
    ffp_cross3(p, g, cross);
    for (int k = 0; k < 3; k++) out[k] += sign * (double)cross[k];
}

// A camera that moves by exp(xi) sees what it saw of Gaussians moved by exp(-xi). A quaternion q turned by a
// small w is q + (0, w) q / 2.
static void add_motion(const FfpGaussians *g, const FfpGaussians *grad, double camera[6]) {
    for (int64_t i = 0; i < g->count; i++) {
        const real *q = g->rotation + 4 * i, *d = grad->rotation + 4 * i;
        for (int k = 0; k < 3; k++) {
            camera[k] -= (double)grad->centre[3 * i + k];
            camera[3 + k] -= 0.5 * (double)(q[0] * d[1 + k] - d[0] * q[1 + k]);
        }
        add_moment(g->centre + 3 * i, grad->centre + 3 * i, -1, camera + 3);
        add_moment(q + 1, d + 1, -0.5, camera + 3);
    }
}

void ffp_rasterise_backward_aim(const FfpRaster *raster, const FfpGaussians *gaussians,
                                const FfpCamera *camera, const FfpRenderSettings *settings,
                                const FfpGbuffer *out, const FfpGbuffer *grad_out, const FfpGaussians *grad,
                                FfpAimGradient *aim) {
    double focal[FFP_CHUNKS][2] = {{0}};
    FfpFocalChunk *chunk = ffp_render_kernels()->focal_chunk;
#pragma omp parallel for schedule(static)
    for (int c = 0; c < FFP_CHUNKS; c++)
        chunk(raster, gaussians, camera, settings, &raster->chunks[c], focal[c]);
    for (int c = 0; c < FFP_CHUNKS; c++)
        for (int k = 0; k < 2; k++) aim->camera_focal[k] += focal[c][k];
    add_motion(gaussians, grad, aim->camera);
    // Normals are those of the world: Gaussians that turn take them along, a camera that turns does not.
    const int pixels = out->width * out->height;
    for (int i = 0; i < pixels; i++)
        add_moment(out->normal + 3 * (size_t)i, grad_out->normal + 3 * (size_t)i, 1, aim->camera + 3);
}
