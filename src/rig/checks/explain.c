// Structured light as a test of the calibration: along the right ray through the projector's picture there is
// a point of the colour that the camera saw; along a wrong one only by chance.
#include <math.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/capture/pixel.h"
#include "core/image/lookup.h"
#include "core/numerics/rank.h"
#include "engine/match/coded.h"
#include "rig/checks/chord.h"
#include "rig/checks/measure.h"

#define PIXELS_A_VIEW 300
#define PIXELS_A_GUESS 80
#define PIXELS_LEAST 16 // fewer are not asked
#define OUTLIERS 20     // one of so many, the worst, does not count in a guess: some lie beyond the sphere
#define DEPTHS 128
#define ERROR_MAX 0.25 // of a pixel's mean square: highlights and shadow edges must not decide
#define MIRRORS 4      // as it is, left to right, upside down, both
#define SHIFTS 6       // across the epipolar lines; along them the depth takes a shift up
#define FAR 4          // shifts by a third of the pattern and round its edges: what chance explains
#define ODD 0.93       // of a view's own error: a shift that leaves less explains it
#define SURE 1.5       // and of its deviations over the pixels, by which it must leave less
#define WORSE 2.5      // times the median error of the views
#define ODD_MOST 3     // one of so many views that are lit may be odd
#define CODE_OFF 4     // pattern pixels that a ray may pass its correspondence by
#define TELLS 0.06     // error of flawless photographs under a pattern that was moved: less tells nothing
enum { VARIANTS = MIRRORS + SHIFTS + FAR };

typedef struct Variant {
    double across; // pattern pixels
    int mirror;    // bit 0: left to right, bit 1: upside down
    int far;       // 1 .. FAR: which third; 0: none
} Variant;

typedef struct Sample { // a lit pixel
    real colour[3];
    FfpChord chord;
    int depths;    // on the chord: DEPTHS, 1 where a correspondence gives it, 0 where none agrees with that
    real usual[3]; // with correspondences: the mean colour of the view's samples
} Sample;

static void make_variants(int width, Variant variants[VARIANTS]) {
    static const double shares[SHIFTS] = {-0.05, -0.025, -0.01, 0.01, 0.025, 0.05};
    for (int i = 0; i < MIRRORS; i++) variants[i] = (Variant){.mirror = i};
    for (int i = 0; i < SHIFTS; i++) {
        const double step = fmax(1, round(fabs(shares[i]) * width));
        variants[MIRRORS + i] = (Variant){.across = shares[i] < 0 ? -step : step};
    }
    for (int i = 0; i < FAR; i++) variants[MIRRORS + SHIFTS + i] = (Variant){.far = i + 1};
}

// Reduces the chord of a pixel that has a correspondence to the depth that this gives.
static bool place_sample(const FfpView *view, size_t i, Sample *sample) {
    const real *pose = view->camera.pose, *d = sample->chord.direction;
    real off = 0;
    const real z = ffp_coded_depth(view, i, &off);
    if (!(view->correspondence.data[3 * i + 2] > 0)) return false;
    sample->depths = z > 0 && off <= CODE_OFF;
    sample->chord.near = sample->chord.far = z / (d[0] * pose[2] + d[1] * pose[6] + d[2] * pose[10]);
    return true;
}

// Of a pixel that is lit and, if `coded`, has a correspondence.
static bool make_sample(const FfpCapture *capture, const FfpView *view, const FfpImage *photograph,
                        bool coded, size_t i, Sample *sample) {
    if (view->coverage.data[i] < 1 || !ffp_lit_ratio(capture, view, photograph, i, sample->colour))
        return false;
    sample->depths = DEPTHS;
    return ffp_chord(capture, &view->camera, i, &sample->chord) && (!coded || place_sample(view, i, sample));
}

static size_t count_samples(const FfpCapture *capture, const FfpView *view, const FfpImage *photograph,
                            bool coded) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    Sample sample;
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++) count += make_sample(capture, view, photograph, coded, i, &sample);
    return count;
}

