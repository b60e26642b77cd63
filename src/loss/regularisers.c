// Terms on the G-buffers (paper, Sec. 3.6): mask entropy, depth, distortion, normal smoothness, albedo-guided
// roughness. Neighbours are the pairs (pixel, its right one) and (pixel, the one below); sums run in a fixed
// order, in double.
#include "loss/loss.h"

#include <stdlib.h>
#include <tgmath.h>
#include "base/arena.h"
#include "base/vec.h"

// Below this opacity (or length of a summed normal) a pixel carries no surface to compare: 1/O would only
// amplify noise.
#define LEAST_COVER 0.1F

real ffp_mask_loss(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity) {
    if (pixels <= 0) return 0;
    const real low = 1e-6F, high = 1 - 1e-6F, scale = weight / (real)pixels;
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        const real o = fmin(fmax(opacity[i], low), high), m = mask[i];
        sum -= m * log(o) + (1 - m) * log(1 - o);
        if (grad_opacity && o == opacity[i]) grad_opacity[i] += scale * (o - m) / (o * (1 - o));
    }
    return weight * (real)(sum / pixels);
}

real ffp_depth_loss(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                    real *grad_depth_sum, real *grad_opacity) {
    int count = 0;
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        if (!(truth[i] > 0 && opacity[i] > 0.5F)) continue;
        const real error = depth_sum[i] / opacity[i] - truth[i];
        sum += error * error;
        count++;
    }
    if (count == 0) return 0;
    const real scale = 2 * weight / (real)count;
    for (int i = 0; i < pixels; i++) {
        if (!(truth[i] > 0 && opacity[i] > 0.5F)) continue;
        const real depth = depth_sum[i] / opacity[i], slope = scale * (depth - truth[i]) / opacity[i];
        if (grad_depth_sum) grad_depth_sum[i] += slope;
        if (grad_opacity) grad_opacity[i] -= slope * depth;
    }
    return weight * (real)(sum / count);
}

real ffp_distortion_loss(const real *distortion, int pixels, real weight, real *grad_distortion) {
    if (pixels <= 0) return 0;
    double sum = 0;
    for (int i = 0; i < pixels; i++) {
        sum += distortion[i];
        if (grad_distortion) grad_distortion[i] += weight / (real)pixels;
    }
    return weight * (real)(sum / pixels);
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

static real sign(real x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

// Unit normals [pixels,3] and the lengths of the sums; used: foreground pixels that carry a normal.
static void normalise_sums(real *unit, real *length, bool *used, const real *sums, const real *mask,
                           int pixels) {
    for (int i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++) unit[3 * i + c] = sums[3 * i + c];
        length[i] = ffp_normalise3(unit + 3 * i);
        used[i] = mask[i] > 0.5F && length[i] > LEAST_COVER;
    }
}

real ffp_normal_smooth_loss(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
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
                slope[3 * j + c] += sign(step);
                slope[3 * i + c] -= sign(step);
            }
        }
    // Through the normalisation: d(n/|n|) = (I - u u^T) dn / |n|.
    for (int i = 0; grad && i < pixels; i++) {
        if (!used[i]) continue;
        const real along = ffp_dot3(slope + 3 * i, unit + 3 * i), scale = weight / ((real)pairs * length[i]);
        for (int c = 0; c < 3 && pairs > 0; c++)
            grad[3 * i + c] += scale * (slope[3 * i + c] - along * unit[3 * i + c]);
    }
    free(used);
    free(unit);
    return pairs > 0 ? weight * (real)(sum / pairs) : 0;
}

real ffp_roughness_loss(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity) {
    const int pixels = width * height;
    if (pixels <= 0) return 0;
    bool *used = ffp_alloc(pixels, sizeof *used);
    real *slope = ffp_alloc(pixels, sizeof *slope);
    for (int i = 0; i < pixels; i++) used[i] = mask[i] > 0.5F && opacity[i] > LEAST_COVER;
    const int pairs = count_pairs(used, width, height);
    double sum = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int other[2];
            const int i = y * width + x, count = neighbours(used, x, y, width, height, other);
            for (int k = 0; k < count; k++) {
                const int j = other[k];
                real change = 0;
                for (int c = 0; c < 3; c++)
                    change += fabs(albedo_sum[3 * j + c] / opacity[j] - albedo_sum[3 * i + c] / opacity[i]);
                const real step = roughness_sum[j] / opacity[j] - roughness_sum[i] / opacity[i],
                           trust = exp(-change);
                sum += fabs(step) * trust;
                slope[j] += sign(step) * trust;
                slope[i] -= sign(step) * trust;
            }
        }
    for (int i = 0; i < pixels && pairs > 0; i++) {
        if (!used[i]) continue;
        const real scaled = weight * slope[i] / ((real)pairs * opacity[i]);
        if (grad_roughness_sum) grad_roughness_sum[i] += scaled;
        if (grad_opacity) grad_opacity[i] -= scaled * roughness_sum[i] / opacity[i];
    }
    free(slope);
    free(used);
    return pairs > 0 ? weight * (real)(sum / pairs) : 0;
}
