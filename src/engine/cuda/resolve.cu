// The samples of each pixel into one, and back; planes of G-buffers.
#include "engine/cuda/launch.h"
#include "engine/cuda/render.h"
extern "C" {
#include "engine/render/resolve_pixel.h"
}

enum { PLANES = 8 };

// A plane of a G-buffer, and the same plane of another.
typedef struct Plane {
    const float *from;
    float *to;
    int channels;
} Plane;

typedef struct FfpPlaneList {
    Plane plane[PLANES];
} FfpPlaneList;

static FfpPlaneList planes_of(const FfpGbuffer *from, const FfpGbuffer *to) {
    return FfpPlaneList{{{from->opacity, to->opacity, 1},
                         {from->depth, to->depth, 1},
                         {from->normal, to->normal, 3},
                         {from->albedo, to->albedo, 3},
                         {from->roughness, to->roughness, 1},
                         {from->ambient, to->ambient, 3},
                         {from->distortion, to->distortion, 1},
                         {from->scattered, to->scattered, 3}}};
}

// One thread a number of three planes' width, as the widest have; a row of blocks for each plane.
static dim3 blocks_for(int width, int height) {
    return dim3(ffp_blocks(3 * (size_t)width * (size_t)height, 256), PLANES);
}

static __global__ void clear_planes(FfpPlaneList list, size_t pixels) {
    const Plane plane = list.plane[blockIdx.y];
    const size_t i = ffp_thread();
    if (plane.to && i < pixels * (size_t)plane.channels) plane.to[i] = 0;
}

void ffp_cuda_gbuffer_clear(FfpGbuffer *g) {
    ffp_launch(clear_planes, blocks_for(g->width, g->height), dim3(256), planes_of(g, g),
               (size_t)g->width * (size_t)g->height);
}

// `width` and `pixels` are those of the means.
static __global__ void average_planes(FfpPlaneList list, int width, size_t pixels, int side) {
    const Plane plane = list.plane[blockIdx.y];
    const int channels = plane.channels;
    const size_t i = ffp_thread();
    if (!plane.to || i >= pixels * (size_t)channels) return;
    const size_t row = (size_t)width * (size_t)channels, y = i / row, in_row = i % row;
    const size_t x = in_row / (size_t)channels, k = in_row % (size_t)channels, stride = row * (size_t)side;
    const float *first = plane.from + y * (size_t)side * stride + x * (size_t)(side * channels) + k;
    plane.to[i] = ffp_sample_mean(first, (ptrdiff_t)stride, channels, side);
}

void ffp_cuda_average_plane(const real *samples, int side, int width, int height, int channels, real *out) {
    FfpPlaneList list = {};
    list.plane[0] = Plane{samples, out, channels};
    const size_t pixels = (size_t)width * (size_t)height;
    ffp_launch(average_planes, dim3(ffp_blocks((size_t)channels * pixels, 256)), dim3(256), list, width,
               pixels, side);
}

void ffp_cuda_average_gbuffer(const FfpGbuffer *samples, int side, FfpGbuffer *out) {
    ffp_launch(average_planes, blocks_for(out->width, out->height), dim3(256), planes_of(samples, out),
               out->width, (size_t)out->width * (size_t)out->height, side);
}

// One thread a number of the samples, whose width and number these are.
static __global__ void average_planes_backward(FfpPlaneList list, int width, size_t pixels, int side) {
    const Plane plane = list.plane[blockIdx.y];
    const size_t channels = (size_t)plane.channels, i = ffp_thread();
    if (!plane.to || i >= pixels * channels) return;
    const size_t row = (size_t)width * channels, y = i / row / (size_t)side;
    const size_t x = i % row / channels / (size_t)side, k = i % channels;
    const float share = 1 / (float)(side * side);
    plane.to[i] = share * plane.from[(y * (size_t)(width / side) + x) * channels + k];
}

void ffp_cuda_average_gbuffer_backward(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples) {
    const int width = grad_samples->width, height = grad_samples->height;
    ffp_launch(average_planes_backward, blocks_for(width, height), dim3(256),
               planes_of(grad_out, grad_samples), width, (size_t)width * (size_t)height, side);
}

static __global__ void resolve_pixels(size_t pixels, int side, const float *mean, const float *opacity,
                                      float *picture) {
    const size_t p = ffp_thread();
    if (p >= pixels) return;
    const float colour[3] = {mean[3 * p], mean[3 * p + 1], mean[3 * p + 2]};
    float shown[3];
    ffp_resolve_pixel(colour, opacity[p], side, shown);
    for (int k = 0; k < 3; k++) picture[3 * p + k] = shown[k];
}

void ffp_cuda_resolve(const FfpImage *mean, const real *opacity, int side, FfpImage *picture) {
    ffp_launch_each((size_t)mean->width * (size_t)mean->height, resolve_pixels, side, mean->data, opacity,
                    picture->data);
}

static __global__ void resolve_pixels_backward(size_t pixels, int side, const float *mean,
                                               const float *opacity, const float *grad_picture,
                                               float *grad_mean, float *grad_opacity) {
    const size_t p = ffp_thread();
    if (p >= pixels) return;
    const float colour[3] = {mean[3 * p], mean[3 * p + 1], mean[3 * p + 2]};
    const float grad[3] = {grad_picture[3 * p], grad_picture[3 * p + 1], grad_picture[3 * p + 2]};
    float d[3];
    ffp_resolve_pixel_backward(colour, opacity[p], side, grad, d, &grad_opacity[p]);
    for (int k = 0; k < 3; k++) grad_mean[3 * p + k] = d[k];
}

void ffp_cuda_resolve_backward(const FfpImage *mean, const real *opacity, int side,
                               const FfpImage *grad_picture, FfpImage *grad_mean, real *grad_opacity) {
    ffp_launch_each((size_t)mean->width * (size_t)mean->height, resolve_pixels_backward, side, mean->data,
                    opacity, grad_picture->data, grad_mean->data, grad_opacity);
}
