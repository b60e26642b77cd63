#include "rig/turntable/outline.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"

#define PAIRS_MAX 400
#define LEVEL 0.5
#define WIDEST                                                                                               \
    1.3 // radians between a tangent plane and the object's middle: more, and the cameras look along
        // the line between them

// --- One silhouette. ---

typedef struct Crossing {
    double x, y; // pixels
    bool cut;
} Crossing;

static int compare(const void *a, const void *b) {
    const Crossing *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

// Positive when a, b, c turn left.
static double turn(const Crossing *a, const Crossing *b, const Crossing *c) {
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

// Andrew's monotone chain (1979), in place: the hull of sorted points; returns its size.
static int hull(Crossing *points, int n) {
    Crossing *out = ffp_alloc(2 * (size_t)n + 1, sizeof *out);
    int count = 0;
    for (int pass = 0; pass < 2; pass++) {
        const int start = count;
        for (int i = 0; i < n; i++) {
            const Crossing *next = &points[pass == 0 ? i : n - 1 - i];
            while (count >= start + 2 && turn(&out[count - 2], &out[count - 1], next) <= 0) count--;
            out[count++] = *next;
        }
        count--; // it begins the other half
    }
    count = count > 0 ? count : n;
    memcpy(points, out, (size_t)count * sizeof *points);
    ffp_free(out);
    return count;
}

// All places between neighbouring pixel centres where the coverage crosses the level; at the picture's edge
// the object's pixels themselves.
static int cross_level(const FfpImage *coverage, Crossing *out) {
    const int w = coverage->width, h = coverage->height;
    int n = 0;
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            const double here = (double)coverage->data[(ptrdiff_t)y * w + x];
            const bool edge = x == 0 || y == 0 || x + 1 == w || y + 1 == h;
            if (edge && here >= LEVEL) out[n++] = (Crossing){x + 0.5, y + 0.5, true};
            for (int k = 0; k < 2; k++) {
                if (k == 0 ? x + 1 == w : y + 1 == h) continue;
                const double next =
                    (double)coverage->data[k == 0 ? (ptrdiff_t)y * w + x + 1 : (ptrdiff_t)(y + 1) * w + x];
                if ((here >= LEVEL) == (next >= LEVEL)) continue;
                const double share = (LEVEL - here) / (next - here);
                out[n++] = (Crossing){x + 0.5 + (k == 0 ? share : 0), y + 0.5 + (k == 1 ? share : 0), false};
            }
        }
    }
    return n;
}

static void to_ray(const FfpCamera *camera, double x, double y, double ray[3]) {
    ray[0] = (x - (double)camera->cx) / (double)camera->fx;
    ray[1] = (y - (double)camera->cy) / (double)camera->fy;
    ray[2] = 1;
    ffp_unit(ray);
}

static void find_centroid(const FfpImage *coverage, const FfpCamera *camera, double ray[3]) {
    double sum = 0, x = 0, y = 0;
    for (int i = 0; i < coverage->width * coverage->height; i++) {
        const double share = (double)coverage->data[i];
        sum += share, x += share * (i % coverage->width + 0.5), y += share * (i / coverage->width + 0.5);
    }
    to_ray(camera, sum > 0 ? x / sum : 0, sum > 0 ? y / sum : 0, ray);
}

FfpOutline ffp_outline_new(const FfpImage *coverage, const FfpCamera *camera) {
    FfpOutline out = {0};
    const size_t pixels = (size_t)coverage->width * (size_t)coverage->height;
    Crossing *points = ffp_alloc(3 * pixels, sizeof *points);
    const int n = cross_level(coverage, points);
    qsort(points, (size_t)n, sizeof *points, compare);
    out.count = n > 2 ? hull(points, n) : 0;
    out.rays = ffp_alloc((size_t)out.count + 1, sizeof *out.rays);
    out.cut = ffp_alloc((size_t)out.count + 1, sizeof *out.cut);
    for (int i = 0; i < out.count; i++) {
        to_ray(camera, points[i].x, points[i].y, out.rays[i]);
        out.cut[i] = points[i].cut;
    }
    find_centroid(coverage, camera, out.centroid);
    ffp_free(points);
    return out;
}

void ffp_outline_free(FfpOutline *outline) {
    ffp_free(outline->rays);
    ffp_free(outline->cut);
    *outline = (FfpOutline){0};
}

// --- All of them. ---

FfpOutlines ffp_outlines_new(const FfpCapture *capture, const double *angles) {
    FfpOutlines out = {.n = capture->n_views, .angles = angles};
    out.outlines = ffp_alloc((size_t)out.n, sizeof *out.outlines);
    for (int i = 0; i < out.n; i++)
        out.outlines[i] = ffp_outline_new(&capture->views[i].coverage, &capture->views[i].camera);
    out.focal = (double)(capture->views[0].camera.fx + capture->views[0].camera.fy) / 2;
    const int all = out.n * (out.n - 1) / 2, step = all / PAIRS_MAX + 1;
    out.pairs = ffp_alloc((size_t)all / (size_t)step + 1, sizeof *out.pairs);
    int seen = 0;
    for (int i = 0; i < out.n; i++) {
        for (int j = i + 1; j < out.n; j++) {
            if (seen++ % step != 0) continue;
            out.pairs[out.n_pairs][0] = i, out.pairs[out.n_pairs++][1] = j;
        }
    }
    return out;
}

void ffp_outlines_free(FfpOutlines *outlines) {
    for (int i = 0; i < outlines->n; i++) ffp_outline_free(&outlines->outlines[i]);
    ffp_free(outlines->outlines);
    ffp_free(outlines->pairs);
    *outlines = (FfpOutlines){0};
}

