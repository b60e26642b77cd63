#include "engine/align/bundle.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/least_squares.h"
#include "engine/align/tie_points.h"
#include "engine/match/reduce.h"

enum { NUMBERS = 12, FOCALS = 2 }; // of a view; shared

#define EVIDENCE 0.05   // of an observation: neighbours repeat each other's errors
#define APART_NOISE 0.7 // footprints by which matched surfaces lie beside each other
#define APART_MAX 6.0   // and from which they are different surfaces
#define FACING 0.5      // cosine between normals that are of one surface
#define TOGETHER 0.1    // of the focal lengths' expected error: what both have in common
#define HUBER 2.0       // deviations from which an observation loses weight

typedef struct Bundle {
    const FfpCapture *capture; // that is matched: reduced or not
    const FfpView *given;
    const FfpPoseErrors *expected;
    double focal;
    int views, n;
    FfpTiePoints *tie_points; // [views]
    double *a, *b;            // [n,n], [n]: half of the squared sum's derivatives
    double off, off_weight, apart, spread_weight;
} Bundle;

// --- Equations. ---

typedef struct Row { // a residual's derivatives by the numbers of one or two views and the focal lengths
    int n, place[2 * NUMBERS + FOCALS];
    double by[2 * NUMBERS + FOCALS];
} Row;

static void add_row(Bundle *bundle, const Row *row, double residual, double weight) {
    const double deviations = fabs(residual) * sqrt(weight);
    const double w = EVIDENCE * weight * (deviations > HUBER ? HUBER / deviations : 1);
    for (int i = 0; i < row->n; i++) {
        double *line = bundle->a + (size_t)row->place[i] * (size_t)bundle->n;
        bundle->b[row->place[i]] += w * row->by[i] * residual;
        for (int k = 0; k < row->n; k++) line[row->place[k]] += w * row->by[i] * row->by[k];
    }
}

static void extend(Row *row, const Bundle *bundle, int view, const double by[FFP_TIE_POINT_NUMBERS],
                   double sign) {
    const int focals = NUMBERS * bundle->views;
    for (int k = 0; k < NUMBERS; k++) {
        row->place[row->n] = NUMBERS * view + k;
        row->by[row->n++] = sign * by[k];
    }
    if (!(bundle->focal > 0)) return;
    for (int k = 0; k < FOCALS; k++) {
        int at = 0;
        while (at < row->n && row->place[at] != focals + k) at++;
        if (at == row->n) {
            row->place[row->n] = focals + k;
            row->by[row->n++] = 0;
        }
        row->by[at] += sign * by[NUMBERS + k];
    }
}

static void add_across(Bundle *bundle, int view, const FfpTiePoint *s) {
    Row row = {0};
    extend(&row, bundle, view, s->off_by, 1);
    add_row(bundle, &row, s->off, s->weight);
    bundle->off += s->weight * s->off * s->off;
    bundle->off_weight += s->weight;
}

static void along_normal(double out[FFP_TIE_POINT_NUMBERS], const FfpTiePoint *s, const double normal[3]) {
    for (int k = 0; k < FFP_TIE_POINT_NUMBERS; k++) out[k] = ffp_dot(s->point_by[k], normal);
}

// The tie point of another view at a point, where both see one surface.
static const FfpTiePoint *same_surface(const Bundle *bundle, const FfpTiePoint *s, int other) {
    const FfpTiePoints *there = &bundle->tie_points[other];
    const real point[3] = {(real)s->point[0], (real)s->point[1], (real)s->point[2]};
    real x, y;
    if (!(ffp_project(&bundle->capture->views[other].camera, point, &x, &y) > 0)) return NULL;
    if (!(x >= 0 && y >= 0 && x < (real)there->width && y < (real)there->height)) return NULL;
    const int index = there->index[(size_t)y * (size_t)there->width + (size_t)x];
    if (index < 0 || ffp_dot(s->normal, there->all[index].normal) < FACING) return NULL;
    return &there->all[index];
}

