#include "rig/turntable/scan.h"
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/capture/pixel.h"
#include "core/image/lookup.h"
#include "core/numerics/rank.h"
#include "rig/optics/matrix.h"

#define VIEWS_MAX 8 // that are looked from
#define PIXELS_A_VIEW 60
#define DEPTHS 80
#define NEIGHBOURS 2    // further stops that must agree, one to either side
#define APART 0.14      // radians between neighbours, at least: from one place the same is seen
#define STEP 0.006      // of the distance's logarithm
#define ERROR_MAX 0.05  // of a pixel's mean square, beyond which a colour is simply wrong
#define UNSEEN 0.5      // of that, for a neighbour that does not see the point lit
#define REACH_LEAST 0.3 // share of points in the projector's frame

typedef struct PointView { // of a point at one stop
    float at[3];           // camera coordinates, axis' unit
    real colour[3];        // of the pattern, as the pixel there shows it; NAN: not seen lit
} PointView;

typedef struct Point {
    PointView point_views[1 + NEIGHBOURS];
} Point;

typedef struct Points { // of all pixels looked through
    Point *points;
    int *first; // [pixels + 1] of each pixel, in `points`
    int pixels;
} Points;

typedef struct Scanner {
    const FfpCapture *capture;
    const FfpOutlines *outlines;
    const FfpAxis *axis;
    int active;
    double centre[3], radius; // of the object at angle 0
} Scanner;

// False where the pixel shows the object in part, or tells no colour.
static bool observe(const Scanner *s, int view, size_t i, real colour[3]) {
    const FfpView *v = &s->capture->views[view];
    return v->coverage.data[i] >= 0.99F && ffp_lit_ratio(s->capture, v, &v->images[s->active], i, colour);
}

// The pixel that shows a point; false when the picture does not.
static bool find_pixel(const FfpCamera *camera, const double point[3], size_t *index) {
    if (!(point[2] > 0)) return false;
    const double x = (double)camera->cx + (double)camera->fx * point[0] / point[2],
                 y = (double)camera->cy + (double)camera->fy * point[1] / point[2];
    if (!(x >= 0 && y >= 0 && x < camera->width && y < camera->height)) return false;
    *index = (size_t)y * (size_t)camera->width + (size_t)x;
    return true;
}

// True if no silhouette speaks against a point of stop `view`.
static bool is_possible(const Scanner *s, int view, const double point[3]) {
    for (int other = 0; other < s->capture->n_views; other++) {
        const size_t width = (size_t)s->capture->views[other].camera.width;
        double there[3];
        size_t index = 0;
        ffp_axis_rotate(s->axis, s->outlines->angles[other] - s->outlines->angles[view], point, there);
        if (find_pixel(&s->capture->views[other].camera, there, &index) &&
            ffp_is_background(&s->capture->views[other].coverage, (int)(index % width), (int)(index / width)))
            return false;
    }
    return true;
}

static void fill_point(const Scanner *s, int view, const int stops[1 + NEIGHBOURS], const double point[3],
                       Point *out) {
    for (int k = 0; k <= NEIGHBOURS; k++) {
        PointView *point_view = &out->point_views[k];
        double there[3] = {0};
        size_t index = 0;
        point_view->colour[0] = NAN;
        if (stops[k] < 0) continue;
        ffp_axis_rotate(s->axis, s->outlines->angles[stops[k]] - s->outlines->angles[view], point, there);
        for (int i = 0; i < 3; i++) point_view->at[i] = (float)there[i];
        if (!find_pixel(&s->capture->views[stops[k]].camera, there, &index) ||
            !observe(s, stops[k], index, point_view->colour))
            point_view->colour[0] = NAN;
    }
}

// The possible points along a pixel's ray within the object's sphere; returns their number.
static int fill_pixel(const Scanner *s, int view, const int stops[1 + NEIGHBOURS], size_t index, Point *out) {
    const FfpCamera *camera = &s->capture->views[view].camera;
    const double x = (double)(index % (size_t)camera->width) + 0.5,
                 y = (double)(index / (size_t)camera->width) + 0.5;
    double ray[3] = {(x - (double)camera->cx) / (double)camera->fx,
                     (y - (double)camera->cy) / (double)camera->fy, 1};
    double middle[3];
    ffp_unit(ray);
    ffp_axis_rotate(s->axis, s->outlines->angles[view], s->centre, middle);
    const double along = ffp_dot(middle, ray),
                 half = s->radius * s->radius - (ffp_dot(middle, middle) - along * along);
    int n = 0;
    for (int k = 0; k < DEPTHS && half > 0; k++) {
        const double t = along + sqrt(half) * (2 * (k + 0.5) / DEPTHS - 1);
        const double point[3] = {t * ray[0], t * ray[1], t * ray[2]};
        if (t > 0 && is_possible(s, view, point)) fill_point(s, view, stops, point, &out[n++]);
    }
    return n;
}

static void fill_view(const Scanner *s, int view, Points *points) {
    const FfpCamera *camera = &s->capture->views[view].camera;
    const size_t pixels = (size_t)camera->width * (size_t)camera->height;
    const int stops[1 + NEIGHBOURS] = {view, ffp_next_stop(s->outlines, view, 1, APART),
                                       ffp_next_stop(s->outlines, view, -1, APART)};
    real colour[3];
    size_t lit = 0, seen = 0;
    for (size_t i = 0; i < pixels; i++) lit += observe(s, view, i, colour);
    const size_t step = lit / PIXELS_A_VIEW + 1;
    for (size_t i = 0; i < pixels; i++) {
        if (!observe(s, view, i, colour) || seen++ % step != 0) continue;
        const int from = points->first[points->pixels];
        const int n = fill_pixel(s, view, stops, i, points->points + from);
        if (n > 0) points->first[++points->pixels] = from + n;
    }
}

