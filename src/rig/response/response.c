#include "rig/response/response.h"
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/real.h"
#include "core/base/vec.h"
#include "core/capture/pixel.h"
#include "core/capture/reduce.h"
#include "core/capture/small.h"
#include "core/image/lookup.h"
#include "core/numerics/rank.h"
#include "engine/match/match.h"

#define PLACE "fit_response"
#define ROUNDS 3 // of matching and fitting
#define SAMPLES_MAX 20000
#define SAMPLES_LEAST 500
#define TRUSTED 0.3F  // confidence of a matched depth
#define GAMMA_LOW 0.4 // searched
#define GAMMA_HIGH 5.0
#define GAMMA_STEPS 18    // of the golden section
#define SCALE_LEAST 0.01  // differences below this are noise
#define CORRELATED 25     // neighbouring pixels err alike: so many say as much as one
#define DEVIATION_MAX 0.1 // of gamma: more, and the pattern does not tell
#define SLOPE_LEAST 0.01  // root mean square of the light's change with gamma, likewise
#define DARK 0.15         // spread of black / white, as a share of it, in a room without light
#define BRIGHT_ALBEDO 0.8 // as the reader of captures has it
#define FACING 0.3        // cosine below which a pixel tells no intensity

typedef struct Sample { // a lit pixel
    real at[2], side;   // place on the pattern, and pixels side by side that it covers
    real ratio[3];      // (active - black) / (white - black)
    real share[3];      // black / white
    real strength;      // pi d^2 (white - black) / cosine, in the capture's unit; 0: seen too flat
} Sample;

typedef struct Fitting {
    const FfpImage *pattern; // as imported
    bool linear;
    int count;
    Sample *samples; // [SAMPLES_MAX]
    real *light;     // [count, 3] looked up
    double scale[3]; // of the differences
} Fitting;

void ffp_response_apply(const FfpResponse *response, bool linear, FfpImage *pattern) {
    const ptrdiff_t values = (ptrdiff_t)pattern->width * pattern->height * 3;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t i = 0; i < values; i++) {
        const real value = linear ? pattern->data[i] : ffp_srgb_encode(pattern->data[i]);
        pattern->data[i] = pow(fmin(fmax(value, (real)0), (real)1), (real)response->gamma[i % 3]);
    }
}

// --- Samples. ---

static bool make_sample(const FfpCapture *capture, const FfpInitialisation *start, int v, size_t i,
                        int active, Sample *out) {
    const FfpView *view = &capture->views[v];
    const size_t k = (size_t)v * (size_t)start->width * (size_t)start->height + i;
    const real *black = view->images[capture->black].data + 3 * i,
               *white = view->images[capture->white].data + 3 * i;
    if (view->coverage.data[i] < 0.99F || start->confidence[k] < TRUSTED ||
        !ffp_lit_ratio(capture, view, &view->images[active], i, out->ratio))
        return false;
    real strongest = 0;
    for (int c = 0; c < 3; c++) {
        out->share[c] = black[c] / white[c];
        strongest = fmax(strongest, white[c] - black[c]);
    }
    real ray[3], point[3], to[3];
    ffp_pixel_ray(&view->camera, (real)(i % (size_t)start->width) + 0.5F,
                  (real)(i / (size_t)start->width) + 0.5F, ray);
    for (int c = 0; c < 3; c++) {
        point[c] = view->camera.pose[4 * c + 3] + start->t[k] * ray[c];
        to[c] = view->projector.pose[4 * c + 3] - point[c];
    }
    const real z = ffp_project(&view->projector, point, &out->at[0], &out->at[1]);
    const real distance = ffp_normalise3(to), cosine = ffp_dot3(to, start->normal + 3 * k);
    out->side = fmax(start->footprint[k] * view->projector.fx / fmax(z, (real)1e-6), (real)1);
    out->strength = cosine > FACING ? (real)FFP_PI_DOUBLE * distance * distance * strongest / cosine : 0;
    return z > 0 && out->at[0] >= 0 && out->at[1] >= 0 && out->at[0] <= (real)view->projector.width &&
           out->at[1] <= (real)view->projector.height;
}

// Evenly strided trusted pixels of all views.
static void collect(Fitting *fitting, const FfpCapture *capture, const FfpInitialisation *start, int active) {
    const size_t pixels = (size_t)start->width * (size_t)start->height, all = pixels * (size_t)start->views;
    Sample sample;
    size_t trusted = 0, seen = 0;
    for (size_t k = 0; k < all; k++)
        trusted += make_sample(capture, start, (int)(k / pixels), k % pixels, active, &sample);
    const size_t step = trusted / SAMPLES_MAX + 1;
    fitting->count = 0;
    for (size_t k = 0; k < all && fitting->count < SAMPLES_MAX; k++) {
        if (make_sample(capture, start, (int)(k / pixels), k % pixels, active, &sample) && seen++ % step == 0)
            fitting->samples[fitting->count++] = sample;
    }
}

