#include "rig/response/spread.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/real.h"
#include "rig/response/seen.h"

#define LIT_MIN 0.01      // of white's light above black's, linear
#define INSIDE 0.99       // of white: a place on the panel, away from its edges
#define OUTLIER 0.25      // encoded difference beyond which a pixel's place is wrong rather than its light
#define SHARE_MAX 0.25    // searched
#define REACH_LEAST 4     // pixels; nearer is blur
#define REACH_SHARE 0.026 // of the panel's width, the farthest that is tried: beyond, light is scattered
#define GAIN_MIN 0.98     // of the error without spread: a smaller gain proves nothing
#define FAINT 0.002       // light below which the eye's curve is taken as straight
#define SAMPLES_MAX 60000 // of all patterns
#define SAMPLES_MIN 500   // of all

typedef struct Sample { // a camera's pixel under one pattern
    FfpSeenBox box;
    real black[3], added[3], seen[3]; // photographs' light: black's, white's above it, the pattern's
    real here[3], around[3], inside;  // the pattern and white: at the pixel, and within the reach
} Sample;

typedef struct Samples {
    const FfpCapture *capture;
    int64_t most; // of a pattern
    int n_patterns, patterns[FFP_PATTERNS_MAX];
    int64_t n, first[FFP_PATTERNS_MAX + 1]; // of each pattern
    Sample *of;
    int n_reaches;
    real (*around)[3]; // [n_reaches, n] as Sample.around
} Samples;

static bool take_sample(const FfpView *view, const FfpCapture *capture, int pattern, int x, int y,
                        const FfpSummed summed[2], Sample *s) {
    const size_t at = 3 * ((size_t)y * (size_t)view->camera.width + (size_t)x);
    real white[3], most = 0;
    if (!ffp_seen_box(&view->correspondence, x, y, &s->box)) return false;
    for (int c = 0; c < 3; c++) {
        s->black[c] = view->images[capture->black].data[at + (size_t)c];
        s->added[c] = view->images[capture->white].data[at + (size_t)c] - s->black[c];
        s->seen[c] = view->images[pattern].data[at + (size_t)c];
        most = fmax(most, s->added[c]);
    }
    if (!(most > (real)LIT_MIN)) return false;
    ffp_lookup(&summed[1], s->box.u, s->box.v, s->box.du, s->box.dv, white);
    ffp_lookup(&summed[0], s->box.u, s->box.v, s->box.du, s->box.dv, s->here);
    return white[1] > (real)INSIDE;
}

// Evenly strided pixels of the views that have both codes and the pattern.
static void take_pattern(Samples *samples, int pattern, const FfpSummed summed[2]) {
    const FfpCapture *capture = samples->capture;
    int64_t pixels = 0, nth = 0;
    for (int v = 0; v < capture->n_views; v++)
        pixels += (int64_t)capture->views[v].camera.width * capture->views[v].camera.height;
    const int64_t step = pixels / (4 * samples->most) + 1; // objects fill a part of the picture
    int64_t taken = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!view->correspondence.data || !view->images[pattern].data) continue;
        const int64_t all = (int64_t)view->camera.width * view->camera.height;
        for (int64_t i = 0; i < all && taken < samples->most; i++) {
            if (nth++ % step) continue;
            const int x = (int)(i % view->camera.width), y = (int)(i / view->camera.width);
            taken += take_sample(view, capture, pattern, x, y, summed, &samples->of[samples->n + taken]);
        }
    }
    samples->n += taken;
}

static Samples collect(const FfpCapture *capture) {
    Samples samples = {.capture = capture};
    samples.n_patterns = ffp_seen_patterns(capture, samples.patterns);
    samples.most = SAMPLES_MAX / (samples.n_patterns > 0 ? samples.n_patterns : 1);
    samples.of = ffp_alloc(SAMPLES_MAX + 1, sizeof *samples.of);
    FfpSummed summed[2];
    summed[1] = ffp_summed_new(&capture->patterns[capture->white].image);
    for (int i = 0; i < samples.n_patterns; i++) {
        summed[0] = ffp_summed_new(&capture->patterns[samples.patterns[i]].image);
        take_pattern(&samples, samples.patterns[i], summed);
        samples.first[i + 1] = samples.n;
        ffp_summed_free(&summed[0]);
    }
    ffp_summed_free(&summed[1]);
    return samples;
}

static real reach_of(int i) {
    return REACH_LEAST * (real)exp2(0.5 * i);
}

// The patterns' means within each reach, over what of them lies on the panel.
static void look_around(Samples *samples) {
    const FfpCapture *capture = samples->capture;
    FfpSummed white = ffp_summed_new(&capture->patterns[capture->white].image);
    for (int p = 0; p < samples->n_patterns; p++) {
        FfpSummed pattern = ffp_summed_new(&capture->patterns[samples->patterns[p]].image);
        const int64_t first = samples->first[p], count = samples->first[p + 1] - first;
#pragma omp parallel for schedule(static)
        for (int64_t k = 0; k < samples->n_reaches * count; k++) {
            const int64_t reach = k / count, i = first + k % count;
            const FfpSeenBox *box = &samples->of[i].box;
            real on_panel[3], *around = samples->around[reach * samples->n + i];
            ffp_seen_through(&pattern, box, reach_of((int)reach), around);
            ffp_seen_through(&white, box, reach_of((int)reach), on_panel);
            for (int c = 0; c < 3; c++) around[c] /= fmax(on_panel[1], (real)0.01);
        }
        ffp_summed_free(&pattern);
    }
    ffp_summed_free(&white);
}

