#include "engine/match/layout.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/foreground.h"
#include "engine/match/labels.h"
#include "engine/match/thresholds.h"
#include "engine/match/unlit_work.h"

enum { PLANES_MAX = 14, POINTS_MAX = 8000, SEEDS = 400, FITS = 3 };
#define NEAR_PLANE 2.0F   // footprints off a plane within which a point lies on it
#define FACING 0.9F       // least cosine between its normal and the plane's
#define LEAST_SHARE 0.02F // of all points that make a plane
#define WALL 0.5F         // of the points on a wall, as many may seem to lie behind it,
#define BEHIND 4.0F       // by so many footprints;
#define WALL_LEAST 0.05F  // share of all points that make one: wrong ones agree on small planes
#define ODD 0.15F         // cost of lying on no plane
#define BEYOND 0.2F       // cost of lying e times as far from a plane's middle as its points do,
#define USUAL 1.5F        // in units of the root of their mean squared distance
#define SMALLER 0.05F     // cost of a plane that has e times fewer points than the largest
#define UNSEEN 0.2F       // share of both where no other view looks: there the pixels around should tell
#define UNSEEN_WALL 0.3F  // cost of a wall there, of which other planes' is FFP_UNLIT_UNKNOWN
#define BURIED 4.0F       // cost of lying behind a wall
#define OUTSIDE 1.0F      // cost of a plane that the ray does not meet from its front,
#define OFF 4.0F          // and of one that a trusted point does not lie on
#define ROUNDS 3          // of labels; in all but the first, by the depths of the round before:
#define VOTES 0.2F        // cost of a plane that all other views see past; less where they agree
#define SAME 0.03F        // difference of depths, as a share, within which they do

typedef struct Plane { // normal . x = away; the normal faces the cameras
    real normal[3], away;
    real middle[3], reach; // of its points: mean, and root of the mean squared distance from there
    int points;
    bool wall; // nothing lies behind it
} Plane;

typedef struct Point {
    real at[3], normal[3], footprint;
} Point;

// --- Planes. ---

static int list_points(Point *points, const FfpDepths *depths, const real *normals) {
    const size_t width = (size_t)depths->width, area = width * (size_t)depths->height,
                 pixels = area * (size_t)depths->capture->n_views;
    size_t trusted = 0, seen = 0;
    int count = 0;
    for (size_t i = 0; i < pixels; i++) trusted += depths->trust[i] > 0 && depths->depth[i] > 0;
    const size_t every = trusted / POINTS_MAX + 1;
    for (size_t i = 0; i < pixels; i++) {
        if (!(depths->trust[i] > 0 && depths->depth[i] > 0) || seen++ % every != 0) continue;
        const FfpCamera *camera = &depths->capture->views[i / area].camera;
        const size_t p = i % area;
        Point *to = &points[count++];
        ffp_point_at(camera, (real)(p % width) + 0.5F, (real)(p / width) + 0.5F, depths->depth[i], to->at);
        for (int k = 0; k < 3; k++) to->normal[k] = normals[3 * i + (size_t)k];
        to->footprint = depths->depth[i] / camera->fx;
    }
    return count;
}

static real height_over(const Plane *plane, const real point[3]) {
    return ffp_dot3(plane->normal, point) - plane->away;
}

static bool lies_on(const Point *point, const Plane *plane) {
    return fabs(height_over(plane, point->at)) <= NEAR_PLANE * point->footprint &&
           ffp_dot3(plane->normal, point->normal) >= FACING;
}

static int count_on(const Plane *plane, const Point *points, int n) {
    int count = 0;
    for (int i = 0; i < n; i++) count += lies_on(&points[i], plane);
    return count;
}

// Least squares of the heights over the plane: height = a + b u + c v about the points' mean, where a is 0.
static void fit(Plane *plane, const Point *points, int n) {
    real mean[3] = {0, 0, 0}, u[3], v[3], uu = 0, uv = 0, vv = 0, uh = 0, vh = 0;
    real square = 0;
    int count = 0;
    for (int i = 0; i < n; i++) {
        if (!lies_on(&points[i], plane)) continue;
        for (int k = 0; k < 3; k++) mean[k] += points[i].at[k];
        count++;
    }
    if (count < 3) return;
    for (int k = 0; k < 3; k++) mean[k] /= (real)count;
    const int least = fabs(plane->normal[0]) < fabs(plane->normal[1]) ? 0 : 1;
    real axis[3] = {0, 0, 0};
    axis[least] = 1;
    ffp_cross3(plane->normal, axis, u);
    ffp_normalise3(u);
    ffp_cross3(plane->normal, u, v);
    for (int i = 0; i < n; i++) {
        if (!lies_on(&points[i], plane)) continue;
        real off[3];
        for (int k = 0; k < 3; k++) off[k] = points[i].at[k] - mean[k];
        const real a = ffp_dot3(off, u), b = ffp_dot3(off, v), h = ffp_dot3(off, plane->normal);
        uu += a * a, uv += a * b, vv += b * b, uh += a * h, vh += b * h;
        square += ffp_dot3(off, off);
    }
    const real det = uu * vv - uv * uv;
    if (!(det > 1e-6F * uu * vv)) return;
    const real b = (vv * uh - uv * vh) / det, c = (uu * vh - uv * uh) / det;
    for (int k = 0; k < 3; k++) plane->normal[k] -= b * u[k] + c * v[k];
    ffp_normalise3(plane->normal);
    plane->away = ffp_dot3(plane->normal, mean);
    plane->points = count;
    plane->reach = sqrt(square / (real)count);
    for (int k = 0; k < 3; k++) plane->middle[k] = mean[k];
}

