// Random walks as their sightings, without pictures, sound ones and those with a fault.
#ifndef FFP_TESTS_WALKS_H
#define FFP_TESTS_WALKS_H

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/lens.h"
#include "core/base/rng.h"
#include "rig/selfcal/selfcal.h"

enum { WALK_PLACES = 8, WALK_BOXES = 3 };

typedef struct Walk {
    int width, height, panel_width, panel_height, places;
    int columns, rows;                                           // of the grid of spots on the panel
    double camera, projector, camera_axis[2], projector_axis[2]; // pixels
    double camera_lens[5], projector_lens[5];
    double noise; // pixels
    double lens;  // focal length that the user gives, pixels; 0: none
    double walls[2][3], boxes[WALK_BOXES][5];
    FfpRigid poses[WALK_PLACES]; // the projector's frame to the camera's there
    // Faults.
    bool each, tagged; // every place is known to have its own camera, and its files say its focal length
    double own[WALK_PLACES][3]; // of the camera there: axis, of the width, and logarithm of focal length
    double panel_aspect, keystone[2]; // of the panel's picture: stretched in x; one side wider
    double lit_turn[WALK_PLACES][2];  // by which the projector has turned there
    double shear[WALK_PLACES];        // of the camera's rows: a shutter that rolls while it is carried
    uint64_t seed;
} Walk;

static double range_of(FfpRng *rng, double from, double to) {
    return (double)ffp_rng_range(rng, (real)from, (real)to);
}

// Two walls that meet, and boxes before them, seen from three to seven places; so many spots, about.
static Walk random_walk(uint64_t seed, int spots) {
    FfpRng rng = ffp_rng(seed, 77);
    Walk w = {.width = 640, .height = 480, .panel_width = 800, .panel_height = 500, .seed = seed};
    w.columns = (int)sqrt(1.6 * spots);
    w.rows = spots / w.columns;
    w.places = 3 + (int)range_of(&rng, 0, 4.99);
    w.camera = 640 * range_of(&rng, 0.8, 1.8), w.projector = 800 * range_of(&rng, 1.2, 2.2);
    for (int k = 0; k < 2; k++) {
        w.camera_axis[k] = (k ? 240 : 320) + 640 * 0.005 * (double)ffp_rng_normal(&rng);
        w.projector_axis[k] =
            k ? 250 + 800 * range_of(&rng, -0.02, 0.35) : 400 + 800 * 0.01 * (double)ffp_rng_normal(&rng);
    }
    w.camera_lens[0] = range_of(&rng, -0.15, 0.05), w.projector_lens[0] = range_of(&rng, -0.05, 0.05);
    w.noise = exp(range_of(&rng, log(0.04), log(0.3)));
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++) w.walls[k][i] = i == 0 ? 0 : range_of(&rng, -0.25, 0.25);
    w.walls[0][0] = 0.22 + 0.5 * fabs(w.walls[0][1]), w.walls[1][0] = range_of(&rng, 0.2, 0.24);
    w.walls[1][1] = -2 * w.walls[0][1];
    for (int b = 0; b < WALK_BOXES; b++) {
        double *box = w.boxes[b];
        box[0] = range_of(&rng, -0.25, 0.2), box[1] = range_of(&rng, -0.2, 0.1);
        box[2] = box[0] + range_of(&rng, 0.04, 0.15), box[3] = box[1] + range_of(&rng, 0.04, 0.15);
        box[4] = range_of(&rng, 2.6, 3.7);
    }
    const double apart = range_of(&rng, 7, 18);
    for (int p = 0; p < w.places; p++) {
        const double angle =
            (p - 0.5 * (w.places - 1)) * apart * FFP_PI_DOUBLE / 180 + 0.3 * range_of(&rng, -1, 1);
        const double turn[3] = {0.1 * range_of(&rng, -1, 1), angle + 0.03 * range_of(&rng, -1, 1),
                                0.1 * range_of(&rng, -1, 1)};
        const double away = 4 * range_of(&rng, 0.85, 1.15);
        const double from[3] = {away * sin(angle), 0.5 * range_of(&rng, -1, 1), 4 - away * cos(angle)};
        ffp_rotation_from_vector(turn, w.poses[p].r);
        for (int k = 0; k < 3; k++) w.poses[p].t[k] = -ffp_dot(w.poses[p].r + 3 * (size_t)k, from);
    }
    return w;
}

