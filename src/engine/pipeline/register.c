#include "engine/pipeline/register.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/base/rigid.h"
#include "core/capture/reduce.h"
#include "core/numerics/least_squares.h"
#include "engine/pipeline/relight.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"

enum { NUMBERS = 12, SMALLEST = 32 }; // of both devices; width of the smallest pictures, pixels
enum { STEPS = 20 };                  // at most, of each size of pictures
enum { SEARCHED = 128 };              // pictures that are less wide are searched for it
enum { MOST_PIXELS = 1 << 18 };       // of the largest: more tell no more of two poses, and take memory
#define PROBE 0.5                     // of the pattern's derivative, camera pixels
#define SEARCH 0.1 // how far the light is looked for, share of the pattern's width, each way
#define BETTER 0.9 // of the cost, at most, for what was found there
#define WORTH 1e-3 // share of the cost that a step must save for another

// One view in pictures of one size.
typedef struct Fit {
    const FfpCapture *capture;
    const FfpGaussians *gaussians;
    FfpViewPass *pass;
    const int *patterns; // [n_patterns] whose photographs are looked at
    int n_patterns;
    const FfpSummed *light; // [n_patterns]; zeros for those that the view lacks, and black
    FfpView view;           // the photographs, sRGB-encoded
    double distance[2];     // of both devices from the object
} Fit;

// A device turned and shifted about its own axes: three radians, three shares of its distance.
static void move_device(FfpCamera *device, const double by[6], double distance) {
    FfpRigid pose = ffp_rigid_from_pose(device->pose), moved = pose;
    double turn[9];
    ffp_rotation_from_vector(by, turn);
    ffp_rotation_product(pose.r, turn, moved.r);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) moved.t[i] += pose.r[3 * i + k] * by[3 + k] * distance;
    ffp_rigid_store(&moved, device->pose);
}

static void draw(const Fit *fit, const double *by) {
    FfpCamera camera = fit->view.camera, projector = fit->view.projector;
    move_device(&camera, by, fit->distance[0]);
    move_device(&projector, by + 6, fit->distance[1]);
    ffp_view_pass_draw(fit->pass, fit->gaussians, &camera, &projector);
}

static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    ffp_cancel_point();
    draw(fit, by);
    FfpImage picture = ffp_view_pass_picture_new(fit->pass);
    const size_t size = 3 * (size_t)picture.width * (size_t)picture.height;
    for (int p = 0; p < fit->capture->n_patterns; p++) {
        const FfpImage *photograph = &fit->view.images[p];
        if (!photograph->data) continue;
        ffp_view_pass_shade(fit->pass, fit->capture->intensity,
                            p == fit->capture->black ? NULL : &fit->light[p], &picture);
        for (size_t i = 0; i < size; i++) *out++ = (double)(picture.data[i] - photograph->data[i]);
    }
    ffp_image_free(&picture);
}

// --- Derivatives. A picture moves with the surface when the camera does, and its light with the pattern's
// when the projector does (Lucas and Kanade 1981, at known depths); from where light comes and what is in
// shadow stays.

typedef struct Point {
    double world[3];
    bool known;
} Point;

static Point point_at(const FfpGbuffer *g, const FfpCamera *camera, int p) {
    real ray[3];
    if (!(g->opacity[p] > 0.05F)) return (Point){0};
    const double across =
        (double)ffp_pixel_ray(camera, (real)(p % g->width) + 0.5F, (real)(p / g->width) + 0.5F, ray);
    const double z = (double)(g->depth[p] / g->opacity[p]);
    Point point = {.known = z > 0};
    for (int k = 0; k < 3; k++)
        point.world[k] = (double)camera->pose[4 * k + 3] + z / across * (double)ray[k];
    return point;
}

// How far a point's image moves, in x and y of a device, by its six numbers.
static void flow(const FfpCamera *device, const double world[3], double distance, double out[2][6]) {
    const FfpRigid pose = ffp_rigid_from_pose(device->pose);
    double q[3] = {0}, by[6][3];
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) q[k] += pose.r[3 * i + k] * (world[i] - pose.t[i]);
    for (int k = 0; k < 3; k++) { // a device turned by w sees a point moved by q x w
        double axis[3] = {k == 0, k == 1, k == 2};
        ffp_cross(q, axis, by[k]);
        for (int i = 0; i < 3; i++) by[3 + k][i] = i == k ? -distance : 0;
    }
    const bool before = q[2] > 1e-6 * distance; // what lies beside or behind the device has no image
    for (int k = 0; k < 6; k++) {
        out[0][k] = out[1][k] = 0;
        if (!before) continue;
        out[0][k] = (double)device->fx * (by[k][0] - q[0] / q[2] * by[k][2]) / q[2];
        out[1][k] = (double)device->fy * (by[k][1] - q[1] / q[2] * by[k][2]) / q[2];
    }
}

