#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "engine/denoise/stack.h"

#define DARK 0.02          // values below it count little
#define MOST 1000000       // pixels that are sampled, about
#define ENOUGH 2000        // pixels that must remain while values are left out
#define LEAST 200          // pixels below which nothing is said
#define ROUNDS 10          // of leaving out outliers
#define OUTLIER 3          // deviations
#define NOISE_LEAST 0.0005 // below which there is none

typedef struct Samples {
    int64_t count;
    int step;                  // between the rows and columns that are sampled
    real (*edges)[FFP_VALUES]; // Laplacian of each value
    uint16_t *bright;          // bit v: value v is nowhere dark around the pixel
} Samples;

// Laplacian of noise of variance 1 has variance 1: 16 + 4 * 4 + 4 * 1 = 36.
static void laplacian(const real *stack, int width, size_t i, real edges[FFP_VALUES], uint16_t *bright) {
    static const real kernel[3] = {1, -2, 1};
    for (int v = 0; v < FFP_VALUES; v++) {
        real sum = 0, least = INFINITY;
        for (int y = 0; y < 3; y++)
            for (int x = 0; x < 3; x++) {
                const ptrdiff_t at = (ptrdiff_t)i + (y - 1) * (ptrdiff_t)width + x - 1;
                const real value = stack[at * FFP_VALUES + v];
                sum += kernel[x] * kernel[y] * value;
                least = fmin(least, value);
            }
        edges[v] = sum / 6;
        if (least > (real)DARK) *bright |= (uint16_t)(1U << v);
    }
}

static bool inside(const FfpImage *coverage, int x, int y) {
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            if (coverage->data[(size_t)(y + dy) * (size_t)coverage->width + (size_t)(x + dx)] < 1)
                return false;
    return true;
}

// Samples of row y, from `at` on; returns the place after the last one. stack NULL: only counts.
static int64_t sample_row(const Samples *s, const FfpView *view, const real *stack, int y, int64_t at) {
    const int width = view->camera.width;
    for (int x = 1; x + 1 < width; x += s->step) {
        if (!inside(&view->coverage, x, y)) continue;
        if (stack) {
            s->bright[at] = 0;
            laplacian(stack, width, (size_t)y * (size_t)width + (size_t)x, s->edges[at], &s->bright[at]);
        }
        at++;
    }
    return at;
}

static void sample_view(Samples *s, const FfpView *view, const int photographs[FFP_PHOTOGRAPHS]) {
    const int height = view->camera.height, rows = height > 2 ? (height - 3) / s->step + 1 : 0;
    real *stack = ffp_stack_new(view, photographs);
    int64_t *first = ffp_alloc((size_t)rows + 1, sizeof *first); // of each row
#pragma omp parallel for schedule(static)
    for (int r = 0; r < rows; r++) first[r + 1] = sample_row(s, view, NULL, 1 + r * s->step, 0);
    first[0] = s->count;
    for (int r = 0; r < rows; r++) first[r + 1] += first[r];
#pragma omp parallel for schedule(dynamic, 8)
    for (int r = 0; r < rows; r++) sample_row(s, view, stack, 1 + r * s->step, first[r]);
    s->count = first[rows];
    ffp_free(first);
    ffp_free(stack);
}

static int64_t count_bright(const Samples *s, uint16_t values) {
    int64_t count = 0;
    for (int64_t i = 0; i < s->count; i++) count += (s->bright[i] & values) == values;
    return count;
}

// Leaves out the value that is dark most often, until enough pixels have all others bright.
static uint16_t choose_values(const Samples *s) {
    uint16_t values = (1U << FFP_VALUES) - 1;
    for (int left = FFP_VALUES; left > 2 && count_bright(s, values) < ENOUGH; left--) {
        int darkest = -1;
        int64_t least = INT64_MAX;
        for (int v = 0; v < FFP_VALUES; v++) {
            const int64_t count = values >> v & 1 ? count_bright(s, (uint16_t)(1U << v)) : INT64_MAX;
            if (count < least) {
                least = count;
                darkest = v;
            }
        }
        values &= (uint16_t) ~(1U << darkest);
    }
    return values;
}

