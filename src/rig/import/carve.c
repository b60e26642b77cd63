#include "rig/import/carve.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/rigid.h"
#include "rig/import/chord.h"

#define REACH 1.1        // of the radius that bounds what is surely object
#define OBJECT_SHARE 0.6 // of the views that have a point in their pictures
#define SEEN_SHARE 0.5   // of all views, which must have it there
#define STAGE_MOST 2     // views that show stage, dim or not: as many carve
enum { CELLS = 112, SAMPLES = 160 };

// --- The sphere. ---

// Adds I - d d^T and its product with the point that the ray of direction d begins at.
static void add_ray(double a[3][3], double b[3], const real origin[3], const real d[3]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double m = (i == j) - (double)d[i] * (double)d[j];
            a[i][j] += m, b[i] += m * (double)origin[j];
        }
}

// Cramer's rule; false when it is singular.
static bool solve(const double a[3][3], const double b[3], double x[3]) {
    double c[3][3];
    for (int i = 0; i < 3; i++) ffp_cross(a[(i + 1) % 3], a[(i + 2) % 3], c[i]);
    const double det = ffp_dot(a[0], c[0]), trace = a[0][0] + a[1][1] + a[2][2];
    for (int i = 0; i < 3; i++) x[i] = (c[0][i] * b[0] + c[1][i] * b[1] + c[2][i] * b[2]) / det;
    return det > 1e-9 * trace * trace * trace;
}

static void origin_of(const FfpCamera *camera, real origin[3]) {
    for (int i = 0; i < 3; i++) origin[i] = camera->pose[4 * i + 3];
}

// The middle of what a view shows as object; false when it shows none.
static bool middle_of(const FfpView *view, const FfpCompared *compared, real direction[3]) {
    const int width = view->camera.width, height = view->camera.height;
    double n = 0, x = 0, y = 0;
    for (int i = 0; i < width * height; i++) {
        if (compared->kinds[i] != FFP_PIXEL_OBJECT) continue;
        n++, x += i % width + 0.5, y += i / width + 0.5;
    }
    if (!(n > 0)) return false;
    ffp_pixel_ray(&view->camera, (real)(x / n), (real)(y / n), direction);
    return true;
}

// The largest distance between the sphere's middle and the ray of an object's pixel.
static double reach_of(const FfpView *view, const FfpCompared *compared, const double centre[3]) {
    const int width = view->camera.width, height = view->camera.height;
    double worst = 0, to[3], across[3], ray[3];
    real origin[3], d[3];
    origin_of(&view->camera, origin);
    for (int k = 0; k < 3; k++) to[k] = centre[k] - (double)origin[k];
    for (int i = 0; i < width * height; i++) {
        if (compared->kinds[i] != FFP_PIXEL_OBJECT) continue;
        ffp_pixel_ray(&view->camera, (real)(i % width) + 0.5F, (real)(i / width) + 0.5F, d);
        for (int k = 0; k < 3; k++) ray[k] = (double)d[k];
        ffp_cross(to, ray, across);
        worst = fmax(worst, ffp_dot(across, across));
    }
    return sqrt(worst);
}

bool ffp_hull_bounds(FfpCapture *capture, const FfpCompared *compared) {
    double a[3][3] = {{0}}, b[3] = {0}, centre[3], radius = 0;
    int views = 0;
    for (int v = 0; v < capture->n_views; v++) {
        real origin[3], direction[3] = {0};
        if (!middle_of(&capture->views[v], &compared[v], direction)) continue;
        origin_of(&capture->views[v].camera, origin);
        add_ray(a, b, origin, direction);
        views++;
    }
    if (views == 0) return false;
    if (!solve(a, b, centre)) return false;
    for (int v = 0; v < capture->n_views; v++)
        radius = fmax(radius, reach_of(&capture->views[v], &compared[v], centre));
    for (int k = 0; k < 3; k++) capture->centre[k] = (real)centre[k];
    capture->radius = (real)(REACH * radius);
    return radius > 0;
}

// --- The voxels. ---

// Whether a point of the world can be the object's.
static bool is_possible(const FfpHull *h, const real point[3]) {
    const int n = h->capture->n_views;
    int seen = 0, object = 0, stage = 0;
    for (int v = 0; v < n; v++) {
        const FfpView *view = &h->capture->views[v];
        real x, y;
        if (!(ffp_project(&view->camera, point, &x, &y) > 0) || x < 0 || y < 0 ||
            x >= (real)ffp_frame_width(view) || y >= (real)ffp_frame_height(view))
            continue;
        const size_t pixel = (size_t)y * (size_t)view->camera.width + (size_t)x;
        const unsigned char kind = h->compared[v].kinds[pixel];
        if (kind == FFP_PIXEL_STAGE || h->shaded[v][pixel]) return false;
        seen++, object += kind == FFP_PIXEL_OBJECT || kind == FFP_PIXEL_LIT,
            stage += kind == FFP_PIXEL_DIM_STAGE;
    }
    return stage < STAGE_MOST && seen >= SEEN_SHARE * n && object >= OBJECT_SHARE * seen;
}

FfpHull ffp_hull_new(const FfpCapture *capture, const FfpCompared *compared, unsigned char *const *shaded) {
    FfpHull h = {capture, compared, shaded, ffp_alloc((size_t)CELLS * CELLS * CELLS, 1)};
    const real step = 2 * capture->radius / CELLS;
    ffp_cancel_point();
#pragma omp parallel for schedule(static)
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
        const int at[3] = {i % CELLS, i / CELLS % CELLS, i / (CELLS * CELLS)};
        real point[3];
        for (int k = 0; k < 3; k++)
            point[k] = capture->centre[k] - capture->radius + ((real)at[k] + 0.5F) * step;
        h.solid[i] = is_possible(&h, point);
    }
    return h;
}

void ffp_hull_free(FfpHull *hull) {
    ffp_free(hull->solid);
    *hull = (FfpHull){0};
}

double ffp_hull_length(const FfpHull *hull, int view, size_t pixel) {
    const FfpCapture *capture = hull->capture;
    FfpChord chord;
    int inside = 0;
    if (!ffp_chord(capture, &capture->views[view].camera, pixel, &chord)) return 0;
    for (int k = 0; k < SAMPLES; k++) {
        real point[3];
        int at[3];
        ffp_chord_point(&chord, k, SAMPLES, point);
        for (int c = 0; c < 3; c++) {
            const real share = (point[c] - capture->centre[c]) / capture->radius;
            at[c] = (int)fmin(fmax((share + 1) / 2 * CELLS, (real)0), (real)(CELLS - 1));
        }
        inside += hull->solid[(at[2] * CELLS + at[1]) * CELLS + at[0]];
    }
    return inside * (double)(chord.far - chord.near) / (SAMPLES * (double)capture->radius);
}
