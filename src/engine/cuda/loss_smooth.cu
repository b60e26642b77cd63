// Smoothness of normals and roughness: pairs of neighbouring pixels. A pixel's thread sums the pairs with its
// right and lower neighbour; for the gradient it takes all four pairs it is in, in the CPU's order.
#include "engine/cuda/loss_room.h"
#include "engine/cuda/loss_sums.h"
extern "C" {
#include "engine/loss/terms.h"
}

// The neighbours inside the map: above, left, right, below; -1 where there is none. Pairs with the first two
// end at the pixel, those with the others begin there.
static __device__ void neighbours(int other[4], int i, int width, int height) {
    const int x = i % width, y = i / width;
    other[0] = y > 0 ? i - width : -1;
    other[1] = x > 0 ? i - 1 : -1;
    other[2] = x + 1 < width ? i + 1 : -1;
    other[3] = y + 1 < height ? i + width : -1;
}

typedef struct Normals {
    const float *sum, *mask; // [pixels,3], [pixels]
    int width, height;
} Normals;

static __device__ bool unit_at(float unit[3], float *length, Normals normals, int i) {
    const float sum[3] = {normals.sum[3 * i], normals.sum[3 * i + 1], normals.sum[3 * i + 2]};
    return ffp_unit_normal(unit, length, sum, normals.mask[i]);
}

static __global__ void normal_pairs(size_t count, FfpPartials sums, Normals normals) {
    const int i = (int)ffp_thread();
    float unit[3], next[3], length;
    double sum = 0;
    int pairs = 0, other[4];
    if (i < (int)count && unit_at(unit, &length, normals, i)) {
        neighbours(other, i, normals.width, normals.height);
        for (int k = 2; k < 4; k++) {
            if (other[k] < 0 || !unit_at(next, &length, normals, other[k])) continue;
            for (int c = 0; c < 3; c++) sum += fabsf(next[c] - unit[c]);
            pairs++;
        }
    }
    ffp_store_partial(sums, 0, sum);
    ffp_store_partial(sums, 1, pairs);
}

// totals[1]: how many pairs there are.
static __global__ void normal_slopes(size_t count, const double *totals, Normals normals, float weight,
                                     float *grad) {
    const int i = (int)ffp_thread();
    float unit[3], next[3], length, other_length, slope[3] = {0, 0, 0};
    int other[4];
    if (i >= (int)count || totals[1] == 0 || !unit_at(unit, &length, normals, i)) return;
    neighbours(other, i, normals.width, normals.height);
    for (int k = 0; k < 4; k++)
        if (other[k] >= 0 && unit_at(next, &other_length, normals, other[k]))
            for (int c = 0; c < 3; c++) slope[c] += ffp_signed(1, unit[c] - next[c]);
    ffp_unit_normal_backward(grad + 3 * i, slope, unit, weight / ((float)totals[1] * length));
}

real ffp_cuda_normal_smooth(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad) {
    const Normals normals = {normal_sum, mask, width, height};
    const size_t pixels = (size_t)width * height;
    const FfpPartials sums = ffp_launch_sums(2, pixels, normal_pairs, normals);
    ffp_cuda_loss_add(&sums);
    if (grad) ffp_launch_each(pixels, normal_slopes, sums.total, normals, weight, grad);
    return (real)ffp_cuda_mean(&sums, false, weight, 0);
}

typedef struct Roughness {
    const float *sum, *albedo_sum, *opacity, *mask; // [pixels], albedo [pixels,3]
    int width, height;
} Roughness;

static __device__ bool counts_at(Roughness map, int i) {
    return i >= 0 && ffp_roughness_counts(map.opacity[i], map.mask[i]);
}

static __device__ float step_between(Roughness map, int i, int j, float *trust) {
    return ffp_roughness_step(map.sum, map.albedo_sum, map.opacity, i, j, trust);
}

static __global__ void roughness_pairs(size_t count, FfpPartials sums, Roughness map) {
    const int i = (int)ffp_thread();
    double sum = 0;
    int pairs = 0, other[4];
    if (i < (int)count && counts_at(map, i)) {
        neighbours(other, i, map.width, map.height);
        for (int k = 2; k < 4; k++) {
            if (!counts_at(map, other[k])) continue;
            float trust;
            const float step = step_between(map, i, other[k], &trust);
            sum += fabsf(step) * trust;
            pairs++;
        }
    }
    ffp_store_partial(sums, 0, sum);
    ffp_store_partial(sums, 1, pairs);
}

static __global__ void roughness_slopes(size_t count, const double *totals, Roughness map, float weight,
                                        float *grad_sum, float *grad_opacity) {
    const int i = (int)ffp_thread();
    int other[4];
    if (i >= (int)count || totals[1] == 0 || !counts_at(map, i)) return;
    neighbours(other, i, map.width, map.height);
    float slope = 0;
    for (int k = 0; k < 4; k++) {
        if (!counts_at(map, other[k])) continue;
        float trust;
        const float step =
            k < 2 ? step_between(map, other[k], i, &trust) : step_between(map, i, other[k], &trust);
        slope += ffp_signed(k < 2 ? trust : -trust, step);
    }
    const float scaled = weight * slope / ((float)totals[1] * map.opacity[i]);
    if (grad_sum) grad_sum[i] += scaled;
    if (grad_opacity) grad_opacity[i] -= scaled * map.sum[i] / map.opacity[i];
}

real ffp_cuda_roughness(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity) {
    const Roughness map = {roughness_sum, albedo_sum, opacity, mask, width, height};
    const size_t pixels = (size_t)width * height;
    const FfpPartials sums = ffp_launch_sums(2, pixels, roughness_pairs, map);
    ffp_cuda_loss_add(&sums);
    if (grad_roughness_sum || grad_opacity)
        ffp_launch_each(pixels, roughness_slopes, sums.total, map, weight, grad_roughness_sum, grad_opacity);
    return (real)ffp_cuda_mean(&sums, false, weight, 0);
}
