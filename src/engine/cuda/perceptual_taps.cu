// A block takes 32 pixels; of each, every one of 16 threads takes some channels.
#include "engine/cuda/perceptual_taps.h"
extern "C" {
#include "engine/loss/terms.h"
}

enum { PIXELS = FFP_WARP, GROUPS = 16 };

unsigned ffp_cuda_tap_blocks(int pixels) {
    return ffp_blocks((size_t)pixels, PIXELS);
}

// Sum over a pixel's threads, for all of them.
static __device__ float pixel_sum(float mine) {
    __shared__ float part[GROUPS][PIXELS];
    part[threadIdx.y][threadIdx.x] = mine;
    __syncthreads();
    float sum = 0;
    for (int g = 0; g < GROUPS; g++) sum += part[g][threadIdx.x];
    __syncthreads(); // the next sum may write
    return sum;
}

// inverse * sum_c head_c (u_c - v_c)^2, u = a/|a|, v = b/|b|, and its gradient times scale: see
// engine/loss/perceptual.c.
static __global__ void lpips_tap(FfpPartials sums, FfpTapPair pair, double inverse, float scale) {
    const int p = (int)(blockIdx.x * PIXELS + threadIdx.x);
    const int end = p < pair.pixels ? pair.channels : 0; // threads without a pixel only come to the meetings
    const size_t row = (size_t)2 * pair.pixels;
    const float *a = pair.value + p, *b = a + pair.pixels;
    float square_a = 0, square_b = 0, value = 0, along = 0;
    for (int c = (int)threadIdx.y; c < end; c += GROUPS) {
        square_a += a[c * row] * a[c * row];
        square_b += b[c * row] * b[c * row];
    }
    const float inverse_a = 1 / (sqrtf(pixel_sum(square_a)) + 1e-10F);
    const float inverse_b = 1 / (sqrtf(pixel_sum(square_b)) + 1e-10F);
    for (int c = (int)threadIdx.y; c < end; c += GROUPS) {
        const float u = a[c * row] * inverse_a, difference = u - b[c * row] * inverse_b;
        value += pair.head[c] * difference * difference;
        along += 2 * pair.head[c] * difference * u;
    }
    along = pixel_sum(along);
    for (int c = (int)threadIdx.y; pair.grad && c < end; c += GROUPS) {
        const float u = a[c * row] * inverse_a, difference = u - b[c * row] * inverse_b;
        pair.grad[(size_t)c * pair.pixels + p] =
            scale * ffp_lpips_slope(a[c * row], u, difference, pair.head[c], along, inverse_a);
    }
    ffp_store_partial(sums, 0, inverse * value);
}

static __global__ void square_tap(FfpPartials sums, FfpTapPair pair, double inverse, float scale) {
    const int p = (int)(blockIdx.x * PIXELS + threadIdx.x);
    const int end = p < pair.pixels ? pair.channels : 0;
    const size_t row = (size_t)2 * pair.pixels;
    float value = 0;
    for (int c = (int)threadIdx.y; c < end; c += GROUPS) {
        const float *a = pair.value + c * row + p, difference = *a - a[pair.pixels];
        value += difference * difference;
        if (pair.grad) pair.grad[(size_t)c * pair.pixels + p] = scale * 2 * difference;
    }
    ffp_store_partial(sums, 0, inverse * value);
}

void ffp_cuda_tap(FfpPartials sums, const FfpTapPair *pair, real weight) {
    // LPIPS averages over pixels and sums channels, the feature distance averages over both.
    const double inverse = 1 / (pair->head ? (double)pair->pixels : (double)pair->pixels * pair->channels);
    ffp_launch_blocks(pair->head ? lpips_tap : square_tap, dim3(ffp_cuda_tap_blocks(pair->pixels)),
                      dim3(PIXELS, GROUPS), 0, sums, *pair, inverse, weight * (real)inverse);
}
