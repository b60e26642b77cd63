// Terms on the G-buffers (paper, Sec. 3.6): mask entropy, depth, distortion, normal smoothness, albedo-guided
// roughness. Neighbours are the pairs (pixel, its right one) and (pixel, the one below); sums run in a fixed
// order, in double.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/vec.h"
#include "engine/loss/loss.h"
#include "engine/loss/table.h"
#include "engine/loss/terms.h"

real ffp_mask_loss(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity) {
    if (pixels <= 0) return 0;
    if (ffp_device()) return ffp_device()->loss->mask(opacity, mask, pixels, weight, grad_opacity);
    const real scale = weight / (real)pixels;
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        sum -= ffp_mask_term(opacity[i], mask[i]);
        if (grad_opacity) grad_opacity[i] += ffp_mask_slope(opacity[i], mask[i], scale);
    }
    return weight * (real)(sum / pixels);
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

// The neighbours of pixel (x,y) that count: 0 to 2 indices into `other`, right one first.
static int neighbours(const bool *used, int x, int y, int width, int height, int other[2]) {
    const int i = y * width + x;
    int count = 0;
    if (!used[i]) return 0;
    if (x + 1 < width && used[i + 1]) other[count++] = i + 1;
    if (y + 1 < height && used[i + width]) other[count++] = i + width;
    return count;
}

static int count_pairs(const bool *used, int width, int height) {
    int count = 0, other[2];
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) count += neighbours(used, x, y, width, height, other);
    return count;
}

// Unit normals [pixels,3] and the lengths of the sums; used: foreground pixels that carry a normal.
static void normalise_sums(real *unit, real *length, bool *used, const real *sums, const real *mask,
                           int pixels) {
    for (int i = 0; i < pixels; i++)
        used[i] = ffp_unit_normal(unit + 3 * i, length + i, sums + 3 * i, mask[i]);
}

real ffp_normal_smooth_loss(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
    if (ffp_device()) return ffp_device()->loss->normal_smooth(normal_sum, mask, width, height, weight, grad);
    real *unit = ffp_alloc((size_t)pixels * 7, sizeof *unit), *slope = unit + 3 * (size_t)pixels;
    real *length = slope + 3 * (size_t)pixels;
    bool *used = ffp_alloc(pixels, sizeof *used);
    normalise_sums(unit, length, used, normal_sum, mask, pixels);
    const int pairs = count_pairs(used, width, height);
    double sum = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int other[2];
            const int i = y * width + x, count = neighbours(used, x, y, width, height, other);
            for (int k = 0; k < 3 * count; k++) {
                const int c = k % 3, j = other[k / 3];
                const real step = unit[3 * j + c] - unit[3 * i + c];
                sum += fabs(step);
                slope[3 * j + c] += ffp_signed(1, step);
                slope[3 * i + c] -= ffp_signed(1, step);
            }
        }
    for (int i = 0; grad && pairs > 0 && i < pixels; i++)
        if (used[i])
            ffp_unit_normal_backward(grad + 3 * i, slope + 3 * i, unit + 3 * i,
                                     weight / ((real)pairs * length[i]));
    ffp_free(used);
    ffp_free(unit);
    return pairs > 0 ? weight * (real)(sum / pairs) : 0;
}

real ffp_roughness_loss(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
    if (ffp_device())
        return ffp_device()->loss->roughness(roughness_sum, albedo_sum, opacity, mask, width, height, weight,
                                             grad_roughness_sum, grad_opacity);
    bool *used = ffp_alloc(pixels, sizeof *used);
    real *slope = ffp_alloc(pixels, sizeof *slope);
    for (int i = 0; i < pixels; i++) used[i] = ffp_roughness_counts(opacity[i], mask[i]);
    const int pairs = count_pairs(used, width, height);
    double sum = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int other[2];
            const int i = y * width + x, count = neighbours(used, x, y, width, height, other);
            for (int k = 0; k < count; k++) {
                const int j = other[k];
                real trust;
                const real step = ffp_roughness_step(roughness_sum, albedo_sum, opacity, i, j, &trust);
                sum += fabs(step) * trust;
                slope[j] += ffp_signed(trust, step);
                slope[i] -= ffp_signed(trust, step);
            }
        }
    for (int i = 0; i < pixels && pairs > 0; i++) {
        if (!used[i]) continue;
        const real scaled = weight * slope[i] / ((real)pairs * opacity[i]);
        if (grad_roughness_sum) grad_roughness_sum[i] += scaled;
        if (grad_opacity) grad_opacity[i] -= scaled * roughness_sum[i] / opacity[i];
    }
    ffp_free(slope);
    ffp_free(used);
    return pairs > 0 ? weight * (real)(sum / pairs) : 0;
}
