#include "rig/response/blur.h"
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/image/lookup.h"
#include "rig/response/seen.h"

#define BLUR_MAX 8        // pixels of the projector, but for
#define BLUR_STEPS 12     // of the golden section: to 0.03 pixels
#define LIT_MIN 0.02      // of white's light above black's, linear
#define OUTLIER 0.25      // squared errors count as no more than this one's square
#define EDGE_MIN 0.02     // change of the pattern's mean over one pixel of the camera: where blur shows
#define GAIN_MIN 0.98     // of the error without blur: a smaller gain proves nothing
#define SAMPLES_MAX 20000 // of a pattern
#define SAMPLES_MIN 500   // pixels at edges

typedef struct Sample { // a camera's pixel
    FfpSeenBox box;
    real share; // (C - B) / (W - B)
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

static real mean_in(const FfpSummed *pattern, const FfpSeenBox *box, real widened) {
    real value[3];
    ffp_lookup(pattern, box->u, box->v, widened * box->du, widened * box->dv, value);
    return (value[0] + value[1] + value[2]) / 3;
}

// True if the pattern changes within a few of the camera's pixels around.
static bool at_edge(const FfpSummed *pattern, const FfpSeenBox *box) {
    return fabs(mean_in(pattern, box, 5) - mean_in(pattern, box, 1)) > (real)EDGE_MIN;
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
            if (!(lit > (real)(3 * LIT_MIN)) || !ffp_seen_box(map, x, y, &s.box) ||
                !at_edge(&seen->pattern, &s.box))
                continue;
            s.share = (sum3(c, pixel) - black) / lit;
            seen->samples[seen->n++] = s;
        }
}

typedef struct Looking {
    const FfpCapture *capture;
    const int *patterns;
    Seen *seen; // of each
} Looking;

static void look_at(void *argument, int64_t i) {
    const Looking *l = argument;
    const FfpCapture *capture = l->capture;
    Seen *seen = &l->seen[i];
    size_t pixels = 0;
    for (int v = 0; v < capture->n_views; v++)
        pixels += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    seen->pattern = ffp_summed_new(&capture->patterns[l->patterns[i]].image);
    seen->samples = ffp_take(pixels, sizeof *seen->samples);
    for (int v = 0; v < capture->n_views; v++) add_view(capture, &capture->views[v], l->patterns[i], seen);
}

// Sum of squared differences under this blur.
static double error_of(const Seen *seen, double blur) {
    const int64_t step = seen->n / SAMPLES_MAX + 1;
    double sum = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum)
    for (int64_t i = 0; i < seen->n; i += step) {
        const Sample *s = &seen->samples[i];
        real value[3];
        ffp_seen_through(&seen->pattern, &s->box, (real)blur, value);
        const double off = (double)(s->share - (value[0] + value[1] + value[2]) / 3);
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
    ffp_parallel_for(n, 0, look_at, &(Looking){capture, patterns, seen});
    for (int i = 0; i < n; i++) samples += seen[i].n;
    double blur = samples < SAMPLES_MIN ? 0 : least(seen, n);
    if (blur > 0 && !(error_of_all(seen, n, blur) < GAIN_MIN * error_of_all(seen, n, 0))) blur = 0;
    for (int i = 0; i < n; i++) {
        ffp_summed_free(&seen[i].pattern);
        ffp_free(seen[i].samples);
    }
    ffp_free(seen);
    return blur;
}

double ffp_fit_blur(const FfpCapture *capture) {
    int patterns[FFP_PATTERNS_MAX];
    const int n = ffp_seen_patterns(capture, patterns);
    return n > 0 ? blur_of(capture, patterns, n) : 0;
}
