#include "rig/selfcal/start.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/lens.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/opencv.h"

enum { COMMON_LEAST = 40, TRIED_TRACKS = 400, PAIRS_MOST = 60, SHORT_TRACKS = 500 };
#define TOLERANCE 2.0    // pixels, before anything is fitted
#define PARALLAX_BEST 15 // degrees between two places' rays: more is no better
#define PLANE 0.004      // median distance from one plane that is needed, of the points' distance
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

static void ray_of(const FfpBundle *b, const double at[2], double ray[2]) {
    const double focal = exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL]);
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
        ray_of(b, a->at, c.first + 2 * (size_t)i);
        ray_of(b, s->at, c.second + 2 * (size_t)i);
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

// The two places that tell most: many points, seen from different sides.
static bool best_pair(const FfpBundle *b, int pair[2], FfpError *err) {
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
            common_free(&c);
            if (!ok) return false;
            ffp_cancel_point();
        }
    return true;
}

// --- The projector, from points. ---

typedef struct Linear { // equations of a projection whose depth is 1 at the points' middle
    int n;
    const double *points, *panel; // [n,3] from the middle, in their spread; [n,2]
    unsigned char *use;
} Linear;

static bool solve_linear(const Linear *l, double m[12]) {
    double a[11 * 11] = {0}, c[11] = {0};
    for (int i = 0; i < l->n; i++) {
        const double *x = l->points + 3 * (size_t)i, *p = l->panel + 2 * (size_t)i;
        if (!l->use[i]) continue;
        for (int k = 0; k < 2; k++) { // (m_k x - p_k m_2 x) = 0
            double row[11] = {0};
            for (int j = 0; j < 3; j++) row[4 * k + j] = x[j], row[8 + j] = -p[k] * x[j];
            row[4 * k + 3] = 1;
            for (int r = 0; r < 11; r++) {
                c[r] -= row[r] * p[k];
                for (int s = 0; s < 11; s++) a[11 * r + s] += row[r] * row[s];
            }
        }
    }
    for (int r = 0; r < 11; r++) a[12 * r] *= 1 + 1e-12;
    m[11] = 1;
    return ffp_solve_positive(a, c, 11, m);
}

// Leaves out what lies far from where the equations put it; the median distance, in the panel's unit.
static double leave_out(const Linear *l, const double m[12]) {
    real *off = ffp_alloc((size_t)l->n + 1, sizeof *off), *sorted = ffp_alloc((size_t)l->n + 1, sizeof *off);
    for (int i = 0; i < l->n; i++) {
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = ffp_dot(m + 4 * (size_t)k, l->points + 3 * (size_t)i) + m[4 * k + 3];
        const double *p = l->panel + 2 * (size_t)i;
        off[i] = sorted[i] = (real)fmin(hypot(at[0] / at[2] - p[0], at[1] / at[2] - p[1]), 1e6);
    }
    const double median = (double)ffp_median(sorted, (size_t)l->n);
    for (int i = 0; i < l->n; i++) l->use[i] = (double)off[i] <= 4 * median;
    ffp_free(off), ffp_free(sorted);
    return median;
}

typedef struct Projector { // in the frame of the points
    double focal, x, y;    // of the panel's unit
    FfpRigid pose;         // points to projector
    bool mirrored;
} Projector;

// Matrix, rotation and place out of a projection (Hartley and Zisserman 2004, section 6.2.4).
static Projector take_apart(const double m[12]) {
    Projector p;
    double r[3][3], across[3], down[3];
    memcpy(r[2], m + 8, sizeof r[2]);
    const double scale = ffp_unit(r[2]);
    p.x = ffp_dot(m, r[2]) / scale, p.y = ffp_dot(m + 4, r[2]) / scale;
    for (int k = 0; k < 3; k++)
        r[0][k] = m[k] / scale - p.x * r[2][k], r[1][k] = m[4 + k] / scale - p.y * r[2][k];
    const double fx = ffp_unit(r[0]), fy = ffp_unit(r[1]);
    p.focal = sqrt(fx * fy);
    ffp_cross(r[2], r[0], down);
    p.mirrored = ffp_dot(down, r[1]) < 0;
    ffp_unit(down);
    ffp_cross(down, r[2], across);
    memcpy(p.pose.r, across, sizeof across), memcpy(p.pose.r + 3, down, sizeof down);
    memcpy(p.pose.r + 6, r[2], sizeof r[2]);
    const double z = 1 / scale;
    p.pose.t[0] = (m[3] - p.x) * z / fx, p.pose.t[1] = (m[7] - p.y) * z / fy, p.pose.t[2] = z;
    return p;
}

// The points' middle goes to 0 and their spread to 1.
static void settle_points(double *points, int n, double middle[3], double *spread) {
    double square = 0;
    memset(middle, 0, 3 * sizeof *middle);
    for (int i = 0; i < 3 * n; i++) middle[i % 3] += points[i] / n;
    for (int i = 0; i < 3 * n; i++) square += pow(points[i] -= middle[i % 3], 2);
    *spread = sqrt(square / n);
    for (int i = 0; i < 3 * n; i++) points[i] /= *spread;
}

