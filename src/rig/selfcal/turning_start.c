// A first arrangement of a turntable, from nothing but the angles: optics that are usual, the motion between
// the devices that the codes give with them, and axes all around, by how well the surfaces turn into each
// other.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/turning.h"

enum { POINTS = 200, PAIRS = 1500, MOVING_LEAST = 200, DIRECTIONS = 160, ARRANGEMENTS = 12, SHORT = 500 };
enum { CANDIDATES = 48, WAVE = 12, FINALISTS = 4, OF_ONE = 6, SHORT_STEPS = 4 };
#define TOLERANCE 2.5    // pixels, of the essential matrix with optics that are guessed
#define INSIDE_SHARE 0.6 // of what the best optics explain
#define COARSE 0.15      // scale of a first look, in the spread of the object in the picture
#define MIDDLE 0.5       // of that: where most candidates are given up
#define LEVEL 1.7        // from one scale to the next
#define FINE 2.0         // pixels
#define SAME 0.94        // cosine: 20 degrees
#define SURE 0.6         // disagreement below which no more are tried
#define AGREED 0.7       // disagreement of an axis that is one
#define ALIKE 0.1  // by which the light of another axis must agree worse, where its surfaces agree as well
#define ALONG 0.2  // disagreement by which an axis along the view must be better to be tried first
#define CLEAR 0.05 // by which another axis must be worse

static const double camera_guesses[] = {1.3, 0.9, 2.0, 3.0}; // focal lengths, of the width
static const double projector_guesses[] = {1.4, 0.9, 2.0, 0.6, 3.0};
static const double shift_guesses[] = {0, 0.28, -0.28}; // of the projector's lens, of the width
static const double depths[] = {0.2, 0.5, 0.8, 1.2, 1.7}, sideways[] = {-0.8, -0.4, 0, 0.4, 0.8};
enum {
    CAMERAS = sizeof camera_guesses / sizeof *camera_guesses,
    PROJECTORS = sizeof projector_guesses / sizeof *projector_guesses,
    SHIFTS = sizeof shift_guesses / sizeof *shift_guesses,
    DEPTHS = sizeof depths / sizeof *depths,
    SIDES = sizeof sideways / sizeof *sideways,
    GUESSES = CAMERAS * PROJECTORS * SHIFTS
};

// --- Optics and the motion between the devices. ---

typedef struct Arrangement {
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid camera;
    int inside;
} Arrangement;

static void set_optics(const FfpTurning *t, int guess, double optics[FFP_BUNDLE_OPTICS]) {
    memset(optics, 0, FFP_BUNDLE_OPTICS * sizeof *optics);
    optics[FFP_BUNDLE_CAMERA_FOCAL] =
        t->usual.focal.deviation > 0 ? t->usual.focal.log
                                     : log(camera_guesses[guess / (PROJECTORS * SHIFTS)] * t->tracks->width);
    optics[FFP_BUNDLE_PROJECTOR_FOCAL] =
        log(projector_guesses[guess / SHIFTS % PROJECTORS] * t->tracks->panel_width);
    optics[FFP_BUNDLE_PROJECTOR_Y] = shift_guesses[guess % SHIFTS];
}

static bool relate(const FfpTurning *t, const int *sightings, int n, Arrangement *a, FfpError *err) {
    double *lit = ffp_alloc((size_t)n, 2 * sizeof(double)), *seen = ffp_alloc((size_t)n, 2 * sizeof(double));
    unsigned char *inside = ffp_alloc((size_t)n, 1);
    const FfpBundleDevice camera = ffp_bundle_camera(t->tracks, a->optics),
                          projector = ffp_bundle_projector(t->tracks, a->optics);
    bool found = false;
    for (int i = 0; i < n; i++) {
        double ray[3];
        ffp_bundle_ray(&projector, t->tracks->tracks[t->track[sightings[i]]].panel, ray);
        memcpy(lit + 2 * (size_t)i, ray, 2 * sizeof *ray);
        ffp_bundle_ray(&camera, t->tracks->sightings[sightings[i]].at, ray);
        memcpy(seen + 2 * (size_t)i, ray, 2 * sizeof *ray);
    }
    const bool ok =
        ffp_cv_relative(lit, seen, n, TOLERANCE / camera.fx, a->camera.r, a->camera.t, inside, &found, err);
    a->inside = 0;
    for (int i = 0; found && i < n; i++) a->inside += inside[i];
    ffp_free(lit), ffp_free(seen), ffp_free(inside);
    return ok;
}

