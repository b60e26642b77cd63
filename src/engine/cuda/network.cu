// The network's heads on the GPU: between feature maps, pixels and Gaussians.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/cuda.h"
#include "engine/network/table.h"
}
#include "engine/cuda/memory.h"

// One thread for each number of `count` rows of `width`.
static __global__ void gather(size_t numbers, float *out, const float *in, const int32_t *index, int width) {
    const size_t i = ffp_thread();
    if (i < numbers) out[i] = in[(size_t)index[i / width] * width + i % width];
}

static __global__ void scatter(size_t numbers, float *out, const float *in, const int32_t *index, int width) {
    const size_t i = ffp_thread();
    if (i < numbers) out[(size_t)index[i / width] * width + i % width] = in[i];
}

static void gather_rows(float *out, const float *in, const int32_t *index, int count, int width) {
    ffp_launch_each((size_t)count * width, gather, out, in, index, width);
}

static void scatter_rows(float *out, const float *in, const int32_t *index, int count, int width) {
    ffp_launch_each((size_t)count * width, scatter, out, in, index, width);
}

// One thread for each number of the rows that are gathered.
static __global__ void gather_rows_by_weight(size_t numbers, float *out, FfpTapTable taps, int64_t first,
                                             const float *map, int features, const float *own, int channels) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const int width = features + channels, k = (int)(i % width);
    const int64_t g = first + (int64_t)(i / width);
    if (k >= features) {
        out[i] = own[g * channels + k - features];
        return;
    }
    float sum = 0;
    for (int t = 0; t < taps.taps; t++) {
        const int64_t e = g * taps.taps + t;
        sum += taps.weight[e] * map[(size_t)taps.row[e] * features + k];
    }
    out[i] = sum;
}

static void gather_features(float *out, const FfpTapTable *taps, int64_t first, int count, const float *map,
                            int features, const float *own, int channels) {
    ffp_launch_each((size_t)count * (features + channels), gather_rows_by_weight, out, *taps, first, map,
                    features, own, channels);
}

// One thread for each number of the map; its takers add up in the order of the Gaussians.
static __global__ void scatter_rows_by_weight(size_t numbers, float *dmap, FfpTapTable taps, int64_t first,
                                              int count, const float *dfeatures, int features) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const size_t row = i / features;
    const int k = (int)(i % features);
    float sum = dmap[i];
    for (int32_t e = taps.first[row]; e < taps.first[row + 1]; e++) {
        const int32_t entry = taps.taker[e];
        const int64_t g = entry / taps.taps - first;
        if (g >= 0 && g < count) sum += taps.weight[entry] * dfeatures[g * features + k];
    }
    dmap[i] = sum;
}

static void scatter_features(float *dmap, const FfpTapTable *taps, int64_t first, int count,
                             const float *dfeatures, int features) {
    ffp_launch_each((size_t)taps->rows * features, scatter_rows_by_weight, dmap, *taps, first, count,
                    dfeatures, features);
}

static __global__ void add_context_inputs_each(size_t numbers, float *hidden, const float *context_inputs,
                                               const float *weight, int width, int channels) {
    const size_t i = ffp_thread();
    if (i >= numbers) return;
    const float *a = context_inputs + i / width * channels, *w = weight + i % width * channels;
    float sum = hidden[i];
    for (int c = 0; c < channels; c++) sum += a[c] * w[c];
    hidden[i] = sum;
}

static void add_context_inputs(float *hidden, const float *context_inputs, const float *weight, int count,
                               int width, int channels) {
    ffp_launch_each((size_t)count * width, add_context_inputs_each, hidden, context_inputs, weight, width,
                    channels);
}

// One thread for each Gaussian; *bad becomes 1 when a number is not finite.
static __global__ void splat_each(size_t count, FfpGaussians out, float *t, const FfpPixelBase *base,
                                  const float *raw, int numbers, int *bad) {
    const size_t g = ffp_thread();
    if (g >= count) return;
    float sum = 0;
    for (int i = 0; i < numbers; i++) sum += raw[g * numbers + i];
    if (!(sum - sum == 0)) *bad = 1;
    FfpPixelSplat splat;
    if (numbers == FFP_RESIDUAL_NUMBERS)
        ffp_residual_splat(&splat, &base[g], raw + g * numbers);
    else
        ffp_plain_splat(&splat, &base[g], raw + g * numbers);
    t[g] = splat.t;
    ffp_splat_store(&out, (int64_t)g, &splat, &base[g]);
}