// Nearness of the surface along a ray (x, y, 1).
static double nearness_at(const Walk *w, double x, double y) {
    double nearest = 0;
    for (int k = 0; k < 2; k++)
        nearest = fmax(nearest, w->walls[k][0] + w->walls[k][1] * x + w->walls[k][2] * y);
    for (int b = 0; b < WALK_BOXES; b++) {
        const double *box = w->boxes[b];
        if (x > box[0] && y > box[1] && x < box[2] && y < box[3])
            nearest = fmax(nearest, (1 + 0.3 * (x - box[0])) / box[4]);
    }
    return nearest;
}

static bool walk_sees(const Walk *w, int place, const double panel[2], double at[2]) {
    const double *own = w->own[place], aspect = w->panel_aspect > 0 ? w->panel_aspect : 1;
    double x = (panel[0] - w->projector_axis[0]) / w->projector * aspect,
           y = (panel[1] - w->projector_axis[1]) / w->projector;
    const double scale = 1 / (1 + w->keystone[0] * x + w->keystone[1] * y);
    double ray[3] = {0, 0, 1}, point[3], seen[3], u, v;
    if (!ffp_lens_undistort(w->projector_lens, x * scale, y * scale, ray)) return false;
    for (int k = 0; k < 2; k++) ray[k] += w->lit_turn[place][k];
    const double nearness = nearness_at(w, ray[0], ray[1]);
    for (int k = 0; k < 3; k++) point[k] = ray[k] / nearness;
    ffp_rigid_apply(&w->poses[place], point, seen);
    if (!(seen[2] > 0)) return false;
    ffp_lens_distort(w->camera_lens, seen[0] / seen[2], seen[1] / seen[2], &u, &v);
    const double focal = w->camera * exp(own[2]);
    at[0] = w->camera_axis[0] + own[0] * w->width + focal * u + w->shear[place] * focal * v;
    at[1] = w->camera_axis[1] + own[1] * w->width + focal * v;
    return at[0] >= 0 && at[1] >= 0 && at[0] < w->width && at[1] < w->height;
}

// The sightings of some spots on the panel, as ffp_tracks_find would have them; ffp_tracks_free frees them.
static FfpTracks tracks_of(const Walk *w) {
    const size_t spots = (size_t)w->columns * (size_t)w->rows;
    FfpTracks t = {.width = w->width,
                   .height = w->height,
                   .panel_width = w->panel_width,
                   .panel_height = w->panel_height,
                   .n_places = w->places,
                   .columns = w->columns,
                   .rows = w->rows,
                   .pitch = (double)w->panel_width / w->columns,
                   .grid = ffp_alloc(spots, sizeof *t.grid),
                   .places = ffp_alloc((size_t)w->places, sizeof *t.places),
                   .tracks = ffp_alloc(spots, sizeof *t.tracks),
                   .sightings = ffp_alloc(spots * (size_t)w->places, sizeof *t.sightings)};
    FfpRng rng = ffp_rng(w->seed, 78);
    for (int p = 0; p < w->places; p++) {
        snprintf(t.places[p].name, sizeof t.places[p].name, "place-%d", p);
        if (w->tagged) t.places[p].focal_35mm = 28 * exp(w->own[p][2]);
    }
    if (w->tagged) t.focal_35mm = 28;
    for (int i = 0; i < w->columns * w->rows; i++) {
        FfpTrack *track = &t.tracks[t.n];
        const double pitch = (double)w->panel_width / w->columns;
        *track = (FfpTrack){.panel = {(i % w->columns + range_of(&rng, 0.2, 0.8)) * pitch,
                                      (i / w->columns + range_of(&rng, 0.2, 0.8)) * pitch},
                            .first = t.n_sightings};
        t.grid[i] = t.n;
        for (int p = 0; p < w->places; p++) {
            FfpSighting *s = &t.sightings[t.n_sightings];
            *s = (FfpSighting){.place = p, .used = true};
            if (!walk_sees(w, p, track->panel, s->at)) continue;
            for (int k = 0; k < 2; k++) s->at[k] += w->noise * (double)ffp_rng_normal(&rng);
            t.n_sightings++, track->n++, t.places[p].seen++;
        }
        if (track->n == 0) t.grid[i] = -1;
        t.n += track->n > 0;
    }
    return t;
}

