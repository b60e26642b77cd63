#include "engine/render/hold.h"
#include <tgmath.h>

#define FAR_MAX 10 // scales: beyond, the pixel shows another surface than its code

typedef struct Hold {
    const FfpTransport *transport;
    FfpTransport *grad;
    int side;
    real scale, slope; // slope: of the cost, for a pixel
} Hold;

static size_t sample_of(const Hold *h, int x, int y, int i) {
    return (size_t)(y * h->side + i / h->side) * (size_t)h->transport->width +
           (size_t)(x * h->side + i % h->side);
}

// The mean place of a pixel's samples; false: one of them is not lit.
static bool mean_place(const Hold *h, int x, int y, real mean[2]) {
    const int samples = h->side * h->side;
    mean[0] = mean[1] = 0;
    for (int i = 0; i < samples; i++) {
        const size_t s = sample_of(h, x, y, i);
        const real *factor = h->transport->factor + 3 * s, *uv = h->transport->uv + 2 * s;
        if (!(factor[0] > 0 || factor[1] > 0 || factor[2] > 0)) return false;
        for (int k = 0; k < 2; k++) mean[k] += uv[k] / (real)samples;
    }
    return true;
}

// The pixel's cost, without the weight.
static real hold_pixel(const Hold *h, int x, int y, const real place[3]) {
    real mean[2];
    if (!(place[2] > 0) || !mean_place(h, x, y, mean)) return 0;
    const real off[2] = {(mean[0] - place[0]) / h->scale, (mean[1] - place[1]) / h->scale};
    const real far = sqrt(off[0] * off[0] + off[1] * off[1]);
    if (far > FAR_MAX) return 0;
    const real slope = h->slope / (h->scale * (far < 1 ? 1 : far) * (real)(h->side * h->side));
    for (int i = 0; i < h->side * h->side; i++)
        for (int k = 0; k < 2; k++) h->grad->uv[2 * sample_of(h, x, y, i) + (size_t)k] += slope * off[k];
    return far < 1 ? far * far / 2 : far - 0.5F;
}

real ffp_hold_places(const FfpTransport *transport, int side, const FfpImage *positions, real scale,
                     real weight, FfpTransport *grad_transport) {
    const int width = positions->width, height = positions->height;
    int64_t known = 0;
    double sum = 0;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)width * height; i++) known += positions->data[3 * i + 2] > 0;
    if (known == 0) return 0;
    const Hold h = {transport, grad_transport, side, scale, weight / (real)known};
#pragma omp parallel for schedule(static) reduction(+ : sum)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            sum +=
                (double)hold_pixel(&h, x, y, positions->data + 3 * ((size_t)y * (size_t)width + (size_t)x));
    return weight * (real)(sum / (double)known);
}
