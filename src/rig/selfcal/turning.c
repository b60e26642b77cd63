#include "rig/selfcal/turning.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

enum { LIKENESS_POINTS = 100 };
enum { EACH = 2 + 2 * FFP_TURNING_NEXT }; // differences of a sighting
enum { CAMERA = FFP_BUNDLE_OPTICS, AXIS = CAMERA + 6, ANGLES = AXIS + FFP_AXIS_NUMBERS };
#define WORTH 1e-5
#define NOISE_SHARE 0.1    // of the scale: what surfaces are taken to be off while they are far apart
#define APART 200          // sightings whose errors have nothing to do with each other
#define APART_TOLD 40      // and those that deviations count: what is off at one stop is off at all
#define SIGHTING_SCALE 2.0 // pixels: what lies farther from its epipolar line counts less and less
#define NEXT_MOST 100.0    // degrees, beyond which two stops see little of the same
#define LIGHT_LEAST 0.01   // below it light is noise
#define STILL 0.7          // pixels
#define STILL_LEAST 3      // stops that see a spot at one pixel

static const double next_least[FFP_TURNING_NEXT] = {5, 35, 75}; // degrees ahead

// --- State. ---

// Degrees from one stop on to another, 0 to 360.
static double ahead(const FfpTurning *t, int from, int to) {
    const double turn = fmod((t->given[to] - t->given[from]) * 180 / FFP_PI_DOUBLE, 360);
    return turn < 0 ? turn + 360 : turn;
}

// The nearest sound stop that is `least` degrees ahead or more; -1: none within NEXT_MOST.
static int next_stop(const FfpTurning *t, int from, double least) {
    double nearest = NEXT_MOST;
    int found = -1;
    for (int q = 0; q < t->tracks->n_places; q++) {
        const double turn = ahead(t, from, q);
        if (t->tracks->places[q].problem[0] == 0 && turn >= least && turn <= nearest)
            nearest = turn, found = q;
    }
    return found;
}

void ffp_turning_set_stops(FfpTurning *t) {
    for (int p = 0; p < t->tracks->n_places; p++)
        for (int k = 0; k < FFP_TURNING_NEXT; k++) {
            const bool sound = t->tracks->places[p].problem[0] == 0;
            const int found = sound ? next_stop(t, p, next_least[k]) : -1;
            t->next[p][k] = k > 0 && (found == t->next[p][0] || found == t->next[p][k - 1]) ? -1 : found;
        }
}

FfpTurning ffp_turning_new(const FfpTracks *tracks, const double *angles) {
    const size_t stops = (size_t)tracks->n_places, sightings = (size_t)tracks->n_sightings + 1;
    FfpTurning t = {.tracks = tracks,
                    .given = angles,
                    .off = ffp_alloc(stops, sizeof(double)),
                    .next = ffp_alloc(stops, sizeof *t.next),
                    .track = ffp_alloc(sightings, sizeof(int)),
                    .nearness = ffp_alloc(sightings, sizeof(double))};
    for (int i = 0; i < tracks->n; i++)
        for (int k = 0; k < tracks->tracks[i].n; k++) t.track[tracks->tracks[i].first + k] = i;
    ffp_turning_set_stops(&t);
    return t;
}

void ffp_turning_free(FfpTurning *t) {
    ffp_free(t->off), ffp_free(t->next), ffp_free(t->track), ffp_free(t->nearness);
    *t = (FfpTurning){0};
}

void ffp_turning_drop_still(FfpTurning *t) {
    for (int i = 0; i < t->tracks->n; i++) {
        const FfpTrack *track = &t->tracks->tracks[i];
        FfpSighting *s = t->tracks->sightings + track->first;
        for (int a = 0; a < track->n; a++) {
            int same = 0;
            for (int b = 0; b < track->n; b++)
                same += hypot(s[a].at[0] - s[b].at[0], s[a].at[1] - s[b].at[1]) < STILL;
            s[a].used = same < STILL_LEAST || 2 * same < track->n;
        }
    }
}

// --- Devices and axis as they are tried. ---

typedef struct Tried {
    FfpDevices devices;
    FfpBundleDevice cameras[FFP_PLACES_MAX]; // one and the same
    FfpRigid camera, places[FFP_PLACES_MAX];
    bool known[FFP_PLACES_MAX];
    FfpRigid turns[FFP_PLACES_MAX][FFP_TURNING_NEXT]; // from each stop to the next ones, camera's frame
} Tried;