static Points fill(const Scanner *s) {
    const int n = s->capture->n_views, step = (n + VIEWS_MAX - 1) / VIEWS_MAX;
    const size_t room = (size_t)VIEWS_MAX * (PIXELS_A_VIEW + 1);
    Points points = {.points = ffp_alloc(room * DEPTHS, sizeof(Point)),
                     .first = ffp_alloc(room + 1, sizeof(int))};
    for (int v = 0; v < n; v += step) fill_view(s, v, &points);
    return points;
}

// --- One distance. ---

typedef struct Lamp {
    const FfpCamera *projector;
    double c2p[16];
    const FfpSummed *pattern;
    real footprint;
} Lamp;

// Mean square difference of a point's colour at one stop; a point the pattern does not reach is as wrong as
// can be.
static double judge(const Lamp *lamp, const PointView *point_view, double factor, bool *reached) {
    double q[3];
    for (int i = 0; i < 3; i++)
        q[i] = lamp->c2p[4 * i + 3] + factor * (lamp->c2p[4 * i] * (double)point_view->at[0] +
                                                lamp->c2p[4 * i + 1] * (double)point_view->at[1] +
                                                lamp->c2p[4 * i + 2] * (double)point_view->at[2]);
    const double u = (double)lamp->projector->cx + (double)lamp->projector->fx * q[0] / q[2],
                 v = (double)lamp->projector->cy + (double)lamp->projector->fy * q[1] / q[2];
    *reached = q[2] > 0 && u >= 0 && v >= 0 && u < lamp->projector->width && v < lamp->projector->height;
    if (!*reached) return ERROR_MAX;
    real colour[3];
    double sum = 0;
    ffp_lookup(lamp->pattern, (real)u, (real)v, lamp->footprint, lamp->footprint, colour);
    for (int c = 0; c < 3; c++) sum += pow((double)colour[c] - (double)point_view->colour[c], 2) / 3;
    return fmin(sum, ERROR_MAX);
}

// Least mean cost of a pixel's points; *reached counts those that the projector's frame holds.
static double best_of_pixel(const Lamp *lamp, const Point *points, int n, double factor, int *reached) {
    double best = ERROR_MAX;
    for (int i = 0; i < n; i++) {
        bool in = false, there;
        double sum = judge(lamp, &points[i].point_views[0], factor, &in);
        *reached += in;
        for (int k = 1; k <= NEIGHBOURS && sum < best * (1 + NEIGHBOURS); k++) {
            const PointView *point_view = &points[i].point_views[k];
            sum +=
                isnan(point_view->colour[0]) ? UNSEEN * ERROR_MAX : judge(lamp, point_view, factor, &there);
        }
        best = fmin(best, sum / (1 + NEIGHBOURS));
    }
    return best;
}

// NAN where the projector does not reach enough of the object.
static double try_distance(const Lamp *lamp, const Points *points, double factor) {
    double sum = 0;
    int reached = 0;
    double *costs = ffp_alloc((size_t)points->pixels + 1, sizeof *costs);
#pragma omp parallel for schedule(static) reduction(+ : reached)
    for (int i = 0; i < points->pixels; i++) {
        const int from = points->first[i];
        costs[i] = best_of_pixel(lamp, points->points + from, points->first[i + 1] - from, factor, &reached);
    }
    for (int i = 0; i < points->pixels; i++) sum += costs[i];
    ffp_free(costs);
    const bool enough = reached >= REACH_LEAST * points->first[points->pixels];
    return points->pixels > 0 && enough ? sum / points->pixels : NAN;
}

// Pattern pixels side by side that a camera pixel covers at a distance.
static real footprint_at(const Scanner *s, const Lamp *lamp, double factor) {
    double z = lamp->c2p[11];
    for (int i = 0; i < 3; i++) z += factor * lamp->c2p[8 + i] * s->centre[i];
    const double camera = factor * s->centre[2] / (double)s->capture->views[0].camera.fx;
    return z > 0 ? (real)fmax(camera * (double)lamp->projector->fx / z, 1) : 1;
}

FfpScan ffp_scan_distance(const FfpCapture *capture, int active, const FfpOutlines *outlines,
                          const FfpAxis *axis, double low, double high) {
    Scanner scanner = {.capture = capture, .outlines = outlines, .axis = axis, .active = active};
    double p2c[16];
    FfpScan out = {.factor = 1, .error = INFINITY};
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    Lamp lamp = {.projector = &capture->views[0].projector, .pattern = &pattern};
    for (int i = 0; i < 16; i++) p2c[i] = (double)lamp.projector->pose[i];
    ffp_pose_inverse(p2c, lamp.c2p);
    ffp_outline_sphere(outlines, axis, scanner.centre, &scanner.radius);
    Points points = fill(&scanner);
    const int steps = (int)(log(high / low) / STEP) + 1;
    double *errors = ffp_alloc((size_t)steps, sizeof *errors);
    for (int i = 0; i < steps; i++) {
        ffp_cancel_point();
        const double factor = low * exp(i * STEP);
        lamp.footprint = footprint_at(&scanner, &lamp, factor);
        const double error = try_distance(&lamp, &points, factor);
        if (isnan(error)) continue;
        errors[out.tried++] = error;
        if (error < out.error) out.error = error, out.factor = factor;
    }
    out.chance = out.tried > 0 ? ffp_median(errors, (size_t)out.tried) : INFINITY;
    ffp_free(errors), ffp_free(points.points), ffp_free(points.first);
    ffp_summed_free(&pattern);
    return out;
}