// A bundle to fit, of at most so many places. bundle_free frees its arrays.
static FfpBundle bundle_of(const FfpTracks *t) {
    const size_t places = (size_t)t->n_places;
    return (FfpBundle){.tracks = t,
                       .places = ffp_alloc(places, sizeof(FfpRigid)),
                       .known = ffp_alloc(places, sizeof(bool)),
                       .own = ffp_alloc(places, sizeof(FfpOwn)),
                       .nearness = ffp_alloc((size_t)t->n + 1, sizeof(double))};
}

static void bundle_free(FfpBundle *b) {
    ffp_free(b->places), ffp_free(b->known), ffp_free(b->own), ffp_free(b->nearness), ffp_free(b->deviation);
    ffp_free(b->own_deviation), ffp_free(b->focal_deviation);
}

// By how many degrees a place is turned wrongly to another.
static double turned_wrongly(const Walk *w, const FfpBundle *b, int from, int to) {
    double back[2][9], truth[9], found[9], difference[9], v[3];
    for (int i = 0; i < 9; i++) {
        back[0][i] = w->poses[from].r[3 * (i % 3) + i / 3];
        back[1][i] = b->places[from].r[3 * (i % 3) + i / 3];
    }
    ffp_rotation_product(w->poses[to].r, back[0], truth);
    ffp_rotation_product(b->places[to].r, back[1], found);
    ffp_rotation_difference(found, truth, difference);
    ffp_rotation_to_vector(difference, v);
    return sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE;
}

// --- Faults. ---

typedef enum WalkFault {
    WALK_SOUND,
    WALK_WANDERING, // by a thousandth of the width: what a lens that focuses does
    WALK_ZOOMED,
    WALK_ZOOMED_A_LITTLE,
    WALK_ZOOMED_FROM_THEN_ON,
    WALK_BREATHING,  // the focal length, by 1.5 %
    WALK_STABILISED, // the picture wanders by a hundredth of the width
    WALK_PAIR,
    WALK_TWO_BODIES,
    WALK_TWO_LENSES, // of a telephone, one after the other; the first is given
    WALK_STRETCHED,  // 4:3 on 16:9
    WALK_STRETCHED_A_LITTLE,
    WALK_KEYSTONED,
    WALK_TURNED, // the projector, by half a degree
    WALK_ROLLING,
    WALK_TWICE, // from one tripod
    WALK_FAULTS
} WalkFault;

static const char *const walk_names[WALK_FAULTS] = {
    "sound",
    "axis wanders by 0.1 %",
    "one place zoomed by 15 %",
    "one place zoomed by 3 %",
    "zoomed by 15 % from one place on",
    "focal length breathes by 1.5 %",
    "stabiliser wanders by 1 %",
    "two places",
    "two bodies",
    "two lenses",
    "4:3 on 16:9",
    "stretched by 3 %",
    "keystone corrected",
    "projector turned by half a degree",
    "shutter rolls",
    "two places on one spot",
};

static void put_fault(Walk *w, WalkFault fault) {
    FfpRng rng = ffp_rng(w->seed, 99);
    const int middle = w->places / 2;
    for (int p = 0; p < w->places; p++) {
        const double x = (double)ffp_rng_normal(&rng), y = (double)ffp_rng_normal(&rng);
        const double wander = fault == WALK_WANDERING ? 0.001 : fault == WALK_STABILISED ? 0.01 : 0;
        w->own[p][0] = wander * x;
        w->own[p][1] = wander * y;
        if (fault == WALK_BREATHING) w->own[p][2] = 0.015 * x;
        if (fault == WALK_ROLLING) w->shear[p] = 0.01 * x;
        if (fault == WALK_TURNED && p >= middle) w->lit_turn[p][0] = 0.01;
        if (fault == WALK_ZOOMED_FROM_THEN_ON && p >= middle) w->own[p][2] = log(1.15);
    }
    if (fault == WALK_ZOOMED) w->own[middle][2] = log(1.15);
    if (fault == WALK_ZOOMED_A_LITTLE) w->own[middle][2] = log(1.03);
    for (int p = 1; fault == WALK_TWO_LENSES && p < w->places; p += 2) w->own[p][2] = log(0.62);
    if (fault == WALK_TWO_LENSES) w->places = 5, w->lens = w->camera;
    if (fault == WALK_PAIR || fault == WALK_TWO_BODIES) w->places = 2;
    if (fault == WALK_TWO_BODIES) w->own[1][0] = 0.004, w->own[1][1] = 0.012;
    if (fault == WALK_STRETCHED) w->panel_aspect = 4 / 3.0 / (16 / 9.0);
    if (fault == WALK_STRETCHED_A_LITTLE) w->panel_aspect = 1.03;
    if (fault == WALK_KEYSTONED) w->keystone[0] = 0.08, w->keystone[1] = 0.25;
    if (fault == WALK_TWICE) w->poses[1] = w->poses[0];
}

