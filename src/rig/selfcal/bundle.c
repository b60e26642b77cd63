#include "rig/selfcal/bundle.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

#define ZOOM_MOST 3 // log of two focal lengths' ratio: a file that says more is not believed

enum { STEPS = 40, ROUNDS = 4, SIGHTINGS_LEAST = 20 };
enum {
    POSE = 6,
    NUMBERS_MOST = FFP_BUNDLE_OPTICS + (POSE + FFP_OWN) * FFP_PLACES_MAX,
    PRIORS_MOST = FFP_BUNDLE_PRIORS + FFP_OWN * FFP_PLACES_MAX
};
#define WORTH 1e-7
#define APART                                                                                                \
    200 // sightings at most that errors can differ between which neighbours share: a lens errs smoothly
#define SHARED 0.02     // pixels that every model of a lens is off by, smoothly
#define NEAREST_OUT 0.5 // pixels: nothing nearer is out of line

// --- All of them. ---

int ffp_bundle_places(const FfpBundle *b) {
    int n = 0;
    for (int p = 0; p < b->tracks->n_places; p++) n += b->known[p];
    return n;
}

double ffp_bundle_expected(const FfpBundle *b, int place) {
    const double own = b->tracks->places[place].focal_35mm, all = b->tracks->focal_35mm;
    const double apart = b->each && own > 0 && all > 0 ? log(own / all) : 0;
    return fabs(apart) < ZOOM_MOST ? apart : 0;
}

bool ffp_bundle_see(const FfpBundle *b, int place, const double point[3], double at[2]) {
    const FfpBundleDevice camera = ffp_bundle_camera_at(b->tracks, b->optics, b->own[place]);
    double x[3];
    ffp_rigid_apply(&b->places[place], point, x);
    return ffp_bundle_pixel(&camera, x, at);
}

bool ffp_bundle_point(const FfpBundle *b, int track, double point[3]) {
    const FfpBundleDevice projector = ffp_bundle_projector(b->tracks, b->optics);
    double ray[3];
    if (!(b->nearness[track] > 0) || !ffp_bundle_ray(&projector, b->tracks->tracks[track].panel, ray))
        return false;
    for (int k = 0; k < 3; k++) point[k] = ray[k] / b->nearness[track];
    return true;
}

typedef struct Fit {
    FfpBundle *bundle;
    int n_tracks, *tracks; // those that take part
    double (*rays)[3];     // [n_tracks] of the projector as it is
    int *at;               // [n_tracks] where their differences begin
    int unused;            // sightings of these that do not count: their differences stay 0
    int count;             // of all differences, usual values behind them
    int n_places, *places; // those with a pose
    int own, each;         // numbers of a place's own camera; of these and its pose
    int numbers;           // all
    double unit;           // distance of the first of these
    double apart, firm; // root of sightings to those that are apart; what a deviation from the usual counts
} Fit;

typedef struct Tried { // devices as they are tried
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid places[FFP_PLACES_MAX];
    FfpOwn own[FFP_PLACES_MAX];
    FfpBundleDevice cameras[FFP_PLACES_MAX];
} Tried;

static FfpDevices devices_of(const FfpBundle *b, Tried *t) {
    for (int p = 0; p < b->tracks->n_places; p++)
        t->cameras[p] = ffp_bundle_camera_at(b->tracks, t->optics, t->own[p]);
    return (FfpDevices){t->cameras, ffp_bundle_projector(b->tracks, t->optics), t->places, b->known};
}

static double unit_of(const FfpRigid *pose) {
    return sqrt(ffp_dot(pose->t, pose->t)); // between the projector and the camera, in either's frame
}

static void as_is(const FfpBundle *b, Tried *t) {
    const size_t n = (size_t)b->tracks->n_places;
    memcpy(t->optics, b->optics, sizeof b->optics);
    memcpy(t->places, b->places, n * sizeof *b->places);
    memcpy(t->own, b->own, n * sizeof *b->own);
}

