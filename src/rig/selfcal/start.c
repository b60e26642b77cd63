#include "rig/selfcal/start.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/lens.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/projection.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/opencv.h"

enum { COMMON_LEAST = 40, TRIED_TRACKS = 400, PAIRS_MOST = 60, SHORT_TRACKS = 500, TURNS = 6 };
#define TOLERANCE 2.0    // pixels, before anything is fitted
#define PARALLAX_BEST 15 // degrees between two places' rays: more is no better
#define PLANE 0.004      // median distance from one plane that is needed, of the points' distance
#define STILL 0.2        // degrees that a camera which stays where it is leaves between rays at most
#define FITTING 0.5      // share of a place's sightings that must lie where the others put them
#define FAR 6            // times the median

static const double focal_guesses[] = {1.2, 0.8, 1.8, 2.7}; // of the width, where nothing is known
enum { GUESSES = sizeof focal_guesses / sizeof *focal_guesses };

// --- What two places see of the same. ---

typedef struct Common {
    int n, *tracks;           // those that both see
    double *first, *second;   // [n,2] rays
    unsigned char *inside;    // [n]
    double r[9], t[3], angle; // second from first; median between the rays, degrees
    int n_inside;
} Common;

static const FfpSighting *sighting_in(const FfpTracks *t, int track, int place) {
    for (int k = 0; k < t->tracks[track].n; k++) {
        const FfpSighting *s = &t->sightings[t->tracks[track].first + k];
        if (s->place == place) return s;
    }
    return NULL;
}

static void ray_of(const FfpBundle *b, int place, const double at[2], double ray[2]) {
    const double focal = exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL] + b->own[place][FFP_OWN_FOCAL]);
    const double x = (at[0] - 0.5 * b->tracks->width) / focal, y = (at[1] - 0.5 * b->tracks->height) / focal;
    const double lens[5] = {b->optics[FFP_BUNDLE_CAMERA_K1], b->optics[FFP_BUNDLE_CAMERA_K2]};
    if (!ffp_lens_undistort(lens, x, y, ray)) ray[0] = x, ray[1] = y;
}

static void common_free(Common *c) {
    ffp_free(c->tracks), ffp_free(c->first), ffp_free(c->second), ffp_free(c->inside);
    *c = (Common){0};
}

static Common common_new(const FfpBundle *b, int first, int second, int most) {
    const FfpTracks *t = b->tracks;
    Common c = {.tracks = ffp_alloc((size_t)t->n + 1, sizeof(int))};
    for (int i = 0; i < t->n; i++)
        if (sighting_in(t, i, first) && sighting_in(t, i, second)) c.tracks[c.n++] = i;
    if (c.n > most) { // evenly chosen
        for (int i = 0; i < most; i++) c.tracks[i] = c.tracks[(size_t)i * (size_t)c.n / (size_t)most];
        c.n = most;
    }
    c.first = ffp_alloc((size_t)c.n + 1, 2 * sizeof(double));
    c.second = ffp_alloc((size_t)c.n + 1, 2 * sizeof(double));
    c.inside = ffp_alloc((size_t)c.n + 1, 1);
    for (int i = 0; i < c.n; i++) {
        const FfpSighting *a = sighting_in(t, c.tracks[i], first), *s = sighting_in(t, c.tracks[i], second);
        ray_of(b, first, a->at, c.first + 2 * (size_t)i);
        ray_of(b, second, s->at, c.second + 2 * (size_t)i);
    }
    return c;
}