// --- What comes out. ---

typedef struct WalkResult {
    bool refused;
    char said[1024];     // the error, or the codes of doubts
    double camera[2];    // the largest error of a place's focal length, relative, and its deviation
    double projector[2]; // likewise; that its picture is stretched is not counted
    double turn[2];      // degrees
    double rms, noise;   // pixels
} WalkResult;

static void keep_doubt(void *user, const FfpFinding *finding) {
    WalkResult *r = user;
    const size_t used = strlen(r->said);
    if (finding->severity >= FFP_FINDING_DOUBT && !strstr(r->said, finding->code))
        snprintf(r->said + used, sizeof r->said - used, "%s%s", used > 0 ? ", " : "", finding->code);
}

static void compare_with_truth(const Walk *w, const FfpBundle *b, WalkResult *r) {
    const double aspect = w->panel_aspect > 0 ? 0.5 * log(w->panel_aspect) : 0;
    int first = 0;
    while (!b->known[first]) first++;
    for (int p = 0; p < w->places; p++) {
        if (!b->known[p]) continue;
        const double off = b->optics[FFP_BUNDLE_CAMERA_FOCAL] + b->own[p][2] - log(w->camera) - w->own[p][2];
        if (fabs(off) > fabs(r->camera[0])) r->camera[0] = off;
        r->turn[0] = fmax(r->turn[0], turned_wrongly(w, b, first, p));
        for (ptrdiff_t k = 0; k < 3; k++)
            r->turn[1] = fmax(r->turn[1],
                              b->deviation[FFP_BUNDLE_OPTICS + 6 * (ptrdiff_t)p + k] * 180 / FFP_PI_DOUBLE);
    }
    r->projector[0] = b->optics[FFP_BUNDLE_PROJECTOR_FOCAL] - log(w->projector) + aspect;
    r->camera[1] = b->deviation[FFP_BUNDLE_CAMERA_FOCAL];
    for (int p = 0; b->each && p < w->places; p++)
        if (b->known[p]) r->camera[1] = fmax(r->camera[1], b->focal_deviation[p]);
    r->projector[1] = b->deviation[FFP_BUNDLE_PROJECTOR_FOCAL];
    r->rms = b->rms, r->noise = b->noise;
}

typedef struct WalkRun {
    const Walk *walk;
    WalkResult *result;
} WalkRun;

static bool run_walk(void *argument, FfpError *err) {
    const WalkRun *run = argument;
    FfpTracks tracks = tracks_of(run->walk);
    FfpBundle b = bundle_of(&tracks);
    b.each = run->walk->each;
    if (run->walk->lens > 0) b.usual.focal = (FfpKnownFocal){log(run->walk->lens), 0.03};
    const bool ok = ffp_self_calibration_fit(&b, err);
    if (ok) compare_with_truth(run->walk, &b, run->result);
    bundle_free(&b);
    ffp_tracks_free(&tracks);
    return ok;
}

static WalkResult solve_walk(const Walk *walk) {
    WalkResult r = {.refused = false};
    FfpContext context = {.settings = {.finding = keep_doubt, .user = &r}};
    FfpError err = {0};
    r.refused = !ffp_call_run(&context, run_walk, &(WalkRun){.walk = walk, .result = &r}, &err);
    if (r.refused) snprintf(r.said, sizeof r.said, "%s", err.text);
    return r;
}

#endif