static void swap(Point *a, Point *b) {
    const Point c = *a;
    *a = *b;
    *b = c;
}

// The planes of most points, one after the other (Fischler and Bolles 1981, with a point and its normal for a
// sample). Returns how many there are; the points change their order.
static int find_planes(Plane planes[PLANES_MAX], Point *points, int n) {
    const int least = (int)(LEAST_SHARE * (real)n) + 3;
    int count = 0;
    while (count < PLANES_MAX && n >= least) {
        Plane best = {.points = 0};
        for (int s = 0; s < SEEDS && s < n; s++) {
            const Point *seed = &points[(int64_t)s * n / (SEEDS < n ? SEEDS : n)];
            Plane tried = {.normal = {seed->normal[0], seed->normal[1], seed->normal[2]}};
            tried.away = ffp_dot3(tried.normal, seed->at);
            tried.points = count_on(&tried, points, n);
            if (tried.points > best.points) best = tried;
        }
        if (best.points < least) break;
        for (int round = 0; round < FITS; round++) fit(&best, points, n);
        planes[count++] = best;
        int left = 0;
        for (int i = 0; i < n; i++)
            if (!lies_on(&points[i], &best)) swap(&points[left++], &points[i]);
        if (left == n) break; // the fit has moved off them
        n = left;
    }
    return count;
}

// Walls, floor and ceiling of a room end it: hardly any point lies behind them. Other planes have points of
// what they stand before.
static void find_walls(Plane *planes, int count, const Point *points, int n) {
    for (int k = 0; k < count; k++) {
        int behind = 0;
        for (int i = 0; i < n; i++)
            behind += height_over(&planes[k], points[i].at) < -BEHIND * points[i].footprint;
        planes[k].wall =
            (real)planes[k].points >= WALL_LEAST * (real)n && (real)behind <= WALL * (real)planes[k].points;
    }
}

// --- Labels. ---

typedef struct Layout {
    const FfpUnlit *scene;
    const Plane *planes;
    int count;
    const real *filled, *lit;
    FfpForeground *foreground; // [views]
    real **evidence;           // [views] of [pixels of the foreground, labels]: costs without votes
    const real *before;        // [views,h,w]: depths of the round before; NULL in the first
    real *depth;
} Layout;

