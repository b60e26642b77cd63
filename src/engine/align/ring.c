#include "engine/align/ring.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/numerics/least_squares.h"

#define STEPS 8
#define DIFFERENCE 1e-6 // in units of what is expected
#define LEAST_TURN 0.1  // sine of an angle between two views that tells the axis

// The ring's numbers: six of the camera, six of the projector, two of the axis' direction and two of its
// place, then an angle a view but the first.
enum { DEVICE = 6, DEVICES = 12, SHARED = 16, ROWS = 12 };

void ffp_ring_free(FfpRing *ring) {
    ffp_free(ring->angle);
    *ring = (FfpRing){0};
}

static FfpRigid on_ring(const FfpRing *ring, const FfpRigid *base, double angle) {
    const double v[3] = {ring->axis[0] * angle, ring->axis[1] * angle, ring->axis[2] * angle};
    double r[9], local[3];
    FfpRigid out;
    ffp_rotation_from_vector(v, r);
    ffp_rotation_product(r, base->r, out.r);
    for (int k = 0; k < 3; k++) local[k] = base->t[k] - ring->point[k];
    for (int k = 0; k < 3; k++) out.t[k] = ring->point[k] + ffp_dot(r + 3 * k, local);
    return out;
}

void ffp_ring_place(const FfpRing *ring, FfpCapture *capture) {
    for (int v = 0; v < ring->views; v++) {
        const FfpRigid camera = on_ring(ring, &ring->camera, ring->angle[v]),
                       projector = on_ring(ring, &ring->projector, ring->angle[v]);
        ffp_rigid_store(&camera, capture->views[v].camera.pose);
        ffp_rigid_store(&projector, capture->views[v].projector.pose);
    }
}

// The motion from the given pose to the one on the ring, in units of the expected errors.
static void difference(const FfpRigid *given, const FfpRigid *wanted, const FfpPoseErrors *e,
                       double out[DEVICE]) {
    double r[9];
    const double far = e->shift * sqrt(ffp_dot(given->t, given->t));
    ffp_rotation_difference(given->r, wanted->r, r);
    ffp_rotation_to_vector(r, out);
    for (int k = 0; k < 3; k++) {
        out[k] /= e->turn;
        out[3 + k] = (wanted->t[k] - given->t[k]) / far;
    }
}

static void differences(const FfpRing *ring, const FfpCapture *capture, const FfpPoseErrors *e, double *out) {
    for (int v = 0; v < ring->views; v++) {
        const FfpView *view = &capture->views[v];
        const FfpRigid given[2] = {ffp_rigid_from_pose(view->camera.pose),
                                   ffp_rigid_from_pose(view->projector.pose)};
        const FfpRigid wanted[2] = {on_ring(ring, &ring->camera, ring->angle[v]),
                                    on_ring(ring, &ring->projector, ring->angle[v])};
        for (int d = 0; d < 2; d++) difference(&given[d], &wanted[d], e, out + ROWS * v + DEVICE * d);
    }
}

// Adds `by` to one number of the ring, in units of what is expected of its kind.
static void move(FfpRing *ring, int number, double by, const FfpPoseErrors *e) {
    if (number >= SHARED) {
        ring->angle[number - SHARED + 1] += by * e->turn;
    } else if (number >= DEVICES) {
        const double *way = ring->across[number % 2];
        const bool direction = number < DEVICES + 2;
        for (int c = 0; c < 3; c++)
            (direction ? ring->axis : ring->point)[c] += by * (direction ? e->turn : e->shift) * way[c];
        ffp_unit(ring->axis);
    } else {
        FfpRigid *base = number < DEVICE ? &ring->camera : &ring->projector;
        double v[3] = {0}, r[9], turned[9];
        if (number % DEVICE >= 3) {
            base->t[number % 3] += by * e->shift;
            return;
        }
        v[number % 3] = by * e->turn;
        ffp_rotation_from_vector(v, r);
        ffp_rotation_product(base->r, r, turned);
        memcpy(base->r, turned, sizeof turned);
    }
}

typedef struct Fit {
    FfpRing *ring;
    const FfpCapture *capture;
    const FfpPoseErrors *expected;
    double *angle; // [views] of the ring that is tried
} Fit;

