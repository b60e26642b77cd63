#include "rig/graycode/codes.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "engine/match/coded.h"
#include "engine/match/line.h"

#define OFF_MAX 4.0  // pixels of the projector that a ray may pass a position by
#define CENTRED 0.25 // camera pixels by which the mean of known positions may lie off what is asked for
#define SPREAD 4     // times what neighbours differ by: more is two surfaces
enum { SCENE_POINTS = 5000 };
#define MISSED_MAX 0.05 // of the surface points that a sphere may leave out
#define STRAY 0.005     // of the points that a sphere around them leaves out at each end
#define MARGIN 1.05     // of its radius
#define SAMPLES_MAX 16  // a side

// --- Without lenses. ---

typedef struct Sum { // of weighted positions
    double weight, x, y, u, v, u_low, u_high, v_low, v_high;
} Sum;

static void add(Sum *sum, double weight, double x, double y, const real *p) {
    const double u = (double)p[0], v = (double)p[1];
    if (!(sum->weight > 0)) sum->u_low = sum->u_high = u, sum->v_low = sum->v_high = v;
    sum->weight += weight, sum->x += weight * x, sum->y += weight * y;
    sum->u += weight * u, sum->v += weight * v;
    sum->u_low = fmin(sum->u_low, u), sum->u_high = fmax(sum->u_high, u);
    sum->v_low = fmin(sum->v_low, v), sum->v_high = fmax(sum->v_high, v);
}

// The four pixels around a place in the photographs.
static void add_around(Sum *sum, const FfpImage *map, double x, double y) {
    const double left = floor(x - 0.5), top = floor(y - 0.5);
    for (int n = 0; n < 4; n++) {
        const double i = left + n % 2, j = top + (n >> 1);
        const double weight = (1 - fabs(i + 0.5 - x)) * (1 - fabs(j + 0.5 - y));
        if (!(weight > 0) || i < 0 || j < 0 || i >= map->width || j >= map->height) continue;
        const real *p = map->data + 3 * ((size_t)j * (size_t)map->width + (size_t)i);
        if (p[2] > 0) add(sum, weight, i + 0.5 - x, j + 0.5 - y, p);
    }
}

typedef struct Rectifying {
    const FfpImage *map;
    double spread;
    const FfpOptics *camera, *projector;
    const FfpCamera *pinhole, *ideal;
    int samples; // a side of each pixel
} Rectifying;

// The position that a pixel of the pinhole saw; false if unknown.
static bool position_at(const Rectifying *r, int column, int row, double *u, double *v) {
    const FfpCamera *pinhole = r->pinhole;
    Sum sum = {0};
    const int n = r->samples;
    for (int k = 0; k < n * n; k++) {
        const double x = (column + (k % n + 0.5) / n - (double)pinhole->cx) / (double)pinhole->fx;
        const double y = (row + (k / n + 0.5) / n - (double)pinhole->cy) / (double)pinhole->fy;
        double at_x, at_y;
        ffp_lens_distort(r->camera->lens, x, y, &at_x, &at_y);
        add_around(&sum, r->map, r->camera->cx + r->camera->fx * at_x, r->camera->cy + r->camera->fy * at_y);
    }
    if (!(sum.weight >= 0.5 * n * n) || hypot(sum.x, sum.y) > CENTRED * sum.weight) return false;
    *u = sum.u / sum.weight, *v = sum.v / sum.weight;
    return sum.u_high - sum.u_low <= r->spread && sum.v_high - sum.v_low <= r->spread;
}

// A place on the panel in the ideal projector's picture.
static bool without_lens(const Rectifying *r, double u, double v, real out[2]) {
    const FfpOptics *o = r->projector;
    double ray[2];
    if (!ffp_lens_undistort(o->lens, (u - o->cx) / o->fx, (v - o->cy) / o->fy, ray)) return false;
    out[0] = (real)((double)r->ideal->cx + (double)r->ideal->fx * ray[0]);
    out[1] = (real)((double)r->ideal->cy + (double)r->ideal->fy * ray[1]);
    // The range that readers of captures accept, whatever a lens makes of a corner.
    return out[0] >= -(real)r->ideal->width && out[0] <= 2 * (real)r->ideal->width &&
           out[1] >= -(real)r->ideal->height && out[1] <= 2 * (real)r->ideal->height;
}

FfpImage ffp_codes_rectify(const FfpImage *map, double step, const FfpOptics *camera,
                           const FfpCamera *pinhole, const FfpOptics *projector, const FfpCamera *ideal) {
    const double shrink = fmax(camera->fx / (double)pinhole->fx, 1);
    const int samples = (int)fmin(ceil(shrink - 1e-6), SAMPLES_MAX);
    const Rectifying r = {map, SPREAD * (step * shrink + 1), camera, projector, pinhole, ideal, samples};
    FfpImage out = ffp_image_new(pinhole->width, pinhole->height, 3);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < out.height; row++)
        for (int column = 0; column < out.width; column++) {
            real *p = out.data + 3 * ((size_t)row * (size_t)out.width + (size_t)column), at[2];
            double u, v;
            if (!position_at(&r, column, row, &u, &v) || !without_lens(&r, u, v, at)) continue;
            p[0] = at[0], p[1] = at[1], p[2] = 1;
        }
    return out;
}

