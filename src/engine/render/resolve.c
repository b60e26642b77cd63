#include "engine/render/resolve.h"
#include <string.h>
#include "engine/render/kernels/kernels.h"
#include "engine/render/resolve_pixel.h"
#include "engine/render/table.h"

enum { PLANES = 8 };

typedef struct Plane {
    real *data;
    int channels;
} Plane;

static void planes_of(const FfpGbuffer *g, Plane planes[PLANES]) {
    const Plane all[PLANES] = {{g->opacity, 1},   {g->depth, 1},   {g->normal, 3},     {g->albedo, 3},
                               {g->roughness, 1}, {g->ambient, 3}, {g->distortion, 1}, {g->scattered, 3}};
    memcpy(planes, all, sizeof all);
}

void ffp_average_plane(const real *samples, int side, int width, int height, int channels, real *out) {
    if (ffp_render_table()) {
        ffp_render_table()->average_plane(samples, side, width, height, channels, out);
        return;
    }
    FfpAverageRow *average = ffp_render_kernels()->average_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) {
        const ptrdiff_t row = (ptrdiff_t)y * width * channels;
        average(samples + row * side * side, width, channels, side, out + row);
    }
}

void ffp_average_gbuffer(const FfpGbuffer *samples, int side, FfpGbuffer *out) {
    if (ffp_render_table()) {
        ffp_render_table()->average_gbuffer(samples, side, out);
        return;
    }
    Plane from[PLANES], to[PLANES];
    planes_of(samples, from);
    planes_of(out, to);
    for (int k = 0; k < PLANES; k++)
        if (to[k].data)
            ffp_average_plane(from[k].data, side, out->width, out->height, to[k].channels, to[k].data);
}

void ffp_average_gbuffer_backward(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples) {
    if (ffp_render_table()) {
        ffp_render_table()->average_gbuffer_backward(grad_out, side, grad_samples);
        return;
    }
    Plane from[PLANES], to[PLANES];
    planes_of(grad_out, from);
    planes_of(grad_samples, to);
    FfpAverageRow *backward = ffp_render_kernels()->average_row_backward;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < grad_out->height; y++)
        for (int k = 0; k < PLANES; k++) {
            const ptrdiff_t row = (ptrdiff_t)y * grad_out->width * to[k].channels;
            if (!to[k].data) continue;
            backward(from[k].data + row, grad_out->width, to[k].channels, side,
                     to[k].data + row * side * side);
        }
}

void ffp_resolve(const FfpImage *mean, const real *opacity, int side, FfpImage *picture) {
    if (ffp_render_table()) {
        ffp_render_table()->resolve(mean, opacity, side, picture);
        return;
    }
    const ptrdiff_t width = mean->width;
    FfpResolveRow *resolve = ffp_render_kernels()->resolve_row;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < mean->height; y++)
        resolve(mean->data + 3 * y * width, opacity + y * width, mean->width, side,
                picture->data + 3 * y * width);
}

void ffp_resolve_backward(const FfpImage *mean, const real *opacity, int side, const FfpImage *grad_picture,
                          FfpImage *grad_mean, real *grad_opacity) {
    if (ffp_render_table()) {
        ffp_render_table()->resolve_backward(mean, opacity, side, grad_picture, grad_mean, grad_opacity);
        return;
    }
    const ptrdiff_t width = mean->width;
    FfpResolveRowBackward *backward = ffp_render_kernels()->resolve_row_backward;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < mean->height; y++)
        backward(mean->data + 3 * y * width, opacity + y * width, mean->width, side,
                 grad_picture->data + 3 * y * width, grad_mean->data + 3 * y * width,
                 grad_opacity + y * width);
}