// --- Gamma. ---

// The light that each sample's place on the pattern sends, by the response.
static void look_up(const Fitting *fitting, const double gamma[3], real *light) {
    const FfpResponse response = {.gamma = {gamma[0], gamma[1], gamma[2]}};
    FfpImage sent = ffp_image_copy(fitting->pattern);
    ffp_response_apply(&response, fitting->linear, &sent);
    FfpSummed summed = ffp_summed_new(&sent);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < fitting->count; i++) {
        const Sample *s = &fitting->samples[i];
        ffp_lookup(&summed, s->at[0], s->at[1], s->side, s->side, light + 3 * i);
    }
    ffp_summed_free(&summed);
    ffp_image_free(&sent);
}

// Three times the median difference: beyond it a sample's depth is wrong rather than its light.
static void settle_scales(Fitting *fitting, const double gamma[3]) {
    double *off = ffp_alloc((size_t)fitting->count + 1, sizeof *off);
    look_up(fitting, gamma, fitting->light);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < fitting->count; i++)
            off[i] = fabs((double)(fitting->light[3 * i + c] - fitting->samples[i].ratio[c]));
        fitting->scale[c] = fmax(3 * ffp_quantile(off, (size_t)fitting->count, 0.5), SCALE_LEAST);
    }
    ffp_free(off);
}

// Geman and McClure's robust cost of each channel.
static void judge(const Fitting *fitting, const double gamma[3], double cost[3]) {
    look_up(fitting, gamma, fitting->light);
    for (int c = 0; c < 3; c++) {
        cost[c] = 0;
        for (int i = 0; i < fitting->count; i++) {
            const double r =
                (double)(fitting->light[3 * i + c] - fitting->samples[i].ratio[c]) / fitting->scale[c];
            cost[c] += r * r / (1 + r * r);
        }
    }
}

// Golden section in the logarithm of gamma, the three channels side by side.
static void fit_gamma(const Fitting *fitting, double gamma[3]) {
    const double golden = (sqrt(5.0) - 1) / 2;
    double low[3], high[3], inner[2][3], cost[2][3], trial[3], found[3];
    for (int c = 0; c < 3; c++) {
        low[c] = log(GAMMA_LOW), high[c] = log(GAMMA_HIGH);
        inner[0][c] = high[c] - golden * (high[c] - low[c]),
        inner[1][c] = low[c] + golden * (high[c] - low[c]);
    }
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++) trial[c] = exp(inner[k][c]);
        judge(fitting, trial, cost[k]);
    }
    for (int step = 0; step < GAMMA_STEPS; step++) {
        int side[3];
        for (int c = 0; c < 3; c++) {
            side[c] = cost[0][c] < cost[1][c] ? 0 : 1;
            const int s = side[c];
            *(s == 0 ? &high[c] : &low[c]) = inner[1 - s][c];
            inner[1 - s][c] = inner[s][c], cost[1 - s][c] = cost[s][c];
            inner[s][c] =
                s == 0 ? high[c] - golden * (high[c] - low[c]) : low[c] + golden * (high[c] - low[c]);
            trial[c] = exp(inner[s][c]);
        }
        judge(fitting, trial, found);
        for (int c = 0; c < 3; c++) cost[side[c]][c] = found[c];
    }
    for (int c = 0; c < 3; c++) gamma[c] = exp((low[c] + high[c]) / 2);
}

// Standard deviations from the differences left over and the light's change with gamma; false when that is
// next to nothing.
static bool estimate_deviation(Fitting *fitting, FfpResponse *response) {
    const double step = 0.02;
    double up[3], down[3];
    real *brighter = ffp_alloc(3 * (size_t)fitting->count + 1, sizeof *brighter),
         *darker = ffp_alloc(3 * (size_t)fitting->count + 1, sizeof *darker);
    bool tells = true;
    for (int c = 0; c < 3; c++) up[c] = response->gamma[c] + step, down[c] = response->gamma[c] - step;
    look_up(fitting, up, darker);
    look_up(fitting, down, brighter);
    look_up(fitting, response->gamma, fitting->light);
    for (int c = 0; c < 3; c++) {
        double slopes = 0, squares = 0, weights = 0;
        for (int i = 0; i < fitting->count; i++) {
            const double off = (double)(fitting->light[3 * i + c] - fitting->samples[i].ratio[c]),
                         slope = (double)(brighter[3 * i + c] - darker[3 * i + c]) / (2 * step),
                         w = 1 + off * off / (fitting->scale[c] * fitting->scale[c]);
            weights += 1 / (w * w), squares += off * off / (w * w), slopes += slope * slope / (w * w);
        }
        response->gamma_deviation[c] = sqrt(squares / weights / slopes * CORRELATED);
        tells = tells && sqrt(slopes / weights) > SLOPE_LEAST && response->gamma_deviation[c] < DEVIATION_MAX;
    }
    ffp_free(brighter), ffp_free(darker);
    return tells;
}

// --- Black level and intensity. ---

