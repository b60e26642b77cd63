// The search for the turns that all views share. Each device turns about its own axes by the same vector in
// every view, which is what a wrong calibration of the pair, a wrong principal point and a misplaced axis
// look like.
#include "engine/align/align.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/log.h"
#include "engine/align/bundle.h"
#include "engine/align/photo_consistency.h"
#include "engine/align/ring.h"

#define FIRST_STEP 1.0 // of the search, in expected turns
#define NEXT_STEP 0.6  // of the one before
#define LOOKS 3        // along a way, each time
#define REACH 1.5      // steps that a parabola may point beyond the last look
#define FOCAL_FIRST                                                                                          \
    0.1             // of the expected errors of poses, while focal lengths have the first half of the steps
#define ALIKE 1.005 // disagreements that differ by no more are alike: right poses, evened out

// Ways to turn. Depth: camera and projector towards each other or apart, along the line between them, which
// moves every surface nearer or farther. Across: against each other at right angles to that. Side: together,
// across the turntable's axis. Together along the axis is left out: it moves the object, and no picture
// tells.
enum { DEPTH, ACROSS, SIDE, WAYS };

typedef struct Way {
    double camera[3], projector[3]; // turns by one unit of what is expected, in the devices' own axes
} Way;

typedef struct Search {
    FfpCapture *capture;
    const FfpView *from; // [views] poses that are turned
    FfpPhotoConsistency *looker;
    int n_ways;
    Way way[WAYS];
    double x[WAYS]; // where it stands
    double best;    // disagreement there
    FfpTask progress;
    int64_t looks;
} Search;

FfpAlignSettings ffp_align_defaults(void) {
    const double degree = 0.017453292519943295;
    return (FfpAlignSettings){.expected = {.turn = 0.2 * degree, .shift = 1e-3}, .steps = 6, .rounds = 8};
}

// Turns that move a device's aim along a world direction.
static void aim_along(const FfpRigid *device, const double direction[3], double by, double turn[3]) {
    double local[3] = {0};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) local[k] += device->r[3 * i + k] * direction[i];
    const double length = hypot(local[0], local[1]);
    turn[0] = length > 0 ? -by * local[1] / length : 0;
    turn[1] = length > 0 ? by * local[0] / length : 0;
    turn[2] = 0;
}

static void set_way(Way *way, const FfpView *view, const double direction[3], double camera,
                    double projector) {
    const FfpRigid c = ffp_rigid_from_pose(view->camera.pose), p = ffp_rigid_from_pose(view->projector.pose);
    aim_along(&c, direction, camera, way->camera);
    aim_along(&p, direction, projector, way->projector);
}

// The ways as the first view's devices lie to each other and to the axis (NULL: not a turntable).
static void set_ways(Search *s, const double axis[3], double turn) {
    const FfpView *view = &s->from[0];
    const FfpRigid camera = ffp_rigid_from_pose(view->camera.pose),
                   projector = ffp_rigid_from_pose(view->projector.pose);
    double apart[3], across[3], side[3];
    const double ahead[3] = {camera.r[2], camera.r[5], camera.r[8]};
    for (int k = 0; k < 3; k++) apart[k] = projector.t[k] - camera.t[k];
    ffp_cross(ahead, apart, across);
    set_way(&s->way[DEPTH], view, apart, turn, -turn);
    set_way(&s->way[ACROSS], view, across, turn, -turn);
    s->n_ways = axis ? WAYS : SIDE;
    if (!axis) return;
    ffp_cross(axis, ahead, side);
    set_way(&s->way[SIDE], view, side, turn, turn);
}

static void rotate_device(const FfpCamera *from, const double v[3], FfpCamera *to) {
    FfpRigid motion = ffp_rigid_from_pose(from->pose);
    double r[9], turned[9];
    ffp_rotation_from_vector(v, r);
    ffp_rotation_product(motion.r, r, turned);
    memcpy(motion.r, turned, sizeof turned);
    ffp_rigid_store(&motion, to->pose);
}

static void place(const Search *s, const double x[WAYS]) {
    double camera[3] = {0}, projector[3] = {0};
    for (int w = 0; w < s->n_ways; w++)
        for (int k = 0; k < 3; k++) {
            camera[k] += x[w] * s->way[w].camera[k];
            projector[k] += x[w] * s->way[w].projector[k];
        }
    for (int v = 0; v < s->capture->n_views; v++) {
        rotate_device(&s->from[v].camera, camera, &s->capture->views[v].camera);
        rotate_device(&s->from[v].projector, projector, &s->capture->views[v].projector);
    }
}

// The disagreement with one number changed; keeps it when it is the least so far.
static bool look_at(Search *s, int way, double by, double origin, double *disagreement, FfpError *err) {
    double x[WAYS];
    memcpy(x, s->x, sizeof x);
    x[way] = origin + by;
    place(s, x);
    if (!ffp_photo_consistency(s->looker, disagreement, err)) return false;
    ffp_task_step(&s->progress, ++s->looks, NULL);
    if (*disagreement < s->best) {
        s->best = *disagreement;
        s->x[way] = x[way];
    }
    return true;
}

// Along one way: a step to both sides, and where the parabola through the three has its least.
static bool search_along(Search *s, int way, double step, FfpError *err) {
    const double origin = s->x[way], middle = s->best;
    double low, high, there;
    if (!look_at(s, way, -step, origin, &low, err) || !look_at(s, way, step, origin, &high, err))
        return false;
    const double curve = low + high - 2 * middle;
    double by = low < high ? -REACH * step : REACH * step;
    if (curve > 0) by = fmax(-REACH * step, fmin(0.5 * step * (low - high) / curve, REACH * step));
    return look_at(s, way, by, origin, &there, err);
}