// The point of two rays, in the first place's frame; the angle between them in *angle, degrees.
static bool meet(const Common *c, int i, double point[3], double *angle) {
    const double a[3] = {c->first[2 * (size_t)i], c->first[2 * (size_t)i + 1], 1},
                 seen[3] = {c->second[2 * (size_t)i], c->second[2 * (size_t)i + 1], 1};
    double d[3], origin[3]; // the second's ray and centre in the first's frame
    for (int k = 0; k < 3; k++) {
        d[k] = c->r[k] * seen[0] + c->r[3 + k] * seen[1] + c->r[6 + k] * seen[2];
        origin[k] = -(c->r[k] * c->t[0] + c->r[3 + k] * c->t[1] + c->r[6 + k] * c->t[2]);
    }
    const double aa = ffp_dot(a, a), ad = ffp_dot(a, d), dd = ffp_dot(d, d), ao = ffp_dot(a, origin),
                 od = ffp_dot(d, origin), determinant = aa * dd - ad * ad;
    *angle = acos(fmin(1, ad / sqrt(aa * dd))) * 180 / FFP_PI_DOUBLE;
    if (!(determinant > 1e-12 * aa * dd)) return false;
    const double s = (ao * dd - od * ad) / determinant, u = (ao * ad - od * aa) / determinant;
    for (int k = 0; k < 3; k++) point[k] = 0.5 * (s * a[k] + origin[k] + u * d[k]);
    return s > 0 && u > 0;
}

static double median_angle(const Common *c) {
    real *angles = ffp_alloc((size_t)c->n + 1, sizeof *angles);
    size_t n = 0;
    for (int i = 0; i < c->n; i++) {
        double point[3], angle;
        if (!c->inside[i]) continue;
        meet(c, i, point, &angle);
        angles[n++] = (real)angle;
    }
    const double median = n > 0 ? (double)ffp_median(angles, n) : 0;
    ffp_free(angles);
    return median;
}

static bool relate(const FfpBundle *b, Common *c, FfpError *err) {
    bool found;
    c->n_inside = 0, c->angle = 0;
    if (c->n < COMMON_LEAST) return true;
    const double tolerance = TOLERANCE / exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL]);
    if (!ffp_cv_relative(c->first, c->second, c->n, tolerance, c->r, c->t, c->inside, &found, err))
        return false;
    for (int i = 0; found && i < c->n; i++) c->n_inside += c->inside[i];
    if (found) c->angle = median_angle(c);
    return true;
}

typedef struct Tie { // of a place to the one with which it shares most
    int other, n, inside;
} Tie;

static void keep_tie(Tie *tie, int other, const Common *c) {
    if (c->n_inside > tie->inside || (c->n_inside == tie->inside && c->n > tie->n))
        *tie = (Tie){other, c->n, c->n_inside};
}

// The two places that tell most: many points, seen from different sides.
static bool best_pair(FfpBundle *b, int pair[2], Tie *ties, FfpError *err) {
    const int places = b->tracks->n_places, pairs = places * (places - 1) / 2;
    double best = 0;
    int index = 0;
    pair[0] = pair[1] = -1;
    for (int i = 0; i < places; i++)
        for (int k = i + 1; k < places; k++, index++) {
            if (pairs > PAIRS_MOST && index * PAIRS_MOST / pairs == (index - 1) * PAIRS_MOST / pairs)
                continue;
            Common c = common_new(b, i, k, TRIED_TRACKS);
            const bool ok = relate(b, &c, err);
            const double score = c.n_inside * fmin(c.angle, PARALLAX_BEST) * (c.n_inside >= FITTING * c.n);
            if (ok && score > best) best = score, pair[0] = i, pair[1] = k;
            keep_tie(&ties[i], k, &c);
            keep_tie(&ties[k], i, &c);
            common_free(&c);
            if (!ok) return false;
            ffp_cancel_point();
        }
    return true;
}

// Why places without a problem of their own are not related to any other.
static void explain_ties(const FfpTracks *t, const Tie *ties) {
    for (int p = 0; p < t->n_places; p++) {
        FfpCameraPlace *place = &t->places[p];
        const Tie *tie = &ties[p];
        const char *other = t->places[tie->other].name;
        if (place->problem[0]) continue;
        if (tie->n < COMMON_LEAST)
            snprintf(place->problem, sizeof place->problem,
                     "it sees at most %d spots of the panel that another place sees, too", tie->n);
        else
            snprintf(
                place->problem, sizeof place->problem,
                "of %d spots of the panel that '%.200s' sees, too, only %d fit any move of the camera "
                "between the two: the projector, the scene or the camera moved during the photographs, or "
                "these are of another order",
                tie->n, other, tie->inside);
    }
}

// --- The projector, from points. ---