static void move_all(void *state, const double *by) {
    const Fit *fit = state;
    for (int k = 0; k < SHARED + fit->ring->views - 1; k++)
        if (by[k] != 0) move(fit->ring, k, by[k], fit->expected);
}

static void differences_of(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    FfpRing there = *fit->ring;
    there.angle = fit->angle;
    memcpy(there.angle, fit->ring->angle, (size_t)there.views * sizeof(double));
    Fit moved = *fit;
    moved.ring = &there;
    move_all(&moved, by);
    differences(&there, fit->capture, fit->expected, out);
}

static void improve(FfpRing *ring, const FfpCapture *capture, const FfpPoseErrors *e) {
    const int n = SHARED + ring->views - 1, rows = ROWS * ring->views;
    double *step = ffp_alloc((size_t)n, sizeof *step);
    for (int k = 0; k < n; k++) step[k] = DIFFERENCE;
    Fit fit = {ring, capture, e, ffp_alloc((size_t)ring->views, sizeof(double))};
    const FfpLeastSquares problem = {.state = &fit,
                                     .numbers = n,
                                     .count = rows,
                                     .differences = differences_of,
                                     .move = move_all,
                                     .step = step,
                                     .steps = STEPS,
                                     .worth = 1e-9};
    ring->misfit = sqrt(ffp_least_squares(&problem, NULL) / rows);
    ffp_free(step);
    ffp_free(fit.angle);
}

// The turn from the first camera to that of a view.
static void rotation_between(const FfpRing *ring, const FfpRigid *pose, double r[9]) {
    double back[9];
    for (int i = 0; i < 9; i++) back[i] = ring->camera.r[3 * (i % 3) + i / 3];
    ffp_rotation_product(pose->r, back, r);
}

static bool guess_axis(FfpRing *ring, const FfpCapture *capture) {
    double most = LEAST_TURN;
    bool found = false;
    for (int v = 1; v < ring->views; v++) {
        const FfpRigid pose = ffp_rigid_from_pose(capture->views[v].camera.pose);
        double r[9], turn[3];
        rotation_between(ring, &pose, r);
        ffp_rotation_to_vector(r, turn);
        const double sine = sin(sqrt(ffp_dot(turn, turn)));
        if (!(sine > most)) continue;
        most = sine;
        found = true;
        memcpy(ring->axis, turn, sizeof turn);
    }
    ffp_unit(ring->axis);
    ffp_perpendiculars(ring->axis, ring->across[0], ring->across[1]);
    return found;
}

// Angles from the cameras' turns, and the point nearest to zero that their places turn about.
static void guess_angles(FfpRing *ring, const FfpCapture *capture) {
    double a[9], b[3] = {0};
    for (int i = 0; i < 9; i++) a[i] = ring->axis[i / 3] * ring->axis[i % 3];
    for (int v = 0; v < ring->views; v++) {
        const FfpRigid pose = ffp_rigid_from_pose(capture->views[v].camera.pose);
        double r[9];
        rotation_between(ring, &pose, r);
        const double half[3] = {(r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2};
        ring->angle[v] = atan2(ffp_dot(half, ring->axis), (r[0] + r[4] + r[8] - 1) / 2);
        for (int k = 0; k < 3; k++) { // (1 - R) point = t - R t0, in least squares
            const double moved = pose.t[k] - ffp_dot(r + 3 * k, ring->camera.t);
            for (int i = 0; i < 3; i++) {
                const double left = (i == k) - r[3 * k + i];
                b[i] -= left * moved;
                for (int j = 0; j < 3; j++) a[3 * i + j] += left * ((k == j) - r[3 * k + j]);
            }
        }
    }
    ffp_solve_positive(a, b, 3, ring->point);
}

bool ffp_ring_fit(FfpRing *ring, const FfpCapture *capture, const FfpPoseErrors *expected) {
    *ring = (FfpRing){.views = capture->n_views};
    if (capture->n_views < 4) return false;
    ring->angle = ffp_alloc((size_t)capture->n_views, sizeof *ring->angle);
    ring->camera = ffp_rigid_from_pose(capture->views[0].camera.pose);
    ring->projector = ffp_rigid_from_pose(capture->views[0].projector.pose);
    if (!guess_axis(ring, capture)) {
        ffp_ring_free(ring);
        return false;
    }
    guess_angles(ring, capture);
    improve(ring, capture, expected);
    return true;
}