// The devices moved by a fit's numbers.
static void moved(const Fit *fit, const double *by, Tried *out) {
    const FfpBundle *b = fit->bundle;
    as_is(b, out);
    for (int i = 0; i < FFP_BUNDLE_OPTICS; i++) out->optics[i] += by[i];
    for (int i = 0; i < fit->n_places; i++) {
        const double *six = by + FFP_BUNDLE_OPTICS + (ptrdiff_t)fit->each * i;
        const int place = fit->places[i];
        const FfpRigid *from = &b->places[place];
        FfpRigid *to = &out->places[place];
        double turn[9];
        ffp_rotation_from_vector(six, turn);
        ffp_rotation_product(turn, from->r, to->r);
        for (int k = 0; k < 3; k++) to->t[k] = from->t[k] + fit->unit * six[3 + k];
        for (int k = 0; k < fit->own; k++) out->own[place][k] += six[POSE + k];
    }
}

static int priors_of(const Fit *fit) {
    return FFP_BUNDLE_PRIORS + fit->own * fit->n_places;
}

static void put_priors(const Fit *fit, const Tried *tried, double *out) {
    const FfpBundle *b = fit->bundle;
    for (int i = 0; i < fit->n_places; i++)
        for (int k = 0; k < fit->own; k++)
            *out++ = fit->firm *
                     (tried->own[fit->places[i]][k] -
                      (k == FFP_OWN_FOCAL ? ffp_bundle_expected(b, fit->places[i]) : 0)) /
                     b->own_usual[k];
    ffp_optics_unusual(tried->optics, &b->usual, fit->firm,
                       unit_of(&tried->places[fit->places[0]]) / fit->unit, out);
}

// Of the central differences, either way.
static double step_of(const Fit *fit, int number) {
    return number < FFP_BUNDLE_OPTICS || (number - FFP_BUNDLE_OPTICS) % fit->each >= POSE ? 1e-5 : 1e-6;
}

static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const FfpBundle *b = fit->bundle;
    Tried tried;
    moved(fit, by, &tried);
    const FfpDevices d = devices_of(b, &tried);
    for (int i = 0; i < fit->n_tracks; i++) {
        const FfpTrack *track = &b->tracks->tracks[fit->tracks[i]];
        double ray[3];
        memset(out + fit->at[i], 0, 2 * (size_t)track->n * sizeof *out);
        ffp_bundle_ray(&d.projector, track->panel, ray);
        ffp_devices_nearness(&d, ray, b->tracks->sightings + track->first, track->n,
                             b->nearness[fit->tracks[i]], out + fit->at[i]);
    }
    put_priors(fit, &tried, out + fit->count - priors_of(fit));
}

// The place that a number belongs to; -1: to the optics of all.
static int place_of(const Fit *fit, int number) {
    return number < FFP_BUNDLE_OPTICS ? -1 : fit->places[(number - FFP_BUNDLE_OPTICS) / fit->each];
}

// Adds a number's share of the differences, every point where it is, as `times` that of a step to one side.
static void add_side(const Fit *fit, int number, double step, double times, double *out) {
    const FfpBundle *b = fit->bundle;
    const int place = place_of(fit, number);
    double by[NUMBERS_MOST] = {0}, priors[PRIORS_MOST];
    Tried tried;
    by[number] = step;
    moved(fit, by, &tried);
    const FfpDevices d = devices_of(b, &tried);
    for (int i = 0; i < fit->n_tracks; i++) {
        const FfpTrack *track = &b->tracks->tracks[fit->tracks[i]];
        double ray[3];
        if (place >= 0)
            memcpy(ray, fit->rays[i], sizeof ray);
        else
            ffp_bundle_ray(&d.projector, track->panel, ray);
        for (int k = 0; k < track->n; k++) {
            const FfpSighting *s = &b->tracks->sightings[track->first + k];
            double *to = out + fit->at[i] + 2 * (ptrdiff_t)k, off[2], slope[2];
            if (!ffp_devices_count(&d, s) || (place >= 0 && s->place != place)) continue;
            ffp_devices_miss(&d, ray, s, b->nearness[fit->tracks[i]], off, slope);
            for (int c = 0; c < 2; c++) to[c] += times * off[c];
        }
    }
    put_priors(fit, &tried, priors);
    for (int i = 0; i < priors_of(fit); i++) out[fit->count - priors_of(fit) + i] += times * priors[i];
}

