// Each view's own projector gives the surface that it sees, whatever the others say. Surfaces of neighbouring
// views are one surface, unless something moved in between.
#include "rig/checks/slip.h"
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/rigid.h"
#include "core/capture/pixel.h"
#include "core/capture/reduce.h"
#include "core/capture/small.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"
#include "engine/match/match.h"
#include "engine/match/surface.h"
#include "rig/checks/measure.h"

// Lengths in radii of the object's sphere.
#define REACH 2          // pixels to either side that a plane is fitted to
#define SAMPLES 400      // pixels of a view that are compared with a neighbour
#define ALIKE 0.7F       // cosine between normals of the same surface
#define APART_MOST 0.3F  // between surfaces that may be the same
#define COARSE 0.1       // between surfaces: beyond it counts less and less; at first, and
#define FINE 0.025       // in the end
#define ACROSS 0.26F     // cosine of 75 degrees: cameras farther apart see what they share at grazing angles
#define STEP 1e-3        // of the derivatives
#define OVERLAP_LEAST 20 // pixels that both views see: fewer tell nothing
#define PATCH ((2 * REACH + 1) * (2 * REACH + 1)) // pixels that share a plane: what they say is one thing
#define PATCHES_SURE 3 // that both views see, for the three numbers of a shift: fewer accuse nobody
#define BROKEN 0.3     // mean cost of a pair, from which on something may have moved, if
#define ABOVE 2.5      // it is so many times what the best quarter of the pairs cost, or
#define CERTAIN 0.7    // above this where all cost much, and
#define MENDED 0.5     // a motion leaves less than this of it
#define CLOSED 0.7     // likewise of the pair where the views end that moved
#define TURNED 0.6     // of the cost under a shift, that a turn must leave less than to be told
enum {
    SHIFT,
    TURN = 3,
    NUMBERS = 6
}; // of a motion: the shift, then the turn about the sphere's centre, radians

typedef struct Surface {
    real (*point)[3], (*normal)[3]; // [h*w] world; normal 0: none
} Surface;

// Two neighbouring views, and how the object moved from the first to the second.
typedef struct Pair {
    const FfpCapture *capture; // normalised
    const Surface *surfaces;   // [views]
    int view[2], count[2];
    size_t *pixel[2]; // [count] of each view, that are compared with the other,
    double step[2];   // one of so many
    double motion[NUMBERS], scale;
    double seen;          // patches that both see, before that motion
    double before, after; // mean costs
} Pair;

// --- Surfaces. ---

// Correspondences, where a view has any, give the only depths that count.
static bool is_lit(const FfpCapture *capture, const FfpView *view, size_t i) {
    if (view->correspondence.data && !(view->correspondence.data[3 * i + 2] > 0)) return false;
    return view->coverage.data[i] >= 0.99F && ffp_is_lit(capture, view, i);
}

// Matched as if it were the only view.
static Surface surface_new(const FfpCapture *capture, int view, int active) {
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpCapture alone = *capture;
    alone.views += view, alone.n_views = 1;
    const FfpCamera *camera = &alone.views->camera;
    const size_t w = (size_t)camera->width, pixels = w * (size_t)camera->height;
    Surface out = {ffp_alloc(pixels, sizeof *out.point), ffp_alloc(pixels, sizeof *out.normal)};
    real *depth = ffp_alloc(pixels, sizeof *depth), *weight = ffp_alloc(pixels, sizeof *weight);
    ffp_match_depth(&alone, 0, &active, 1, &settings, depth);
    for (size_t i = 0; i < pixels; i++) weight[i] = is_lit(&alone, alone.views, i);
    FfpSheet sheet = ffp_sheet_new(depth, weight, camera, REACH);
    for (size_t i = 0; i < pixels; i++) {
        FfpPlane planes[FFP_MATCH_LANES];
        const real x = (real)(i % w) + 0.5F, y = (real)(i / w) + 0.5F;
        if (!(weight[i] > 0)) continue;
        ffp_fit_planes(planes, &sheet, (int)(i % w), (int)(i / w));
        if (!(planes->q0 > 0)) continue;
        ffp_plane_normal(planes, camera, x, y, out.normal[i]);
        ffp_point_at(camera, x, y, 1 / planes->q0, out.point[i]);
    }
    ffp_sheet_free(&sheet);
    ffp_free(depth);
    ffp_free(weight);
    return out;
}