// The picture's slope along x (0) or y (1) of the pattern, per pixel of it.
static void light_slope(const Fit *fit, int p, int axis, FfpImage *spare, FfpImage *out) {
    const FfpCamera *projector = &fit->view.projector;
    const real step = fmax((real)1, (real)(PROBE * (double)projector->width / fit->view.camera.width));
    const real x = axis ? 0 : step, y = axis ? step : 0;
    ffp_view_pass_shift(fit->pass, x, y);
    ffp_view_pass_shade(fit->pass, fit->capture->intensity, &fit->light[p], out);
    ffp_view_pass_shift(fit->pass, -2 * x, -2 * y);
    ffp_view_pass_shade(fit->pass, fit->capture->intensity, &fit->light[p], spare);
    ffp_view_pass_shift(fit->pass, x, y);
    const ptrdiff_t size = (ptrdiff_t)3 * out->width * out->height;
    for (ptrdiff_t i = 0; i < size; i++) out->data[i] = (out->data[i] - spare->data[i]) / (2 * step);
}

// The slope of a picture's value i between its neighbours, `apart` values away from it, where both are
// inside.
static double picture_slope(const FfpImage *picture, ptrdiff_t i, ptrdiff_t apart, int at, int size) {
    const ptrdiff_t before = at > 0 ? apart : 0, after = at + 1 < size ? apart : 0;
    return before + after == 0 ? 0
                               : (double)(picture->data[i + after] - picture->data[i - before]) *
                                     (double)apart / (double)(before + after);
}

static void picture_slopes(const Fit *fit, const FfpImage pictures[3], bool lit, size_t first, size_t count,
                           double *out) {
    const FfpGbuffer *g = ffp_view_pass_gbuffer(fit->pass);
    const FfpCamera *camera = &fit->view.camera, *projector = &fit->view.projector;
    const int width = g->width;
#pragma omp parallel for schedule(static)
    for (int p = 0; p < width * g->height; p++) {
        const Point point = point_at(g, camera, p);
        double seen[2][6], light[2][6];
        if (point.known) flow(camera, point.world, fit->distance[0], seen);
        if (point.known) flow(projector, point.world, fit->distance[1], light);
        for (int c = 0; c < 3; c++) {
            const ptrdiff_t i = 3 * (ptrdiff_t)p + c;
            const double x = picture_slope(&pictures[0], i, 3, p % width, width),
                         y = picture_slope(&pictures[0], i, (ptrdiff_t)3 * width, p / width, g->height);
            for (int k = 0; k < 6; k++) {
                out[(size_t)k * count + first + (size_t)i] =
                    point.known ? -x * seen[0][k] - y * seen[1][k] : 0;
                out[(size_t)(6 + k) * count + first + (size_t)i] =
                    point.known && lit ? (double)pictures[1].data[i] * light[0][k] +
                                             (double)pictures[2].data[i] * light[1][k]
                                       : 0;
            }
        }
    }
}

static int count_photographs(const Fit *fit) {
    int count = 0;
    for (int p = 0; p < fit->capture->n_patterns; p++) count += fit->view.images[p].data != NULL;
    return count;
}

static void slopes(const void *state, double *out) {
    static const double still[NUMBERS] = {0};
    const Fit *fit = state;
    const size_t size = (size_t)3 * (size_t)fit->view.camera.width * (size_t)fit->view.camera.height;
    const size_t count = (size_t)count_photographs(fit) * size;
    FfpImage pictures[3], spare; // the picture, and its slopes along the pattern
    size_t first = 0;
    ffp_cancel_point();
    draw(fit, still);
    spare = ffp_view_pass_picture_new(fit->pass);
    for (int k = 0; k < 3; k++) pictures[k] = ffp_view_pass_picture_new(fit->pass);
    for (int p = 0; p < fit->capture->n_patterns; p++) {
        const bool lit = p != fit->capture->black, varied = lit && !fit->light[p].plain;
        if (!fit->view.images[p].data) continue;
        ffp_view_pass_shade(fit->pass, fit->capture->intensity, lit ? &fit->light[p] : NULL, &pictures[0]);
        for (int axis = 0; varied && axis < 2; axis++) light_slope(fit, p, axis, &spare, &pictures[1 + axis]);
        picture_slopes(fit, pictures, varied, first, count, out);
        first += size;
    }
    for (int k = 0; k < 3; k++) ffp_image_free(&pictures[k]);
    ffp_image_free(&spare);
}

