// Validation on fixed scenes of the validation split, beside the classical initialisation on the same
// pictures.
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/numerics/rank.h"
#include "engine/loss/metrics.h"
#include "engine/render/pass.h"
#include "lab/train/train.h"

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
    Viewer viewer = {.settings = ffp_render_settings(ffp_model_is_paper_form(model), model->samples),
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
    const double median = 100 * ffp_median(errors, (size_t)count);
    ffp_free(errors);
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

typedef struct Scores { // of scenes of one kind: input poses and new poses, alone and after the fit
    Tally rendering, novel_pose, polished_rendering, polished_novel_pose;
} Scores;

typedef struct Validation { // one call of ffp_validate
    const FfpModel *model;
    const FfpTrainConfig *config;
    Viewer viewer;
    FfpImage sheet;
    FfpRun *run;
    Scores turntable, free;
    Tally start_rendering, start_novel_pose, depth;
} Validation;

static bool predict(Validation *v, const FfpScene *scene, int looks, FfpError *err) {
    v->run->looks = looks;
    return ffp_model_forward(v->model, v->run, &scene->inputs, &scene->start, &scene->context, scene->active,
                             err);
}

// Scores the prediction in the run, and what a fit makes of the one before looks.
static bool score_both(Validation *v, const FfpScene *scene, int number, Scores *scores, FfpError *err) {
    score(&v->viewer, scene, &v->run->gaussians, &scores->rendering, &scores->novel_pose);
    if (v->model->config.looks > 0 && !predict(v, scene, 0, err)) return false;
    FfpGaussians polished = ffp_gaussians_copy(&v->run->gaussians);
    const bool ok = ffp_scene_polish(&polished, v->config, &v->viewer.settings, scene, (uint64_t)number, err);
    if (ok) score(&v->viewer, scene, &polished, &scores->polished_rendering, &scores->polished_novel_pose);
    ffp_gaussians_free(&polished);
    return ok;
}

static bool validate_turntable(Validation *v, int number, FfpError *err) {
    FfpScene scene;
    if (!ffp_scene_open(&scene, v->config, NULL, "validation", number, err)) return false;
    bool ok = predict(v, &scene, FFP_LOOKS_MAX, err);
    if (ok) {
        FfpGaussians start = ffp_initialisation_gaussians(&scene.inputs, &scene.start);
        score(&v->viewer, &scene, &start, &v->start_rendering, &v->start_novel_pose);
        v->depth.sum += depth_error_median(&scene, v->run);
        v->depth.count++;
        draw_row(&v->viewer, &scene, &start, &v->run->gaussians, &v->sheet, number);
        ok = score_both(v, &scene, number, &v->turntable, err);
        ffp_gaussians_free(&start);
    }
    ffp_scene_close(&scene);
    return ok;
}

static bool validate_free(Validation *v, int number, FfpError *err) {
    FfpScene scene;
    if (!ffp_scene_open_free(&scene, v->config, number, err)) return false;
    const bool ok = predict(v, &scene, FFP_LOOKS_MAX, err) && score_both(v, &scene, number, &v->free, err);
    ffp_scene_close(&scene);
    return ok;
}

static FfpValidation figures(const Validation *v) {
    return (FfpValidation){.rendering = mean(v->turntable.rendering),
                           .novel_pose = mean(v->turntable.novel_pose),
                           .polished_rendering = mean(v->turntable.polished_rendering),
                           .polished_novel_pose = mean(v->turntable.polished_novel_pose),
                           .start_rendering = mean(v->start_rendering),
                           .start_novel_pose = mean(v->start_novel_pose),
                           .free_rendering = mean(v->free.rendering),
                           .free_novel_pose = mean(v->free.novel_pose),
                           .polished_free_rendering = mean(v->free.polished_rendering),
                           .polished_free_novel_pose = mean(v->free.polished_novel_pose),
                           .depth_median = mean(v->depth)};
}

bool ffp_validate(const FfpModel *model, const FfpTrainConfig *config, const char *picture,
                  FfpValidation *result, FfpError *err) {
    const int scenes = config->validation_scenes;
    const int free_scenes = scenes < FFP_FREE_VALIDATION ? scenes : FFP_FREE_VALIDATION;
    Validation v = {.model = model,
                    .config = config,
                    .viewer = viewer_new(&config->model, config->resolution),
                    .sheet = ffp_image_new(6 * config->resolution, scenes * config->resolution, 3),
                    .run = ffp_run_new(false)};
    bool ok = true;
    for (int i = 0; i < scenes && ok; i++) ok = validate_turntable(&v, i, err);
    for (int i = 0; config->free_share > 0 && i < free_scenes && ok; i++) ok = validate_free(&v, i, err);
    *result = figures(&v);
    ok = ok && (!picture || ffp_image_write_png(&v.sheet, picture, err));
    ffp_run_free(v.run);
    ffp_image_free(&v.sheet);
    viewer_free(&v.viewer);
    return ok;
}