// Evenly strided lit pixels of a view, up to `most`; those with correspondences, if there are enough.
static int collect(const FfpCapture *capture, const FfpView *view, const FfpImage *photograph, int most,
                   Sample *samples) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    bool coded = view->correspondence.data;
    size_t lit = coded ? count_samples(capture, view, photograph, true) : 0, seen = 0;
    int count = 0;
    coded = lit >= PIXELS_LEAST;
    if (!coded) lit = count_samples(capture, view, photograph, false);
    const size_t step = lit / (size_t)most + 1;
    for (size_t i = 0; i < pixels && count < most; i++) {
        if (make_sample(capture, view, photograph, coded, i, &samples[count]) && seen++ % step == 0) count++;
    }
    return count;
}

// Explains the samples by a constant. With correspondences it stands for chance: stripes may look the same
// elsewhere.
static void set_usual(Sample *samples, int n) {
    double sum[3] = {0};
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 3; c++) sum[c] += (double)samples[i].colour[c];
    for (int i = 0; i < n; i++)
        for (int c = 0; c < 3; c++) samples[i].usual[c] = (real)(sum[c] / n);
}

static double squared_difference(const real a[3], const real b[3]) {
    double sum = 0;
    for (int c = 0; c < 3; c++) sum += pow((double)(a[c] - b[c]), 2) / 3;
    return sum;
}

// How many pattern pixels one camera pixel covers, side by side, at the object's centre.
static real footprint(const FfpCapture *capture, const FfpView *view) {
    real x, y;
    const real camera = ffp_project(&view->camera, capture->centre, &x, &y);
    const real projector = ffp_project(&view->projector, capture->centre, &x, &y);
    const real side = projector > 0 ? camera / view->camera.fx * view->projector.fx / projector : 1;
    return side > 1 ? side : 1;
}

// The direction on the pattern across the epipolar line of the camera's ray to the object's centre.
static void across_line(const FfpCapture *capture, const FfpView *view, double out[2]) {
    real near[3], far[3], a[2] = {0, 0}, b[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        const real step = 0.01F * (capture->centre[i] - view->camera.pose[4 * i + 3]);
        near[i] = capture->centre[i] - step, far[i] = capture->centre[i] + step;
    }
    ffp_project(&view->projector, near, &a[0], &a[1]);
    ffp_project(&view->projector, far, &b[0], &b[1]);
    out[0] = (double)(a[1] - b[1]), out[1] = (double)(b[0] - a[0]);
    const double length = hypot(out[0], out[1]), sign = out[0] < 0 || (out[0] == 0 && out[1] < 0) ? -1 : 1;
    for (int i = 0; i < 2 && length > 0; i++) out[i] *= sign / length;
}

static real wrapped(real x, int size) {
    const real n = (real)size;
    return x - n * (real)floor((double)(x / n));
}

// Where the variant looks instead of at (u, v).
static void vary(const Variant *variant, const FfpSummed *pattern, const double across[2], real *u, real *v) {
    static const int thirds[FAR][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    if (variant->mirror & 1) *u = (real)pattern->width - *u;
    if (variant->mirror & 2) *v = (real)pattern->height - *v;
    *u -= (real)(variant->across * across[0]), *v -= (real)(variant->across * across[1]);
    if (variant->far == 0) return;
    const int *third = thirds[variant->far - 1];
    *u = wrapped(*u + (real)(third[0] * pattern->width) / 3, pattern->width);
    *v = wrapped(*v + (real)(third[1] * pattern->height) / 3, pattern->height);
}

// Mean square of a pixel's best depth, for each of n variants.
static void judge(const FfpView *view, const FfpSummed *pattern, const Sample *sample,
                  const Variant *variants, int n, const double across[2], real side, double *best) {
    for (int k = 0; k < n; k++) {
        const bool constant = variants[k].far > 0 && sample->depths < DEPTHS;
        best[k] = constant ? fmin(ERROR_MAX, squared_difference(sample->usual, sample->colour)) : ERROR_MAX;
    }
    for (int d = 0; d < sample->depths; d++) {
        real point[3], u, v;
        ffp_chord_point(&sample->chord, d, sample->depths, point);
        if (!(ffp_project(&view->projector, point, &u, &v) > 0)) continue;
        for (int k = 0; k < n; k++) {
            real colour[3], x = u, y = v;
            if (variants[k].far > 0 && sample->depths < DEPTHS) continue;
            vary(&variants[k], pattern, across, &x, &y);
            ffp_lookup(pattern, x, y, side, side, colour);
            best[k] = fmin(best[k], squared_difference(colour, sample->colour));
        }
    }
}

// A view's squared errors.
typedef struct Sums {
    int pixels;
    double errors[VARIANTS]; // sums for each variant,
    double mended[VARIANTS]; // and of the squares of what it takes from a pixel's
} Sums;

static Sums look_at_view(const FfpCapture *capture, const FfpView *view, const FfpSummed *summed, int pattern,
                         const Variant *variants) {
    Sample *samples = ffp_alloc(PIXELS_A_VIEW, sizeof *samples);
    double(*best)[VARIANTS] = ffp_alloc(PIXELS_A_VIEW, sizeof *best);
    const int n = collect(capture, view, &view->images[pattern], PIXELS_A_VIEW, samples);
    const real side = footprint(capture, view);
    double across[2];
    across_line(capture, view, across);
    set_usual(samples, n);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < n; i++) judge(view, summed, &samples[i], variants, VARIANTS, across, side, best[i]);
    Sums out = {.pixels = n};
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < VARIANTS; k++) {
            out.errors[k] += best[i][k];
            out.mended[k] += pow(best[i][0] - best[i][k], 2);
        }
    }
    ffp_free(samples);
    ffp_free(best);
    ffp_cancel_point();
    return out;
}

