#include "rig/graycode/edges.h"
#include <math.h>
#include <stddef.h>
#include "core/base/alloc.h"
#include "core/base/call.h"

#define EDGES_LEAST 6                       // that a plane is laid through,
#define SPREAD_LEAST 1.0                    // and their variance in any direction, camera pixels squared
#define MISFIT_MAX 0.6                      // root mean square, blocks: more is not a plane
#define BEYOND_MAX 0.3                      // blocks by which a plane may leave the block that the code names
static const int reaches[] = {3, 5, 8, 12}; // camera pixels around, the next where the one before has too few

int ffp_gray_edge_bit(const FfpGrayAxis *axis, int a, int b) {
    if (a < 0 || b < 0 || (a - b != 1 && b - a != 1)) return -1;
    unsigned difference = ((unsigned)a ^ (unsigned)a >> 1) ^ ((unsigned)b ^ (unsigned)b >> 1);
    int bit = axis->bits - 1;
    for (; !(difference & 1U); difference >>= 1) bit--;
    return bit;
}

// Where between two neighbouring pixels the edge lies, as a share of the way; -1: there is none.
static float edge_between(const FfpGrayAxis *axis, size_t from, size_t to) {
    const int bit = ffp_gray_edge_bit(axis, axis->code[from], axis->code[to]);
    if (bit < 0) return -1;
    const int a = ffp_gray_signal(axis->signal[bit][from]), b = ffp_gray_signal(axis->signal[bit][to]);
    return a != b ? (float)a / (float)(a - b) : -1;
}

typedef struct Fit { // sums over edges, relative to the pixel and its block's middle
    int edges;
    double n, x, y, xx, xy, yy, u, ux, uy, uu; // weighted
} Fit;

static void add(Fit *fit, double w, double x, double y, double u) {
    fit->edges++;
    fit->n += w, fit->x += w * x, fit->y += w * y, fit->u += w * u;
    fit->xx += w * x * x, fit->xy += w * x * y, fit->yy += w * y * y;
    fit->ux += w * u * x, fit->uy += w * u * y, fit->uu += w * u * u;
}

// The plane's value at the pixel; false where the edges do not make one.
static bool solve(const Fit *fit, double block, double *value) {
    if (fit->edges < EDGES_LEAST) return false;
    const double x = fit->x / fit->n, y = fit->y / fit->n, u = fit->u / fit->n;
    const double xx = fit->xx / fit->n - x * x, xy = fit->xy / fit->n - x * y, yy = fit->yy / fit->n - y * y;
    const double ux = fit->ux / fit->n - u * x, uy = fit->uy / fit->n - u * y, uu = fit->uu / fit->n - u * u;
    const double least = 0.5 * (xx + yy) - hypot(0.5 * (xx - yy), xy), determinant = xx * yy - xy * xy;
    if (!(least >= SPREAD_LEAST)) return false;
    const double across = (ux * yy - uy * xy) / determinant, down = (uy * xx - ux * xy) / determinant;
    const double misfit = uu - across * ux - down * uy;
    *value = u - across * x - down * y;
    return misfit <= MISFIT_MAX * MISFIT_MAX * block * block;
}

typedef struct Edges {
    const FfpGrayAxis *axis;
    float *right, *below; // [h,w] between a pixel and the next
    float *position;
} Edges;

// Edges of the surface that the pixel shows: their codes go on from its own.
static Fit gather(const Edges *e, int x, int y, int reach) {
    const FfpGrayAxis *axis = e->axis;
    const size_t width = (size_t)axis->width;
    const int own = axis->code[(size_t)y * width + (size_t)x], far = 2 * reach + 1;
    Fit fit = {0};
    for (int j = y > reach ? y - reach : 0; j <= y + reach && j < axis->height; j++)
        for (int i = x > reach ? x - reach : 0; i <= x + reach && i < axis->width; i++) {
            const size_t at = (size_t)j * width + (size_t)i;
            const float t[2] = {e->right[at], e->below[at]};
            for (int k = 0; k < 2; k++) {
                if (t[k] < 0) continue;
                const size_t next = k ? at + width : at + 1;
                const int a = axis->code[at], b = axis->code[next], edge = a > b ? a : b;
                if (edge - own > far || own - edge > far) continue;
                const double light = (double)fminf(axis->light[at], axis->light[next]);
                if (!(light > 0)) continue;
                add(&fit, light * light, i - x + (k ? 0.0 : (double)t[k]), j - y + (k ? (double)t[k] : 0.0),
                    axis->block * (edge - own - 0.5));
            }
        }
    return fit;
}

static float position_of(const Edges *e, int x, int y) {
    const double block = e->axis->block, most = (0.5 + BEYOND_MAX) * block;
    const int code = e->axis->code[(size_t)y * (size_t)e->axis->width + (size_t)x];
    double value = 0;
    bool found = false;
    for (size_t r = 0; r < sizeof reaches / sizeof *reaches && !found; r++) {
        const Fit fit = gather(e, x, y, reaches[r]);
        found = solve(&fit, block, &value) && fabs(value) <= most;
    }
    return (float)(block * (code + 0.5) + (found ? value : 0));
}

static void find_edges(void *argument, int64_t row) {
    const Edges *e = argument;
    const size_t width = (size_t)e->axis->width, first = (size_t)row * width;
    const bool last = row == e->axis->height - 1;
    for (size_t i = first; i < first + width; i++) {
        e->right[i] = i + 1 < first + width ? edge_between(e->axis, i, i + 1) : -1;
        e->below[i] = last ? -1 : edge_between(e->axis, i, i + width);
    }
}

static void place_row(void *argument, int64_t row) {
    const Edges *e = argument;
    const size_t width = (size_t)e->axis->width;
    for (int x = 0; x < e->axis->width; x++) {
        const size_t i = (size_t)row * width + (size_t)x;
        if (e->axis->code[i] >= 0 && e->axis->light[i] > 0) e->position[i] = position_of(e, x, (int)row);
    }
    ffp_cancel_point();
}

void ffp_gray_positions(float *position, const FfpGrayAxis *axis) {
    const size_t pixels = (size_t)axis->width * (size_t)axis->height;
    Edges edges = {axis, ffp_alloc(pixels, sizeof(float)), ffp_alloc(pixels, sizeof(float)), position};
    ffp_parallel_for(axis->height, 0, find_edges, &edges);
    ffp_parallel_for(axis->height, 0, place_row, &edges);
    ffp_free(edges.right), ffp_free(edges.below);
}