static bool splat(FfpGaussians *out, float *t, const FfpPixelBase *base, const float *raw, int64_t count,
                  bool residual) {
    int bad = 0, *there = (int *)ffp_cuda_alloc(sizeof *there);
    ffp_cuda_zero(there, sizeof *there);
    ffp_launch_each((size_t)count, splat_each, *out, t, base, raw,
                    residual ? (int)FFP_RESIDUAL_NUMBERS : (int)FFP_PLAIN_NUMBERS, there);
    ffp_cuda_download(&bad, there, sizeof bad);
    ffp_cuda_release(there);
    return !bad;
}

static __device__ FfpPixelSplat gradient_of(const FfpGaussians *grad, const float *grad_t, size_t g,
                                            const FfpPixelBase *base) {
    FfpPixelSplat d;
    d.t = grad_t ? grad_t[g] : 0;
    for (int k = 0; k < 3; k++) {
        d.t += grad->centre[3 * g + k] * base->direction[k];
        d.scale[k] = grad->scale[3 * g + k];
        d.albedo[k] = grad->albedo[3 * g + k];
        d.ambient[k] = grad->ambient[3 * g + k];
    }
    for (int k = 0; k < 4; k++) d.rotation[k] = grad->rotation[4 * g + k];
    d.opacity = grad->opacity[g];
    d.roughness = grad->roughness[g];
    return d;
}

static __global__ void splat_each_backward(size_t count, float *draw, const FfpPixelBase *base,
                                           const float *raw, int64_t first, int numbers, FfpGaussians grad,
                                           const float *grad_t) {
    const size_t i = ffp_thread(), g = (size_t)first + i;
    if (i >= count) return;
    const FfpPixelSplat d = gradient_of(&grad, grad_t, g, &base[g]);
    if (numbers == FFP_RESIDUAL_NUMBERS)
        ffp_residual_splat_backward(draw + i * numbers, &d, &base[g], raw + g * numbers);
    else
        ffp_plain_splat_backward(draw + i * numbers, &d, &base[g], raw + g * numbers);
}

static void splat_backward(float *draw, const FfpPixelBase *base, const float *raw, int64_t first, int count,
                           bool residual, const FfpGaussians *grad, const float *grad_t) {
    ffp_launch_each((size_t)count, splat_each_backward, draw, base, raw, first,
                    residual ? (int)FFP_RESIDUAL_NUMBERS : (int)FFP_PLAIN_NUMBERS, *grad, grad_t);
}

static __global__ void look_compare_each(size_t pixels, float *numbers, FfpLookPictures drawn,
                                         const float *colour, const float *coverage) {
    const size_t i = ffp_thread();
    if (i < pixels)
        ffp_look_pixel(numbers + i * FFP_LOOK_NUMBERS, &drawn, i, colour + i * FFP_LOOK_COLOURS, coverage[i]);
}

static void look_compare(float *numbers, const FfpLookPictures *drawn, const float *colour,
                         const float *coverage, size_t pixels) {
    ffp_launch_each(pixels, look_compare_each, numbers, *drawn, colour, coverage);
}

static __global__ void look_gather_each(size_t count, float *out, FfpLookInputs l, int64_t first) {
    const size_t i = ffp_thread(), g = (size_t)first + i;
    if (i < count)
        ffp_look_inputs(out + i * (size_t)(FFP_LOOK_SEEN + l.numbers), &l.maps, l.pixel[g], l.centre + 3 * g,
                        l.raw + g * (size_t)l.numbers, l.numbers);
}

static void look_gather(float *out, const FfpLookInputs *looked, int64_t first, int count) {
    ffp_launch_each((size_t)count, look_gather_each, out, *looked, first);
}

extern "C" const struct FfpNetworkTable ffp_cuda_network = {
    .gather_rows = gather_rows,
    .scatter_rows = scatter_rows,
    .gather_features = gather_features,
    .scatter_features = scatter_features,
    .add_context_inputs = add_context_inputs,
    .splat = splat,
    .splat_backward = splat_backward,
    .look_compare = look_compare,
    .look_gather = look_gather,
};