static int count_moving(const FfpTurning *t) {
    int n = 0;
    for (int i = 0; i < t->tracks->n_sightings; i++) n += t->tracks->sightings[i].used;
    return n;
}

// Every so many of the sightings that move, `most` at most; their number.
static int choose(const FfpTurning *t, int most, int *out) {
    const int stride = count_moving(t) / most + 1;
    int n = 0, at = 0;
    for (int i = 0; i < t->tracks->n_sightings; i++)
        if (t->tracks->sightings[i].used && at++ % stride == 0) out[n++] = i;
    return n;
}

// The optics that explain most, best first; their number.
static int arrange_all(const FfpTurning *t, Arrangement out[GUESSES], FfpError *err) {
    int *sightings = ffp_alloc(PAIRS, sizeof *sightings), n = choose(t, PAIRS, sightings), found = 0;
    const int guesses = t->usual.focal.deviation > 0 ? PROJECTORS * SHIFTS : GUESSES;
    bool ok = true;
    for (int g = 0; ok && g < guesses; g++) {
        Arrangement a;
        set_optics(t, g, a.optics);
        ok = relate(t, sightings, n, &a, err);
        if (!ok || a.inside == 0) continue;
        int at = found++;
        for (; at > 0 && out[at - 1].inside < a.inside; at--) out[at] = out[at - 1];
        out[at] = a;
        ffp_cancel_point();
    }
    ffp_free(sightings);
    if (!ok) return -1;
    int kept = found;
    while (kept > 0 && (kept > ARRANGEMENTS || out[kept - 1].inside < INSIDE_SHARE * out[0].inside)) kept--;
    return kept;
}

// --- The axis. ---

typedef struct Candidate {
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid camera;
    FfpAxis axis;
    bool reversed;
    double cost;
} Candidate;

typedef struct Cloud { // of the points that are turned, in the camera's frame
    double middle[3], spread;
} Cloud;

static Cloud cloud_of(const FfpTurning *t, int stride) {
    const size_t most = (size_t)t->tracks->n_sightings / (size_t)stride + 1;
    double(*points)[3] = ffp_alloc(most, sizeof *points);
    real *values = ffp_alloc(most, sizeof *values);
    Cloud c = {.spread = 0};
    size_t n = 0;
    for (int i = 0; i < t->tracks->n_sightings; i += stride)
        if (ffp_turning_point(t, i, points[n])) n++;
    for (int k = 0; k < 3 && n > 0; k++) {
        for (size_t i = 0; i < n; i++) values[i] = (real)points[i][k];
        c.middle[k] = (double)ffp_median(values, n);
    }
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) points[i][k] -= c.middle[k];
        values[i] = (real)sqrt(ffp_dot(points[i], points[i]));
    }
    if (n > 0) c.spread = (double)ffp_median(values, n);
    ffp_free(values), ffp_free(points);
    return c;
}

// Directions all around, evenly (a Fibonacci lattice over half a sphere; Gonzalez 2010).
static void direction_of(int index, double out[3]) {
    const double height = (index + 0.5) / DIRECTIONS, round = index * FFP_PI_DOUBLE * (3 - sqrt(5)),
                 radius = sqrt(1 - height * height);
    out[0] = radius * cos(round), out[1] = -height, out[2] = radius * sin(round);
}

// Into a list that is in order; what is at `at`, or the worst, falls out.
static void offer(Candidate *list, int at, const Candidate *c) {
    if (!(c->cost < list[at].cost)) return;
    for (; at > 0 && list[at - 1].cost > c->cost; at--) list[at] = list[at - 1];
    list[at] = *c;
}