// Root mean square, about an axis, of the turns from one set of poses to another.
static double turned(const FfpView *from, const FfpView *to, int views) {
    double square = 0;
    for (int d = 0; d < 2 * views; d++) {
        const FfpView *a = &from[d / 2], *b = &to[d / 2];
        const FfpRigid old = ffp_rigid_from_pose(d % 2 ? a->projector.pose : a->camera.pose),
                       new = ffp_rigid_from_pose(d % 2 ? b->projector.pose : b->camera.pose);
        double r[9], v[3];
        ffp_rotation_difference(old.r, new.r, r);
        ffp_rotation_to_vector(r, v);
        square += ffp_dot(v, v) / (6 * views);
    }
    return sqrt(square);
}

// Keeps the ring's poses when pictures agree no worse under them.
static bool even_out(Search *s, const FfpRing *ring, FfpAlignReport *report, FfpError *err) {
    const int n = s->capture->n_views;
    double there;
    FfpView *before = ffp_alloc((size_t)n, sizeof *before);
    memcpy(before, s->capture->views, (size_t)n * sizeof *before);
    ffp_ring_place(ring, s->capture);
    const bool ok = ffp_photo_consistency(s->looker, &there, err);
    report->turntable = ok && there <= ALIKE * s->best;
    if (report->turntable) {
        report->evened = turned(before, s->capture->views, n);
        s->best = there;
    } else {
        memcpy(s->capture->views, before, (size_t)n * sizeof *before);
    }
    ffp_free(before);
    return ok;
}

// Steps that give each view poses of its own; keeps those under which the pictures agree best.
static bool adjust_each(Search *s, int active, const FfpAlignSettings *settings, FfpAlignReport *report,
                        FfpError *err) {
    const size_t size = (size_t)s->capture->n_views * sizeof(FfpView);
    FfpView *given = ffp_alloc(1, size), *best = ffp_alloc(1, size);
    FfpBundleReport here = {0}, kept = {0};
    memcpy(given, s->capture->views, size);
    memcpy(best, given, size);
    FfpTask progress = ffp_task("aligning each view", settings->steps);
    bool ok = true, better = false;
    for (int step = 0; ok && step <= settings->steps; step++) {
        double there = s->best;
        if (step > 0) ok = ffp_photo_consistency(s->looker, &there, err);
        const bool keep = ok && there < s->best;
        if (keep) {
            memcpy(best, s->capture->views, size);
            s->best = there;
            better = true;
        }
        // A step reports on the poses before it.
        const double share = settings->focal > 0 && 2 * step < settings->steps ? FOCAL_FIRST : 1;
        const FfpPoseErrors expected = {share * settings->expected.turn, share * settings->expected.shift};
        ok = ok && ffp_bundle_step(s->capture, given, active, &expected, settings->focal, &here, err);
        if (ok && step == 0) {
            report->off[0] = here.off;
            report->apart[0] = here.apart;
            kept = here;
        }
        if (ok && keep) kept = here;
        if (ok) ffp_task_step(&progress, step, NULL);
    }
    ffp_task_end(&progress);
    memcpy(s->capture->views, best, size);
    report->own = better;
    report->turned = kept.turned;
    report->off[1] = kept.off;
    report->apart[1] = kept.apart;
    report->camera = kept.camera;
    report->projector = kept.projector;
    ffp_free(given);
    ffp_free(best);
    return ok;
}

bool ffp_align(FfpCapture *capture, int active, const FfpAlignSettings *settings, FfpAlignReport *report,
               FfpError *err) {
    const size_t size = (size_t)capture->n_views * sizeof(FfpView);
    Search s = {.capture = capture, .looker = ffp_photo_consistency_new(capture, active)};
    FfpRing ring = {0};
    FfpView *from = ffp_alloc(1, size);
    *report = (FfpAlignReport){.camera = 1, .projector = 1};
    bool ok = ffp_photo_consistency(s.looker, &s.best, err);
    report->before = s.best;
    if (ok && ffp_ring_fit(&ring, capture, &settings->expected)) ok = even_out(&s, &ring, report, err);
    const bool each = !report->turntable || settings->focal > 0;
    const bool many = capture->n_views > FFP_BUNDLE_VIEWS_MAX;
    if (each && many)
        ffp_note("%d views: with more than %d, views do not get poses of their own", capture->n_views,
                 FFP_BUNDLE_VIEWS_MAX);
    if (ok && each && capture->n_views > 1 && !many) ok = adjust_each(&s, active, settings, report, err);
    memcpy(from, capture->views, size);
    s.from = from;
    set_ways(&s, report->turntable ? ring.axis : NULL, settings->expected.turn);
    s.progress = ffp_task("aligning", (int64_t)settings->rounds * s.n_ways * LOOKS);
    double step = FIRST_STEP;
    for (int round = 0; ok && round < settings->rounds; round++) {
        for (int way = 0; ok && way < s.n_ways; way++) ok = search_along(&s, way, step, err);
        step *= NEXT_STEP;
    }
    ffp_task_end(&s.progress);
    place(&s, s.x);
    report->after = s.best;
    report->depth = s.x[DEPTH] * settings->expected.turn;
    report->across = s.x[ACROSS] * settings->expected.turn;
    report->side = s.x[SIDE] * settings->expected.turn;
    ffp_ring_free(&ring);
    ffp_photo_consistency_free(s.looker);
    ffp_free(from);
    return ok;
}
