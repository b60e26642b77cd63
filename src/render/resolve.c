#include "render/resolve.h"

#include <string.h>
#include "render/resolve_pixel.h"
#include "render/table.h"

enum { PLANES = 7 };

typedef struct Plane {
    real *data;
    int channels;
} Plane;

static void planes_of(const FfpGbuffer *g, Plane planes[PLANES]) {
    const Plane all[PLANES] = {{g->opacity, 1},   {g->depth, 1},   {g->normal, 3},    {g->albedo, 3},
                               {g->roughness, 1}, {g->ambient, 3}, {g->distortion, 1}};
    memcpy(planes, all, sizeof all);
}

// A row of [width,channels] means of side x side samples.
static void average_row(const real *samples, int width, int channels, int side, real *out) {
    const ptrdiff_t stride = (ptrdiff_t)width * side * channels;
    for (int x = 0; x < width; x++)
        for (int k = 0; k < channels; k++)
            out[x * channels + k] =
                ffp_sample_mean(samples + x * side * channels + k, stride, channels, side);
}

static void average_row_backward(const real *grad, int width, int channels, int side, real *samples) {
    const ptrdiff_t stride = (ptrdiff_t)width * side * channels;
    const real share = 1 / (real)(side * side);
    for (int v = 0; v < side; v++)
        for (int x = 0; x < width * side; x++)
            for (int k = 0; k < channels; k++)
                samples[v * stride + x * channels + k] += share * grad[x / side * channels + k];
}

void ffp_average_plane(const real *samples, int side, int width, int height, int channels, real *out) {
    if (ffp_render_table()) {
        ffp_render_table()->average_plane(samples, side, width, height, channels, out);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) {
        const ptrdiff_t row = (ptrdiff_t)y * width * channels;
        average_row(samples + row * side * side, width, channels, side, out + row);
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
#pragma omp parallel for schedule(static)
    for (int y = 0; y < grad_out->height; y++)
        for (int k = 0; k < PLANES; k++) {
            const ptrdiff_t row = (ptrdiff_t)y * grad_out->width * to[k].channels;
            average_row_backward(from[k].data + row, grad_out->width, to[k].channels, side,
                                 to[k].data + row * side * side);
        }
}

void ffp_resolve(const FfpImage *samples, const real *opacity, int side, FfpImage *mean, FfpImage *picture) {
    if (ffp_render_table()) {
        ffp_render_table()->resolve(samples, opacity, side, mean, picture);
        return;
    }
    const int width = mean->width;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < mean->height; y++) {
        const ptrdiff_t row = (ptrdiff_t)y * width;
        average_row(samples->data + 3 * row * side * side, width, 3, side, mean->data + 3 * row);
        for (ptrdiff_t p = row; p < row + width; p++)
            ffp_resolve_pixel(mean->data + 3 * p, opacity[p], side, picture->data + 3 * p);
    }
}

void ffp_resolve_backward(const FfpImage *mean, const real *opacity, int side, const FfpImage *grad_picture,
                          FfpImage *grad_samples, real *grad_opacity) {
    if (ffp_render_table()) {
        ffp_render_table()->resolve_backward(mean, opacity, side, grad_picture, grad_samples, grad_opacity);
        return;
    }
    const int width = mean->width;
    const real share = 1 / (real)(side * side);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < mean->height; y++)
        for (int x = 0; x < width; x++) {
            const ptrdiff_t p = (ptrdiff_t)y * width + x;
            real *first = grad_samples->data + 3 * side * (p + (ptrdiff_t)y * width * (side - 1));
            real grad_mean[3];
            ffp_resolve_pixel_backward(mean->data + 3 * p, opacity[p], side, grad_picture->data + 3 * p,
                                       grad_mean, &grad_opacity[p]);
            for (int i = 0; i < side * side; i++)
                for (int k = 0; k < 3; k++)
                    first[3 * ((ptrdiff_t)(i / side) * width * side + i % side) + k] = share * grad_mean[k];
        }
}