static void add_spread(Bundle *bundle, int view, const FfpTiePoint *s, int other, const FfpTiePoint *t) {
    const double difference[3] = {s->point[0] - t->point[0], s->point[1] - t->point[1],
                                  s->point[2] - t->point[2]};
    const double apart = ffp_dot(difference, t->normal), unit = fmax(s->footprint, t->footprint);
    double by[FFP_TIE_POINT_NUMBERS];
    Row row = {0};
    if (fabs(apart) > APART_MAX * unit) return;
    along_normal(by, s, t->normal);
    extend(&row, bundle, view, by, 1);
    along_normal(by, t, t->normal);
    extend(&row, bundle, other, by, -1);
    const double trust = s->trust * t->trust, noise = APART_NOISE * unit;
    add_row(bundle, &row, apart, trust / (noise * noise));
    bundle->apart += trust * apart * apart / (unit * unit);
    bundle->spread_weight += trust;
}

// --- What is expected. ---

static void difference(const FfpCamera *given, const FfpCamera *now, double out[6]) {
    const FfpRigid a = ffp_rigid_from_pose(given->pose), b = ffp_rigid_from_pose(now->pose);
    double r[9];
    ffp_rotation_difference(a.r, b.r, r);
    ffp_rotation_to_vector(r, out);
    for (int k = 0; k < 3; k++) out[3 + k] = b.t[k] - a.t[k];
}

static void expect_row(Bundle *bundle, const Row *row, double value, double deviation) {
    const double weight = 1 / (deviation * deviation);
    for (int i = 0; i < row->n; i++) {
        bundle->b[row->place[i]] += weight * row->by[i] * value;
        for (int k = 0; k < row->n; k++)
            bundle->a[(size_t)row->place[i] * (size_t)bundle->n + (size_t)row->place[k]] +=
                weight * row->by[i] * row->by[k];
    }
}

// Together the two focal lengths only make the object larger or smaller, of which matched surfaces say less
// than matching errs by: what is found is how one is to the other.
static void expect_focals(Bundle *bundle) {
    const FfpView *given = &bundle->given[0], *now = &bundle->capture->views[0];
    const double smaller = (double)given->camera.width / now->camera.width; // what is matched
    const double camera = log(smaller * (double)(now->camera.fx / given->camera.fx)),
                 projector = log((double)(now->projector.fx / given->projector.fx));
    const int first = NUMBERS * bundle->views;
    Row both = {2, {first, first + 1}, {0.5, 0.5}}, apart = {2, {first, first + 1}, {1, -1}};
    const double alike = TOGETHER * bundle->focal;
    expect_row(bundle, &both, (camera + projector) / 2, alike);
    expect_row(bundle, &apart, camera - projector, bundle->focal);
}

static void add_expectations(Bundle *bundle) {
    for (int d = 0; d < 2 * bundle->views; d++) {
        const FfpView *given = &bundle->given[d / 2], *now = &bundle->capture->views[d / 2];
        const FfpCamera *from = d % 2 ? &given->projector : &given->camera,
                        *to = d % 2 ? &now->projector : &now->camera;
        double numbers[6];
        difference(from, to, numbers);
        const FfpRigid at = ffp_rigid_from_pose(from->pose);
        const double far = bundle->expected->shift * sqrt(ffp_dot(at.t, at.t));
        for (int k = 0; k < 6; k++) {
            const Row row = {1, {6 * d + k}, {1}};
            expect_row(bundle, &row, numbers[k], k < 3 ? bundle->expected->turn : far);
        }
    }
    if (bundle->focal > 0) expect_focals(bundle);
}

// --- The step. ---

static void move_device(FfpCamera *device, const double numbers[6], double focal) {
    FfpRigid motion = ffp_rigid_from_pose(device->pose);
    double r[9], turned[9];
    ffp_rotation_from_vector(numbers, r);
    ffp_rotation_product(motion.r, r, turned);
    memcpy(motion.r, turned, sizeof turned);
    for (int k = 0; k < 3; k++) motion.t[k] += numbers[3 + k];
    ffp_rigid_store(&motion, device->pose);
    device->fx *= (real)exp(focal);
    device->fy *= (real)exp(focal);
}

typedef struct Looking {
    Bundle *bundle;
    const FfpInitialisation *start;
    int active;
} Looking;