// Camera depth at which a pixel's ray meets a plane from its front, within the view's range; 0: it does not.
static real depth_on(const Plane *plane, const FfpView *view, size_t pixel) {
    const FfpCamera *camera = &view->camera;
    const size_t width = (size_t)camera->width;
    const real local[3] = {((real)(pixel % width) + 0.5F - camera->cx) / camera->fx,
                           ((real)(pixel / width) + 0.5F - camera->cy) / camera->fy, 1};
    const real eye[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    real direction[3];
    ffp_rotate(camera->pose, local, direction);
    const real towards = ffp_dot3(plane->normal, direction);
    if (!(towards < -1e-4F)) return 0;
    const real z = (plane->away - ffp_dot3(plane->normal, eye)) / towards;
    return z >= view->near && z <= view->far ? z : 0;
}

// How far beyond the points that make a plane its point at depth z of a pixel lies: 0 among them, 1 at e
// times their usual reach.
static real beyond(const Plane *plane, const FfpView *view, size_t pixel, real z) {
    const size_t width = (size_t)view->camera.width;
    real at[3], off[3];
    ffp_point_at(&view->camera, (real)(pixel % width) + 0.5F, (real)(pixel / width) + 0.5F, z, at);
    for (int k = 0; k < 3; k++) off[k] = at[k] - plane->middle[k];
    const real far = sqrt(ffp_dot3(off, off)) / (USUAL * plane->reach + 1e-6F);
    return far > 1 ? log(far) : 0;
}

// The evidence against a plane before any picture is asked: it is small, and ends before the pixel's
// point at depth z.
static real plane_prior(const Layout *l, int k, const FfpView *view, size_t pixel, real z) {
    return SMALLER * log((real)l->planes[0].points / (real)l->planes[k].points) +
           BEYOND * beyond(&l->planes[k], view, pixel, z);
}

// The other views' judgement of the ray's point at depth z, by their depths of the round before: 1 if all
// that can tell see past it, -1 if all have it, 0 if fewer than two can tell.
static real votes(const Layout *l, const FfpUnlitRay *ray, real z) {
    const FfpDepths *depths = l->scene->depths;
    const FfpAsked *asked = &l->scene->support_views.asked[ray->view];
    int past = 0, agree = 0;
    for (int k = 0; k < asked->count; k++) {
        const int other = asked->view[k];
        real u = -1, v = -1;
        if (other == ray->view) continue;
        const real depth = ffp_line_at(&ray->camera[other], z, &u, &v);
        if (!(u >= 0 && v >= 0 && u < (real)depths->width && v < (real)depths->height)) continue;
        const size_t row = (size_t)other * (size_t)depths->height + (size_t)v;
        const real theirs = l->before[row * (size_t)depths->width + (size_t)u];
        past += depth < (1 - SAME) * theirs;
        agree += depth >= (1 - SAME) * theirs && depth <= (1 + SAME) * theirs;
    }
    return past + agree > 1 ? (real)(past - agree) / (real)(past + agree) : 0;
}

// The cost that a pixel's point at depth z has for lying behind a wall.
static real burial(const Layout *l, const FfpView *view, size_t pixel, real z) {
    const size_t width = (size_t)view->camera.width;
    real point[3];
    ffp_point_at(&view->camera, (real)(pixel % width) + 0.5F, (real)(pixel / width) + 0.5F, z, point);
    for (int k = 0; k < l->count; k++)
        if (l->planes[k].wall && height_over(&l->planes[k], point) < -BEHIND * z / view->camera.fx)
            return BURIED;
    return 0;
}

// Cost of a pixel without a trusted depth to lie on plane k, at depth z, without votes.
static real plane_cost(const Layout *l, int k, const FfpUnlitRay *ray, size_t pixel, real z) {
    const FfpView *view = &l->scene->depths->capture->views[ray->view];
    if (!(z > 0)) return OUTSIDE;
    const real seen = ffp_unlit_cost(l->scene, ray, z);
    const bool unknown = seen == FFP_UNLIT_UNKNOWN;
    const real cost = unknown && l->planes[k].wall ? UNSEEN_WALL : seen;
    return cost + (unknown ? UNSEEN : 1) * plane_prior(l, k, view, pixel, z) + burial(l, view, pixel, z);
}

// Cost of its filled depth. Of an unlit pixel that was found by chance, so that it is no better than unknown.
static real filled_cost(const Layout *l, const FfpUnlitRay *ray, size_t i) {
    const real cost = ffp_unlit_cost(l->scene, ray, l->filled[i]);
    return l->lit[i] >= FFP_LIT_MIN ? cost : fmax(cost, FFP_UNLIT_UNKNOWN);
}

// Costs of a pixel's labels without votes: the planes, and none of them last.
static void label_costs(real *cost, const Layout *l, int view, size_t pixel, FfpLine *lines) {
    const FfpDepths *depths = l->scene->depths;
    const FfpView *self = &depths->capture->views[view];
    const size_t i = (size_t)view * (size_t)depths->width * (size_t)depths->height + pixel;
    const bool trusted = depths->trust[i] > 0;
    const FfpUnlitRay ray = ffp_unlit_ray(l->scene, view, pixel, lines);
    for (int k = 0; k < l->count; k++) {
        const real z = depth_on(&l->planes[k], self, pixel), slack = 2 * NEAR_PLANE * z / self->camera.fx;
        const bool on = z > 0 && fabs(z - depths->depth[i]) <= slack;
        cost[k] = trusted ? (on ? 0 : OFF) : plane_cost(l, k, &ray, pixel, z);
    }
    cost[l->count] = ODD + (trusted ? 0 : filled_cost(l, &ray, i) + burial(l, self, pixel, l->filled[i]));
}

static void gather_evidence(void *argument, int64_t view) {
    const Layout *l = argument;
    const FfpCapture *capture = l->scene->depths->capture;
    const FfpForeground foreground = ffp_foreground_new(&capture->views[view].coverage);
    const size_t labels = (size_t)l->count + 1;
    real *cost = ffp_alloc(foreground.count * labels, sizeof *cost);
    FfpLine *lines = ffp_alloc(2 * (size_t)capture->n_views, sizeof *lines);
    for (size_t slot = 0; slot < foreground.count; slot++)
        label_costs(cost + slot * labels, l, (int)view, foreground.pixel[slot], lines);
    ffp_free(lines);
    l->foreground[view] = foreground;
    l->evidence[view] = cost;
    ffp_cancel_point();
}

// Adds the votes on the planes to a view's costs.
static void count_votes(real *cost, const Layout *l, int view) {
    const FfpDepths *depths = l->scene->depths;
    const FfpForeground *foreground = &l->foreground[view];
    const size_t first = (size_t)view * (size_t)depths->width * (size_t)depths->height;
    FfpLine *lines = ffp_alloc(2 * (size_t)depths->capture->n_views, sizeof *lines);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t pixel = foreground->pixel[slot];
        if (depths->trust[first + pixel] > 0) continue;
        const FfpUnlitRay ray = ffp_unlit_ray(l->scene, view, pixel, lines);
        for (int k = 0; k < l->count; k++) {
            const real z = depth_on(&l->planes[k], &depths->capture->views[view], pixel);
            if (z > 0) cost[slot * ((size_t)l->count + 1) + (size_t)k] += VOTES * votes(l, &ray, z);
        }
    }
    ffp_free(lines);
}