// The derivatives, with the points solved for (variable projection in Kaufman's form, 1975): what a point
// would take up by moving along its ray is taken out.
static void slopes(const void *state, double *out) {
    const Fit *fit = state;
    const FfpBundle *b = fit->bundle;
    Tried tried;
    as_is(b, &tried);
    const FfpDevices d = devices_of(b, &tried);
    double *along = ffp_alloc((size_t)fit->count, sizeof *along);
    for (int i = 0; i < fit->n_tracks; i++) {
        const FfpTrack *track = &b->tracks->tracks[fit->tracks[i]];
        double off[2], square = 0;
        double *a = along + fit->at[i];
        ffp_bundle_ray(&d.projector, track->panel, fit->rays[i]);
        for (int k = 0; k < track->n; k++) {
            const FfpSighting *s = &b->tracks->sightings[track->first + k];
            if (ffp_devices_count(&d, s))
                ffp_devices_miss(&d, fit->rays[i], s, b->nearness[fit->tracks[i]], off, a + 2 * (ptrdiff_t)k);
        }
        for (int k = 0; k < 2 * track->n; k++) square += a[k] * a[k];
        for (int k = 0; k < 2 * track->n && square > 0; k++) a[k] /= sqrt(square);
    }
#pragma omp parallel for schedule(dynamic)
    for (int n = 0; n < fit->numbers; n++) {
        double *slope = out + (size_t)n * (size_t)fit->count;
        const double step = step_of(fit, n);
        memset(slope, 0, (size_t)fit->count * sizeof *slope);
        add_side(fit, n, step, 0.5 / step, slope);
        add_side(fit, n, -step, -0.5 / step, slope);
        for (int i = 0; i < fit->n_tracks; i++) {
            const int count = 2 * b->tracks->tracks[fit->tracks[i]].n;
            const double *a = along + fit->at[i];
            double *at = slope + fit->at[i], shared = 0;
            for (int k = 0; k < count; k++) shared += a[k] * at[k];
            for (int k = 0; k < count; k++) at[k] -= shared * a[k];
        }
    }
    ffp_free(along);
}

static void move(void *state, const double *by) {
    const Fit *fit = state;
    FfpBundle *b = fit->bundle;
    Tried tried;
    moved(fit, by, &tried);
    memcpy(b->optics, tried.optics, sizeof b->optics);
    memcpy(b->places, tried.places, (size_t)b->tracks->n_places * sizeof *b->places);
    memcpy(b->own, tried.own, (size_t)b->tracks->n_places * sizeof *b->own);
    ffp_bundle_triangulate(b);
}

void ffp_bundle_triangulate(FfpBundle *b) {
    Tried tried;
    as_is(b, &tried);
    const FfpDevices d = devices_of(b, &tried);
    for (int i = 0; i < b->tracks->n; i++) {
        const FfpTrack *track = &b->tracks->tracks[i];
        const FfpSighting *s = b->tracks->sightings + track->first;
        double ray[3];
        ffp_bundle_ray(&d.projector, track->panel, ray);
        b->nearness[i] = ffp_devices_nearness(&d, ray, s, track->n, b->nearness[i], NULL);
    }
}

// Root of how many sightings, of n, there are to one whose error has nothing to do with another's: noise is
// new in each, and what neighbours share counts a few times at most.
static double apart_of(const FfpBundle *b, double n) {
    const double of_all = fmax(1, n / APART);
    if (!(b->rms > 0)) return sqrt(of_all);
    const double noise = fmin(b->noise, b->rms),
                 shared = fmax(b->rms * b->rms - noise * noise, SHARED * SHARED);
    return sqrt((noise * noise + shared * of_all) / (noise * noise + shared));
}

