#include "rig/selfcal/bundle.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/lens.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

enum { STEPS = 40, NEARNESS_STEPS = 6, ROUNDS = 4, SIGHTINGS_LEAST = 20 };
#define WORTH 1e-7
#define NOISE 0.3 // pixels: what a sighting is off by at first, next to which usual values count
#define APART                                                                                                \
    200 // sightings whose errors have nothing to do with each other: lenses and surfaces err smoothly
#define NEAREST_OUT 0.5 // pixels: nothing nearer is out of line
#define UNIT_HELD 1e-5  // relative: the unit of length, which no photograph tells
#define BEHIND 1e3      // pixels: what a sighting counts whose point is behind the camera

// Deviations from 0 that are usual, of the shares of the width and of the lens terms; of focal lengths any.
static const double usual[FFP_BUNDLE_OPTICS] = {
    [FFP_BUNDLE_CAMERA_X] = 0.01,   [FFP_BUNDLE_CAMERA_Y] = 0.01,    [FFP_BUNDLE_CAMERA_K1] = 0.2,
    [FFP_BUNDLE_CAMERA_K2] = 0.05,  [FFP_BUNDLE_PROJECTOR_X] = 0.03, [FFP_BUNDLE_PROJECTOR_Y] = 0.5,
    [FFP_BUNDLE_PROJECTOR_K1] = 0.1};

// --- Devices. ---

typedef struct Device {
    double focal, x, y, lens[5];
} Device;

static Device camera_of(const FfpBundle *b, const double *optics) {
    return (Device){exp(optics[FFP_BUNDLE_CAMERA_FOCAL]),
                    (0.5 + optics[FFP_BUNDLE_CAMERA_X]) * b->tracks->width,
                    0.5 * b->tracks->height + optics[FFP_BUNDLE_CAMERA_Y] * b->tracks->width,
                    {optics[FFP_BUNDLE_CAMERA_K1], optics[FFP_BUNDLE_CAMERA_K2]}};
}

static Device projector_of(const FfpBundle *b, const double *optics) {
    return (Device){exp(optics[FFP_BUNDLE_PROJECTOR_FOCAL]),
                    (0.5 + optics[FFP_BUNDLE_PROJECTOR_X]) * b->tracks->panel_width,
                    0.5 * b->tracks->panel_height + optics[FFP_BUNDLE_PROJECTOR_Y] * b->tracks->panel_width,
                    {optics[FFP_BUNDLE_PROJECTOR_K1]}};
}

static bool ray_of(const Device *device, const double pixel[2], double ray[3]) {
    ray[2] = 1;
    return ffp_lens_undistort(device->lens, (pixel[0] - device->x) / device->focal,
                              (pixel[1] - device->y) / device->focal, ray);
}

static bool see(const Device *camera, const double x[3], double at[2]) {
    double u, v;
    if (!(x[2] > 0)) return false;
    ffp_lens_distort(camera->lens, x[0] / x[2], x[1] / x[2], &u, &v);
    at[0] = camera->x + camera->focal * u, at[1] = camera->y + camera->focal * v;
    return true;
}

