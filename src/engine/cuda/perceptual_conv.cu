// Convolution as a product over unfolded input, in strips where all of it would take too much memory; its
// adjoint gathers, so that no two threads add to one value.
#include "engine/cuda/launch.h"
#include "engine/cuda/products.h"
extern "C" {
#include "engine/cuda/perceptual_conv.h"
}

// A convolution and a run of its output pixels, counted through all images.
typedef struct Strip {
    FfpConv conv;
    int width, height, images; // of the output
    size_t first, count;
} Strip;

static FfpCudaOperands operands = FFP_OPERANDS_TF32;

void ffp_cuda_conv_exact(bool exact) {
    operands = exact ? FFP_OPERANDS_F32 : FFP_OPERANDS_TF32;
}

static bool is_direct(const FfpConv *conv) { // the input is its own unfolded form
    return conv->kernel == 1 && conv->stride == 1 && conv->pad == 0;
}

static size_t depth_of(const FfpConv *conv) {
    return (size_t)conv->in * conv->kernel * conv->kernel;
}

static Strip whole(const FfpConv *conv, int images) {
    Strip strip = {*conv,
                   ffp_conv_side(conv->width, conv->kernel, conv->stride, conv->pad),
                   ffp_conv_side(conv->height, conv->kernel, conv->stride, conv->pad),
                   images,
                   0,
                   0};
    strip.count = (size_t)strip.width * strip.height * images;
    return strip;
}

size_t ffp_cuda_columns(const FfpConv *conv, int images) {
    return is_direct(conv) ? 0 : depth_of(conv) * whole(conv, images).count;
}

// The strip from `first` on that fits, of a convolution with `total` output pixels.
static void fit(Strip *strip, size_t first, size_t total, FfpColumns columns) {
    size_t most = columns.capacity / depth_of(&strip->conv);
    if (most > 256) most -= most % 256;
    strip->first = first;
    strip->count = total - first < most ? total - first : most;
}

// A thread for each output pixel and input channel (blockIdx.y): what the kernel sees from there.
static __global__ void unfold(float *columns, const float *x, Strip strip) {
    const FfpConv conv = strip.conv;
    const size_t k = ffp_thread(), pixels = (size_t)strip.width * strip.height;
    if (k >= strip.count) return;
    const size_t image = (strip.first + k) / pixels, pixel = (strip.first + k) % pixels;
    const int left = (int)(pixel % strip.width) * conv.stride - conv.pad;
    const int top = (int)(pixel / strip.width) * conv.stride - conv.pad;
    const float *plane = x + (blockIdx.y * (size_t)strip.images + image) * conv.width * conv.height;
    float *to = columns + (size_t)blockIdx.y * conv.kernel * conv.kernel * strip.count + k;
    for (int v = top; v < top + conv.kernel; v++)
        for (int u = left; u < left + conv.kernel; u++, to += strip.count)
            *to = u >= 0 && v >= 0 && u < conv.width && v < conv.height ? plane[v * conv.width + u] : 0;
}

// A thread for each input pixel and channel (blockIdx.y): the sum of all places of the strip's columns that
// it was unfolded to. One image.
static __global__ void fold(float *dx, const float *columns, Strip strip, bool add) {
    const FfpConv conv = strip.conv;
    const size_t k = ffp_thread(), pixels = (size_t)conv.width * conv.height;
    if (k >= pixels) return;
    const int u = (int)(k % conv.width) + conv.pad, v = (int)(k / conv.width) + conv.pad;
    columns += (size_t)blockIdx.y * conv.kernel * conv.kernel * strip.count;
    float sum = 0;
    for (int i = v % conv.stride; i < conv.kernel && i <= v; i += conv.stride)
        for (int j = u % conv.stride; j < conv.kernel && j <= u; j += conv.stride) {
            const int x = (u - j) / conv.stride, y = (v - i) / conv.stride;
            const size_t at = (size_t)y * strip.width + x;
            if (x < strip.width && y < strip.height && at >= strip.first && at < strip.first + strip.count)
                sum += columns[(size_t)(i * conv.kernel + j) * strip.count + (at - strip.first)];
        }
    float *to = dx + blockIdx.y * pixels + k;
    *to = add ? *to + sum : sum;
}

void ffp_cuda_picture_conv_forward(float *y, const float *x, const float *w, const FfpConv *conv, int images,
                                   FfpColumns columns) {
    Strip strip = whole(conv, images);
    const size_t total = strip.count;
    const int depth = (int)depth_of(conv);
    const FfpFactor weights = ffp_factor(w, conv->out, depth, depth);
    if (is_direct(conv)) {
        ffp_cuda_multiply(operands, 1, weights, ffp_factor(x, depth, (int)total, (int)total), 0, y,
                          (int)total);
        return;
    }
    for (size_t first = 0; first < total; first += strip.count) {
        fit(&strip, first, total, columns);
        ffp_launch(unfold, dim3(ffp_blocks(strip.count, 256), (unsigned)conv->in), dim3(256), columns.values,
                   x, strip);
        const FfpFactor patches = ffp_factor(columns.values, depth, (int)strip.count, (int)strip.count);
        ffp_cuda_multiply(operands, 1, weights, patches, 0, y + first, (int)total);
    }
}