// The projector in the frame of the pair's first place.
static bool find_projector(const FfpBundle *b, const Common *c, Projector *p) {
    double *points = ffp_alloc((size_t)c->n, 3 * sizeof(double)), m[12], middle[3], spread, angle;
    double *panel = ffp_alloc((size_t)c->n, 2 * sizeof(double));
    Linear l = {.points = points, .panel = panel, .use = ffp_alloc((size_t)c->n, 1)};
    const double unit = b->tracks->panel_width;
    for (int i = 0; i < c->n; i++) {
        if (!c->inside[i] || !meet(c, i, points + 3 * (size_t)l.n, &angle)) continue;
        const double *at = b->tracks->tracks[c->tracks[i]].panel;
        panel[2 * (size_t)l.n] = at[0] / unit - 0.5;
        panel[2 * (size_t)l.n + 1] = (at[1] - 0.5 * b->tracks->panel_height) / unit;
        l.use[l.n++] = 1;
    }
    bool ok = l.n >= COMMON_LEAST / 2;
    if (ok) settle_points(points, l.n, middle, &spread);
    for (int round = 0; ok && round < 3; round++) {
        ok = solve_linear(&l, m);
        if (ok) leave_out(&l, m);
    }
    if (ok) {
        *p = take_apart(m); // of points at (X - middle) / spread
        for (int k = 0; k < 3; k++)
            p->pose.t[k] = p->pose.t[k] * spread - ffp_dot(p->pose.r + 3 * (size_t)k, middle);
    }
    ffp_free(points), ffp_free(panel), ffp_free(l.use);
    return ok && isfinite(p->focal);
}

// --- From the pair to all places. ---

static void begin_with(FfpBundle *b, const int pair[2], const Common *c, const Projector *p) {
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

// A pair and the projector with this focal length to begin with; false where that leads nowhere.
static bool try_pair(FfpBundle *b, const int pair[2], bool *mirrored, bool *done, FfpError *err) {
    Common c = common_new(b, pair[0], pair[1], 4 * TRIED_TRACKS);
    Projector projector;
    bool ok = relate(b, &c, err);
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

// The bundle as it would be with each guess of the focal length; it keeps the one that fits best.
static bool choose_focal(FfpBundle *b, const int pair[2], FfpError *err) {
    const size_t tracks = (size_t)b->tracks->n, sightings = (size_t)b->tracks->n_sightings;
    double optics[FFP_BUNDLE_OPTICS], rms = 0, least = INFINITY;
    bool *used = ffp_alloc(sightings + 1, sizeof *used), any = false, mirrored = false, done;
    FfpRigid poses[2];
    for (int g = 0; g < (b->focal.deviation > 0 ? 1 : GUESSES); g++) {
        for (size_t i = 0; i < sightings; i++) b->tracks->sightings[i].used = true;
        memset(b->nearness, 0, tracks * sizeof *b->nearness);
        memset(b->optics, 0, sizeof b->optics);
        b->optics[FFP_BUNDLE_CAMERA_FOCAL] =
            b->focal.deviation > 0 ? b->focal.log : log(focal_guesses[g] * b->tracks->width);
        b->rms = 0;
        bool turned = false;
        if (!try_pair(b, pair, &turned, &done, err)) return ffp_free(used), false;
        mirrored = mirrored || turned;
        const double found = done && b->known[pair[0]] && b->known[pair[1]] ? misfit(b) : INFINITY;
        for (int k = 0; k < 2; k++) { // what one guess lost, the next may find
            b->known[pair[k]] = false;
            b->tracks->places[pair[k]].problem[0] = 0;
        }
        if (!(found < least)) continue;
        least = found, any = true;
        rms = b->rms;
        memcpy(optics, b->optics, sizeof optics);
        for (int k = 0; k < 2; k++) poses[k] = b->places[pair[k]];
        for (size_t i = 0; i < sightings; i++) used[i] = b->tracks->sightings[i].used;
    }
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
    return ffp_fail(err, FFP_ERROR_FILE, NULL, "%s",
                    mirrored ? FFP_MIRRORED_CODES
                             : "no place of projector and camera explains the positions that the codes give");
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
        ray_of(b, s->at, rays + 2 * (size_t)n++);
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

// How far half of the points lie from the plane that fits them best, as shares of their distance.
static double off_plane(const FfpBundle *b) {
    const size_t n = (size_t)b->tracks->n;
    double a[9] = {0}, c[3] = {0}, normal[3], point[3];
    real *off = ffp_alloc(n + 1, sizeof *off);
    size_t found = 0;
    for (size_t i = 0; i < n; i++) { // n . X = 1
        if (!ffp_bundle_point(b, (int)i, point)) continue;
        for (int r = 0; r < 3; r++) {
            c[r] -= point[r];
            for (int s = 0; s < 3; s++) a[3 * r + s] += point[r] * point[s];
        }
    }
    const bool ok = ffp_solve_positive(a, c, 3, normal);
    for (size_t i = 0; ok && i < n; i++)
        if (ffp_bundle_point(b, (int)i, point)) off[found++] = (real)fabs(ffp_dot(normal, point) - 1);
    const double median = found > 0 ? (double)ffp_median(off, found) : 0;
    ffp_free(off);
    return median;
}

static bool check_plane(const FfpBundle *b, FfpError *err) {
    return off_plane(b) > PLANE || ffp_fail(err, FFP_ERROR_FILE, NULL,
                                            "all that the camera sees lies on one plane, which leaves focal "
                                            "lengths undetermined: put things "
                                            "of different depth before the projector");
}

bool ffp_bundle_start(FfpBundle *b, FfpError *err) {
    int pair[2];
    b->optics[FFP_BUNDLE_CAMERA_FOCAL] =
        b->focal.deviation > 0 ? b->focal.log : log(focal_guesses[0] * b->tracks->width);
    if (!best_pair(b, pair, err)) return false;
    if (pair[0] < 0)
        return ffp_fail(
            err, FFP_ERROR_FILE, NULL,
            "no two places of the camera see enough of the same: the projector or the scene moved between "
            "them, or they are too far apart");
    return choose_focal(b, pair, err) && check_plane(b, err) && add_places(b, err);
}
