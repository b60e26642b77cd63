#include "rig/turntable/cloud.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/capture/pixel.h"
#include "engine/match/match.h"
#include "rig/optics/matrix.h"

#define POINTS_A_PAIR 600
#define APART 0.14     // radians
#define REACH 2        // pixels to either side that a plane is fitted to
#define PLANE_LEAST 14 // of them that must belong to one surface
#define JUMP 0.03      // of the inverse depth, to a neighbour of the same surface
#define ROUGH 0.003    // of the inverse depth: planes that fit worse are none
#define ALIKE 0.7      // cosine between normals of the same surface
#define FAR_SHARE 0.15 // of the object's radius

// --- The rig about an axis. ---

FfpCapture ffp_placed_new(const FfpCapture *capture, const FfpOutlines *outlines, const FfpAxis *axis,
                          double *radius) {
    FfpCapture out = *capture;
    double centre[3], p2c[16], c2w[16], p2w[16];
    static const double axes[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
    for (int i = 0; i < 16; i++) p2c[i] = (double)capture->views[0].projector.pose[i];
    out.views = ffp_alloc((size_t)out.n_views, sizeof *out.views);
    for (int v = 0; v < out.n_views; v++) {
        out.views[v] = capture->views[v];
        for (int k = 0; k < 4; k++) {
            double column[3];
            if (k < 3)
                ffp_axis_rotate_direction(axis, -outlines->angles[v], axes[k], column);
            else
                ffp_axis_rotate(axis, -outlines->angles[v], axes[k], column);
            for (int i = 0; i < 3; i++) c2w[4 * i + k] = column[i];
            c2w[12 + k] = k == 3;
        }
        ffp_pose_product(c2w, p2c, p2w);
        for (int i = 0; i < 16; i++)
            out.views[v].camera.pose[i] = (real)c2w[i], out.views[v].projector.pose[i] = (real)p2w[i];
    }
    ffp_outline_sphere(outlines, axis, centre, radius);
    for (int i = 0; i < 3; i++) out.centre[i] = (real)centre[i];
    out.radius = (real)*radius;
    const real middle[3] = {out.centre[0], out.centre[1], out.centre[2]};
    ffp_capture_normalise(&out, middle, out.radius);
    return out;
}

void ffp_placed_free(FfpCapture *placed) {
    ffp_free(placed->views);
    *placed = (FfpCapture){0};
}

// --- Planes. ---

static bool is_lit(const FfpCapture *capture, const FfpView *view, size_t i) {
    return view->coverage.data[i] >= 0.99F && ffp_is_lit(capture, view, i);
}

// Sums for a plane of inverse depth q = a + b x + c y.
typedef struct PlaneSums {
    double n, x, y, xx, xy, yy, q, xq, yq, qq;
} PlaneSums;

static void add_to_plane(PlaneSums *s, double x, double y, double q) {
    s->n++, s->x += x, s->y += y, s->xx += x * x, s->xy += x * y, s->yy += y * y;
    s->q += q, s->xq += x * q, s->yq += y * q, s->qq += q * q;
}

// a, b, c and the root mean square that is left; false when the pixels lie on a line.
static bool solve_plane(const PlaneSums *s, double plane[3], double *rest) {
    const double xx = s->xx - s->x * s->x / s->n, yy = s->yy - s->y * s->y / s->n,
                 xy = s->xy - s->x * s->y / s->n, xq = s->xq - s->x * s->q / s->n,
                 yq = s->yq - s->y * s->q / s->n, qq = s->qq - s->q * s->q / s->n;
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-9)) return false;
    plane[1] = (yy * xq - xy * yq) / det, plane[2] = (xx * yq - xy * xq) / det;
    plane[0] = (s->q - plane[1] * s->x - plane[2] * s->y) / s->n;
    *rest = sqrt(fmax(0, qq - plane[1] * xq - plane[2] * yq) / s->n);
    return true;
}

static void fit_plane(const double *inverse, const FfpCamera *camera, int x, int y, double plane[3]) {
    const int w = camera->width, h = camera->height;
    const double here = inverse[(ptrdiff_t)y * w + x];
    PlaneSums sums = {0};
    double q[3], rest = 0;
    memset(plane, 0, 3 * sizeof *plane);
    if (!(here > 0)) return;
    for (int dy = -REACH; dy <= REACH; dy++) {
        for (int dx = -REACH; dx <= REACH; dx++) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= w || y + dy >= h) continue;
            const double there = inverse[(ptrdiff_t)(y + dy) * w + x + dx];
            if (fabs(there - here) < JUMP * here) add_to_plane(&sums, dx, dy, there);
        }
    }
    if (sums.n < PLANE_LEAST || !solve_plane(&sums, q, &rest) || rest > ROUGH * here) return;
    const double at[2] = {(x + 0.5 - (double)camera->cx) / (double)camera->fx,
                          (y + 0.5 - (double)camera->cy) / (double)camera->fy};
    plane[0] = q[1] * (double)camera->fx, plane[1] = q[2] * (double)camera->fy;
    plane[2] = q[0] - plane[0] * at[0] - plane[1] * at[1];
}