int ffp_next_stop(const FfpOutlines *o, int view, int side, double apart) {
    const double turn = 2 * acos(-1.0);
    double least = turn / 2;
    int best = -1;
    for (int k = 0; k < o->n; k++) {
        double angle = fmod((o->angles[k] - o->angles[view]) * side, turn);
        if (angle < 0) angle += turn;
        if (angle >= apart && angle < least) least = angle, best = k;
    }
    return best;
}

typedef struct Touch { // of a plane through the line between two cameras
    double angle;      // about it, from the plane through the object's middle
    double lever;      // pixels that a radian moves it
    bool cut;
} Touch;

// The two touching planes, given two directions across the line, of which `ahead` is angle 0.
static bool touch(const FfpOutline *outline, const double ahead[3], const double aside[3], double focal,
                  Touch out[2]) {
    out[0] = (Touch){.angle = INFINITY, .cut = true}, out[1] = (Touch){.angle = -INFINITY, .cut = true};
    for (int i = 0; i < outline->count; i++) {
        const double *ray = outline->rays[i], x = ffp_dot(ray, ahead), y = ffp_dot(ray, aside);
        const double angle = atan2(y, x);
        const Touch here = {angle, focal * hypot(x, y), outline->cut[i]};
        if (angle < out[0].angle) out[0] = here;
        if (angle > out[1].angle) out[1] = here;
    }
    return out[0].angle > -WIDEST && out[1].angle < WIDEST;
}

static void compare_pair(const FfpOutlines *o, const FfpAxis *axis, int first, int second, double out[2]) {
    // In the object's frame at the first stop, the second camera is the first one turned about the axis.
    static const double origin[3] = {0, 0, 0};
    const double back = o->angles[first] - o->angles[second];
    double line[3], ahead[3], aside[3], turned[2][3];
    Touch a[2], b[2];
    out[0] = out[1] = INFINITY;
    if (o->outlines[first].count == 0 || o->outlines[second].count == 0) return;
    ffp_axis_rotate(axis, back, origin, line);
    if (!(ffp_unit(line) > 1e-6 * sqrt(ffp_dot(axis->point, axis->point)))) return;
    const double *middle = o->outlines[first].centroid, along = ffp_dot(middle, line);
    for (int i = 0; i < 3; i++) ahead[i] = middle[i] - along * line[i];
    if (!(ffp_unit(ahead) > 0.05)) return;
    ffp_cross(line, ahead, aside);
    ffp_axis_rotate_direction(axis, -back, ahead, turned[0]);
    ffp_axis_rotate_direction(axis, -back, aside, turned[1]);
    if (!touch(&o->outlines[first], ahead, aside, o->focal, a) ||
        !touch(&o->outlines[second], turned[0], turned[1], o->focal, b))
        return;
    for (int k = 0; k < 2; k++) {
        if (!a[k].cut && !b[k].cut) out[k] = (a[k].angle - b[k].angle) * (a[k].lever + b[k].lever) / 2;
    }
}

void ffp_outline_residuals(const void *context, const FfpAxis *axis, double *residuals) {
    const FfpOutlines *outlines = context;
#pragma omp parallel for schedule(static)
    for (int i = 0; i < outlines->n_pairs; i++)
        compare_pair(outlines, axis, outlines->pairs[i][0], outlines->pairs[i][1], residuals + 2 * i);
}

// --- Where the object is. ---

// Solves a symmetric positive 3x3 system by Cramer's rule; false when it is singular.
static bool solve3(double a[3][3], const double b[3], double x[3]) {
    double c[3][3];
    for (int i = 0; i < 3; i++) ffp_cross(a[(i + 1) % 3], a[(i + 2) % 3], c[i]);
    const double det = ffp_dot(a[0], c[0]), trace = a[0][0] + a[1][1] + a[2][2];
    for (int i = 0; i < 3; i++) x[i] = (c[0][i] * b[0] + c[1][i] * b[1] + c[2][i] * b[2]) / det;
    return det > 1e-9 * trace * trace * trace;
}

// A ray of stop i as it is when the object stands at angle 0.
static void rotate_back(const FfpOutlines *o, const FfpAxis *axis, int stop, const double ray[3],
                        double from[3], double direction[3]) {
    static const double origin[3] = {0, 0, 0};
    ffp_axis_rotate(axis, -o->angles[stop], origin, from);
    ffp_axis_rotate_direction(axis, -o->angles[stop], ray, direction);
}

void ffp_outline_sphere(const FfpOutlines *o, const FfpAxis *axis, double centre[3], double *radius) {
    double a[3][3] = {{0}}, b[3] = {0}, from[3], d[3];
    for (int s = 0; s < o->n; s++) {
        rotate_back(o, axis, s, o->outlines[s].centroid, from, d);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double m = (i == j) - d[i] * d[j];
                a[i][j] += m, b[i] += m * from[j];
            }
        }
    }
    if (!solve3(a, b, centre)) memcpy(centre, axis->point, 3 * sizeof *centre);
    double worst = 0;
    for (int s = 0; s < o->n; s++) {
        for (int k = 0; k < o->outlines[s].count; k++) {
            double to[3], across[3];
            rotate_back(o, axis, s, o->outlines[s].rays[k], from, d);
            for (int i = 0; i < 3; i++) to[i] = centre[i] - from[i];
            ffp_cross(to, d, across);
            worst = fmax(worst, ffp_dot(across, across));
        }
    }
    *radius = sqrt(worst);
}