// X -> R(u, angle) (X - p) + p
static FfpRigid turn_about(const FfpAxis *axis, double angle) {
    FfpRigid turn;
    double vector[3];
    for (int k = 0; k < 3; k++) vector[k] = angle * axis->direction[k];
    ffp_rotation_from_vector(vector, turn.r);
    for (int k = 0; k < 3; k++) turn.t[k] = axis->point[k] - ffp_dot(turn.r + 3 * (size_t)k, axis->point);
    return turn;
}

static void set_turns(const FfpTurning *t, const FfpAxis *axis, const double *off, Tried *out) {
    for (int p = 0; p < t->tracks->n_places; p++)
        for (int k = 0; k < FFP_TURNING_NEXT; k++) {
            const int q = t->next[p][k];
            if (q < 0) continue;
            const double by = t->given[q] - t->given[p];
            out->turns[p][k] = turn_about(axis, (t->reversed ? -by : by) + off[q] - off[p]);
        }
}

static void arrange(const FfpTurning *t, const double *optics, const FfpRigid *camera, const FfpAxis *axis,
                    const double *off, Tried *out) {
    out->camera = *camera;
    const FfpBundleDevice one = ffp_bundle_camera(t->tracks, optics);
    for (int p = 0; p < t->tracks->n_places; p++) {
        out->cameras[p] = one;
        out->places[p] = *camera;
        out->known[p] = true;
    }
    out->devices =
        (FfpDevices){out->cameras, ffp_bundle_projector(t->tracks, optics), out->places, out->known};
    set_turns(t, axis, off, out);
}

// Where a point of a stop, in the camera's frame, is seen and lit once it is turned. False: behind a device.
static bool turn_on(const Tried *tried, const FfpRigid *turn, const double point[3], double seen[2],
                    double panel[2]) {
    double turned[3], lit[3], from[3];
    ffp_rigid_apply(turn, point, turned);
    for (int k = 0; k < 3; k++) from[k] = turned[k] - tried->camera.t[k];
    for (int k = 0; k < 3; k++)
        lit[k] = tried->camera.r[k] * from[0] + tried->camera.r[3 + k] * from[1] +
                 tried->camera.r[6 + k] * from[2];
    return ffp_bundle_pixel(&tried->cameras[0], turned, seen) &&
           ffp_bundle_pixel(&tried->devices.projector, lit, panel);
}

// The sighting of a stop's spot that a place on the panel falls on; -1: none.
static int sighting_at(const FfpTracks *t, const double panel[2], int stop) {
    const double column = floor(panel[0] / t->pitch), row = floor(panel[1] / t->pitch);
    if (stop < 0 || !(column >= 0 && row >= 0 && column < t->columns && row < t->rows)) return -1;
    const int track = t->grid[(size_t)row * (size_t)t->columns + (size_t)column];
    for (int k = 0; track >= 0 && k < t->tracks[track].n; k++) {
        const FfpSighting *s = &t->sightings[t->tracks[track].first + k];
        if (s->place == stop) return s->used ? t->tracks[track].first + k : -1;
    }
    return -1;
}

// From where the place on the panel is seen by a sighting's stop, to `seen`.
static void miss(const FfpTurning *t, int sighting, const double panel[2], const double seen[2],
                 double out[2]) {
    const FfpSighting *s = &t->tracks->sightings[sighting];
    const double *spot = t->tracks->tracks[t->track[sighting]].panel;
    const double u = panel[0] - spot[0], v = panel[1] - spot[1];
    for (int k = 0; k < 2; k++) out[k] = seen[k] - (s->at[k] + s->slope[2 * k] * u + s->slope[2 * k + 1] * v);
}

// The projector's ray through the spot of a sighting.
static bool light(const FfpTurning *t, const FfpBundleDevice *projector, int sighting, double ray[3]) {
    return ffp_bundle_ray(projector, t->tracks->tracks[t->track[sighting]].panel, ray);
}

// The point of a sighting in the camera's frame and how far from its pixel that is seen; its nearness, or 0.
static double solve(const FfpTurning *t, const Tried *tried, int index, const double ray[3], double point[3],
                    double out[2]) {
    double lit[3];
    const double nearness =
        ffp_devices_nearness(&tried->devices, ray, t->tracks->sightings + index, 1, t->nearness[index], out);
    if (!(nearness > 0)) return 0;
    for (int k = 0; k < 3; k++) lit[k] = ray[k] / nearness;
    ffp_rigid_apply(&tried->camera, lit, point);
    return nearness;
}

