// Terms on the G-buffers (paper, Sec. 3.6): mask entropy, depth, distortion, normal smoothness, albedo-guided
// roughness. Neighbours are the pairs (pixel, its right one) and (pixel, the one below); sums run in a fixed
// order, in double.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/integer.h"
#include "core/base/vec.h"
#include "engine/loss/loss.h"
#include "engine/loss/rows.h"
#include "engine/loss/table.h"
#include "engine/loss/terms.h"

#define PART 1024 // pixels of a sum that no row bounds

typedef struct Cover {
    const real *opacity, *mask;
    real *grad, scale; // grad: NULL: not wanted
    int pixels;
} Cover;

static double mask_part(const void *argument, int part) {
    const Cover *c = argument;
    const int end = ffp_smaller((part + 1) * PART, c->pixels);
    double sum = 0;
    for (int i = part * PART; i < end; i++) {
        sum -= ffp_mask_term(c->opacity[i], c->mask[i]);
        if (c->grad) c->grad[i] += ffp_mask_slope(c->opacity[i], c->mask[i], c->scale);
    }
    return sum;
}

real ffp_mask_loss(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity) {
    if (pixels <= 0) return 0;
    if (ffp_device()) return ffp_device()->loss->mask(opacity, mask, pixels, weight, grad_opacity);
    const Cover cover = {opacity, mask, grad_opacity, weight / (real)pixels, pixels};
    return weight * (real)(ffp_sum_of_rows((pixels - 1) / PART + 1, mask_part, &cover) / pixels);
}

real ffp_depth_loss(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                    real *grad_depth_sum, real *grad_opacity) {
    if (pixels <= 0) return 0;
    if (ffp_device())
        return ffp_device()->loss->depth(depth_sum, opacity, truth, pixels, weight, grad_depth_sum,
                                         grad_opacity);
    int count = 0;
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        if (!ffp_depth_counts(opacity[i], truth[i])) continue;
        sum += ffp_depth_term(depth_sum[i], opacity[i], truth[i]);
        count++;
    }
    if (count == 0) return 0;
    const real scale = 2 * weight / (real)count;
    for (int i = 0; i < pixels; i++) {
        if (!ffp_depth_counts(opacity[i], truth[i])) continue;
        real by_opacity;
        const real slope = ffp_depth_slope(depth_sum[i], opacity[i], truth[i], scale, &by_opacity);
        if (grad_depth_sum) grad_depth_sum[i] += slope;
        if (grad_opacity) grad_opacity[i] -= by_opacity;
    }
    return weight * (real)(sum / count);
}

real ffp_distortion_loss(const real *distortion, int pixels, real weight, real *grad_distortion) {
    if (pixels <= 0) return 0;
    if (ffp_device()) return ffp_device()->loss->distortion(distortion, pixels, weight, grad_distortion);
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        sum += distortion[i];
        if (grad_distortion) grad_distortion[i] += weight / (real)pixels;
    }
    return weight * (real)(sum / pixels);
}

double ffp_truth_loss(const real *sum, const real *opacity, const FfpImage *truth, const FfpImage *coverage,
                      real weight, real *grad) {
    if (ffp_device()) return ffp_device()->loss->truth(sum, opacity, truth, coverage, weight, grad);
    const int pixels = truth->width * truth->height, channels = truth->channels;
    double total = 0;
    int64_t count = 0;
    for (int p = 0; p < pixels; p++) count += coverage->data[p] > 0.5F;
    const real step = weight / (real)(count > 0 ? count * channels : 1);
    for (int p = 0; p < pixels; p++) {
        if (coverage->data[p] <= 0.5F) continue;
        for (int k = 0; k < channels; k++) {
            const int i = p * channels + k;
            const real difference = sum[i] - opacity[p] * truth->data[i];
            total += (double)fabs(difference);
            grad[i] += ffp_signed(step, difference);
        }
    }
    return total * (double)step;
}

double ffp_distance_loss(const real *t, const real *truth, int64_t count, real weight, real *grad) {
    if (ffp_device()) return ffp_device()->loss->distance(t, truth, count, weight, grad);
    double total = 0;
    int64_t known = 0;
    for (int64_t i = 0; i < count; i++) {
        grad[i] = 0;
        if (truth[i] <= 0) continue;
        total += (double)fabs(t[i] - truth[i]);
        grad[i] = t[i] > truth[i] ? 1 : -1;
        known++;
    }
    if (known == 0) return 0;
    for (int64_t i = 0; i < count; i++) grad[i] *= weight / (real)known;
    return total * (double)weight / (double)known;
}

typedef struct Pairs { // of neighbours that both count
    int width, height, channels;
    bool *used;         // [pixels]
    real *right, *down; // [pixels,channels] what the pair of a pixel with its right one, or with the one
                        // below, adds to that one's slope and takes from its own; 0: no pair
    int *counts;        // [height] of pairs
    const real *values; // [pixels,channels] unit normals, or sums of roughness,
    const real *albedo, *opacity; // with these
} Pairs;

static Pairs pairs_new(int width, int height, int channels) {
    const size_t pixels = (size_t)width * (size_t)height, numbers = pixels * (size_t)channels;
    real *right = ffp_alloc(2 * numbers, sizeof *right);
    return (Pairs){.width = width,
                   .height = height,
                   .channels = channels,
                   .used = ffp_take(pixels, sizeof(bool)),
                   .right = right,
                   .down = right + numbers,
                   .counts = ffp_alloc((size_t)height, sizeof(int))};
}

