// Validation on fixed scenes of the validation split, beside the classical start on the same pictures.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "loss/metrics.h"
#include "render/pass.h"
#include "train/train.h"

typedef struct Tally {
    double sum;
    int count;
} Tally;

static double mean(Tally t) {
    return t.count ? t.sum / t.count : 0;
}

typedef struct Viewer { // what rendering needs from picture to picture
    FfpRenderSettings settings;
    FfpViewPass *pass;
    FfpImage picture;
} Viewer;

static Viewer viewer_new(const FfpModelConfig *model, int side) {
    Viewer viewer = {.settings = ffp_render_settings(ffp_model_drawing(model)),
                     .picture = ffp_image_new(side, side, 3)};
    viewer.pass = ffp_view_pass_new(&viewer.settings);
    return viewer;
}

static void viewer_free(Viewer *viewer) {
    ffp_view_pass_free(viewer->pass);
    ffp_image_free(&viewer->picture);
}

static void aim(Viewer *viewer, const FfpGaussians *gaussians, const FfpView *view) {
    ffp_view_pass_draw(viewer->pass, gaussians, &view->camera, &view->projector);
}

// The encoded picture under one pattern, left in viewer->picture.
static void show(Viewer *viewer, const FfpScene *scene, int pattern) {
    ffp_view_pass_shade(viewer->pass, scene->capture.intensity,
                        pattern == scene->capture.black ? NULL : &scene->patterns[pattern], &viewer->picture);
}

// Lollipops that were not given at the input poses; every pattern at the new poses.
static void score(Viewer *viewer, const FfpScene *scene, const FfpGaussians *gaussians, Tally *rendering,
                  Tally *novel_pose) {
    const FfpCapture *capture = &scene->capture;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const bool input = v < scene->inputs.n_views;
        aim(viewer, gaussians, view);
        for (int p = 0; p < capture->n_patterns; p++) {
            if (input && (p == capture->black || p == capture->white || p == scene->active)) continue;
            show(viewer, scene, p);
            FfpImage truth = ffp_image_copy(&view->images[p]);
            ffp_image_to_srgb(&truth);
            Tally *tally = input ? rendering : novel_pose;
            tally->sum += ffp_psnr(&viewer->picture, &truth);
            tally->count++;
            ffp_image_free(&truth);
        }
    }
}

double ffp_scene_psnr(const FfpModel *model, const FfpTrainConfig *config, const FfpScene *scene) {
    Viewer viewer = viewer_new(&config->model, scene->start.width);
    FfpRun *run = ffp_run_new();
    Tally rendering = {0}, novel_pose = {0};
    if (ffp_model_forward(model, run, &scene->inputs, &scene->start, scene->active, NULL))
        score(&viewer, scene, &run->gaussians, &rendering, &novel_pose);
    ffp_run_free(run);
    viewer_free(&viewer);
    return mean(rendering);
}

static int compare(const void *a, const void *b) {
    const real x = *(const real *)a, y = *(const real *)b;
    return (x > y) - (x < y);
}

static double depth_error_median(const FfpScene *scene, const FfpRun *run) {
    const int width = scene->start.width, pixels = width * scene->start.height;
    real *errors = ffp_alloc((size_t)run->gaussians.count, sizeof *errors);
    int64_t count = 0;
    for (int64_t i = 0; i < run->gaussians.count; i++) {
        const FfpView *view = &scene->capture.views[run->pixel[i] / pixels];
        const int at = (int)(run->pixel[i] % pixels);
        const real truth = ffp_true_t(view, at);
        if (truth > 0) errors[count++] = fabsf(run->t[i] - truth);
    }
    qsort(errors, (size_t)count, sizeof *errors, compare);
    const double median = count ? 100 * errors[count / 2] : 0;
    free(errors);
    return median;
}

static void paste(FfpImage *sheet, const FfpImage *image, int column, int row) {
    for (int y = 0; y < image->height; y++)
        memcpy(sheet->data + 3 * ((size_t)(row * image->height + y) * sheet->width + column * image->width),
               image->data + 3 * (size_t)y * image->width, 3 * (size_t)image->width * sizeof(real));
}

// A row of the sheet: truth, start, prediction at the first input pose; the same at the first new pose.
static void draw_row(Viewer *viewer, const FfpScene *scene, const FfpGaussians *start,
                     const FfpGaussians *prediction, FfpImage *sheet, int row) {
    const FfpCapture *capture = &scene->capture;
    const int pattern = capture->n_patterns - 1;
    for (int half = 0; half < 2; half++) {
        const int v = half ? scene->inputs.n_views : 0;
        if (v >= capture->n_views) return;
        FfpImage truth = ffp_image_copy(&capture->views[v].images[pattern]);
        ffp_image_to_srgb(&truth);
        paste(sheet, &truth, 3 * half, row);
        ffp_image_free(&truth);
        aim(viewer, start, &capture->views[v]);
        show(viewer, scene, pattern);
        paste(sheet, &viewer->picture, 3 * half + 1, row);
        aim(viewer, prediction, &capture->views[v]);
        show(viewer, scene, pattern);
        paste(sheet, &viewer->picture, 3 * half + 2, row);
    }
}

bool ffp_validate(const FfpModel *model, const FfpTrainConfig *config, int resolution, const char *picture,
                  FfpValidation *result, FfpError *err) {
    Tally tallies[6] = {0}; // rendering and novel pose of the prediction, polished, of the start
    double depth = 0;
    Viewer viewer = viewer_new(&config->model, resolution);
    FfpImage sheet = ffp_image_new(6 * resolution, config->validation_scenes * resolution, 3);
    FfpRun *run = ffp_run_new();
    bool ok = true;
    for (int i = 0; i < config->validation_scenes && ok; i++) {
        FfpScene scene;
        if (!(ok = ffp_scene_open(&scene, config, "validation", i, resolution, err))) break;
        ok = ffp_model_forward(model, run, &scene.inputs, &scene.start, scene.active, err);
        if (ok) {
            FfpGaussians start = ffp_start_gaussians(&scene.inputs, &scene.start);
            score(&viewer, &scene, &run->gaussians, &tallies[0], &tallies[1]);
            score(&viewer, &scene, &start, &tallies[4], &tallies[5]);
            depth += depth_error_median(&scene, run);
            draw_row(&viewer, &scene, &start, &run->gaussians, &sheet, i);
            FfpGaussians polished = ffp_gaussians_copy(&run->gaussians);
            ok = ffp_scene_polish(&polished, config, &viewer.settings, &scene, (uint64_t)i, err);
            if (ok) score(&viewer, &scene, &polished, &tallies[2], &tallies[3]);
            ffp_gaussians_free(&polished);
            ffp_gaussians_free(&start);
        }
        ffp_scene_close(&scene);
    }
    *result = (FfpValidation){mean(tallies[0]),
                              mean(tallies[1]),
                              mean(tallies[2]),
                              mean(tallies[3]),
                              mean(tallies[4]),
                              mean(tallies[5]),
                              depth / config->validation_scenes};
    ok = ok && (!picture || ffp_image_write_png(&sheet, picture, err));
    ffp_run_free(run);
    ffp_image_free(&sheet);
    viewer_free(&viewer);
    return ok;
}
