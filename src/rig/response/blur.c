#include "rig/response/blur.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/capture/project.h"
#include "core/image/lookup.h"
#include "engine/match/match.h"

#define BLUR_MAX 8        // pixels of the projector, but for
#define BLUR_STEPS 12     // of the golden section: to 0.03 pixels
#define LIT_MIN 0.02      // of white's light above black's, linear
#define OUTLIER 0.25      // squared errors count as no more than this one's square
#define EDGE_MIN 0.02     // change of the pattern's mean over one pixel of the camera: where blur shows
#define GAIN_MIN 0.98     // of the error without blur: a smaller gain proves nothing
#define TRUSTED 0.5       // matching's confidence, where there are no codes
#define SAMPLES_MAX 20000 // of a pattern
#define SAMPLES_MIN 500   // pixels at edges

typedef struct Sample { // a camera's pixel
    real u, v, du, dv;  // its box in the projector
    real share;         // (C - B) / (W - B)
} Sample;

typedef struct Seen { // of one pattern
    FfpSummed pattern;
    Sample *samples;
    int64_t n;
} Seen;

static real sum3(const FfpImage *image, size_t pixel) {
    const real *p = image->data + 3 * pixel;
    return p[0] + p[1] + p[2];
}

// The box that pixel (x, y) covers, from its neighbours' positions; false: not all are known.
static bool box_at(const FfpImage *map, int x, int y, Sample *s) {
    const real *here = map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x);
    if (x < 1 || y < 1 || x + 1 >= map->width || y + 1 >= map->height || !(here[2] > 0)) return false;
    const real *left = here - 3, *right = here + 3, *above = here - 3 * (size_t)map->width,
               *below = here + 3 * (size_t)map->width;
    if (!(left[2] > 0 && right[2] > 0 && above[2] > 0 && below[2] > 0)) return false;
    s->u = here[0], s->v = here[1];
    s->du = fmax(hypot(right[0] - left[0], below[0] - above[0]) / 2, (real)1);
    s->dv = fmax(hypot(right[1] - left[1], below[1] - above[1]) / 2, (real)1);
    return true;
}

static real mean_in(const FfpSummed *pattern, const Sample *s, real du, real dv) {
    real value[3];
    ffp_lookup(pattern, s->u, s->v, du, dv, value);
    return (value[0] + value[1] + value[2]) / 3;
}

// True if the pattern changes within a few of the camera's pixels around.
static bool at_edge(const FfpSummed *pattern, const Sample *s) {
    return fabs(mean_in(pattern, s, 5 * s->du, 5 * s->dv) - mean_in(pattern, s, s->du, s->dv)) >
           (real)EDGE_MIN;
}

static void add_view(const FfpCapture *capture, const FfpView *view, int p, Seen *seen) {
    const FfpImage *c = &view->images[p], *b = &view->images[capture->black],
                   *w = &view->images[capture->white], *map = &view->correspondence;
    if (!map->data || !c->data) return;
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            Sample s;
            const size_t pixel = (size_t)y * (size_t)map->width + (size_t)x;
            const real black = sum3(b, pixel), lit = sum3(w, pixel) - black;
            if (!(lit > (real)(3 * LIT_MIN)) || !box_at(map, x, y, &s) || !at_edge(&seen->pattern, &s))
                continue;
            s.share = (sum3(c, pixel) - black) / lit;
            seen->samples[seen->n++] = s;
        }
}

static Seen look_at(const FfpCapture *capture, int p) {
    Seen seen = {.pattern = ffp_summed_new(&capture->patterns[p].image)};
    size_t pixels = 0;
    for (int v = 0; v < capture->n_views; v++)
        pixels += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    seen.samples = ffp_alloc(pixels, sizeof *seen.samples);
    for (int v = 0; v < capture->n_views; v++) add_view(capture, &capture->views[v], p, &seen);
    return seen;
}

// The pattern through the Gaussian and the pixel's box: three places a side have half of the Gaussian's
// variance (the nodes and weights of Gauss and Hermite), wider boxes the other half.
static real seen_through(const FfpSummed *pattern, const Sample *s, double blur) {
    static const real weights[3] = {1.0F / 6, 2.0F / 3, 1.0F / 6};
    const real apart = (real)(sqrt(1.5) * blur), more = (real)(6 * blur * blur),
               du = sqrt(s->du * s->du + more), dv = sqrt(s->dv * s->dv + more);
    real mean = 0;
    for (int k = 0; k < 9; k++) {
        Sample moved = *s;
        moved.u += (real)(k % 3 - 1) * apart, moved.v += (real)(k / 3 - 1) * apart;
        mean += weights[k % 3] * weights[k / 3] * mean_in(pattern, &moved, du, dv);
    }
    return mean;
}