// The projector in the frame of the pair's first place.
static bool find_projector(const FfpBundle *b, const Common *c, FfpLinearDevice *p) {
    double *points = ffp_alloc((size_t)c->n, 3 * sizeof(double)), angle;
    double *panel = ffp_alloc((size_t)c->n, 2 * sizeof(double));
    unsigned char *use = ffp_alloc((size_t)c->n, 1);
    const double unit = b->tracks->panel_width;
    int n = 0;
    for (int i = 0; i < c->n; i++) {
        if (!c->inside[i] || !meet(c, i, points + 3 * (size_t)n, &angle)) continue;
        const double *at = b->tracks->tracks[c->tracks[i]].panel;
        panel[2 * (size_t)n] = at[0] / unit - 0.5;
        panel[2 * (size_t)n + 1] = (at[1] - 0.5 * b->tracks->panel_height) / unit;
        use[n++] = 1;
    }
    const bool ok = n >= COMMON_LEAST / 2 && ffp_projection_find(points, panel, use, n, 3, p);
    ffp_free(points), ffp_free(panel), ffp_free(use);
    return ok;
}

// --- From the pair to all places. ---

static void begin_with(FfpBundle *b, const int pair[2], const Common *c, const FfpLinearDevice *p) {
    FfpRigid *first = &b->places[pair[0]], *second = &b->places[pair[1]];
    b->optics[FFP_BUNDLE_PROJECTOR_FOCAL] = log(p->focal * b->tracks->panel_width);
    b->optics[FFP_BUNDLE_PROJECTOR_X] = fmax(-0.2, fmin(0.2, p->x));
    b->optics[FFP_BUNDLE_PROJECTOR_Y] = fmax(-1, fmin(1, p->y));
    ffp_rigid_inverse(&p->pose, first);
    ffp_rotation_product(c->r, first->r, second->r);
    for (int k = 0; k < 3; k++) second->t[k] = ffp_dot(c->r + 3 * (size_t)k, first->t) + c->t[k];
    b->known[pair[0]] = b->known[pair[1]] = true;
}

static int stride_of(const FfpBundle *b) {
    return b->tracks->n / SHORT_TRACKS + 1;
}

// By how much the two see things in different directions if one camera is turned like the other, degrees,
// median: without a step between them an essential matrix says anything.
static double shift_of(const Common *c) {
    real *angles = ffp_alloc((size_t)c->n + 1, sizeof *angles);
    double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    size_t n = 0;
    for (int round = 0; round < TURNS; round++) {
        double matrix[9] = {0}, vector[3] = {0}, by[3], turn[9], was[9];
        n = 0;
        for (int i = 0; i < c->n; i++) {
            double a[3] = {c->first[2 * (size_t)i], c->first[2 * (size_t)i + 1], 1}, across[3], turned[3],
                   seen[3] = {c->second[2 * (size_t)i], c->second[2 * (size_t)i + 1], 1};
            if (!c->inside[i]) continue;
            ffp_unit(a);
            ffp_unit(seen);
            for (int k = 0; k < 3; k++) turned[k] = ffp_dot(r + 3 * (ptrdiff_t)k, seen);
            ffp_cross(turned, a, across);
            angles[n++] = (real)(asin(fmin(1, sqrt(ffp_dot(across, across)))) * 180 / FFP_PI_DOUBLE);
            for (int k = 0; k < 9; k++) matrix[k] += (k % 4 == 0) - turned[k / 3] * turned[k % 3];
            for (int k = 0; k < 3; k++) vector[k] -= across[k];
        }
        if (!ffp_solve_positive(matrix, vector, 3, by)) break;
        memcpy(was, r, sizeof was);
        ffp_rotation_from_vector(by, turn);
        ffp_rotation_product(turn, was, r);
    }
    const double median = n > 0 ? (double)ffp_median(angles, n) : 0;
    ffp_free(angles);
    return median;
}