static void try_as_is(const FfpTurning *t, Tried *tried) {
    arrange(t, t->optics, &t->camera, &t->axis, t->off, tried);
}

bool ffp_turning_point(const FfpTurning *t, int sighting, double point[3]) {
    const FfpSighting *s = &t->tracks->sightings[sighting];
    double ray[3], lit[3];
    const FfpBundleDevice projector = ffp_bundle_projector(t->tracks, t->optics);
    if (!s->used || !(t->nearness[sighting] > 0) || !light(t, &projector, sighting, ray)) return false;
    for (int k = 0; k < 3; k++) lit[k] = ray[k] / t->nearness[sighting];
    ffp_rigid_apply(&t->camera, lit, point);
    return true;
}

double ffp_turning_parallax(const FfpTurning *t) {
    real *angles = ffp_alloc((size_t)t->tracks->n_sightings + 1, sizeof *angles);
    size_t n = 0;
    for (int i = 0; i < t->tracks->n_sightings; i++) {
        double point[3], from[3];
        if (!ffp_turning_point(t, i, point)) continue;
        for (int k = 0; k < 3; k++) from[k] = point[k] - t->camera.t[k];
        ffp_unit(point), ffp_unit(from);
        angles[n++] = (real)(acos(fmin(1, ffp_dot(point, from))) * 180 / FFP_PI_DOUBLE);
    }
    const double median = n > 0 ? (double)ffp_median(angles, n) : 0;
    ffp_free(angles);
    return median;
}

void ffp_turning_triangulate(FfpTurning *t, int stride) {
    Tried tried;
    try_as_is(t, &tried);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < t->tracks->n_sightings; i += stride) {
        double ray[3], point[3], off[2];
        t->nearness[i] = 0;
        if (t->tracks->sightings[i].used && light(t, &tried.devices.projector, i, ray))
            t->nearness[i] = solve(t, &tried, i, ray, point, off);
    }
}

double ffp_turning_disagreement(const FfpTurning *t, int stride, double scale) {
    Tried tried;
    double sum = 0;
    int n = 0;
    try_as_is(t, &tried);
    for (int i = 0; i < t->tracks->n_sightings; i += stride) {
        const int stop = t->tracks->sightings[i].place;
        double point[3], off[2];
        if (t->next[stop][0] < 0 || !ffp_turning_point(t, i, point)) continue;
        double seen[2], panel[2];
        const int met = turn_on(&tried, &tried.turns[stop][0], point, seen, panel)
                            ? sighting_at(t->tracks, panel, t->next[stop][0])
                            : -1;
        n++, sum++;
        if (met < 0) continue;
        miss(t, met, panel, seen, off);
        sum -= 1 / (1 + (off[0] * off[0] + off[1] * off[1]) / (scale * scale));
    }
    return n > 0 ? sum / n : 1;
}

// The sighting that one meets at the stop after its own, within `far` pixels or not; -1: none.
static int meet(const FfpTurning *t, const Tried *tried, int sighting, double far, bool *near) {
    const int stop = t->tracks->sightings[sighting].place;
    double point[3], seen[2], panel[2], off[2];
    if (t->next[stop][0] < 0 || !ffp_turning_point(t, sighting, point) ||
        !turn_on(tried, &tried->turns[stop][0], point, seen, panel))
        return -1;
    const int met = sighting_at(t->tracks, panel, t->next[stop][0]);
    if (met < 0) return -1;
    miss(t, met, panel, seen, off);
    *near = hypot(off[0], off[1]) < far;
    return met;
}

void ffp_turning_agreement(const FfpTurning *t, double far, double *shares) {
    int agree[FFP_PLACES_MAX] = {0}, all[FFP_PLACES_MAX] = {0};
    Tried tried;
    try_as_is(t, &tried);
    for (int i = 0; i < t->tracks->n_sightings; i++) {
        const int stop = t->tracks->sightings[i].place, next = t->next[stop][0];
        bool near;
        if (meet(t, &tried, i, far, &near) < 0) continue;
        all[stop]++, all[next]++;
        agree[stop] += near, agree[next] += near;
    }
    for (int p = 0; p < t->tracks->n_places; p++) shares[p] = all[p] > 0 ? (double)agree[p] / all[p] : -1;
}