FfpImage ffp_codes_region(const FfpImage *coverage, const FfpCamera *pinhole, const FfpOptics *camera) {
    FfpImage region = ffp_image_new(camera->width, camera->height, 1);
    const int reach =
        (int)ceil(0.5 * fmax(camera->fx / (double)pinhole->fx, camera->fy / (double)pinhole->fy));
    for (int y = 0; y < coverage->height; y++)
        for (int x = 0; x < coverage->width; x++) {
            double u, v;
            if (!(coverage->data[(size_t)y * (size_t)coverage->width + (size_t)x] > 0)) continue;
            ffp_lens_distort(camera->lens, (x + 0.5 - (double)pinhole->cx) / (double)pinhole->fx,
                             (y + 0.5 - (double)pinhole->cy) / (double)pinhole->fy, &u, &v);
            const int column = (int)floor(camera->cx + camera->fx * u),
                      row = (int)floor(camera->cy + camera->fy * v);
            for (int j = row > reach ? row - reach : 0; j <= row + reach && j < camera->height; j++)
                for (int i = column > reach ? column - reach : 0; i <= column + reach && i < camera->width;
                     i++)
                    region.data[(size_t)j * (size_t)camera->width + (size_t)i] = 1;
        }
    return region;
}

// --- Against the poses. ---

FfpCodesFit ffp_codes_check(FfpView *view) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    real *offs = ffp_alloc(pixels, sizeof *offs);
    FfpCodesFit fit = {0};
    for (size_t i = 0; i < pixels; i++) {
        real *p = view->correspondence.data + 3 * i, off = INFINITY;
        if (!(p[2] > 0)) continue;
        if (!(ffp_coded_depth(view, i, &off) > 0)) off = INFINITY;
        offs[fit.known++] = off;
        if (off <= (real)OFF_MAX)
            fit.kept++;
        else
            memset(p, 0, 3 * sizeof *p);
    }
    fit.off = (double)ffp_median(offs, (size_t)fit.known);
    ffp_free(offs);
    return fit;
}

// --- The object's sphere. ---

// True if most of the other views that have a point in their pictures show background there.
static bool is_background(const FfpCapture *capture, int own, const real point[3]) {
    int seen = 0, empty = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        if (v == own || !(ffp_project(&view->camera, point, &x, &y) > 0) || x < 0 || y < 0 ||
            x >= (real)view->camera.width || y >= (real)view->camera.height)
            continue;
        seen++;
        empty += !(view->coverage.data[(ptrdiff_t)y * view->camera.width + (ptrdiff_t)x] > 0);
    }
    return 2 * empty > seen;
}

// World points of all known positions, [count,3], less those of the wall at a silhouette's edge.
static real *surface_points(const FfpCapture *capture, size_t *count) {
    size_t room = 1;
    for (int v = 0; v < capture->n_views; v++)
        room += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    real *points = ffp_alloc(room, 3 * sizeof(real)), off;
    *count = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const size_t width = (size_t)view->camera.width, pixels = width * (size_t)view->camera.height;
        for (size_t i = 0; view->correspondence.data && i < pixels; i++) {
            const real z = ffp_coded_depth(view, i, &off);
            real *point = points + 3 * *count;
            if (!(z > 0)) continue;
            ffp_point_at(&view->camera, (real)(i % width) + 0.5F, (real)(i / width) + 0.5F, z, point);
            *count += !is_background(capture, v, point);
        }
    }
    return points;
}

static double distance_from(const real centre[3], const real *point) {
    double square = 0;
    for (int k = 0; k < 3; k++) square += pow((double)(point[k] - centre[k]), 2);
    return sqrt(square);
}

// The points' k-th coordinate below which a share of them lies.
static real quantile_of(real *scratch, const real *points, size_t count, int k, double share) {
    for (size_t i = 0; i < count; i++) scratch[i] = points[3 * i + (size_t)k];
    return ffp_quantile(scratch, count, share);
}

bool ffp_codes_bounds(FfpCapture *capture) {
    size_t count, missed = 0;
    real *points = surface_points(capture, &count), *scratch = ffp_alloc(count + 1, sizeof *scratch);
    for (size_t i = 0; i < count; i++)
        missed += distance_from(capture->centre, points + 3 * i) > (double)capture->radius;
    const bool move = count > 0 && (double)missed > MISSED_MAX * (double)count;
    if (move) {
        for (int k = 0; k < 3; k++)
            capture->centre[k] = (quantile_of(scratch, points, count, k, STRAY) +
                                  quantile_of(scratch, points, count, k, 1 - STRAY)) /
                                 2;
        for (size_t i = 0; i < count; i++) scratch[i] = (real)distance_from(capture->centre, points + 3 * i);
        capture->radius = (real)MARGIN * ffp_quantile(scratch, count, 1 - STRAY);
    }
    ffp_free(points), ffp_free(scratch);
    return move;
}

bool ffp_codes_scene_bounds(FfpCapture *capture) {
    size_t count;
    real *points = surface_points(capture, &count);
    const size_t stride = count / SCENE_POINTS + 1, n = (count + stride - 1) / stride;
    for (size_t i = 1; i < n; i++) memcpy(points + 3 * i, points + 3 * stride * i, 3 * sizeof *points);
    if (n > 0) ffp_capture_bound_scene(capture, (real(*)[3])(void *)points, (int)n);
    ffp_free(points);
    return n > 0;
}