// A pair and the projector with this focal length to begin with; false where that leads nowhere.
static bool try_pair(FfpBundle *b, const int pair[2], bool *mirrored, bool *done, FfpError *err) {
    Common c = common_new(b, pair[0], pair[1], 4 * TRIED_TRACKS);
    FfpLinearDevice projector;
    bool ok = relate(b, &c, err);
    if (ok) b->apart = shift_of(&c);
    *done = ok && c.n_inside >= COMMON_LEAST / 2 && find_projector(b, &c, &projector);
    if (*done) {
        *mirrored = projector.mirrored;
        *done = projector.focal > 0.2 && projector.focal < 20 && !projector.mirrored;
    }
    if (*done) {
        begin_with(b, pair, &c, &projector);
        ffp_bundle_fit(b, stride_of(b), FAR, false);
    }
    common_free(&c);
    return ok;
}

// How badly all sightings fit, used or not, from 0 to 1: what is left out does not make a bad arrangement
// good.
static double misfit(const FfpBundle *b) {
    double sum = 0;
    int n = 0;
    for (int i = 0; i < b->tracks->n; i++) {
        double point[3], at[2];
        const bool there = ffp_bundle_point(b, i, point);
        for (int k = 0; k < b->tracks->tracks[i].n; k++) {
            const FfpSighting *s = &b->tracks->sightings[b->tracks->tracks[i].first + k];
            if (!b->known[s->place]) continue;
            const bool seen = there && ffp_bundle_see(b, s->place, point, at);
            sum += seen ? fmin(1, hypot(at[0] - s->at[0], at[1] - s->at[1]) / TOLERANCE) : 1;
            n++;
        }
    }
    return sum / fmax(1, n);
}

// Photographs of one place taken twice look as if they had no depth.
static bool give_up(FfpBundle *b, FfpRuleId why) {
    const bool near = why != FFP_RULE_CODES_MIRRORED && b->apart < STILL;
    b->refused = near ? FFP_RULE_PLACES_NEAR : why;
    return false;
}

// The bundle as it would be with each guess of the focal length; it keeps the one that fits best.
static bool choose_focal(FfpBundle *b, const int pair[2], FfpError *err) {
    const size_t tracks = (size_t)b->tracks->n, sightings = (size_t)b->tracks->n_sightings;
    double optics[FFP_BUNDLE_OPTICS], rms = 0, least = INFINITY, apart = 0, farthest = 0;
    bool *used = ffp_alloc(sightings + 1, sizeof *used), any = false, mirrored = false, done;
    FfpRigid poses[2];
    for (int g = 0; g < (b->usual.focal.deviation > 0 ? 1 : GUESSES); g++) {
        for (size_t i = 0; i < sightings; i++) b->tracks->sightings[i].used = true;
        memset(b->nearness, 0, tracks * sizeof *b->nearness);
        memset(b->optics, 0, sizeof b->optics);
        b->optics[FFP_BUNDLE_CAMERA_FOCAL] =
            b->usual.focal.deviation > 0 ? b->usual.focal.log : log(focal_guesses[g] * b->tracks->width);
        b->rms = 0;
        bool turned = false;
        if (!try_pair(b, pair, &turned, &done, err)) return ffp_free(used), false;
        mirrored = mirrored || turned;
        farthest = fmax(farthest, b->apart);
        const double found = done && b->known[pair[0]] && b->known[pair[1]] ? misfit(b) : INFINITY;
        for (int k = 0; k < 2; k++) { // what one guess lost, the next may find
            b->known[pair[k]] = false;
            b->tracks->places[pair[k]].problem[0] = 0;
        }
        if (!(found < least)) continue;
        least = found, any = true;
        rms = b->rms, apart = b->apart;
        memcpy(optics, b->optics, sizeof optics);
        for (int k = 0; k < 2; k++) poses[k] = b->places[pair[k]];
        for (size_t i = 0; i < sightings; i++) used[i] = b->tracks->sightings[i].used;
    }
    b->apart = any ? apart : farthest;
    if (any) {
        b->rms = rms;
        memcpy(b->optics, optics, sizeof optics);
        for (int k = 0; k < 2; k++) b->places[pair[k]] = poses[k], b->known[pair[k]] = true;
        for (size_t i = 0; i < sightings; i++) b->tracks->sightings[i].used = used[i];
        memset(b->nearness, 0, tracks * sizeof *b->nearness);
        ffp_bundle_triangulate(b);
    }
    ffp_free(used);
    if (any) return true;
    return give_up(b, mirrored ? FFP_RULE_CODES_MIRRORED : FFP_RULE_PLACES_UNEXPLAINED);
}