static bool is_there(const Surface *surface, size_t i) {
    const real *n = surface->normal[i];
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

// How far a point of one view's surface, moved to `at`, lies before the other's, in whose pixel *i it falls;
// INFINITY: that view does not see it.
static double distance_to(const Pair *pair, int side, const double at[3], const double normal[3], size_t *i) {
    const Surface *other = &pair->surfaces[pair->view[side]];
    const FfpCamera *camera = &pair->capture->views[pair->view[side]].camera;
    const real point[3] = {(real)at[0], (real)at[1], (real)at[2]};
    real x, y, distance = 0, alike = 0;
    if (!(ffp_project(camera, point, &x, &y) > 0)) return INFINITY;
    if (!(x >= 0 && y >= 0 && x < (real)camera->width && y < (real)camera->height)) return INFINITY;
    *i = (size_t)y * (size_t)camera->width + (size_t)x;
    for (int k = 0; k < 3; k++) {
        alike += other->normal[*i][k] * (real)normal[k];
        distance += other->normal[*i][k] * (point[k] - other->point[*i][k]);
    }
    return alike > ALIKE && fabs((double)distance) < APART_MOST ? (double)distance : INFINITY;
}

// --- Motions. ---

// A point and a normal of the pair's view `side`, as the other saw them: R p + t, and back.
static void carry(const double turn[9], const double shift[3], int side, const real p[3], const real m[3],
                  double at[3], double normal[3]) {
    for (int i = 0; i < 3; i++) {
        at[i] = side == 0 ? shift[i] : 0;
        normal[i] = 0;
        for (int k = 0; k < 3; k++) {
            const double r = side == 0 ? turn[3 * i + k] : turn[3 * k + i];
            at[i] += r * ((double)p[k] - (side == 0 ? 0 : shift[k]));
            normal[i] += r * (double)m[k];
        }
    }
}

// Of pixel i of the view `side`, before the other's surface. A place of the other's that this view does not
// see hides the point, as the near side of a thin thing hides the far one: INFINITY.
static double distance_of(const Pair *pair, const double turn[9], const double shift[3], int side, size_t i) {
    const Surface *own = &pair->surfaces[pair->view[side]], *other = &pair->surfaces[pair->view[1 - side]];
    double at[3], normal[3];
    size_t there, back;
    carry(turn, shift, side, own->point[i], own->normal[i], at, normal);
    const double distance = distance_to(pair, 1 - side, at, normal, &there);
    if (!isfinite(distance)) return distance;
    carry(turn, shift, 1 - side, other->point[there], other->normal[there], at, normal);
    return isfinite(distance_to(pair, side, at, normal, &back)) ? distance : INFINITY;
}

// [count[0] + count[1]] How far the points of each view lie before the other's surface.
static void distances(const Pair *pair, const double motion[NUMBERS], double *out) {
    double turn[9];
    ffp_rotation_from_vector(motion + TURN, turn);
    for (int side = 0; side < 2; side++)
        for (int n = 0; n < pair->count[side]; n++)
            *out++ = distance_of(pair, turn, motion + SHIFT, side, pair->pixel[side][n]);
}

static void differences(const void *state, const double *by, double *out) {
    const Pair *pair = state;
    double motion[NUMBERS];
    for (int k = 0; k < NUMBERS; k++) motion[k] = pair->motion[k] + by[k];
    distances(pair, motion, out);
}

static void move(void *state, const double *by) {
    Pair *pair = state;
    for (int k = 0; k < NUMBERS; k++) pair->motion[k] += by[k];
}

// The function of Geman and McClure; what the other does not see costs as much as what is far off.
static double weigh(const void *state, const double *found, double *weights) {
    const Pair *pair = state;
    double sum = 0;
    for (int i = 0; i < pair->count[0] + pair->count[1]; i++) {
        const double q = found[i] / pair->scale, square = q * q;
        weights[i] = isfinite(square) ? 1 / ((1 + square) * (1 + square)) : 0;
        sum += isfinite(square) ? square / (1 + square) : 1;
    }
    return sum;
}

// Mean cost of what both views see under a motion, 1 where that is too little; *seen or NULL: how many
// patches.
static double cost_of(const Pair *pair, const double motion[NUMBERS], double *seen) {
    const int count = pair->count[0] + pair->count[1];
    double *found = ffp_alloc((size_t)count + 1, sizeof *found), sum = 0, pixels = 0;
    int n = 0;
    distances(pair, motion, found);
    for (int i = 0; i < count; i++) {
        const double q = found[i] / FINE;
        if (!isfinite(q)) continue;
        sum += q * q / (1 + q * q);
        pixels += pair->step[i >= pair->count[0]] / 2; // both see them
        n++;
    }
    ffp_free(found);
    if (seen) *seen = pixels / PATCH;
    return n >= OVERLAP_LEAST ? sum / n : 1;
}

// The shift under which the surfaces meet, with a turn if that brings them much closer.
static void fit(Pair *pair) {
    static const double step[NUMBERS] = {STEP, STEP, STEP, STEP, STEP, STEP};
    FfpLeastSquares problem = {.state = pair,
                               .count = pair->count[0] + pair->count[1],
                               .differences = differences,
                               .move = move,
                               .weigh = weigh,
                               .step = step,
                               .steps = 12,
                               .worth = 1e-3};
    Pair shifted = *pair;
    for (problem.numbers = TURN; problem.numbers <= NUMBERS; problem.numbers += NUMBERS - TURN) {
        for (int pass = 0; pass < 2; pass++) {
            pair->scale = pass == 0 ? COARSE : FINE;
            ffp_least_squares(&problem, NULL);
        }
        pair->after = cost_of(pair, pair->motion, NULL);
        if (problem.numbers == TURN) shifted = *pair;
    }
    if (pair->after > TURNED * shifted.after) *pair = shifted;
}

// Of two cameras' directions from the object's centre, which is the origin.
static real cosine_between(const FfpCapture *capture, int first, int second) {
    const real *a = capture->views[first].camera.pose, *b = capture->views[second].camera.pose;
    real product = 0, squares[2] = {0};
    for (int i = 3; i < 12; i += 4)
        product += a[i] * b[i], squares[0] += a[i] * a[i], squares[1] += b[i] * b[i];
    return product / (real)sqrt((double)(squares[0] * squares[1]));
}

static Pair pair_new(const FfpCapture *capture, const Surface *surfaces, int first, int second) {
    static const double none[NUMBERS] = {0};
    const FfpCamera *camera = &capture->views[0].camera;
    const size_t pixels = (size_t)camera->width * (size_t)camera->height;
    Pair out = {.capture = capture, .surfaces = surfaces, .view = {first, second}};
    if (cosine_between(capture, first, second) < ACROSS) return out;
    for (int k = 0; k < 2; k++) {
        const Surface *surface = &surfaces[out.view[k]];
        size_t there = 0, seen = 0;
        for (size_t i = 0; i < pixels; i++) there += is_there(surface, i);
        const size_t step = there / SAMPLES + 1;
        out.pixel[k] = ffp_alloc(SAMPLES + 1, sizeof *out.pixel[k]);
        out.step[k] = (double)step;
        for (size_t i = 0; i < pixels; i++)
            if (is_there(surface, i) && seen++ % step == 0) out.pixel[k][out.count[k]++] = i;
    }
    out.before = cost_of(&out, none, &out.seen);
    out.after = out.before;
    if (out.before > BROKEN) fit(&out);
    ffp_cancel_point();
    return out;
}

// --- Who moved. ---

static bool is_broken(const Pair *pair, double limit) {
    return pair->seen >= PATCHES_SURE && pair->before > limit && pair->after < MENDED * pair->before;
}

// The cost from which on something may have moved, in view of how well this capture's surfaces meet.
static double limit_of(const Pair *pairs, int n) {
    double *costs = ffp_alloc((size_t)n, sizeof *costs);
    int sure = 0;
    for (int p = 0; p < n; p++)
        if (pairs[p].seen >= PATCHES_SURE) costs[sure++] = pairs[p].before;
    if (sure > 0) ffp_rank(costs, (size_t)sure, (size_t)sure / 4);
    const double usual = sure > 0 ? costs[sure / 4] : 0;
    ffp_free(costs);
    return fmax(BROKEN, fmin(ABOVE * usual, CERTAIN));
}

// The pair that the motion back from that of `broken` mends best: there the moved views end; -1: none.
static int find_end(const Pair *pairs, int n, int broken) {
    double turn[9], back[NUMBERS] = {0}, least = CLOSED;
    const double *motion = pairs[broken].motion;
    int best = -1;
    ffp_rotation_from_vector(motion + TURN, turn);
    for (int i = 0; i < 3; i++) {
        back[TURN + i] = -motion[TURN + i];
        for (int k = 0; k < 3; k++) back[SHIFT + i] -= turn[3 * k + i] * motion[SHIFT + k];
    }
    for (int p = 0; p < n; p++) {
        const bool apart = p != broken && pairs[p].before > BROKEN;
        const double left = apart ? cost_of(&pairs[p], back, NULL) / pairs[p].before : INFINITY;
        if (!(left < least)) continue;
        least = left;
        best = p;
    }
    return best;
}

// Two pairs that do not fit, round an object: the views between them moved. One of the two may show too
// little.
static void explain(FfpSlip *out, const Pair *pairs, int n) {
    const double limit = limit_of(pairs, n);
    int end = -1;
    for (int p = 0; p < n; p++) {
        if (!is_broken(&pairs[p], limit)) continue;
        const int worst = out->pair;
        out->pairs++;
        out->pair = worst < 0 || pairs[p].after * pairs[worst].before < pairs[worst].after * pairs[p].before
                        ? p
                        : worst;
        end = out->pair == p ? worst : p;
    }
    if (out->pairs == 1) end = find_end(pairs, n, out->pair);
    if (out->pairs == 0 || out->pairs > 2 || end < 0) return;
    const double *motion = pairs[out->pair].motion;
    out->first = (out->pair < end ? out->pair : end) + 1;
    out->last = out->pair < end ? end : out->pair;
    out->shift = sqrt(ffp_dot(motion + SHIFT, motion + SHIFT));
    out->turn = sqrt(ffp_dot(motion + TURN, motion + TURN)) * 180 / acos(-1.0);
}

FfpSlip ffp_rig_slip(const FfpCapture *capture, int active) {
    const int n = capture->n_views;
    FfpSlip out = {.pair = -1, .first = -1, .last = -1};
    if (n < FFP_RIG_VIEWS_TO_ACCUSE) return out;
    FfpCapture small = ffp_small_new(capture, active);
    ffp_capture_normalise(&small, capture->centre, capture->radius);
    Surface *surfaces = ffp_alloc((size_t)n, sizeof *surfaces);
    Pair *pairs = ffp_alloc((size_t)n, sizeof *pairs);
    for (int v = 0; v < n; v++) surfaces[v] = surface_new(&small, v, active);
    for (int v = 0; v < n; v++) {
        pairs[v] = pair_new(&small, surfaces, v, (v + 1) % n);
        out.compared += pairs[v].seen >= PATCHES_SURE;
    }
    explain(&out, pairs, n);
    out.shift *= (double)capture->radius;
    for (int v = 0; v < n; v++) {
        for (int k = 0; k < 2; k++) ffp_free(pairs[v].pixel[k]);
        ffp_free(surfaces[v].point);
        ffp_free(surfaces[v].normal);
    }
    ffp_free(pairs);
    ffp_free(surfaces);
    ffp_capture_reduced_free(&small);
    return out;
}