static void pairs_free(Pairs *pairs) {
    ffp_free(pairs->used);
    ffp_free(pairs->right);
    ffp_free(pairs->counts);
}

static int count_of(const Pairs *pairs) {
    int count = 0;
    for (int y = 0; y < pairs->height; y++) count += pairs->counts[y];
    return count;
}

// The slope of channel c at a pixel: what its four pairs make of it.
static real slope_at(const Pairs *pairs, int i, int c) {
    const int n = pairs->channels, above = i - pairs->width, k = i * n + c;
    const real from_above = above >= 0 ? pairs->down[above * n + c] : 0,
               from_left = i % pairs->width > 0 ? pairs->right[k - n] : 0;
    return from_above + from_left - pairs->right[k] - pairs->down[k];
}

// The neighbours of pixel (x,y) that count: 0 to 2 indices into `other`, right one first, and where the
// pairs' slopes belong.
static int neighbours(const Pairs *pairs, int x, int y, int other[2], real *slope[2]) {
    const int width = pairs->width, i = y * width + x;
    int count = 0;
    if (!pairs->used[i]) return 0;
    if (x + 1 < width && pairs->used[i + 1]) {
        slope[count] = pairs->right + (size_t)i * pairs->channels;
        other[count++] = i + 1;
    }
    if (y + 1 < pairs->height && pairs->used[i + width]) {
        slope[count] = pairs->down + (size_t)i * pairs->channels;
        other[count++] = i + width;
    }
    pairs->counts[y] += count;
    return count;
}

static double normal_row(const void *argument, int y) {
    const Pairs *pairs = argument;
    const real *unit = pairs->values;
    double sum = 0;
    for (int x = 0; x < pairs->width; x++) {
        int other[2];
        real *slope[2];
        const int i = y * pairs->width + x, count = neighbours(pairs, x, y, other, slope);
        for (int k = 0; k < 3 * count; k++) {
            const int c = k % 3, j = other[k / 3];
            const real step = unit[3 * j + c] - unit[3 * i + c];
            sum += fabs(step);
            slope[k / 3][c] = ffp_signed(1, step);
        }
    }
    return sum;
}

static void add_normal_slopes(const Pairs *pairs, const real *length, real weight, int count, real *grad) {
    const int pixels = pairs->width * pairs->height;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < pixels; i++) {
        if (!pairs->used[i]) continue;
        const real slope[3] = {slope_at(pairs, i, 0), slope_at(pairs, i, 1), slope_at(pairs, i, 2)};
        ffp_unit_normal_backward(grad + 3 * i, slope, pairs->values + 3 * i,
                                 weight / ((real)count * length[i]));
    }
}

real ffp_normal_smooth_loss(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
    if (ffp_device()) return ffp_device()->loss->normal_smooth(normal_sum, mask, width, height, weight, grad);
    Pairs pairs = pairs_new(width, height, 3);
    real *unit = ffp_take((size_t)pixels * 4, sizeof *unit), *length = unit + 3 * (size_t)pixels;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < pixels; i++)
        pairs.used[i] = ffp_unit_normal(unit + 3 * i, length + i, normal_sum + 3 * i, mask[i]);
    pairs.values = unit;
    const double sum = ffp_sum_of_rows(height, normal_row, &pairs);
    const int count = count_of(&pairs);
    if (grad && count > 0) add_normal_slopes(&pairs, length, weight, count, grad);
    ffp_free(unit);
    pairs_free(&pairs);
    return count > 0 ? weight * (real)(sum / count) : 0;
}

static double roughness_row(const void *argument, int y) {
    const Pairs *pairs = argument;
    double sum = 0;
    for (int x = 0; x < pairs->width; x++) {
        int other[2];
        real *slope[2];
        const int i = y * pairs->width + x, count = neighbours(pairs, x, y, other, slope);
        for (int k = 0; k < count; k++) {
            real trust;
            const real step =
                ffp_roughness_step(pairs->values, pairs->albedo, pairs->opacity, i, other[k], &trust);
            sum += fabs(step) * trust;
            *slope[k] = ffp_signed(trust, step);
        }
    }
    return sum;
}

static void add_roughness_slopes(const Pairs *pairs, real weight, int count, real *grad_roughness_sum,
                                 real *grad_opacity) {
    const int pixels = pairs->width * pairs->height;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < pixels; i++) {
        if (!pairs->used[i]) continue;
        const real opacity = pairs->opacity[i];
        const real scaled = weight * slope_at(pairs, i, 0) / ((real)count * opacity);
        if (grad_roughness_sum) grad_roughness_sum[i] += scaled;
        if (grad_opacity) grad_opacity[i] -= scaled * pairs->values[i] / opacity;
    }
}

real ffp_roughness_loss(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
    if (ffp_device())
        return ffp_device()->loss->roughness(roughness_sum, albedo_sum, opacity, mask, width, height, weight,
                                             grad_roughness_sum, grad_opacity);
    Pairs pairs = pairs_new(width, height, 1);
    for (int i = 0; i < pixels; i++) pairs.used[i] = ffp_roughness_counts(opacity[i], mask[i]);
    pairs.values = roughness_sum;
    pairs.albedo = albedo_sum;
    pairs.opacity = opacity;
    const double sum = ffp_sum_of_rows(height, roughness_row, &pairs);
    const int count = count_of(&pairs);
    if (count > 0) add_roughness_slopes(&pairs, weight, count, grad_roughness_sum, grad_opacity);
    pairs_free(&pairs);
    return count > 0 ? weight * (real)(sum / count) : 0;
}