// Into a list of one of each direction.
static void offer_direction(Candidate list[OF_ONE], const Candidate *c) {
    int at = OF_ONE - 1;
    for (int i = 0; i < OF_ONE; i++)
        if (list[i].cost <= 1 && list[i].reversed == c->reversed &&
            fabs(ffp_dot(list[i].axis.direction, c->axis.direction)) >= SAME) {
            at = i;
            break;
        }
    offer(list, at, c);
}

// The best axis of one direction, among places behind the middle of what is seen. Axes along the view come
// later than they agree: about them what is seen stays in the picture, whatever its shape.
static Candidate best_place(const FfpTurning *from, const Cloud *cloud, int index, int stride, double scale) {
    FfpTurning t = *from;
    Candidate best = {.cost = 2};
    double view[3], side[3];
    direction_of(index / 2, t.axis.direction);
    t.reversed = index % 2 != 0;
    const double along = ffp_dot(cloud->middle, t.axis.direction);
    for (int k = 0; k < 3; k++) view[k] = cloud->middle[k] - along * t.axis.direction[k];
    if (!(ffp_unit(view) > 0)) return best;
    ffp_cross(t.axis.direction, view, side);
    for (int d = 0; d < DEPTHS; d++)
        for (int s = 0; s < SIDES; s++) {
            for (int k = 0; k < 3; k++)
                t.axis.point[k] =
                    cloud->middle[k] + cloud->spread * (depths[d] * view[k] + sideways[s] * side[k]);
            const double cost = ffp_turning_disagreement(&t, stride, scale);
            if (cost < best.cost) best.cost = cost, best.axis = t.axis, best.reversed = t.reversed;
        }
    best.cost += ALONG * t.axis.direction[2] * t.axis.direction[2];
    return best;
}

static void search_axes(const FfpTurning *t, double scale, Candidate best[OF_ONE]) {
    const int stride = t->tracks->n_sightings / POINTS + 1;
    const Cloud cloud = cloud_of(t, stride);
    Candidate *all = ffp_alloc(2 * DIRECTIONS, sizeof *all);
#pragma omp parallel for schedule(dynamic, 8)
    for (int i = 0; i < 2 * DIRECTIONS; i++) all[i] = best_place(t, &cloud, i, stride, scale);
    for (int i = 0; i < 2 * DIRECTIONS; i++) offer_direction(best, &all[i]);
    ffp_free(all);
}

// Median distance of what turns from its middle in the picture, pixels.
static double spread_in_picture(const FfpTurning *t) {
    const FfpTracks *tracks = t->tracks;
    real *x = ffp_alloc((size_t)tracks->n_sightings + 1, sizeof *x),
         *y = ffp_alloc((size_t)tracks->n_sightings + 1, sizeof *y);
    size_t n = 0;
    for (int i = 0; i < tracks->n_sightings; i++) {
        if (!tracks->sightings[i].used) continue;
        x[n] = (real)tracks->sightings[i].at[0], y[n++] = (real)tracks->sightings[i].at[1];
    }
    const double middle[2] = {(double)ffp_median(x, n), (double)ffp_median(y, n)};
    n = 0;
    for (int i = 0; i < tracks->n_sightings; i++)
        if (tracks->sightings[i].used)
            x[n++] =
                (real)hypot(tracks->sightings[i].at[0] - middle[0], tracks->sightings[i].at[1] - middle[1]);
    const double spread = (double)ffp_median(x, n);
    ffp_free(x), ffp_free(y);
    return spread;
}

// --- From candidates to one. ---

static void take(FfpTurning *t, const Candidate *c) {
    memcpy(t->optics, c->optics, sizeof t->optics);
    memset(t->off, 0, (size_t)t->tracks->n_places * sizeof *t->off);
    t->camera = c->camera, t->axis = c->axis, t->reversed = c->reversed;
    memset(t->nearness, 0, (size_t)t->tracks->n_sightings * sizeof *t->nearness);
}