// The shift across that explains a view best, 0: none does clearly better, and what it leaves of the error. A
// few pixels may fit a shift by chance: those of sound views mend up to one deviation, those of a camera that
// was bumped by a pixel 1.7 or more.
static double shift_of(const Variant *variants, const Sums *own, double *left) {
    const double *errors = own->errors;
    int best = 0;
    for (int k = MIRRORS; k < MIRRORS + SHIFTS; k++) best = errors[k] < errors[best] ? k : best;
    const double mended = errors[0] - errors[best],
                 deviation = sqrt(fmax(0, own->mended[best] - mended * mended / own->pixels));
    *left = errors[0] > 0 ? sqrt(errors[best] / errors[0]) : 1;
    return *left < ODD && mended > SURE * deviation ? variants[best].across : 0;
}

// The median error of the views that were asked, which have one.
static double usual_error(const double *errors, int n) {
    double *sorted = ffp_alloc((size_t)n, sizeof *sorted);
    int asked = 0;
    for (int v = 0; v < n; v++)
        if (errors[v] > 0) sorted[asked++] = errors[v];
    const double usual = ffp_median(sorted, (size_t)asked);
    ffp_free(sorted);
    return usual;
}

// The view that is explained worse than most, when it is far worse.
static int worst_view(const double *errors, int n, double usual) {
    int worst = 0;
    for (int v = 0; v < n; v++) worst = errors[v] > errors[worst] ? v : worst;
    return errors[worst] > WORSE * usual ? worst : -1;
}

// The views one by one: their sum, and the one that a shift mends most, if few need one; otherwise the one
// that nothing mends.
static void look_at_views(FfpExplanation *out, const FfpCapture *capture, int pattern,
                          const FfpSummed *summed, const Variant *variants, double sums[VARIANTS]) {
    double least = 1, left;
    int odd = 0, judged = 0;
    double *errors = ffp_alloc((size_t)capture->n_views, sizeof *errors);
    for (int v = 0; v < capture->n_views; v++) {
        if (!capture->views[v].images[pattern].data) continue;
        const Sums own = look_at_view(capture, &capture->views[v], summed, pattern, variants);
        const int n = own.pixels;
        for (int k = 0; k < VARIANTS; k++) sums[k] += own.errors[k];
        out->pixels += n;
        errors[v] = n >= PIXELS_LEAST ? sqrt(own.errors[0] / n) : 0;
        const double across = n >= PIXELS_LEAST ? shift_of(variants, &own, &left) : 0;
        judged += n >= PIXELS_LEAST;
        odd += across != 0;
        if (across == 0 || left >= least) continue;
        least = left, out->odd = v, out->odd_across = across;
    }
    if (odd * ODD_MOST > judged) { // also where the others are too dark to be asked
        out->odd = -1;
        out->odd_across = 0;
    }
    const double usual = usual_error(errors, capture->n_views);
    if (out->odd >= 0 && !(errors[out->odd] > usual)) { // it fits as well as the others do
        out->odd = -1;
        out->odd_across = 0;
    }
    if (odd == 0) out->odd = worst_view(errors, capture->n_views, usual);
    ffp_free(errors);
}