double ffp_turning_likeness(const FfpTurning *t, double far) {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    Tried tried;
    try_as_is(t, &tried);
    for (int i = 0; i < t->tracks->n_sightings; i++) {
        bool near;
        const int met = meet(t, &tried, i, far, &near);
        if (met < 0 || !near) continue;
        const double x = log(fmax((double)t->tracks->sightings[i].light, LIGHT_LEAST)),
                     y = log(fmax((double)t->tracks->sightings[met].light, LIGHT_LEAST));
        n++, a += x, b += y, aa += x * x, bb += y * y, ab += x * y;
    }
    const double spread = (n * aa - a * a) * (n * bb - b * b);
    return n >= LIKENESS_POINTS && spread > 0 ? (n * ab - a * b) / sqrt(spread) : 0;
}

// --- Fitting. ---

typedef struct Fit {
    FfpTurning *turning;
    int n, *sightings;            // [n] those that take part
    FfpBundleDevice projector;    // as the turning has it,
    double (*rays)[3];            // [n] and its rays through their spots, which most derivatives leave alone
    int (*met)[FFP_TURNING_NEXT]; // [n] the sightings that each meets at the next stops; -1: none
    int numbers, count;
    double scale, apart, firm;
} Fit;

static void moved(const Fit *fit, const double *by, double optics[FFP_BUNDLE_OPTICS], FfpRigid *camera,
                  FfpAxis *axis, double off[FFP_PLACES_MAX]) {
    const FfpTurning *t = fit->turning;
    double turn[9];
    for (int i = 0; i < FFP_BUNDLE_OPTICS; i++) optics[i] = t->optics[i] + by[i];
    ffp_rotation_from_vector(by + CAMERA, turn);
    ffp_rotation_product(turn, t->camera.r, camera->r);
    for (int k = 0; k < 3; k++) camera->t[k] = t->camera.t[k] + by[CAMERA + 3 + k];
    ffp_axis_move(&t->axis, by + AXIS, axis);
    for (int p = 0; p < t->tracks->n_places; p++)
        off[p] = t->off[p] + (ANGLES + p - 1 < fit->numbers && p > 0 ? by[ANGLES + p - 1] : 0);
}

static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const FfpTurning *t = fit->turning;
    double optics[FFP_BUNDLE_OPTICS], off[FFP_PLACES_MAX];
    FfpRigid camera;
    FfpAxis axis;
    Tried tried;
    moved(fit, by, optics, &camera, &axis, off);
    arrange(t, optics, &camera, &axis, off, &tried);
    const FfpBundleDevice *projector = &tried.devices.projector;
    const bool as_is = memcmp(projector, &fit->projector, sizeof *projector) == 0;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < fit->n; i++) {
        const int index = fit->sightings[i], stop = t->tracks->sightings[index].place;
        double *at = out + EACH * (size_t)i, own[3], point[3], seen[2], panel[2];
        const double *ray = as_is ? fit->rays[i] : own;
        if (!as_is) light(t, projector, index, own);
        at[0] = at[1] = 0;
        for (int k = 2; k < EACH; k++) at[k] = INFINITY;
        if (!(solve(t, &tried, index, ray, point, at) > 0)) continue;
        for (int k = 0; k < FFP_TURNING_NEXT; k++)
            if (fit->met[i][k] >= 0 && turn_on(&tried, &tried.turns[stop][k], point, seen, panel))
                miss(t, fit->met[i][k], panel, seen, at + 2 + 2 * (ptrdiff_t)k);
    }
    double *priors = out + EACH * (size_t)fit->n;
    ffp_optics_unusual(optics, &t->usual, fit->firm, sqrt(ffp_dot(camera.t, camera.t)), priors);
    for (int p = 1; p < t->tracks->n_places && ANGLES < fit->numbers; p++)
        priors[FFP_BUNDLE_PRIORS + p - 1] = fit->firm * off[p] / t->angles_known;
}

static void set_rays(Fit *fit) {
    fit->projector = ffp_bundle_projector(fit->turning->tracks, fit->turning->optics);
    for (int i = 0; i < fit->n; i++) light(fit->turning, &fit->projector, fit->sightings[i], fit->rays[i]);
}