// Fits a candidate from one scale down to another.
static void polish(FfpTurning *t, Candidate *c, double from, double to) {
    const int stride = t->tracks->n_sightings / SHORT + 1;
    take(t, c);
    const int levels = (int)ceil(log(fmax(from / to, 1)) / log(LEVEL));
    for (int i = 0; i <= levels; i++)
        ffp_turning_fit(t, stride, fmax(from * pow(LEVEL, -i), to), SHORT_STEPS, false);
    c->cost = ffp_turning_disagreement(t, stride, to);
    memcpy(c->optics, t->optics, sizeof c->optics);
    c->camera = t->camera, c->axis = t->axis;
}

static int by_cost(const void *a, const void *b) {
    const double first = ((const Candidate *)a)->cost, second = ((const Candidate *)b)->cost;
    return (first > second) - (first < second);
}

static bool same_axis(const Candidate *a, const Candidate *b) {
    const double turned = ffp_dot(a->axis.direction, b->axis.direction);
    return (a->reversed == b->reversed ? turned : -turned) > SAME;
}

// The same axis about which all turns the other way: fluted and square things look alike both ways.
static Candidate twin_of(FfpTurning *t, const Candidate *best) {
    Candidate twin = *best;
    twin.reversed = !twin.reversed;
    polish(t, &twin, FINE, FINE);
    return twin;
}

// How alike the light is where surfaces meet.
static double likeness_of(FfpTurning *t, const Candidate *c) {
    take(t, c);
    ffp_turning_triangulate(t, 1);
    return ffp_turning_likeness(t, 2 * FINE);
}

// Of candidates whose surfaces agree as well as the best one's, the one whose light does; `unclear`: that
// of another axis does nearly as well.
static int choose_by_light(FfpTurning *t, const Candidate *list, int n, bool *unclear) {
    double likeness[FINALISTS + 1], other = -1;
    int best = 0;
    for (int i = 0; i < n; i++) {
        likeness[i] = list[i].cost - list[0].cost < CLEAR ? likeness_of(t, &list[i]) : -1;
        if (likeness[i] > likeness[best]) best = i;
    }
    for (int i = 0; i < n; i++)
        if (!same_axis(&list[i], &list[best])) other = fmax(other, likeness[i]);
    *unclear = other > -1 && likeness[best] - other < ALIKE;
    return best;
}

// The best FINALISTS of some candidates, fitted, best first; their number.
static int fit_wave(FfpTurning *t, Candidate *wave, int n, double scale) {
    const double middle = fmax(MIDDLE * scale, FINE);
    for (int i = 0; i < n; i++) {
        polish(t, &wave[i], scale, middle);
        ffp_cancel_point();
    }
    qsort(wave, (size_t)n, sizeof *wave, by_cost);
    n = n < FINALISTS ? n : FINALISTS;
    for (int i = 0; i < n; i++) polish(t, &wave[i], middle, FINE);
    qsort(wave, (size_t)n, sizeof *wave, by_cost);
    return n;
}

// False: none is one. `unclear`: another is as good. The less likely ones are tried where the others fail.
static bool choose_one(FfpTurning *t, Candidate *list, double scale, bool *unclear) {
    Candidate finalists[FINALISTS + 1] = {{.cost = 2}};
    int all = 0, n = 0;
    while (all < CANDIDATES && list[all].cost <= 1) all++;
    for (int first = 0; first < all && !(finalists[0].cost < SURE); first += WAVE) {
        const int found = fit_wave(t, list + first, all - first < WAVE ? all - first : WAVE, scale);
        if (!(list[first].cost < finalists[0].cost)) continue;
        n = found;
        memcpy(finalists, list + first, (size_t)n * sizeof *finalists);
    }
    if (!(finalists[0].cost < AGREED)) return false;
    finalists[n] = twin_of(t, &finalists[0]);
    qsort(finalists, (size_t)++n, sizeof *finalists, by_cost);
    take(t, &finalists[choose_by_light(t, finalists, n, unclear)]);
    ffp_turning_triangulate(t, 1);
    return true;
}