// In a dark room black / white is the same everywhere; otherwise the least of it bounds the projector's
// share.
bool ffp_response_black(double *shares, size_t n, double *black) {
    const double median = ffp_quantile(shares, n, 0.5),
                 spread = ffp_quantile(shares, n, 0.9) - ffp_quantile(shares, n, 0.1);
    const bool dark = spread <= DARK * median || median < 1e-3;
    *black = dark ? median : ffp_quantile(shares, n, 0.02);
    return dark;
}

static void find_black(const Fitting *fitting, FfpResponse *response) {
    double *shares = ffp_alloc((size_t)fitting->count + 1, sizeof *shares);
    response->black_known = true;
    const size_t n = (size_t)fitting->count;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < fitting->count; i++) shares[i] = (double)fitting->samples[i].share[c];
        const bool dark = ffp_response_black(shares, n, &response->black[c]);
        response->black_known = response->black_known && dark;
    }
    ffp_free(shares);
}

static void find_intensity(const Fitting *fitting, double unit, FfpResponse *response) {
    double *strengths = ffp_alloc((size_t)fitting->count + 1, sizeof *strengths);
    int n = 0;
    for (int i = 0; i < fitting->count; i++)
        if (fitting->samples[i].strength > 0) strengths[n++] = (double)fitting->samples[i].strength;
    response->intensity = ffp_quantile(strengths, (size_t)n, 0.95) / BRIGHT_ALBEDO * unit * unit;
    ffp_free(strengths);
}

// --- All of it. ---

static bool same_sizes(const FfpCapture *capture, FfpError *err) {
    for (int v = 1; v < capture->n_views; v++) {
        const FfpCamera *a = &capture->views[0].camera, *b = &capture->views[v].camera;
        if (a->width != b->width || a->height != b->height)
            return ffp_fail(err, FFP_ERROR_FILE, PLACE, "the views' pictures have different sizes");
    }
    return true;
}

// One round: depth by the response so far, then the response by that depth.
static bool run_round(Fitting *fitting, FfpCapture *small, int active, const FfpImage *sent,
                      FfpResponse *response, FfpError *err) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpImage kept = small->patterns[active].image;
    FfpInitialisation start;
    small->patterns[active].image = *sent;
    const bool ok = ffp_initialisation_new(&start, small, &active, 1, &settings, err);
    small->patterns[active].image = kept;
    if (!ok) return false;
    collect(fitting, small, &start, active);
    ffp_initialisation_free(&start);
    if (fitting->count < SAMPLES_LEAST)
        return ffp_fail(
            err, FFP_ERROR_FILE, PLACE,
            "only %d pixels are lit, not clipped, and matched with confidence: the response needs "
            "%d",
            fitting->count, SAMPLES_LEAST);
    settle_scales(fitting, response->gamma);
    fit_gamma(fitting, response->gamma);
    return true;
}

static bool fit(Fitting *fitting, FfpCapture *small, int active, double unit, FfpResponse *response,
                FfpError *err) {
    bool ok = true;
    for (int c = 0; c < 3; c++) response->gamma[c] = fitting->linear ? 1 : 2.2;
    for (int round = 0; round < ROUNDS && ok; round++) {
        FfpImage sent = ffp_image_copy(fitting->pattern);
        if (round > 0) ffp_response_apply(response, fitting->linear, &sent);
        ok = run_round(fitting, small, active, &sent, response, err);
        ffp_image_free(&sent);
    }
    if (!ok) return false;
    response->samples = fitting->count;
    find_black(fitting, response);
    find_intensity(fitting, unit, response);
    return estimate_deviation(fitting, response) ||
           ffp_fail(err, FFP_ERROR_FILE, PLACE,
                    "the pattern '%s' does not determine the projector's gamma: it needs mid-range values in "
                    "all channels",
                    small->patterns[active].name);
}

bool ffp_fit_response(FfpResponse *response, const FfpCapture *capture, int active, bool linear,
                      FfpError *err) {
    *response = (FfpResponse){0};
    if (!same_sizes(capture, err)) return false;
    FfpCapture small = ffp_small_new(capture, active);
    const double unit = (double)capture->radius;
    FfpPattern *patterns = ffp_alloc((size_t)small.n_patterns, sizeof *patterns);
    for (int p = 0; p < small.n_patterns; p++) patterns[p] = capture->patterns[p];
    small.patterns = patterns;
    ffp_capture_normalise(&small, capture->centre, capture->radius);
    Fitting fitting = {.pattern = &capture->patterns[active].image,
                       .linear = linear,
                       .samples = ffp_alloc(SAMPLES_MAX, sizeof(Sample)),
                       .light = ffp_alloc(3 * (size_t)SAMPLES_MAX, sizeof(real))};
    const bool ok = fit(&fitting, &small, active, unit, response, err);
    ffp_free(fitting.samples), ffp_free(fitting.light), ffp_free(patterns);
    ffp_capture_reduced_free(&small);
    return ok;
}