// Keeps the chosen values of the pixels where all are bright; returns how many values that are.
static int keep(Samples *s, uint16_t values) {
    int64_t kept = 0;
    int n = 0;
    for (int64_t i = 0; i < s->count; i++) {
        if ((s->bright[i] & values) != values) continue;
        n = 0;
        for (int v = 0; v < FFP_VALUES; v++)
            if (values >> v & 1) s->edges[kept][n++] = s->edges[i][v];
        kept++;
    }
    s->count = kept;
    return n;
}

static double along(const real *edges, const double *direction, int n) {
    double sum = 0;
    for (int v = 0; v < n; v++) sum += (double)edges[v] * direction[v];
    return sum;
}

typedef struct Products { // of the values of samples: sums of e e^T, its lower half
    double sum[FFP_VALUES * FFP_VALUES];
    int64_t count;
} Products;

// All samples but the outliers along a direction.
static Products products_of(const Samples *s, int64_t from, int64_t end, int n, const double *direction,
                            double most) {
    Products out = {0};
    for (int64_t i = from; i < end; i++) {
        const real *e = s->edges[i];
        const double d = along(e, direction, n);
        if (d * d > most) continue;
        out.count++;
        for (int p = 0; p < n; p++)
            for (int q = 0; q <= p; q++) out.sum[p * n + q] += (double)e[p] * (double)e[q];
    }
    return out;
}

// The same in parts that do not depend on the number of threads; returns how many samples count.
static int64_t covariance(const Samples *s, int n, const double *direction, double most, double *a) {
    enum { PARTS = 64 };
    Products *parts = ffp_take(PARTS, sizeof *parts);
    int64_t count = 0;
#pragma omp parallel for schedule(static)
    for (int k = 0; k < PARTS; k++)
        parts[k] = products_of(s, k * s->count / PARTS, (k + 1) * s->count / PARTS, n, direction, most);
    memset(a, 0, (size_t)(n * n) * sizeof *a);
    for (int k = 0; k < PARTS; k++) {
        count += parts[k].count;
        for (int i = 0; i < n * n; i++) a[i] += parts[k].sum[i];
    }
    for (int i = 0; count > 0 && i < n * n; i++) a[i] /= (double)count;
    ffp_free(parts);
    return count;
}

// Smallest eigenvalue of the covariance of all but the outliers along its own direction.
static double smallest_variance(const Samples *s, int n) {
    double direction[FFP_VALUES] = {0}, values[FFP_VALUES] = {INFINITY};
    for (int round = 0; round < ROUNDS; round++) {
        double a[FFP_VALUES * FFP_VALUES];
        if (covariance(s, n, direction, OUTLIER * OUTLIER * values[0], a) == 0) return 0;
        ffp_eigen(a, n, values);
        memcpy(direction, a, (size_t)n * sizeof *a);
    }
    return fmax(values[0], 0);
}

// Chooses the step, and returns how many samples there can be.
static size_t make_room(Samples *s, const FfpCapture *capture) {
    double pixels = 0;
    size_t room = 0;
    for (int v = 0; v < capture->n_views; v++)
        pixels += (double)capture->views[v].camera.width * capture->views[v].camera.height;
    s->step = (int)ceil(sqrt(fmax(pixels / MOST, 1)));
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        room += (size_t)(camera->width / s->step + 1) * (size_t)(camera->height / s->step + 1);
    }
    return room;
}

double ffp_noise_estimate(const FfpCapture *capture, const int photographs[FFP_PHOTOGRAPHS]) {
    Samples s = {0};
    const size_t room = make_room(&s, capture);
    s.edges = ffp_alloc(room, sizeof *s.edges);
    s.bright = ffp_alloc(room, sizeof *s.bright);
    for (int v = 0; v < capture->n_views; v++)
        if (ffp_has_photographs(&capture->views[v], photographs))
            sample_view(&s, &capture->views[v], photographs);
    const int n = keep(&s, choose_values(&s));
    const double noise = s.count < LEAST ? 0 : sqrt(smallest_variance(&s, n));
    ffp_free(s.edges);
    ffp_free(s.bright);
    return noise < NOISE_LEAST ? 0 : noise;
}
