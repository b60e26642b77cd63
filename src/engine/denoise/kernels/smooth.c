// Smooths a pixel by the windows that hold it, and the table of one CPU level.
#include <string.h>
#include <tgmath.h>
#include "engine/denoise/kernels/kernels.h"

// Adds what a window says of a pixel's values.
static void add(const FfpWindow *window, const real *values, real coverage, real sum[FFP_VALUES]) {
    real off[FFP_VALUES];
    for (int v = 0; v < FFP_VALUES; v++) off[v] = values[v] - coverage * window->mean[v];
    for (int p = 0; p < FFP_VALUES; p++) {
        real value = coverage * window->mean[p];
        for (int q = 0; q < FFP_VALUES; q++) value += window->kept[p * FFP_VALUES + q] * off[q];
        sum[p] += window->weight * value;
    }
}

void FFP_K(smooth)(const FfpFilter *f, int x, int y, real values[FFP_VALUES]) {
    const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
    real sum[FFP_VALUES] = {0}, weight = 0;
    memcpy(values, f->stack + i * FFP_VALUES, FFP_VALUES * sizeof *values);
    for (int row = ffp_first_window(f, y); row < f->down && row * f->stride <= y + FFP_WINDOW_RADIUS; row++)
        for (int column = ffp_first_window(f, x);
             column < f->across && column * f->stride <= x + FFP_WINDOW_RADIUS; column++) {
            const FfpWindow *window =
                &f->windows[(size_t)(row - f->first) * (size_t)f->across + (size_t)column];
            if (window->weight <= 0) continue;
            add(window, values, f->coverage[i], sum);
            weight += window->weight;
        }
    for (int v = 0; weight > 0 && v < FFP_VALUES; v++) values[v] = fmax(sum[v] / weight, 0);
}

const FfpDenoiseKernels FFP_K(denoise) = {.smooth = FFP_K(smooth)};