FfpExplanation ffp_rig_explain(const FfpCapture *capture, int pattern) {
    Variant variants[VARIANTS];
    double sums[VARIANTS] = {0};
    FfpExplanation out = {.odd = -1};
    FfpSummed summed = ffp_summed_new(&capture->patterns[pattern].image);
    make_variants(summed.width, variants);
    look_at_views(&out, capture, pattern, &summed, variants, sums);
    ffp_summed_free(&summed);
    if (out.pixels == 0) return out;
    double errors[VARIANTS];
    for (int k = 0; k < VARIANTS; k++) errors[k] = sqrt(sums[k] / out.pixels);
    out.error = out.best = errors[0];
    out.mirrored = fmin(errors[1], fmin(errors[2], errors[3]));
    for (int k = MIRRORS; k < MIRRORS + SHIFTS; k++) {
        if (errors[k] < out.best) out.best = errors[k], out.across = variants[k].across;
    }
    out.chance = errors[MIRRORS + SHIFTS];
    for (int k = 1; k < FAR; k++) out.chance = fmin(out.chance, errors[MIRRORS + SHIFTS + k]);
    across_line(capture, &capture->views[0], out.direction);
    return out;
}

static void reverse_channels(Sample *sample) {
    const real red = sample->colour[0];
    sample->colour[0] = sample->colour[2];
    sample->colour[2] = red;
}

// A flawless photograph's colour of a surface in the middle of the chord.
static void idealise(const FfpView *view, const FfpSummed *pattern, real side, Sample *sample) {
    real point[3], u, v;
    ffp_chord_point(&sample->chord, 0, 1, point);
    if (ffp_project(&view->projector, point, &u, &v) > 0)
        ffp_lookup(pattern, u, v, side, side, sample->colour);
}

double ffp_rig_guess(const FfpCapture *capture, const FfpView *view, const FfpGuess *guess) {
    static const double across[2] = {0, 0};
    const Variant variant = {.mirror = guess->mirror, .far = guess->third};
    const real side = footprint(capture, view);
    Sample *samples = ffp_alloc(PIXELS_A_GUESS, sizeof *samples);
    const int n = collect(capture, view, guess->photograph, PIXELS_A_GUESS, samples);
    double *best = ffp_take(PIXELS_A_GUESS, sizeof *best), sum = 0;
    const int kept = n - n / OUTLIERS;
    for (int i = 0; i < n; i++) {
        if (guess->reversed) reverse_channels(&samples[i]);
        if (guess->ideal) idealise(view, guess->pattern, side, &samples[i]);
    }
    set_usual(samples, n);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < n; i++) judge(view, guess->pattern, &samples[i], &variant, 1, across, side, &best[i]);
    if (n > 0) ffp_rank(best, (size_t)n, (size_t)kept - 1);
    for (int i = 0; i < kept; i++) sum += best[i];
    ffp_free(best);
    ffp_free(samples);
    ffp_cancel_point();
    return n >= PIXELS_LEAST ? sqrt(sum / kept) : NAN;
}

double ffp_error_of(const FfpCapture *capture, int active, int view, FfpGuess guess) {
    const int end = view < 0 ? capture->n_views : view + 1;
    double sum = 0;
    int n = 0;
    for (int v = view < 0 ? 0 : view; v < end; v++) {
        FfpGuess own = guess;
        if (!own.photograph) own.photograph = &capture->views[v].images[active];
        const double error = own.photograph->data ? ffp_rig_guess(capture, &capture->views[v], &own) : NAN;
        if (isnan(error)) continue;
        sum += error * error;
        n++;
    }
    return n > 0 ? sqrt(sum / n) : NAN;
}

// The least of the thirds by which the pattern may be moved.
static double least_error(const FfpCapture *capture, int active, int view, FfpGuess guess) {
    double least = INFINITY;
    for (guess.third = 1; guess.third <= FAR; guess.third++)
        least = fmin(least, ffp_error_of(capture, active, view, guess));
    return least;
}

double ffp_chance_of(const FfpCapture *capture, int active, const FfpSummed *pattern, int view) {
    return least_error(capture, active, view, (FfpGuess){.pattern = pattern});
}

bool ffp_rig_tells(const FfpCapture *capture, int pattern) {
    FfpSummed summed = ffp_summed_new(&capture->patterns[pattern].image);
    const double least = least_error(capture, pattern, -1, (FfpGuess){.pattern = &summed, .ideal = true});
    ffp_summed_free(&summed);
    return least >= TELLS;
}