static void choose_depths(const Layout *l, int view, const real *total) {
    const FfpDepths *depths = l->scene->depths;
    const FfpForeground *foreground = &l->foreground[view];
    const size_t first = (size_t)view * (size_t)depths->width * (size_t)depths->height;
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t pixel = foreground->pixel[slot], i = first + pixel;
        const real *here = total + slot * ((size_t)l->count + 1);
        int best = l->count;
        if (depths->trust[i] > 0) continue;
        for (int k = 0; k < l->count; k++)
            if (here[k] < here[best]) best = k;
        const FfpView *self = &depths->capture->views[view];
        const real z = best < l->count ? depth_on(&l->planes[best], self, pixel) : 0;
        l->depth[i] = z > 0 ? z : l->filled[i];
    }
}

static void label_view(void *argument, int64_t index) {
    const Layout *l = argument;
    const FfpDepths *depths = l->scene->depths;
    const int view = (int)index, labels = l->count + 1;
    const size_t first = (size_t)view * (size_t)depths->width * (size_t)depths->height,
                 cells = l->foreground[view].count * (size_t)labels;
    real *total = ffp_alloc(cells, sizeof(real)), *voted = NULL;
    if (l->before) {
        voted = ffp_alloc(cells, sizeof(real));
        memcpy(voted, l->evidence[view], cells * sizeof(real));
        count_votes(voted, l, view);
    }
    ffp_labels_total(total, voted ? voted : l->evidence[view], &l->foreground[view], labels,
                     l->scene->encoded + 3 * first);
    choose_depths(l, view, total);
    ffp_free(voted);
    ffp_free(total);
    ffp_cancel_point();
}

static void label_views(Layout *l, int rounds) {
    const FfpDepths *depths = l->scene->depths;
    const int views = depths->capture->n_views;
    const size_t count = (size_t)depths->width * (size_t)depths->height * (size_t)views;
    real *before = ffp_alloc(count, sizeof(real));
    l->foreground = ffp_alloc((size_t)views, sizeof *l->foreground);
    l->evidence = ffp_alloc((size_t)views, sizeof *l->evidence);
    ffp_parallel_for(views, 0, gather_evidence, l);
    for (int round = 0; round < rounds; round++) {
        memcpy(before, l->depth, count * sizeof(real));
        l->before = round > 0 ? before : NULL;
        ffp_parallel_for(views, 0, label_view, l);
    }
    for (int v = 0; v < views; v++) {
        ffp_free(l->evidence[v]);
        ffp_foreground_free(&l->foreground[v]);
    }
    ffp_free(l->evidence);
    ffp_free(l->foreground);
    ffp_free(before);
}

void ffp_layout_depths(real *depth, const FfpDepths *depths, const real *normals, const real *filled,
                       const real *lit) {
    const size_t count = (size_t)depths->width * (size_t)depths->height * (size_t)depths->capture->n_views;
    memcpy(depth, filled, count * sizeof(real));
    Point *points = ffp_alloc(POINTS_MAX + 1, sizeof *points);
    Plane planes[PLANES_MAX];
    const int listed = list_points(points, depths, normals), found = find_planes(planes, points, listed);
    const bool several =
        depths->capture->n_views > 2; // two see too little of a room, and of each other's part
    if (several) find_walls(planes, found, points, listed);
    ffp_free(points);
    if (found == 0) return;
    FfpUnlit scene = ffp_unlit_new(depths);
    Layout layout = {
        .scene = &scene, .planes = planes, .count = found, .filled = filled, .lit = lit, .depth = depth};
    label_views(&layout, several ? ROUNDS : 1);
    ffp_unlit_free(&scene);
}
