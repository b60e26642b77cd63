#include "rig/selfcal/bundle.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

enum { STEPS = 40, ROUNDS = 4, SIGHTINGS_LEAST = 20 };
#define WORTH 1e-7
#define APART                                                                                                \
    200 // sightings whose errors have nothing to do with each other: lenses and surfaces err smoothly
#define NEAREST_OUT 0.5 // pixels: nothing nearer is out of line

// --- All of them. ---

bool ffp_bundle_see(const FfpBundle *b, int place, const double point[3], double at[2]) {
    const FfpBundleDevice camera = ffp_bundle_camera(b->tracks, b->optics);
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
    int *at;               // [n_tracks] where their differences begin
    int count;             // of all differences, usual values behind them
    int n_places, *places; // those with a pose
    double unit;           // distance of the first of these
    double apart, firm; // root of sightings to those that are apart; what a deviation from the usual counts
} Fit;

static FfpDevices devices_of(const FfpBundle *b, const double *optics, const FfpRigid *places) {
    return (FfpDevices){ffp_bundle_camera(b->tracks, optics), ffp_bundle_projector(b->tracks, optics), places,
                        b->known};
}

static double unit_of(const FfpRigid *pose) {
    return sqrt(ffp_dot(pose->t, pose->t)); // between the projector and the camera, in either's frame
}

// The devices moved by a fit's numbers; `places` [n_places of the tracks].
static void moved(const Fit *fit, const double *by, double optics[FFP_BUNDLE_OPTICS], FfpRigid *places) {
    const FfpBundle *b = fit->bundle;
    memcpy(optics, b->optics, sizeof b->optics);
    for (int i = 0; i < FFP_BUNDLE_OPTICS; i++) optics[i] += by[i];
    for (int i = 0; i < fit->n_places; i++) {
        const double *six = by + FFP_BUNDLE_OPTICS + 6 * (size_t)i;
        const FfpRigid *from = &b->places[fit->places[i]];
        FfpRigid *to = &places[fit->places[i]];
        double turn[9];
        ffp_rotation_from_vector(six, turn);
        ffp_rotation_product(turn, from->r, to->r);
        for (int k = 0; k < 3; k++) to->t[k] = from->t[k] + fit->unit * six[3 + k];
    }
}

static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const FfpBundle *b = fit->bundle;
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid places[FFP_PLACES_MAX];
    moved(fit, by, optics, places);
    const FfpDevices d = devices_of(b, optics, places);
    for (int i = 0; i < fit->n_tracks; i++) {
        const FfpTrack *track = &b->tracks->tracks[fit->tracks[i]];
        double ray[3];
        memset(out + fit->at[i], 0, 2 * (size_t)track->n * sizeof *out);
        ffp_bundle_ray(&d.projector, track->panel, ray);
        ffp_devices_nearness(&d, ray, b->tracks->sightings + track->first, track->n,
                             b->nearness[fit->tracks[i]], out + fit->at[i]);
    }
    ffp_optics_unusual(optics, &b->focal, fit->firm, unit_of(&places[fit->places[0]]) / fit->unit,
                       out + fit->count - FFP_BUNDLE_PRIORS);
}

static void move(void *state, const double *by) {
    Fit *fit = state;
    FfpRigid places[FFP_PLACES_MAX];
    double optics[FFP_BUNDLE_OPTICS];
    moved(fit, by, optics, places);
    memcpy(fit->bundle->optics, optics, sizeof optics);
    for (int i = 0; i < fit->n_places; i++) fit->bundle->places[fit->places[i]] = places[fit->places[i]];
    ffp_bundle_triangulate(fit->bundle);
}

void ffp_bundle_triangulate(FfpBundle *b) {
    const FfpDevices d = devices_of(b, b->optics, b->places);
    for (int i = 0; i < b->tracks->n; i++) {
        const FfpTrack *track = &b->tracks->tracks[i];
        const FfpSighting *s = b->tracks->sightings + track->first;
        double ray[3];
        ffp_bundle_ray(&d.projector, track->panel, ray);
        b->nearness[i] = ffp_devices_nearness(&d, ray, s, track->n, b->nearness[i], NULL);
    }
}