// Planes of a stop from its matched depth.
static void fit_planes(const FfpCapture *capture, const FfpCapture *placed, int view, int active,
                       double radius, double (*planes)[3]) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpCamera *camera = &capture->views[view].camera;
    const size_t pixels = (size_t)camera->width * (size_t)camera->height;
    real *depth = ffp_alloc(pixels, sizeof *depth);
    double *inverse = ffp_alloc(pixels, sizeof *inverse);
    ffp_match_depth(placed, view, &active, 1, &settings, depth);
    for (size_t i = 0; i < pixels; i++) {
        const bool there = depth[i] > 0 && is_lit(capture, &capture->views[view], i);
        inverse[i] = there ? 1 / ((double)depth[i] * radius) : 0;
    }
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels; i++)
        fit_plane(inverse, camera, (int)(i % (size_t)camera->width), (int)(i / (size_t)camera->width),
                  planes[i]);
    ffp_free(depth), ffp_free(inverse);
}

// --- Points. ---

static bool pixel_point(const FfpCamera *camera, const double plane[3], size_t index, int stop, int next,
                        FfpCloudPoint *out) {
    const double ray[3] = {
        ((double)(index % (size_t)camera->width) + 0.5 - (double)camera->cx) / (double)camera->fx,
        ((double)(index / (size_t)camera->width) + 0.5 - (double)camera->cy) / (double)camera->fy, 1};
    const double q = ffp_dot(plane, ray);
    if (!(q > 0)) return false;
    *out = (FfpCloudPoint){.stop = stop, .next = next};
    for (int i = 0; i < 3; i++) out->at[i] = ray[i] / q, out->normal[i] = -plane[i];
    ffp_unit(out->normal);
    return true;
}

static void add_points(FfpClouds *clouds, int stop, int next) {
    const size_t pixels = (size_t)clouds->camera->width * (size_t)clouds->camera->height;
    double(*planes)[3] = clouds->planes[stop];
    size_t there = 0, seen = 0;
    for (size_t i = 0; i < pixels; i++) there += planes[i][2] != 0;
    const size_t step = there / POINTS_A_PAIR + 1;
    for (size_t i = 0; i < pixels && next >= 0; i++) {
        if (planes[i][2] == 0 || seen++ % step != 0) continue;
        if (pixel_point(clouds->camera, planes[i], i, stop, next, &clouds->points[clouds->count]))
            clouds->count++;
    }
}

FfpClouds ffp_clouds_new(const FfpCapture *capture, int active, const FfpOutlines *outlines,
                         const FfpAxis *axis) {
    FfpClouds out = {.camera = &capture->views[0].camera, .angles = outlines->angles, .n = capture->n_views};
    const size_t pixels = (size_t)out.camera->width * (size_t)out.camera->height;
    double radius = 0;
    FfpCapture placed = ffp_placed_new(capture, outlines, axis, &radius);
    out.far = FAR_SHARE * radius;
    out.planes = ffp_alloc((size_t)out.n, sizeof *out.planes);
    out.points = ffp_alloc((size_t)out.n * 2 * (POINTS_A_PAIR + 1), sizeof *out.points);
    for (int v = 0; v < out.n; v++) {
        out.planes[v] = ffp_alloc(pixels, sizeof *out.planes[v]);
        fit_planes(capture, &placed, v, active, radius, out.planes[v]);
    }
    for (int v = 0; v < out.n; v++) {
        add_points(&out, v, ffp_next_stop(outlines, v, 1, APART));
        add_points(&out, v, ffp_next_stop(outlines, v, -1, APART));
    }
    ffp_placed_free(&placed);
    return out;
}

void ffp_clouds_free(FfpClouds *clouds) {
    for (int v = 0; v < clouds->n; v++) ffp_free(clouds->planes[v]);
    ffp_free(clouds->planes);
    ffp_free(clouds->points);
    *clouds = (FfpClouds){0};
}

static double residual(const FfpClouds *clouds, const FfpAxis *axis, const FfpCloudPoint *point) {
    const FfpCamera *camera = clouds->camera;
    const double angle = clouds->angles[point->next] - clouds->angles[point->stop];
    double there[3], normal[3];
    ffp_axis_rotate(axis, angle, point->at, there);
    if (!(there[2] > 0)) return INFINITY;
    const double x = (double)camera->cx + (double)camera->fx * there[0] / there[2],
                 y = (double)camera->cy + (double)camera->fy * there[1] / there[2];
    if (!(x >= 0 && y >= 0 && x < camera->width && y < camera->height)) return INFINITY;
    const double *plane = clouds->planes[point->next][(size_t)y * (size_t)camera->width + (size_t)x];
    const double length = sqrt(ffp_dot(plane, plane));
    ffp_axis_rotate_direction(axis, angle, point->normal, normal);
    if (!(-ffp_dot(normal, plane) > ALIKE * length)) return INFINITY;
    const double distance = (ffp_dot(plane, there) - 1) / length;
    return fabs(distance) < clouds->far ? distance : INFINITY;
}

void ffp_cloud_residuals(const void *context, const FfpAxis *axis, double *residuals) {
    const FfpClouds *clouds = context;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < clouds->count; i++) residuals[i] = residual(clouds, axis, &clouds->points[i]);
}
