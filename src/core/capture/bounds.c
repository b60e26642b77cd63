// Where the object is: what all devices look at, or, where their axes run nearly alike and do not tell, the
// surfaces that the projected colours give; and how far its silhouettes reach.
#include <math.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "core/capture/capture.h"
#include "core/capture/coarse_depth.h"
#include "core/numerics/rank.h"

#define MARGIN 1.02 // on the radius
// Smallest eigenvalue of the mean of 1 - d d^T below which axes d are nearly alike: for one camera and one
// projector, 37 degrees between them. A device's axis need not hit the object: lenses are shifted.
#define ALIKE 0.1
#define OUTLIERS 0.05 // share of matched points at either end that may be wrong

// Solves the symmetric 3x3 system by Cramer's rule; false when it is singular to working precision.
static bool solve3(const double a[3][3], const double b[3], double x[3]) {
    const double c0 = a[1][1] * a[2][2] - a[1][2] * a[2][1], c1 = a[1][2] * a[2][0] - a[1][0] * a[2][2];
    const double c2 = a[1][0] * a[2][1] - a[1][1] * a[2][0], det = a[0][0] * c0 + a[0][1] * c1 + a[0][2] * c2;
    const double trace = a[0][0] + a[1][1] + a[2][2];
    if (!(det > 1e-9 * trace * trace * trace)) return false;
    for (int i = 0; i < 3; i++) {
        double m[3][3];
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++) m[r][c] = c == i ? b[r] : a[r][c];
        }
        x[i] = (m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])) /
               det;
    }
    return true;
}

// Sum over devices of (1 - d d^T), and of it times their places.
static void sum_axes(const FfpCapture *capture, double a[3][3], double b[3]) {
    for (int k = 0; k < 2 * capture->n_views; k++) {
        const FfpView *view = &capture->views[k / 2];
        const real *pose = k % 2 == 0 ? view->camera.pose : view->projector.pose;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double m = (i == j) - (double)pose[4 * i + 2] * (double)pose[4 * j + 2];
                a[i][j] += m;
                b[i] += m * (double)pose[4 * j + 3];
            }
        }
    }
}

// The point nearest to all axes: sum over devices of (1 - d d^T)(c - o) = 0.
static bool meeting_point(const FfpCapture *capture, double centre[3]) {
    double a[3][3] = {{0}}, b[3] = {0};
    sum_axes(capture, a, b);
    return solve3(a, b, centre);
}

// The smallest eigenvalue is n times 1 - the largest of the mean of d d^T, found by powers of that.
static bool axes_are_alike(const FfpCapture *capture) {
    const double n = 2.0 * capture->n_views;
    double a[3][3] = {{0}}, b[3] = {0}, v[3] = {0.3, 0.5, 0.8}, largest = 0;
    sum_axes(capture, a, b);
    for (int step = 0; step < 100; step++) {
        double next[3], length = 0;
        for (int i = 0; i < 3; i++) {
            next[i] = v[i];
            for (int j = 0; j < 3; j++) next[i] -= a[i][j] * v[j] / n;
            length += next[i] * next[i];
        }
        largest = sqrt(length);
        for (int i = 0; i < 3 && largest > 0; i++) v[i] = next[i] / largest;
    }
    return 1 - largest < ALIKE;
}

// For rigs whose axes are parallel: in front of the devices' mean, four times as far as they lie apart.
static void point_ahead(const FfpCapture *capture, double centre[3]) {
    const int n = 2 * capture->n_views;
    double mean[3] = {0}, ahead[3] = {0}, spread = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < n; k++) {
            const FfpView *view = &capture->views[k / 2];
            const real *pose = k % 2 == 0 ? view->camera.pose : view->projector.pose;
            double square = 0;
            for (int i = 0; i < 3; i++) {
                if (pass == 0) {
                    mean[i] += (double)pose[4 * i + 3] / n;
                    ahead[i] += (double)pose[4 * i + 2] / n;
                } else {
                    square += pow((double)pose[4 * i + 3] - mean[i], 2);
                }
            }
            spread = fmax(spread, sqrt(square));
        }
    }
    for (int i = 0; i < 3; i++) centre[i] = mean[i] + ahead[i] * (spread > 0 ? 4 * spread : 1);
}

// Squared distance between the centre and the line of a pixel's ray.
static double ray_distance_squared(const FfpCamera *camera, int x, int y, const double centre[3]) {
    real direction[3];
    ffp_pixel_ray(camera, (real)x + 0.5F, (real)y + 0.5F, direction);
    double along = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        const double to = centre[i] - (double)camera->pose[4 * i + 3];
        along += to * (double)direction[i];
        square += to * to;
    }
    return fmax(0, square - along * along);
}

static double silhouette_radius(const FfpCapture *capture, const double centre[3]) {
    double worst = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        for (int y = 0; y < view->coverage.height; y++) {
            for (int x = 0; x < view->coverage.width; x++) {
                if (view->coverage.data[(ptrdiff_t)y * view->coverage.width + x] <= 0) continue;
                worst = fmax(worst, ray_distance_squared(&view->camera, x, y, centre));
            }
        }
    }
    return sqrt(worst);
}