static Fit fit_new(FfpBundle *b, int stride) {
    const FfpTracks *t = b->tracks;
    Fit fit = {.bundle = b,
               .tracks = ffp_alloc((size_t)t->n + 1, sizeof(int)),
               .at = ffp_alloc((size_t)t->n + 1, sizeof(int)),
               .places = ffp_alloc((size_t)t->n_places, sizeof(int))};
    for (int p = 0; p < t->n_places; p++)
        if (b->known[p]) fit.places[fit.n_places++] = p;
    fit.unit = unit_of(&b->places[fit.places[0]]);
    for (int i = 0; i < t->n; i += stride) {
        if (!(b->nearness[i] > 0)) continue;
        fit.tracks[fit.n_tracks] = i, fit.at[fit.n_tracks++] = fit.count;
        fit.count += 2 * t->tracks[i].n;
    }
    fit.apart = sqrt(fmax(1, 0.5 * fit.count / APART));
    fit.firm = fit.apart * (b->rms > 0 ? fmin(b->rms, FFP_BUNDLE_NOISE) : FFP_BUNDLE_NOISE);
    fit.count += FFP_BUNDLE_PRIORS;
    return fit;
}

static void fit_free(Fit *fit) {
    ffp_free(fit->tracks), ffp_free(fit->at), ffp_free(fit->places);
}

static double *steps_of(const Fit *fit) {
    const int numbers = FFP_BUNDLE_OPTICS + 6 * fit->n_places;
    double *step = ffp_alloc((size_t)numbers, sizeof *step);
    for (int i = 0; i < numbers; i++) step[i] = i < FFP_BUNDLE_OPTICS ? 1e-5 : 1e-6;
    return step;
}

// Each number's own deviation, those of unknown places INFINITY: as if APART sightings were all there is.
static void keep_deviations(const Fit *fit, const double *covariance) {
    FfpBundle *b = fit->bundle;
    const int numbers = FFP_BUNDLE_OPTICS + 6 * fit->n_places,
              all = FFP_BUNDLE_OPTICS + 6 * b->tracks->n_places;
    if (!b->deviation) b->deviation = ffp_alloc((size_t)all, sizeof *b->deviation);
    for (int i = 0; i < all; i++) b->deviation[i] = INFINITY;
    for (int i = 0; i < numbers; i++) {
        const int place = (i - FFP_BUNDLE_OPTICS) / 6, k = (i - FFP_BUNDLE_OPTICS) % 6;
        const int to = i < FFP_BUNDLE_OPTICS ? i : FFP_BUNDLE_OPTICS + 6 * fit->places[place] + k;
        b->deviation[to] = fit->apart * sqrt(covariance[(size_t)numbers * (size_t)i + (size_t)i]);
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

static void measure(FfpBundle *b) {
    size_t n;
    double *found = distances(b, 0, &n), sum = 0;
    for (size_t i = 0; i < n; i++) sum += found[i] * found[i];
    b->rms = n > 0 ? sqrt(sum / (double)n) : INFINITY;
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
        const int numbers = FFP_BUNDLE_OPTICS + 6 * fit.n_places;
        const bool judge = deviations && (far <= 0 || round == ROUNDS - 1);
        double *step = steps_of(&fit);
        double *covariance = judge ? ffp_alloc((size_t)numbers * (size_t)numbers, sizeof(double)) : NULL;
        ffp_least_squares(&(FfpLeastSquares){.state = &fit,
                                             .numbers = numbers,
                                             .count = fit.count,
                                             .differences = differences,
                                             .move = move,
                                             .step = step,
                                             .steps = STEPS,
                                             .worth = WORTH},
                          covariance);
        if (judge) keep_deviations(&fit, covariance);
        ffp_free(covariance), ffp_free(step);
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