static Fit fit_new(FfpBundle *b, int stride) {
    const FfpTracks *t = b->tracks;
    Fit fit = {.bundle = b,
               .tracks = ffp_alloc((size_t)t->n + 1, sizeof(int)),
               .at = ffp_alloc((size_t)t->n + 1, sizeof(int)),
               .rays = ffp_alloc((size_t)t->n + 1, 3 * sizeof(double)),
               .places = ffp_alloc((size_t)t->n_places, sizeof(int))};
    for (int p = 0; p < t->n_places; p++)
        if (b->known[p]) fit.places[fit.n_places++] = p;
    fit.unit = unit_of(&b->places[fit.places[0]]);
    for (int i = 0; i < t->n; i += stride) {
        if (!(b->nearness[i] > 0)) continue;
        fit.tracks[fit.n_tracks] = i, fit.at[fit.n_tracks++] = fit.count;
        fit.count += 2 * t->tracks[i].n;
        const FfpSighting *s = &t->sightings[t->tracks[i].first];
        for (int k = 0; k < t->tracks[i].n; k++) fit.unused += !(s[k].used && b->known[s[k].place]);
    }
    fit.apart = apart_of(b, 0.5 * fit.count - fit.unused);
    fit.firm = fit.apart * (b->rms > 0 ? fmin(b->rms, FFP_BUNDLE_NOISE) : FFP_BUNDLE_NOISE);
    while (fit.own < FFP_OWN && b->own_usual[fit.own] > 0) fit.own++;
    fit.each = POSE + fit.own;
    fit.numbers = FFP_BUNDLE_OPTICS + fit.each * fit.n_places;
    fit.count += priors_of(&fit);
    return fit;
}

static void fit_free(Fit *fit) {
    ffp_free(fit->tracks), ffp_free(fit->at), ffp_free(fit->rays), ffp_free(fit->places);
}

// The deviation of a place's focal length, which is the common one and the place's own together.
static double focal_deviation(const Fit *fit, const double *covariance, int i) {
    const size_t n = (size_t)fit->numbers, common = FFP_BUNDLE_CAMERA_FOCAL,
                 own = FFP_BUNDLE_OPTICS + (size_t)fit->each * (size_t)i + POSE + FFP_OWN_FOCAL;
    if (fit->own == 0) return fit->apart * sqrt(covariance[n * common + common]);
    return fit->apart * sqrt(fmax(0, covariance[n * common + common] + covariance[n * own + own] +
                                         2 * covariance[n * common + own]));
}

// Each number's own deviation, those of unknown places INFINITY: as if APART sightings were all there is.
static void keep_deviations(const Fit *fit, const double *covariance) {
    FfpBundle *b = fit->bundle;
    const int numbers = fit->numbers, all = FFP_BUNDLE_OPTICS + 6 * b->tracks->n_places;
    if (!b->deviation) b->deviation = ffp_alloc((size_t)all, sizeof *b->deviation);
    if (!b->own_deviation)
        b->own_deviation = ffp_alloc((size_t)b->tracks->n_places, sizeof *b->own_deviation);
    if (!b->focal_deviation)
        b->focal_deviation = ffp_alloc((size_t)b->tracks->n_places, sizeof *b->focal_deviation);
    for (int i = 0; i < fit->n_places; i++)
        b->focal_deviation[fit->places[i]] = focal_deviation(fit, covariance, i);
    for (int i = 0; i < all; i++) b->deviation[i] = INFINITY;
    for (int i = 0; i < numbers; i++) {
        const int place = (i - FFP_BUNDLE_OPTICS) / fit->each, k = (i - FFP_BUNDLE_OPTICS) % fit->each;
        const double deviation = fit->apart * sqrt(covariance[(size_t)numbers * (size_t)i + (size_t)i]);
        if (i < FFP_BUNDLE_OPTICS)
            b->deviation[i] = deviation;
        else if (k < POSE)
            b->deviation[FFP_BUNDLE_OPTICS + POSE * fit->places[place] + k] = deviation;
        else
            b->own_deviation[fit->places[place]][k - POSE] = deviation;
    }
}