static void move(void *state, const double *by) {
    Fit *fit = state;
    move_device(&fit->view.camera, by, fit->distance[0]);
    move_device(&fit->view.projector, by + 6, fit->distance[1]);
}

// Mean absolute difference of drawn and photographed values, where the devices are now.
static double disagreement(const Fit *fit) {
    static const double still[NUMBERS] = {0};
    const size_t count =
        3 * (size_t)count_photographs(fit) * (size_t)fit->view.camera.width * (size_t)fit->view.camera.height;
    double *values = ffp_alloc(count, sizeof *values), sum = 0;
    differences(fit, still, values);
    for (size_t i = 0; i < count; i++) sum += fabs(values[i]);
    ffp_free(values);
    return sum / (double)count;
}

static void fit_open(Fit *fit, const FfpView *view, int width, int height) {
    const FfpCapture *capture = fit->capture;
    fit->view = ffp_view_reduced(view, capture->n_patterns, fit->patterns, fit->n_patterns, width, height);
    for (int p = 0; p < capture->n_patterns; p++)
        if (fit->view.images[p].data) ffp_image_to_srgb(&fit->view.images[p]);
    const FfpCamera *devices[2] = {&view->camera, &view->projector};
    for (int d = 0; d < 2; d++) {
        double sum = 0;
        for (int k = 0; k < 3; k++) {
            const double apart = (double)(devices[d]->pose[4 * k + 3] - capture->centre[k]);
            sum += apart * apart;
        }
        fit->distance[d] = sqrt(sum);
    }
}

static void fit_close(Fit *fit) {
    ffp_view_reduced_free(&fit->view, fit->capture->n_patterns);
}

static double cost_of_light(const Fit *fit, FfpImage *picture) {
    double sum = 0;
    for (int p = 0; p < fit->capture->n_patterns; p++) {
        const FfpImage *photograph = &fit->view.images[p];
        if (!photograph->data || p == fit->capture->black || fit->light[p].plain) continue;
        ffp_view_pass_shade(fit->pass, fit->capture->intensity, &fit->light[p], picture);
        for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * picture->width * picture->height; i++) {
            const double apart = (double)(picture->data[i] - photograph->data[i]);
            sum += apart * apart;
        }
    }
    return sum;
}

// Turns the projector to where its light agrees best, all around, with the photographs: from letters and
// stripes no slope leads to the next but one.
static void look_for_light(Fit *fit) {
    static const double still[NUMBERS] = {0};
    const FfpCamera *projector = &fit->view.projector;
    const real step = (real)projector->width / (real)fit->view.camera.width;
    const int reach = (int)(SEARCH * (double)projector->width / (double)step);
    double best, found[2] = {0}, by[NUMBERS] = {0};
    draw(fit, still);
    FfpImage picture = ffp_view_pass_picture_new(fit->pass);
    best = BETTER * cost_of_light(fit, &picture);
    for (int y = -reach; y <= reach; y++)
        for (int x = -reach; x <= reach; x++) {
            ffp_cancel_point();
            ffp_view_pass_shift(fit->pass, step * (real)x, step * (real)y);
            const double cost = cost_of_light(fit, &picture);
            ffp_view_pass_shift(fit->pass, -step * (real)x, -step * (real)y);
            if (cost < best) best = cost, found[0] = x, found[1] = y;
        }
    by[6] = found[1] * (double)(step / projector->fy), by[7] = -found[0] * (double)(step / projector->fx);
    move(fit, by);
    ffp_image_free(&picture);
}

// Steps downhill at one size; the view's poses follow.
static void descend(Fit *fit, FfpView *view) {
    const FfpLeastSquares problem = {.state = fit,
                                     .numbers = NUMBERS,
                                     .count = 3 * count_photographs(fit) * fit->view.camera.width *
                                              fit->view.camera.height,
                                     .differences = differences,
                                     .move = move,
                                     .slopes = slopes,
                                     .steps = STEPS,
                                     .worth = WORTH};
    ffp_least_squares(&problem, NULL);
    memcpy(view->camera.pose, fit->view.camera.pose, sizeof view->camera.pose);
    memcpy(view->projector.pose, fit->view.projector.pose, sizeof view->projector.pose);
}