// Sum of squared differences under this blur.
static double error_of(const Seen *seen, double blur) {
    const int64_t step = seen->n / SAMPLES_MAX + 1;
    double sum = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum)
    for (int64_t i = 0; i < seen->n; i += step) {
        const Sample *s = &seen->samples[i];
        const double off = (double)(s->share - seen_through(&seen->pattern, s, blur));
        sum += fmin(off * off, OUTLIER * OUTLIER);
    }
    return sum;
}

static double error_of_all(const Seen *seen, int n, double blur) {
    double sum = 0;
    for (int i = 0; i < n; i++) sum += error_of(&seen[i], blur);
    return sum;
}

// Golden section: the error falls to its least and rises again.
static double least(const Seen *seen, int n) {
    const double golden = (sqrt(5.0) - 1) / 2;
    double low = 0, high = BLUR_MAX, a = high - golden * (high - low), b = low + golden * (high - low),
           at_a = error_of_all(seen, n, a), at_b = error_of_all(seen, n, b);
    for (int i = 0; i < BLUR_STEPS; i++) {
        if (at_a < at_b) {
            high = b, b = a, at_b = at_a;
            at_a = error_of_all(seen, n, a = high - golden * (high - low));
        } else {
            low = a, a = b, at_a = at_b;
            at_b = error_of_all(seen, n, b = low + golden * (high - low));
        }
    }
    return (low + high) / 2;
}

static double blur_of(const FfpCapture *capture, const int *patterns, int n) {
    Seen *seen = ffp_alloc((size_t)n, sizeof *seen);
    int64_t samples = 0;
    for (int i = 0; i < n; i++) {
        seen[i] = look_at(capture, patterns[i]);
        samples += seen[i].n;
    }
    double blur = samples < SAMPLES_MIN ? 0 : least(seen, n);
    if (blur > 0 && !(error_of_all(seen, n, blur) < GAIN_MIN * error_of_all(seen, n, 0))) blur = 0;
    for (int i = 0; i < n; i++) {
        ffp_summed_free(&seen[i].pattern);
        ffp_free(seen[i].samples);
    }
    ffp_free(seen);
    return blur;
}

// Positions of all views' trusted pixels as matching finds them, for captures without Gray codes.
static void take_positions(FfpCapture *capture, const FfpInitialisation *start) {
    const size_t pixels = (size_t)start->width * (size_t)start->height;
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        view->correspondence = ffp_image_new(start->width, start->height, 3);
        for (size_t i = 0; i < pixels; i++) {
            const size_t k = (size_t)v * pixels + i;
            real ray[3], point[3], *at = view->correspondence.data + 3 * i;
            if (!(start->confidence[k] > (real)TRUSTED)) continue;
            ffp_pixel_ray(&view->camera, (real)(i % (size_t)start->width) + 0.5F,
                          (real)(i / (size_t)start->width) + 0.5F, ray);
            for (int c = 0; c < 3; c++) point[c] = view->camera.pose[4 * c + 3] + start->t[k] * ray[c];
            if (ffp_project(&view->projector, point, &at[0], &at[1]) > 0) at[2] = 1;
        }
    }
}

// The views of `matched` are the caller's. False: matching is not possible.
static bool match(FfpCapture *matched, const int *patterns, int n) {
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpInitialisation start;
    const size_t views = (size_t)matched->n_views;
    FfpView *own = ffp_alloc(views, sizeof *own);
    memcpy(own, matched->views, views * sizeof *own);
    matched->views = own;
    const real centre[3] = {matched->centre[0], matched->centre[1], matched->centre[2]};
    ffp_capture_normalise(matched, centre, matched->radius);
    if (!ffp_initialisation_new(&start, matched, patterns, n, &settings, NULL)) return false;
    take_positions(matched, &start);
    ffp_initialisation_free(&start);
    return true;
}

static bool is_coded(const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++)
        if (capture->views[v].correspondence.data) return true;
    return false;
}

double ffp_fit_blur(const FfpCapture *capture) {
    FfpCapture matched = *capture;
    int patterns[FFP_PATTERNS_MAX], n = 0;
    for (int p = 0; p < capture->n_patterns; p++)
        if (p != capture->black && p != capture->white &&
            (p >= ffp_patterns_shown(capture) || !capture->patterns[p].novel))
            patterns[n++] = p;
    if (n == 0) return 0;
    if (is_coded(capture)) return blur_of(capture, patterns, n);
    double blur = 0;
    if (match(&matched, patterns, n)) {
        blur = blur_of(&matched, patterns, n);
        for (int v = 0; v < matched.n_views; v++) ffp_image_free(&matched.views[v].correspondence);
    }
    ffp_free(matched.views);
    return blur;
}