static void into(const FfpRigid *pose, const double p[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = ffp_dot(pose->r + 3 * k, p) + pose->t[k];
}

bool ffp_bundle_see(const FfpBundle *b, int place, const double point[3], double at[2]) {
    const Device camera = camera_of(b, b->optics);
    double x[3];
    into(&b->places[place], point, x);
    return see(&camera, x, at);
}

bool ffp_bundle_point(const FfpBundle *b, int track, double point[3]) {
    const Device projector = projector_of(b, b->optics);
    double ray[3];
    if (!(b->nearness[track] > 0) || !ray_of(&projector, b->tracks->tracks[track].panel, ray)) return false;
    for (int k = 0; k < 3; k++) point[k] = ray[k] / b->nearness[track];
    return true;
}

// --- One track: its nearness, and how far its sightings lie from where that puts them. ---

typedef struct Devices { // as they are tried
    Device camera, projector;
    const FfpRigid *places;
    const bool *known;
} Devices;

static bool counts(const Devices *d, const FfpSighting *s) {
    return s->used && d->known[s->place];
}

// A pixel and its change with the nearness, in the camera's frame x + nearness t for the ray's x.
static bool sight(const Device *c, const double x[3], const double t[3], double nearness, double at[2],
                  double slope[2]) {
    const double z = x[2] + nearness * t[2];
    if (!(z > 0)) return false;
    const double u = (x[0] + nearness * t[0]) / z, v = (x[1] + nearness * t[1]) / z;
    const double du = (t[0] - u * t[2]) / z, dv = (t[1] - v * t[2]) / z;
    const double r2 = u * u + v * v, radial = 1 + r2 * (c->lens[0] + r2 * c->lens[1]);
    const double more = 2 * (u * du + v * dv) * (c->lens[0] + 2 * r2 * c->lens[1]);
    at[0] = c->x + c->focal * u * radial, at[1] = c->y + c->focal * v * radial;
    slope[0] = c->focal * (du * radial + u * more), slope[1] = c->focal * (dv * radial + v * more);
    return true;
}

// A first nearness, linear in it: a x_2 = x_0 for each sighting at a.
static double first_nearness(const Devices *d, const FfpSighting *s, int n, const double ray[3]) {
    double above = 0, below = 0;
    for (int i = 0; i < n; i++) {
        if (!counts(d, &s[i])) continue;
        const FfpRigid *pose = &d->places[s[i].place];
        const double a[2] = {(s[i].at[0] - d->camera.x) / d->camera.focal,
                             (s[i].at[1] - d->camera.y) / d->camera.focal};
        for (int k = 0; k < 2; k++) {
            const double fixed = a[k] * ffp_dot(pose->r + 6, ray) - ffp_dot(pose->r + 3 * k, ray);
            const double moves = a[k] * pose->t[2] - pose->t[k];
            above -= fixed * moves, below += moves * moves;
        }
    }
    return below > 0 ? above / below : 0;
}

// The nearness from `start` (0: none), and the differences [n,2] there; those that do not count stay.
static double solve_track(const Devices *d, const FfpTrack *track, const FfpSighting *s, double start,
                          double *differences) {
    double ray[3];
    bool ok = ray_of(&d->projector, track->panel, ray);
    double nearness = start > 0 ? start : ok ? first_nearness(d, s, track->n, ray) : 0;
    for (int step = 0; ok && step <= NEARNESS_STEPS; step++) {
        double above = 0, below = 0;
        for (int i = 0; i < track->n; i++) {
            if (!counts(d, &s[i])) continue;
            const FfpRigid *pose = &d->places[s[i].place];
            const double x[3] = {ffp_dot(pose->r, ray), ffp_dot(pose->r + 3, ray), ffp_dot(pose->r + 6, ray)};
            double at[2] = {s[i].at[0] + BEHIND, s[i].at[1]}, slope[2] = {0};
            if (nearness > 0) sight(&d->camera, x, pose->t, nearness, at, slope);
            for (int k = 0; k < 2; k++) {
                const double off = at[k] - s[i].at[k];
                if (differences) differences[2 * i + k] = off;
                above += slope[k] * off, below += slope[k] * slope[k];
            }
        }
        if (step == NEARNESS_STEPS || !(below > 0)) break;
        const double by = above / below;
        nearness = fmax(nearness - by, 0.2 * nearness);
        if (fabs(by) < 1e-9 * nearness) step = NEARNESS_STEPS - 1; // once more, for the differences
    }
    return ok && nearness > 0 ? nearness : 0;
}

// --- All of them. ---

typedef struct Fit {
    FfpBundle *bundle;
    int n_tracks, *tracks; // those that take part
    int *at;               // [n_tracks] where their differences begin
    int count;             // of all differences, usual values behind them
    int n_places, *places; // those with a pose
    double unit;           // distance of the first of these
    double apart, firm; // root of sightings to those that are apart; what a deviation from the usual counts
} Fit;

enum { PRIORS = FFP_BUNDLE_OPTICS + 1 };

static Devices devices_of(const FfpBundle *b, const double *optics, const FfpRigid *places) {
    return (Devices){camera_of(b, optics), projector_of(b, optics), places, b->known};
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

static void add_usual(const Fit *fit, const double *optics, const FfpRigid *places, double *out) {
    const FfpBundle *b = fit->bundle;
    for (int i = 0; i < FFP_BUNDLE_OPTICS; i++) out[i] = usual[i] > 0 ? fit->firm * optics[i] / usual[i] : 0;
    if (b->focal_known > 0)
        out[FFP_BUNDLE_CAMERA_FOCAL] =
            fit->firm * (optics[FFP_BUNDLE_CAMERA_FOCAL] - b->focal) / b->focal_known;
    out[FFP_BUNDLE_OPTICS] = log(unit_of(&places[fit->places[0]]) / fit->unit) / UNIT_HELD * NOISE;
}

static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const FfpBundle *b = fit->bundle;
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid places[FFP_PLACES_MAX];
    moved(fit, by, optics, places);
    const Devices d = devices_of(b, optics, places);
    for (int i = 0; i < fit->n_tracks; i++) {
        const FfpTrack *track = &b->tracks->tracks[fit->tracks[i]];
        memset(out + fit->at[i], 0, 2 * (size_t)track->n * sizeof *out);
        solve_track(&d, track, b->tracks->sightings + track->first, b->nearness[fit->tracks[i]],
                    out + fit->at[i]);
    }
    add_usual(fit, optics, places, out + fit->count - PRIORS);
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
    const Devices d = devices_of(b, b->optics, b->places);
    for (int i = 0; i < b->tracks->n; i++) {
        const FfpTrack *track = &b->tracks->tracks[i];
        const FfpSighting *s = b->tracks->sightings + track->first;
        b->nearness[i] = solve_track(&d, track, s, b->nearness[i], NULL);
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
    fit.firm = fit.apart * (b->rms > 0 ? fmin(b->rms, NOISE) : NOISE);
    fit.count += PRIORS;
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