void ffp_cuda_picture_conv_backward(float *dx, const float *dy, const float *w, const FfpConv *conv, bool add,
                                    FfpColumns columns) {
    Strip strip = whole(conv, 1);
    const size_t total = strip.count, pixels = (size_t)conv->width * conv->height;
    const int depth = (int)depth_of(conv);
    const FfpFactor weights = ffp_transposed(ffp_factor(w, conv->out, depth, depth));
    if (is_direct(conv)) {
        const FfpFactor gradients = ffp_factor(dy, conv->out, (int)total, (int)total);
        ffp_cuda_multiply(operands, 1, weights, gradients, add, dx, (int)total);
        return;
    }
    for (size_t first = 0; first < total; first += strip.count) {
        fit(&strip, first, total, columns);
        const FfpFactor gradients = ffp_factor(dy + first, conv->out, (int)strip.count, (int)total);
        ffp_cuda_multiply(operands, 1, weights, gradients, 0, columns.values, (int)strip.count);
        ffp_launch(fold, dim3(ffp_blocks(pixels, 256), (unsigned)conv->in), dim3(256), dx, columns.values,
                   strip, add || first > 0);
    }
}

// A channel for each blockIdx.y in the kernels below.
static __global__ void bias_relu(float *y, const float *bias, size_t row) {
    const size_t i = ffp_thread();
    if (i >= row) return;
    float *value = y + blockIdx.y * row + i;
    const float sum = *value + bias[blockIdx.y];
    *value = sum > 0 ? sum : 0;
}

void ffp_cuda_bias_relu(float *y, const float *bias, int channels, size_t row) {
    ffp_launch(bias_relu, dim3(ffp_blocks(row, 256), (unsigned)channels), dim3(256), y, bias, row);
}

static __global__ void relu_backward(float *dy, const float *y, int images, size_t row) {
    const size_t i = ffp_thread();
    if (i < row && !(y[blockIdx.y * images * row + i] > 0)) dy[blockIdx.y * row + i] = 0;
}

void ffp_cuda_relu_backward(float *dy, const float *y, int channels, int images, size_t row) {
    ffp_launch(relu_backward, dim3(ffp_blocks(row, 256), (unsigned)channels), dim3(256), dy, y, images, row);
}

static __global__ void pool_forward(float *y, const float *x, FfpPool pool, int width, int height) {
    const size_t i = ffp_thread(), pixels = (size_t)width * height;
    if (i >= pixels) return;
    const float *plane = x + blockIdx.y * (size_t)pool.width * pool.height;
    y[blockIdx.y * pixels + i] = plane[ffp_pool_largest(plane, &pool, (int)(i % width), (int)(i / width))];
}

void ffp_cuda_maxpool_forward(float *y, const float *x, const FfpPool *pool, int images) {
    const int width = ffp_pool_side(pool->width, pool->kernel, pool->stride, pool->round_up);
    const int height = ffp_pool_side(pool->height, pool->kernel, pool->stride, pool->round_up);
    ffp_launch(pool_forward,
               dim3(ffp_blocks((size_t)width * height, 256), (unsigned)(pool->channels * images)), dim3(256),
               y, x, *pool, width, height);
}

// The first window that reaches position u from below, given windows of `kernel` every `stride`.
static __device__ int first_window(int u, const FfpPool &pool) {
    return u < pool.kernel ? 0 : (u - pool.kernel) / pool.stride + 1;
}

// A thread for each input pixel: the gradients of those windows around it whose largest value it is.
static __global__ void pool_backward(float *dx, const float *dy, const float *x, FfpPool pool, int images,
                                     int width, int height, bool add) {
    const size_t pixels = (size_t)pool.width * pool.height, k = ffp_thread();
    if (k >= pixels) return;
    const int u = (int)(k % pool.width), v = (int)(k / pool.width);
    const float *plane = x + blockIdx.y * images * pixels, *from = dy + blockIdx.y * (size_t)width * height;
    float sum = 0;
    for (int j = first_window(v, pool); j < height && j * pool.stride <= v; j++)
        for (int i = first_window(u, pool); i < width && i * pool.stride <= u; i++)
            if (ffp_pool_largest(plane, &pool, i, j) == (int)k) sum += from[j * width + i];
    float *to = dx + blockIdx.y * pixels + k;
    *to = add ? *to + sum : sum;
}

void ffp_cuda_maxpool_backward(float *dx, const float *dy, const float *x, const FfpPool *pool, int images,
                               bool add) {
    const int width = ffp_pool_side(pool->width, pool->kernel, pool->stride, pool->round_up);
    const int height = ffp_pool_side(pool->height, pool->kernel, pool->stride, pool->round_up);
    ffp_launch(pool_backward,
               dim3(ffp_blocks((size_t)pool->width * pool->height, 256), (unsigned)pool->channels), dim3(256),
               dx, dy, x, *pool, images, width, height, add);
}