static void look(void *argument, int64_t view) {
    const Looking *l = argument;
    l->bundle->tie_points[view] = ffp_tie_points_new(l->bundle->capture, l->start, (int)view, l->active);
}

static void add_all(Bundle *bundle) {
    for (int v = 0; v < bundle->views; v++) {
        for (int64_t i = 0; i < bundle->tie_points[v].count; i++) {
            const FfpTiePoint *s = &bundle->tie_points[v].all[i];
            add_across(bundle, v, s);
            for (int other = 0; other < bundle->views; other++) {
                const FfpTiePoint *t = other != v ? same_surface(bundle, s, other) : NULL;
                if (t) add_spread(bundle, v, s, other, t);
            }
        }
        ffp_cancel_point();
    }
    add_expectations(bundle);
}

static void tell(const Bundle *bundle, FfpBundleReport *report) {
    double square = 0;
    for (int d = 0; d < 2 * bundle->views; d++) {
        const FfpView *given = &bundle->given[d / 2], *now = &bundle->capture->views[d / 2];
        double numbers[6];
        difference(d % 2 ? &given->projector : &given->camera, d % 2 ? &now->projector : &now->camera,
                   numbers);
        square += ffp_dot(numbers, numbers) / (6 * bundle->views);
    }
    const FfpView *given = &bundle->given[0], *now = &bundle->capture->views[0];
    *report = (FfpBundleReport){.off = sqrt(bundle->off / fmax(bundle->off_weight, 1e-30)),
                                .apart = sqrt(bundle->apart / fmax(bundle->spread_weight, 1e-30)),
                                .turned = sqrt(square),
                                .camera = (double)(now->camera.fx / given->camera.fx) * given->camera.width /
                                          now->camera.width,
                                .projector = (double)(now->projector.fx / given->projector.fx)};
}

static void step(Bundle *bundle, FfpCapture *capture, FfpBundleReport *report) {
    double *x = ffp_alloc((size_t)bundle->n, sizeof *x);
    add_all(bundle);
    tell(bundle, report);
    ffp_solve_positive(bundle->a, bundle->b, bundle->n, x);
    double focals[FOCALS] = {0};
    if (bundle->focal > 0) memcpy(focals, x + (ptrdiff_t)NUMBERS * bundle->views, sizeof focals);
    for (int v = 0; v < bundle->views; v++) {
        move_device(&capture->views[v].camera, x + (ptrdiff_t)NUMBERS * v, focals[0]);
        move_device(&capture->views[v].projector, x + (ptrdiff_t)NUMBERS * v + 6, focals[1]);
    }
    ffp_free(x);
}

bool ffp_bundle_step(FfpCapture *capture, const FfpView *given, int active, const FfpPoseErrors *expected,
                     double focal, FfpBundleReport *report, FfpError *err) {
    const FfpMatchSettings matching = ffp_match_defaults();
    FfpInitialisation start;
    if (capture->n_views > FFP_BUNDLE_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "more than %d views", FFP_BUNDLE_VIEWS_MAX);
    if (!ffp_initialisation_new(&start, capture, &active, 1, &matching, err)) return false;
    Bundle bundle = {.capture = start.reduced ? &start.reduced->capture : capture,
                     .given = given,
                     .expected = expected,
                     .focal = focal,
                     .views = capture->n_views};
    bundle.n = NUMBERS * bundle.views + (focal > 0 ? FOCALS : 0);
    bundle.a = ffp_alloc((size_t)bundle.n * (size_t)bundle.n, sizeof *bundle.a);
    bundle.b = ffp_alloc((size_t)bundle.n, sizeof *bundle.b);
    bundle.tie_points = ffp_alloc((size_t)bundle.views, sizeof *bundle.tie_points);
    Looking looking = {&bundle, start.reduced ? &start.reduced->start : &start, active};
    ffp_parallel_for(bundle.views, 0, look, &looking);
    step(&bundle, capture, report);
    for (int v = 0; v < bundle.views; v++) ffp_tie_points_free(&bundle.tie_points[v]);
    ffp_free(bundle.a);
    ffp_free(bundle.b);
    ffp_free(bundle.tie_points);
    ffp_initialisation_free(&start);
    return true;
}