// Distances of all sightings that count, of any track; in *n how many. With `out`, those beyond it are no
// longer used and those within are again.
static double *distances(FfpBundle *b, double out, size_t *n) {
    const FfpTracks *t = b->tracks;
    double *found = ffp_alloc((size_t)t->n_sightings + 1, sizeof *found);
    *n = 0;
    for (int i = 0; i < t->n; i++) {
        double point[3], at[2];
        const bool there = ffp_bundle_point(b, i, point);
        for (int k = 0; k < t->tracks[i].n; k++) {
            FfpSighting *s = &t->sightings[t->tracks[i].first + k];
            if (!b->known[s->place]) continue;
            const double off = there && ffp_bundle_see(b, s->place, point, at)
                                   ? hypot(at[0] - s->at[0], at[1] - s->at[1])
                                   : INFINITY;
            if (out > 0) s->used = off <= out;
            if (s->used) found[(*n)++] = off;
        }
    }
    return found;
}

static double median_distance(FfpBundle *b) {
    size_t n;
    double *found = distances(b, 0, &n);
    real *values = ffp_alloc(n + 1, sizeof *values);
    for (size_t i = 0; i < n; i++) values[i] = (real)fmin(found[i], 1e6);
    const double median = n > 0 ? (double)ffp_median(values, n) : 0;
    ffp_free(values), ffp_free(found);
    return median;
}

// From a track's sighting at a place to where its point is seen; false: it is not used there.
static bool miss(const void *bundle, int track, int place, double off[2]) {
    const FfpBundle *b = bundle;
    double point[3], at[2];
    if (!b->known[place]) return false;
    for (int k = 0; k < b->tracks->tracks[track].n; k++) {
        const FfpSighting *s = &b->tracks->sightings[b->tracks->tracks[track].first + k];
        if (s->place != place) continue;
        if (!s->used || !ffp_bundle_point(b, track, point) || !ffp_bundle_see(b, place, point, at))
            return false;
        for (int i = 0; i < 2; i++) off[i] = at[i] - s->at[i];
        return true;
    }
    return false;
}

static void measure(FfpBundle *b) {
    size_t n;
    double *found = distances(b, 0, &n), sum = 0;
    for (size_t i = 0; i < n; i++) sum += found[i] * found[i];
    b->rms = n > 0 ? sqrt(sum / (double)n) : INFINITY;
    b->noise = ffp_tracks_noise(b->tracks, b, miss);
    ffp_free(found);
}

// Places nearly all of whose sightings are out of line are not where they seemed.
static void drop_lost(FfpBundle *b) {
    int left[FFP_PLACES_MAX] = {0};
    for (int i = 0; i < b->tracks->n_sightings; i++)
        left[b->tracks->sightings[i].place] += b->tracks->sightings[i].used;
    for (int p = 0; p < b->tracks->n_places; p++) {
        FfpCameraPlace *place = &b->tracks->places[p];
        if (!b->known[p] || left[p] >= SIGHTINGS_LEAST) continue;
        b->known[p] = false;
        snprintf(place->problem, sizeof place->problem,
                 "only %d of its %d spots lie where other places put them: the projector or the scene moved "
                 "between them",
                 left[p], place->seen);
    }
}

void ffp_bundle_fit(FfpBundle *b, int stride, double far, bool deviations) {
    ffp_bundle_triangulate(b);
    for (int round = 0; round < (far > 0 ? ROUNDS : 1); round++) {
        Fit fit = fit_new(b, stride);
        const int numbers = fit.numbers;
        const bool judge = deviations && (far <= 0 || round == ROUNDS - 1);
        double *covariance = judge ? ffp_alloc((size_t)numbers * (size_t)numbers, sizeof(double)) : NULL;
        ffp_least_squares(&(FfpLeastSquares){.state = &fit,
                                             .numbers = numbers,
                                             .count = fit.count,
                                             .solved = fit.n_tracks + 2 * fit.unused,
                                             .differences = differences,
                                             .move = move,
                                             .slopes = slopes,
                                             .steps = STEPS,
                                             .worth = WORTH,
                                             .end = judge ? &b->end : NULL},
                          covariance);
        if (judge) keep_deviations(&fit, covariance);
        ffp_free(covariance);
        fit_free(&fit);
        measure(b);
        if (far > 0 && round < ROUNDS - 1) {
            size_t n;
            ffp_free(distances(b, fmax(far * median_distance(b), NEAREST_OUT), &n));
            drop_lost(b);
            ffp_bundle_triangulate(b);
        }
    }
}