// The mean distance, in a device's pixels, between where it saw the view's surface and where it does now.
static double shifted(const Fit *fit, const FfpCamera *from, const FfpCamera *to) {
    const FfpGbuffer *g = ffp_view_pass_gbuffer(fit->pass);
    double sum = 0, count = 0;
    for (int p = 0; p < g->width * g->height; p++) {
        const Point point = point_at(g, &fit->view.camera, p);
        const real at[3] = {(real)point.world[0], (real)point.world[1], (real)point.world[2]};
        real a[2], b[2];
        if (!point.known || !(ffp_project(from, at, &a[0], &a[1]) > 0) ||
            !(ffp_project(to, at, &b[0], &b[1]) > 0))
            continue;
        sum += hypot((double)(a[0] - b[0]), (double)(a[1] - b[1]));
        count++;
    }
    return count > 0 ? sum / count : 0;
}

// Degrees between two attitudes of a device, and the distance between its places.
static void add_motion(const FfpCamera *from, const FfpCamera *to, double *turned, double *moved) {
    const FfpRigid a = ffp_rigid_from_pose(from->pose), b = ffp_rigid_from_pose(to->pose);
    double between[9], vector[3], sum = 0;
    ffp_rotation_difference(a.r, b.r, between);
    ffp_rotation_to_vector(between, vector);
    for (int k = 0; k < 3; k++) sum += (b.t[k] - a.t[k]) * (b.t[k] - a.t[k]);
    *turned += sqrt(ffp_dot(vector, vector)) * 180 / FFP_PI_DOUBLE;
    *moved += sqrt(sum);
}

static void register_view(Fit *fit, FfpView *view, FfpAlignmentStats *sums) {
    const FfpView given = *view;
    const int width = view->camera.width, height = view->camera.height;
    const int64_t pixels = (int64_t)width * height;
    int smaller = 1;
    while (width / (2 * smaller) >= SMALLEST && height / (2 * smaller) > 0) smaller *= 2;
    fit_open(fit, view, width, height);
    const double before = disagreement(fit);
    fit_close(fit);
    for (; smaller >= 1 && pixels / smaller / smaller <= MOST_PIXELS; smaller /= 2) {
        fit_open(fit, view, width / smaller, height / smaller);
        if (width / smaller < SEARCHED) look_for_light(fit);
        descend(fit, view);
        fit_close(fit);
    }
    fit_open(fit, view, width, height);
    const double after = disagreement(fit);
    const bool better = after < before;
    if (better) sums->camera_pixels += shifted(fit, &given.camera, &view->camera);
    if (better) sums->projector_pixels += shifted(fit, &given.projector, &view->projector);
    fit_close(fit);
    if (!better) {
        memcpy(view->camera.pose, given.camera.pose, sizeof view->camera.pose);
        memcpy(view->projector.pose, given.projector.pose, sizeof view->projector.pose);
    }
    sums->before += before;
    sums->after += better ? after : before;
    add_motion(&given.camera, &view->camera, &sums->camera_turned, &sums->camera_moved);
    add_motion(&given.projector, &view->projector, &sums->projector_turned, &sums->projector_moved);
}

void ffp_registration_run(FfpCapture *capture, const FfpGaussians *gaussians, int pattern,
                          FfpAlignmentStats *stats) {
    const double begin = ffp_seconds();
    FfpAlignmentStats sums = {.known = true, .own = true, .focal = {1, 1}};
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){0}, NULL);
    FfpSummed *light = ffp_alloc((size_t)capture->n_patterns, sizeof *light);
    int *patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *patterns);
    for (int p = 0; p < capture->n_patterns; p++) {
        patterns[p] = pattern < 0 ? p : pattern;
        if (p != capture->black && capture->patterns[p].image.data)
            light[p] = ffp_pattern_summed(&capture->patterns[p].image);
    }
    const FfpTask task = ffp_task("finding the devices again", capture->n_views);
    Fit fit = {.capture = capture,
               .gaussians = gaussians,
               .pass = ffp_view_pass_new(&settings),
               .light = light,
               .patterns = patterns,
               .n_patterns = pattern < 0 ? ffp_patterns_shown(capture) : 1};
    for (int v = 0; v < capture->n_views; v++) {
        register_view(&fit, &capture->views[v], &sums);
        ffp_task_step(&task, v + 1, NULL);
    }
    ffp_task_end(&task);
    ffp_view_pass_free(fit.pass);
    for (int p = 0; p < capture->n_patterns; p++) ffp_summed_free(&light[p]);
    ffp_free(light);
    ffp_free(patterns);
    double *const means[] = {
        &sums.camera_pixels, &sums.projector_pixels, &sums.before,           &sums.after,
        &sums.camera_turned, &sums.camera_moved,     &sums.projector_turned, &sums.projector_moved};
    for (size_t i = 0; i < sizeof means / sizeof *means; i++) *means[i] /= capture->n_views;
    sums.elapsed_s = ffp_seconds() - begin;
    if (stats) *stats = sums;
}
