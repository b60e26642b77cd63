// Pixel losses: mean absolute and squared differences, and the way back through the sRGB transfer function.
#include <assert.h>
#include <tgmath.h>
#include "core/base/device.h"
#include "engine/loss/loss.h"
#include "engine/loss/table.h"
#include "engine/loss/terms.h"

real ffp_l1_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    assert(prediction->width == target->width && prediction->height == target->height &&
           prediction->channels == target->channels);
    const size_t row = (size_t)prediction->width * prediction->channels, count = row * prediction->height;
    if (count == 0) return 0;
    if (ffp_device()) return ffp_device()->loss->l1(prediction, target, weight, grad);
    const real step = weight / (real)count;
    double total = 0; // row by row in real, rows in double: a picture's sum in fp32 would lose digits
    for (int y = 0; y < prediction->height; y++) {
        const real *p = prediction->data + y * row, *t = target->data + y * row;
        real sum = 0;
#pragma omp simd reduction(+ : sum)
        for (size_t i = 0; i < row; i++) sum += fabs(p[i] - t[i]);
        total += sum;
        if (!grad) continue;
        real *g = grad->data + y * row;
        for (size_t i = 0; i < row; i++) g[i] += ffp_signed(step, p[i] - t[i]);
    }
    return weight * (real)(total / (double)count);
}

real ffp_square_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    assert(prediction->width == target->width && prediction->height == target->height &&
           prediction->channels == target->channels);
    const size_t row = (size_t)prediction->width * prediction->channels, count = row * prediction->height;
    if (count == 0) return 0;
    if (ffp_device()) return ffp_device()->loss->square(prediction, target, weight, grad);
    const real step = 2 * weight / (real)count;
    double total = 0;
    for (int y = 0; y < prediction->height; y++) {
        const real *p = prediction->data + y * row, *t = target->data + y * row;
        real sum = 0;
#pragma omp simd reduction(+ : sum)
        for (size_t i = 0; i < row; i++) sum += (p[i] - t[i]) * (p[i] - t[i]);
        total += sum;
        if (!grad) continue;
        real *g = grad->data + y * row;
        for (size_t i = 0; i < row; i++) g[i] += step * (p[i] - t[i]);
    }
    return weight * (real)(total / (double)count);
}