static void move(void *state, const double *by) {
    Fit *fit = state;
    FfpTurning *t = fit->turning;
    double optics[FFP_BUNDLE_OPTICS], off[FFP_PLACES_MAX];
    FfpRigid camera;
    FfpAxis axis;
    moved(fit, by, optics, &camera, &axis, off);
    memcpy(t->optics, optics, sizeof optics);
    memcpy(t->off, off, (size_t)t->tracks->n_places * sizeof *off);
    t->camera = camera, t->axis = axis;
    Tried tried;
    try_as_is(t, &tried);
    set_rays(fit);
    for (int i = 0; i < fit->n; i++) {
        double point[3], unused[2];
        t->nearness[fit->sightings[i]] = solve(t, &tried, fit->sightings[i], fit->rays[i], point, unused);
    }
}

// Geman and McClure's function of each pair's length, in pixels squared.
static double weigh_pair(const double pair[2], double scale, double weights[2]) {
    const double square = (pair[0] * pair[0] + pair[1] * pair[1]) / (scale * scale);
    weights[0] = weights[1] = isfinite(square) ? 1 / ((1 + square) * (1 + square)) : 0;
    return scale * scale * (isfinite(square) ? square / (1 + square) : 1);
}

static double weigh(const void *state, const double *residuals, double *weights) {
    const Fit *fit = state;
    double sum = 0;
    for (int i = 0; i < fit->n; i++) {
        const size_t at = EACH * (size_t)i;
        sum += weigh_pair(residuals + at, SIGHTING_SCALE, weights + at);
        for (size_t k = at + 2; k < at + EACH; k += 2)
            sum += weigh_pair(residuals + k, fit->scale, weights + k);
    }
    for (int i = EACH * fit->n; i < fit->count; i++) weights[i] = 1, sum += residuals[i] * residuals[i];
    return sum;
}

static void set_met(Fit *fit) {
    const FfpTurning *t = fit->turning;
    Tried tried;
    try_as_is(t, &tried);
    for (int i = 0; i < fit->n; i++) {
        const int stop = t->tracks->sightings[fit->sightings[i]].place;
        double point[3], seen[2], panel[2];
        const bool there = ffp_turning_point(t, fit->sightings[i], point);
        for (int k = 0; k < FFP_TURNING_NEXT; k++)
            fit->met[i][k] =
                there && t->next[stop][k] >= 0 && turn_on(&tried, &tried.turns[stop][k], point, seen, panel)
                    ? sighting_at(t->tracks, panel, t->next[stop][k])
                    : -1;
    }
}

static Fit fit_new(FfpTurning *t, int stride, double scale) {
    const FfpTracks *tracks = t->tracks;
    const size_t most = (size_t)tracks->n_sightings + 1;
    Fit fit = {.turning = t,
               .sightings = ffp_alloc(most, sizeof(int)),
               .rays = ffp_alloc(most, sizeof *fit.rays),
               .met = ffp_alloc(most, sizeof *fit.met)};
    for (int i = 0; i < tracks->n_sightings; i += stride)
        if (tracks->sightings[i].used && t->nearness[i] > 0) fit.sightings[fit.n++] = i;
    set_rays(&fit);
    set_met(&fit);
    fit.scale = scale;
    fit.apart = sqrt(fmax(1, (double)fit.n / APART));
    fit.firm = fit.apart * fmax(t->surface > 0 ? fmin(t->surface, FFP_BUNDLE_NOISE) : FFP_BUNDLE_NOISE,
                                NOISE_SHARE * scale);
    fit.numbers = ANGLES + (t->angles_known > 0 ? tracks->n_places - 1 : 0);
    fit.count = EACH * fit.n + FFP_BUNDLE_PRIORS + fit.numbers - ANGLES;
    return fit;
}

static void keep_deviations(const Fit *fit, const double *covariance) {
    FfpTurning *t = fit->turning;
    const size_t n = (size_t)fit->numbers;
    const double apart = sqrt(fmax(1, (double)fit->n / APART_TOLD));
    for (size_t i = 0; i < AXIS; i++) t->deviation[i] = apart * sqrt(covariance[n * i + i]);
    const double *c = covariance + n * AXIS + AXIS, a = c[0], b = c[n + 1];
    t->tilt = apart * sqrt((a + b) / 2 + hypot((a - b) / 2, c[1]));
    t->shift = apart * sqrt(fmax(c[(n + 1) * FFP_AXIS_SIDEWAYS], c[(n + 1) * FFP_AXIS_DISTANCE]));
}