// --- Every other place. ---

static int seen_of(const FfpBundle *b, int place) {
    int n = 0;
    for (int i = 0; i < b->tracks->n; i++)
        n += b->nearness[i] > 0 && sighting_in(b->tracks, i, place) != NULL;
    return n;
}

static bool add_place(FfpBundle *b, int place, FfpError *err) {
    FfpCameraPlace *p = &b->tracks->places[place];
    const int room = b->tracks->n;
    double *points = ffp_alloc((size_t)room, 3 * sizeof(double)),
           *rays = ffp_alloc((size_t)room, 2 * sizeof(double));
    unsigned char *inside = ffp_alloc((size_t)room, 1);
    int n = 0, good = 0;
    bool found = false, ok = true;
    for (int i = 0; i < room; i++) {
        const FfpSighting *s = sighting_in(b->tracks, i, place);
        if (!s || !ffp_bundle_point(b, i, points + 3 * (size_t)n)) continue;
        ray_of(b, place, s->at, rays + 2 * (size_t)n++);
    }
    if (n >= COMMON_LEAST) {
        FfpRigid *pose = &b->places[place];
        ok = ffp_cv_pose(points, rays, n, 2 * TOLERANCE / exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL]), pose->r,
                         pose->t, inside, &found, err);
        for (int i = 0; found && i < n; i++) good += inside[i];
    }
    b->known[place] = found && good >= FITTING * n;
    if (!b->known[place] && n < COMMON_LEAST)
        snprintf(p->problem, sizeof p->problem,
                 "only %d spots of the panel are seen there that other places see", n);
    else if (!b->known[place])
        snprintf(p->problem, sizeof p->problem,
                 "of %d spots of the panel that other places see, only %d lie where these put them: the "
                 "projector or "
                 "the scene moved between them, or the photographs are of another order",
                 n, good);
    ffp_free(points), ffp_free(rays), ffp_free(inside);
    return ok;
}

static bool add_places(FfpBundle *b, FfpError *err) {
    for (;;) {
        int best = -1, most = -1;
        for (int p = 0; p < b->tracks->n_places; p++) {
            if (b->known[p] || b->tracks->places[p].problem[0]) continue;
            const int seen = seen_of(b, p);
            if (seen > most) best = p, most = seen;
        }
        if (best < 0) return true;
        if (!add_place(b, best, err)) return false;
        ffp_bundle_triangulate(b);
        if (b->known[best]) ffp_bundle_fit(b, stride_of(b), FAR, false);
        ffp_cancel_point();
    }
}

// --- What cannot be solved. ---

static double off_plane(const FfpBundle *b) {
    double *points = ffp_alloc((size_t)b->tracks->n + 1, 3 * sizeof *points);
    int n = 0;
    for (int i = 0; i < b->tracks->n; i++) n += ffp_bundle_point(b, i, points + 3 * (size_t)n);
    const double off = ffp_off_plane(points, n);
    ffp_free(points);
    return off;
}

static bool check_plane(FfpBundle *b) {
    return off_plane(b) > PLANE || give_up(b, FFP_RULE_ONE_PLANE);
}

bool ffp_bundle_start(FfpBundle *b, FfpError *err) {
    int pair[2];
    Tie ties[FFP_PLACES_MAX] = {{0}};
    b->refused = 0;
    for (int p = 0; p < b->tracks->n_places; p++) b->own[p][FFP_OWN_FOCAL] = ffp_bundle_expected(b, p);
    b->optics[FFP_BUNDLE_CAMERA_FOCAL] =
        b->usual.focal.deviation > 0 ? b->usual.focal.log : log(focal_guesses[0] * b->tracks->width);
    if (!best_pair(b, pair, ties, err)) return false;
    if (pair[0] < 0) {
        b->refused = FFP_RULE_PLACES_UNRELATED;
        explain_ties(b->tracks, ties);
        return false;
    }
    return choose_focal(b, pair, err) && check_plane(b) && add_places(b, err);
}