// The middle of what lies between the outliers, along each axis, and how far that reaches from it.
static void enclose(real (*points)[3], int n, double centre[3], double *reach) {
    real *values = ffp_alloc((size_t)n, sizeof *values);
    const size_t count = (size_t)n, skipped = (size_t)(OUTLIERS * n);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < n; k++) values[k] = points[k][i];
        const double low = (double)ffp_rank(values, count, skipped),
                     high = (double)ffp_rank(values, count, count - 1 - skipped);
        centre[i] = (low + high) / 2;
    }
    for (int k = 0; k < n; k++) {
        double square = 0;
        for (int i = 0; i < 3; i++) square += pow((double)points[k][i] - centre[i], 2);
        values[k] = (real)sqrt(square);
    }
    *reach = (double)ffp_rank(values, count, count - 1 - skipped);
    ffp_free(values);
}

// Where the projected colours say that the lit surfaces are, in place of `centre`, unless they tell nothing.
static void match_surfaces(const FfpCapture *capture, bool guessed, double centre[3], double *reach) {
    real(*points)[3] = ffp_alloc(FFP_COARSE_POINTS_MAX, sizeof *points);
    const int n = ffp_coarse_points(capture, guessed ? centre : NULL, points);
    if (n > 0) enclose(points, n, centre, reach);
    ffp_free(points);
}

// --- Whole scenes. ---

#define SCENE_LOW 0.02 // share of the lit points that may be wrong, at the near and at the far end
#define NEARER 0.5F    // what is not lit may lie so much nearer than anything that is,
#define FARTHER 10     // and so much farther
#define NEVER 100      // near end of a view that sees no lit point: far end over this

// Near and far end of a view from the lit points that lie in its picture; false if there are too few.
static bool range_of_view(FfpView *view, real (*points)[3], int n) {
    enum { LEAST = 20 };
    const FfpCamera *camera = &view->camera;
    real *depths = ffp_alloc((size_t)n + 1, sizeof *depths);
    size_t count = 0;
    for (int i = 0; i < n; i++) {
        real x, y;
        const real z = ffp_project(camera, points[i], &x, &y);
        if (z > 0 && x >= 0 && y >= 0 && x < (real)camera->width && y < (real)camera->height)
            depths[count++] = z;
    }
    const bool enough = count >= LEAST;
    if (enough) {
        const size_t skipped = (size_t)(SCENE_LOW * (double)count);
        view->near = NEARER * ffp_rank(depths, count, skipped);
        view->far = FARTHER * ffp_rank(depths, count, count - 1 - skipped);
    }
    ffp_free(depths);
    return enough;
}

// The middle of the lit points, and their reach.
static void bound_scene(FfpCapture *capture, real (*points)[3], int n, bool sphere) {
    double centre[3], reach = 0;
    if (!meeting_point(capture, centre)) point_ahead(capture, centre);
    if (n > 0) enclose(points, n, centre, &reach);
    if (sphere) {
        for (int i = 0; i < 3; i++) capture->centre[i] = (real)centre[i];
        capture->radius = (real)(reach > 0 ? MARGIN * reach : silhouette_radius(capture, centre));
    }
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        real x, y;
        if (view->near > 0 || range_of_view(view, points, n)) continue;
        const real middle = ffp_project(&view->camera, capture->centre, &x, &y);
        view->far = FARTHER * (real)fmax((double)(middle + capture->radius), (double)capture->radius);
        view->near = view->far / NEVER;
    }
}

static void estimate_scene(FfpCapture *capture, bool sphere) {
    real(*points)[3] = ffp_alloc(FFP_COARSE_POINTS_MAX, sizeof *points);
    bound_scene(capture, points, ffp_clear_points(capture, points), sphere);
    ffp_free(points);
}

void ffp_capture_bound_scene(FfpCapture *capture, real (*points)[3], int n) {
    bound_scene(capture, points, n, true);
}

void ffp_capture_estimate_ranges(FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        if (capture->views[v].near > 0) continue;
        estimate_scene(capture, false);
        return;
    }
}

void ffp_capture_estimate_bounds(FfpCapture *capture) {
    if (capture->scene) {
        estimate_scene(capture, true);
        return;
    }
    double centre[3], reach = 0;
    const bool meet = meeting_point(capture, centre);
    if (!meet) point_ahead(capture, centre);
    if (axes_are_alike(capture)) match_surfaces(capture, meet, centre, &reach);
    double radius = MARGIN * fmax(silhouette_radius(capture, centre), reach);
    if (radius <= 0) { // nothing is covered: a third of the way to the first camera
        double square = 0;
        for (int i = 0; i < 3; i++)
            square += pow(centre[i] - (double)capture->views[0].camera.pose[4 * i + 3], 2);
        radius = square > 0 ? sqrt(square) / 3 : 1;
    }
    for (int i = 0; i < 3; i++) capture->centre[i] = (real)centre[i];
    capture->radius = (real)radius;
}