typedef struct SeenAsIs {
    const FfpTurning *turning;
    Tried tried;
} SeenAsIs;

static bool miss_alone(const void *state, int index, double off[2]) {
    const SeenAsIs *as_is = state;
    const FfpTurning *t = as_is->turning;
    double ray[3], point[3];
    return t->tracks->sightings[index].used && t->nearness[index] > 0 &&
           light(t, &as_is->tried.devices.projector, index, ray) &&
           solve(t, &as_is->tried, index, ray, point, off) > 0;
}

static bool miss_at(const void *state, int track, int place, double off[2]) {
    const FfpTracks *t = ((const SeenAsIs *)state)->turning->tracks;
    for (int k = 0; k < t->tracks[track].n; k++)
        if (t->sightings[t->tracks[track].first + k].place == place)
            return miss_alone(state, t->tracks[track].first + k, off);
    return false;
}

void ffp_turning_stop_errors(const FfpTurning *t, double *errors) {
    const FfpTracks *tracks = t->tracks;
    SeenAsIs as_is = {.turning = t};
    real *found = ffp_alloc((size_t)tracks->n_sightings + 1, sizeof *found);
    try_as_is(t, &as_is.tried);
    for (int p = 0; p < tracks->n_places; p++) {
        size_t n = 0;
        for (int i = 0; i < tracks->n_sightings; i++) {
            double off[2];
            if (tracks->sightings[i].place == p && miss_alone(&as_is, i, off))
                found[n++] = (real)hypot(off[0], off[1]);
        }
        errors[p] = n > 0 ? (double)ffp_median(found, n) : -1;
    }
    ffp_free(found);
}

static void measure_noise(FfpTurning *t) {
    SeenAsIs as_is = {.turning = t};
    ffp_turning_triangulate(t, 1);
    try_as_is(t, &as_is.tried);
    t->noise = ffp_tracks_noise(t->tracks, &as_is, miss_at);
}

// Root mean square of the sightings, and the median of what was turned.
static void measure(const Fit *fit) {
    FfpTurning *t = fit->turning;
    double *found = ffp_alloc((size_t)fit->count, sizeof *found), *none, sum = 0;
    real *turned = ffp_alloc((size_t)fit->count + 1, sizeof *turned);
    size_t n = 0;
    none = ffp_alloc((size_t)fit->numbers, sizeof *none);
    differences(fit, none, found);
    for (int i = 0; i < fit->n; i++) {
        const double *at = found + EACH * (size_t)i;
        sum += fmin(at[0] * at[0] + at[1] * at[1], 9 * SIGHTING_SCALE * SIGHTING_SCALE);
        for (int k = 2; k < EACH; k += 2)
            if (hypot(at[k], at[k + 1]) < 3 * fit->scale) turned[n++] = (real)hypot(at[k], at[k + 1]);
    }
    t->rms = fit->n > 0 ? sqrt(sum / fit->n) : INFINITY;
    t->surface = n > 0 ? (double)ffp_median(turned, n) : INFINITY;
    ffp_free(found), ffp_free(turned), ffp_free(none);
}

void ffp_turning_fit(FfpTurning *t, int stride, double scale, int steps, bool deviations) {
    ffp_turning_triangulate(t, stride);
    Fit fit = fit_new(t, stride, scale);
    double *step = ffp_alloc((size_t)fit.numbers, sizeof *step);
    double *covariance =
        deviations ? ffp_alloc((size_t)fit.numbers * (size_t)fit.numbers, sizeof(double)) : NULL;
    for (int i = 0; i < fit.numbers; i++) step[i] = 1e-5;
    ffp_least_squares(&(FfpLeastSquares){.state = &fit,
                                         .numbers = fit.numbers,
                                         .count = fit.count,
                                         .solved = fit.n,
                                         .differences = differences,
                                         .move = move,
                                         .weigh = weigh,
                                         .step = step,
                                         .steps = steps,
                                         .worth = WORTH,
                                         .end = deviations ? &t->end : NULL},
                      covariance);
    if (deviations) keep_deviations(&fit, covariance);
    measure(&fit);
    if (deviations) measure_noise(t);
    ffp_free(covariance), ffp_free(step), ffp_free(fit.sightings), ffp_free(fit.rays), ffp_free(fit.met);
}