static void search_arrangement(FfpTurning *t, const Arrangement *a, double scale,
                               Candidate list[CANDIDATES]) {
    Candidate best[OF_ONE];
    for (int k = 0; k < OF_ONE; k++) best[k].cost = 2;
    memcpy(t->optics, a->optics, sizeof t->optics);
    t->camera = a->camera;
    memset(t->nearness, 0, (size_t)t->tracks->n_sightings * sizeof *t->nearness);
    ffp_turning_triangulate(t, t->tracks->n_sightings / POINTS + 1);
    search_axes(t, scale, best);
    for (int k = 0; k < OF_ONE && best[k].cost <= 1; k++) {
        memcpy(best[k].optics, t->optics, sizeof t->optics);
        best[k].camera = t->camera;
        offer(list, CANDIDATES - 1, &best[k]);
    }
}

static bool search(FfpTurning *t, bool *found, bool *unclear, FfpError *err) {
    Arrangement *arrangements = ffp_alloc(GUESSES, sizeof *arrangements);
    Candidate list[CANDIDATES];
    for (int i = 0; i < CANDIDATES; i++) list[i].cost = 2;
    const int n = arrange_all(t, arrangements, err);
    const double scale = fmax(COARSE * spread_in_picture(t), FINE);
    const FfpTask task = ffp_task("looking for the axis", n > 0 ? n : 1);
    for (int i = 0; i < n; i++) {
        search_arrangement(t, &arrangements[i], scale, list);
        ffp_task_step(&task, i + 1, NULL);
        ffp_cancel_point();
    }
    ffp_task_end(&task);
    ffp_free(arrangements);
    *found = n >= 0 && choose_one(t, list, scale, unclear);
    return n >= 0;
}

// A lens that is known is held at first, and forgotten where that leads to nothing.
static bool search_by_lens(FfpTurning *t, bool *found, bool *unclear, FfpError *err) {
    const double deviation = t->usual.focal.deviation;
    if (deviation > 0) t->usual.focal.deviation = FFP_FOCAL_HELD;
    bool ok = search(t, found, unclear, err);
    t->usual.focal.deviation = ok && *found ? deviation : 0;
    return !ok || *found || !(deviation > 0) ? ok : search(t, found, unclear, err);
}

static void mirror(const FfpTracks *t) {
    for (int i = 0; i < t->n_sightings; i++) {
        FfpSighting *s = &t->sightings[i];
        s->at[0] = t->width - s->at[0], s->slope[0] = -s->slope[0], s->slope[1] = -s->slope[1];
    }
}

// Two devices alone explain mirrored pictures too; only what turns does not.
static bool fail_to_turn(FfpTurning *t, FfpError *err) {
    bool mirrored, unclear;
    mirror(t->tracks);
    const bool ok = search(t, &mirrored, &unclear, err);
    mirror(t->tracks);
    return ok && ffp_refuse(mirrored ? FFP_RULE_CODES_MIRRORED : FFP_RULE_STOPS_UNTURNED, &(FfpFacts){0},
                            NULL, err);
}

bool ffp_turning_check_parallax(const FfpTurning *t, double least, FfpError *err) {
    const double parallax = ffp_turning_parallax(t);
    return parallax >= least ||
           ffp_refuse(FFP_RULE_DEVICES_NEAR, &(FfpFacts){.figure = parallax, .limit = least}, NULL, err);
}

bool ffp_turning_start(FfpTurning *t, FfpError *err) {
    const int moving = count_moving(t);
    bool found, unclear;
    if (moving < MOVING_LEAST) return ffp_refuse(FFP_RULE_STOPS_ALIKE, &(FfpFacts){.x = moving}, NULL, err);
    if (!search_by_lens(t, &found, &unclear, err)) return false;
    if (!found) return fail_to_turn(t, err);
    if (!unclear) return true;
    return ffp_turning_check_parallax(t, FFP_PARALLAX_CLEAR, err) &&
           ffp_refuse(FFP_RULE_AXES_SEVERAL, &(FfpFacts){0}, NULL, err);
}
