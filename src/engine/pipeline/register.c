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
enum { STEPS = 12 };                  // at most, of each size of pictures
enum { MOST_PIXELS = 1 << 18 };       // of the largest: more tell no more of two poses, and take memory
#define PROBE 0.3                     // of the numeric derivatives, pixels
#define WORTH 1e-3                    // share of the cost that a step must save for another

// One view in pictures of one size.
typedef struct Fit {
    const FfpCapture *capture;
    const FfpGaussians *gaussians;
    FfpViewPass *pass;
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

static void move(void *state, const double *by) {
    Fit *fit = state;
    move_device(&fit->view.camera, by, fit->distance[0]);
    move_device(&fit->view.projector, by + 6, fit->distance[1]);
}

static int count_photographs(const Fit *fit) {
    int count = 0;
    for (int p = 0; p < fit->capture->n_patterns; p++) count += fit->view.images[p].data != NULL;
    return count;
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

static void fit_open(Fit *fit, const FfpView *view, const int *patterns, int width, int height) {
    const FfpCapture *capture = fit->capture;
    fit->view =
        ffp_view_reduced(view, capture->n_patterns, patterns, ffp_patterns_shown(capture), width, height);
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

// Steps downhill at one size; the view's poses follow.
static void descend(Fit *fit, FfpView *view) {
    double step[NUMBERS];
    for (int i = 0; i < NUMBERS; i++) step[i] = PROBE / (double)fit->view.camera.fx;
    const FfpLeastSquares problem = {.state = fit,
                                     .numbers = NUMBERS,
                                     .count = 3 * count_photographs(fit) * fit->view.camera.width *
                                              fit->view.camera.height,
                                     .differences = differences,
                                     .move = move,
                                     .step = step,
                                     .steps = STEPS,
                                     .worth = WORTH};
    ffp_least_squares(&problem, NULL);
    memcpy(view->camera.pose, fit->view.camera.pose, sizeof view->camera.pose);
    memcpy(view->projector.pose, fit->view.projector.pose, sizeof view->projector.pose);
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

static void register_view(Fit *fit, FfpView *view, const int *patterns, FfpAlignmentStats *sums) {
    const FfpView given = *view;
    const int width = view->camera.width, height = view->camera.height;
    const int64_t pixels = (int64_t)width * height;
    int smaller = 1;
    while (width / (2 * smaller) >= SMALLEST && height / (2 * smaller) > 0) smaller *= 2;
    fit_open(fit, view, patterns, width, height);
    const double before = disagreement(fit);
    fit_close(fit);
    for (; smaller >= 1 && pixels / smaller / smaller <= MOST_PIXELS; smaller /= 2) {
        fit_open(fit, view, patterns, width / smaller, height / smaller);
        descend(fit, view);
        fit_close(fit);
    }
    fit_open(fit, view, patterns, width, height);
    const double after = disagreement(fit);
    fit_close(fit);
    const bool better = after < before;
    if (!better) {
        memcpy(view->camera.pose, given.camera.pose, sizeof view->camera.pose);
        memcpy(view->projector.pose, given.projector.pose, sizeof view->projector.pose);
    }
    sums->before += before;
    sums->after += better ? after : before;
    add_motion(&given.camera, &view->camera, &sums->camera_turned, &sums->camera_moved);
    add_motion(&given.projector, &view->projector, &sums->projector_turned, &sums->projector_moved);
}

void ffp_registration_run(FfpCapture *capture, const FfpGaussians *gaussians, FfpAlignmentStats *stats) {
    const double begin = ffp_seconds();
    FfpAlignmentStats sums = {.known = true, .own = true, .focal = {1, 1}};
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){0}, NULL);
    FfpSummed *light = ffp_alloc((size_t)capture->n_patterns, sizeof *light);
    int *patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *patterns);
    for (int p = 0; p < capture->n_patterns; p++) {
        patterns[p] = p;
        if (p != capture->black && capture->patterns[p].image.data)
            light[p] = ffp_pattern_summed(&capture->patterns[p].image);
    }
    const FfpTask task = ffp_task("finding the devices again", capture->n_views);
    Fit fit = {
        .capture = capture, .gaussians = gaussians, .pass = ffp_view_pass_new(&settings), .light = light};
    for (int v = 0; v < capture->n_views; v++) {
        register_view(&fit, &capture->views[v], patterns, &sums);
        ffp_task_step(&task, v + 1, NULL);
    }
    ffp_task_end(&task);
    ffp_view_pass_free(fit.pass);
    for (int p = 0; p < capture->n_patterns; p++) ffp_summed_free(&light[p]);
    ffp_free(light);
    ffp_free(patterns);
    double *const means[] = {&sums.before,           &sums.after,
                             &sums.camera_turned,    &sums.camera_moved,
                             &sums.projector_turned, &sums.projector_moved};
    for (size_t i = 0; i < sizeof means / sizeof *means; i++) *means[i] /= capture->n_views;
    sums.seconds = ffp_seconds() - begin;
    if (stats) *stats = sums;
}
