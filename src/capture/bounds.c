// Where the object is, from what all devices look at and from how far its silhouettes reach.
#include <math.h>

#include "base/vec.h"
#include "capture/capture.h"

#define MARGIN 1.02 // on the radius

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

// The point nearest to all axes: sum over devices of (1 - d d^T)(c - o) = 0.
static bool meeting_point(const FfpCapture *capture, double centre[3]) {
    double a[3][3] = {{0}}, b[3] = {0};
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
    return solve3(a, b, centre);
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
                if (pass == 0)
                    mean[i] += (double)pose[4 * i + 3] / n, ahead[i] += (double)pose[4 * i + 2] / n;
                else
                    square += pow((double)pose[4 * i + 3] - mean[i], 2);
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

void ffp_capture_estimate_bounds(FfpCapture *capture) {
    double centre[3];
    if (!meeting_point(capture, centre)) point_ahead(capture, centre);
    double radius = MARGIN * silhouette_radius(capture, centre);
    if (radius <= 0) { // nothing is covered: a third of the way to the first camera
        double square = 0;
        for (int i = 0; i < 3; i++)
            square += pow(centre[i] - (double)capture->views[0].camera.pose[4 * i + 3], 2);
        radius = square > 0 ? sqrt(square) / 3 : 1;
    }
    for (int i = 0; i < 3; i++) capture->centre[i] = (real)centre[i];
    capture->radius = (real)radius;
}
