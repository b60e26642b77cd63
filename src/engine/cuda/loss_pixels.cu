// Losses and conversions that take every value of a picture by itself.
#include "engine/cuda/loss_room.h"
#include "engine/cuda/loss_sums.h"
extern "C" {
#include "engine/loss/terms.h"
}

static size_t values_of(const FfpImage *image) {
    return (size_t)image->width * image->height * image->channels;
}

static __global__ void l1_values(size_t count, FfpPartials sums, const float *prediction, const float *target,
                                 float step, float *grad) {
    const size_t i = ffp_thread();
    const float difference = i < count ? prediction[i] - target[i] : 0;
    if (grad && i < count) grad[i] += ffp_signed(step, difference);
    ffp_store_partial(sums, 0, fabsf(difference));
}

real ffp_cuda_l1(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    const size_t count = values_of(prediction);
    const FfpPartials sums = ffp_launch_sums(1, count, l1_values, prediction->data, target->data,
                                             weight / (real)count, grad ? grad->data : NULL);
    return (real)ffp_cuda_mean(&sums, true, weight, (double)count);
}

static __global__ void square_values(size_t count, FfpPartials sums, const float *prediction,
                                     const float *target, float step, float *grad) {
    const size_t i = ffp_thread();
    const float difference = i < count ? prediction[i] - target[i] : 0;
    if (grad && i < count) grad[i] += step * difference;
    ffp_store_partial(sums, 0, difference * difference);
}

real ffp_cuda_square(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    const size_t count = values_of(prediction);
    const FfpPartials sums = ffp_launch_sums(1, count, square_values, prediction->data, target->data,
                                             2 * weight / (real)count, grad ? grad->data : NULL);
    return (real)ffp_cuda_mean(&sums, true, weight, (double)count);
}

static __global__ void squared_values(size_t count, FfpPartials sums, const float *a, const float *b,
                                      const float *mask, int channels) {
    const size_t i = ffp_thread();
    const bool used = i < count && (!mask || mask[i / channels] > 0.5F);
    const double difference = used ? (double)a[i] - b[i] : 0;
    ffp_store_partial(sums, 0, difference * difference);
    ffp_store_partial(sums, 1, used);
}

double ffp_cuda_squared_error(const FfpImage *a, const FfpImage *b, const FfpImage *mask, size_t *count) {
    *count = 0;
    if (values_of(a) == 0) return 0;
    const FfpPartials sums = ffp_launch_sums(2, values_of(a), squared_values, a->data, b->data,
                                             mask ? mask->data : NULL, a->channels);
    if (ffp_cuda_losses_are_deferred() && !mask) return ffp_cuda_mean(&sums, true, 1, 0);
    double totals[2];
    ffp_cuda_loss_totals(totals, &sums, true);
    *count = (size_t)totals[1];
    return totals[0];
}

// A fourth channel is not a colour.
static __device__ bool is_colour(size_t i, int channels) {
    return channels != 4 || i % 4 != 3;
}

static __global__ void encode(size_t count, float *data, int channels) {
    const size_t i = ffp_thread();
    if (i < count && is_colour(i, channels)) data[i] = ffp_srgb_encode(data[i]);
}

static __global__ void decode(size_t count, float *data, int channels) {
    const size_t i = ffp_thread();
    if (i < count && is_colour(i, channels)) data[i] = ffp_srgb_decode(data[i]);
}

void ffp_cuda_to_srgb(FfpImage *image) {
    ffp_launch_each(values_of(image), encode, image->data, image->channels);
}

void ffp_cuda_to_linear(FfpImage *image) {
    ffp_launch_each(values_of(image), decode, image->data, image->channels);
}