static void take_reach(Samples *samples, int reach) {
    for (int64_t i = 0; i < samples->n; i++)
        memcpy(samples->of[i].around, samples->around[reach * samples->n + i], sizeof *samples->around);
}

static real predicted(const Sample *s, int c, real share) {
    return s->black[c] + s->added[c] * (s->here[c] + share * (s->around[c] - s->here[c]));
}

static bool is_placed(const Sample *s, int c) {
    return fabs(ffp_srgb_encode(predicted(s, c, 0)) - ffp_srgb_encode(s->seen[c])) < (real)OUTLIER;
}

// True if pattern i is of the half (0 or 1); half 2: all are.
static bool is_in(int i, int half) {
    return half == 2 || i % 2 == half;
}

// Least squares over a half of the patterns, differences weighted by the slope of the eye's curve there.
static void fit_shares(const Samples *samples, int half, real share[3]) {
    for (int c = 0; c < 3; c++) {
        double along = 0, square = 0;
        for (int p = 0; p < samples->n_patterns; p++) {
            if (!is_in(p, half)) continue;
            for (int64_t i = samples->first[p]; i < samples->first[p + 1]; i++) {
                const Sample *s = &samples->of[i];
                if (!is_placed(s, c)) continue;
                const real plain = predicted(s, c, 0),
                           slope = pow(fmax(fmax(plain, s->seen[c]), (real)FAINT), (real)(1 / 2.4 - 1));
                const double x = (double)(slope * (predicted(s, c, 1) - plain)),
                             off = (double)(slope * (s->seen[c] - plain));
                along += x * off, square += x * x;
            }
        }
        share[c] = square > 0 ? (real)fmin(fmax(along / square, 0), SHARE_MAX) : 0;
    }
}

// Sum of squared encoded differences over a half of the patterns; *count: of how many.
static double error_of(const Samples *samples, int half, const real share[3], double *count) {
    double sum = 0;
    for (int p = 0; p < samples->n_patterns; p++) {
        if (!is_in(p, half)) continue;
        for (int64_t i = samples->first[p]; i < samples->first[p + 1]; i++)
            for (int c = 0; c < 3; c++) {
                const Sample *s = &samples->of[i];
                if (!is_placed(s, c)) continue;
                const double off =
                    (double)(ffp_srgb_encode(predicted(s, c, share[c])) - ffp_srgb_encode(s->seen[c]));
                sum += off * off, *count += 1;
            }
    }
    return sum;
}

// The reach at which all patterns are explained best; samples hold its means.
static real find_reach(Samples *samples) {
    const int width = samples->capture->views[0].projector.width;
    double least = INFINITY;
    int best = 0;
    samples->n_reaches = (int)floor(2 * log2(fmax(REACH_SHARE * width / REACH_LEAST, 0.5)) + 1e-9) + 1;
    if (samples->n_reaches < 1) return 0; // of a panel that is narrower than the least reach has room for
    samples->around = ffp_take((size_t)samples->n_reaches * (size_t)samples->n, sizeof *samples->around);
    look_around(samples);
    for (int i = 0; i < samples->n_reaches; i++) {
        real share[3];
        double count = 0;
        take_reach(samples, i);
        fit_shares(samples, 2, share);
        const double error = error_of(samples, 2, share, &count);
        if (error < least) least = error, best = i;
    }
    take_reach(samples, best);
    ffp_free(samples->around);
    return reach_of(best);
}

// Each half of the patterns judged by the other's shares; true where both gain.
static bool judge(const Samples *samples, FfpSpread *spread) {
    const real none[3] = {0};
    double before = 0, after = 0, count = 0, skip = 0;
    bool gains = true;
    for (int half = 0; half < 2; half++) {
        real share[3];
        fit_shares(samples, 1 - half, share);
        const double without = error_of(samples, half, none, &count),
                     with = error_of(samples, half, share, &skip);
        gains = gains && with < GAIN_MIN * without;
        before += without, after += with;
    }
    spread->before = -10 * log10(before / count), spread->after = -10 * log10(after / count);
    return gains;
}

FfpSpread ffp_fit_spread(const FfpCapture *capture) {
    Samples samples = collect(capture);
    FfpSpread spread = {.reach = 0};
    if (samples.n_patterns >= 2 && samples.n >= SAMPLES_MIN) {
        spread.reach = find_reach(&samples);
        if (spread.reach > 0 && !judge(&samples, &spread)) spread.reach = 0;
        if (spread.reach > 0) fit_shares(&samples, 2, spread.share);
    }
    ffp_free(samples.of);
    return spread;
}
