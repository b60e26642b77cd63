// How well weights predict photographs of captures that they were not taught.
#include "core/base/alloc.h"
#include "engine/loss/metrics.h"
#include "engine/render/pass.h"
#include "lab/train/captures.h"

typedef struct Scoring {
    const FfpTrainConfig *config;
    FfpRenderSettings settings;
    FfpViewPass *pass;
    double alone, polished; // sums
    int photographs;
} Scoring;

// True if the picture could be predicted at all: it is not what the Gaussians were made from.
static bool is_held_out(const FfpScene *scene, int view, int pattern) {
    const bool given =
        pattern == scene->capture.black || pattern == scene->capture.white || pattern == scene->active;
    return view >= scene->inputs.n_views || !given;
}

// Sum over the held-out photographs, and their number.
static double sum_of(Scoring *s, const FfpScene *scene, const FfpGaussians *gaussians, int *photographs) {
    const FfpCapture *capture = &scene->capture;
    double sum = 0;
    *photographs = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        FfpImage picture = ffp_image_new(view->camera.width, view->camera.height, 3);
        ffp_view_pass_draw(s->pass, gaussians, &view->camera, &view->projector);
        for (int p = 0; p < capture->n_patterns; p++) {
            if (!is_held_out(scene, v, p)) continue;
            ffp_view_pass_shade(s->pass, capture->intensity, p == capture->black ? NULL : &scene->patterns[p],
                                &picture);
            FfpImage truth = ffp_image_copy(&view->images[p]);
            ffp_image_to_srgb(&truth);
            sum += ffp_psnr(&picture, &truth);
            ++*photographs;
            ffp_image_free(&truth);
        }
        ffp_image_free(&picture);
    }
    return sum;
}

static bool predict(FfpRun *run, const FfpModel *model, const FfpScene *scene, int looks, FfpError *err) {
    run->looks = looks;
    return ffp_model_forward(model, run, &scene->inputs, &scene->start, &scene->context, scene->active, err);
}

static bool score_scene(Scoring *s, const FfpModel *model, FfpRun *run, const FfpScene *scene, int number,
                        FfpError *err) {
    int photographs;
    if (!predict(run, model, scene, FFP_LOOKS_MAX, err)) return false;
    const double alone = sum_of(s, scene, &run->gaussians, &photographs);
    if (model->config.looks > 0 && !predict(run, model, scene, 0, err)) return false;
    FfpGaussians polished = ffp_gaussians_copy(&run->gaussians);
    const bool ok = ffp_scene_polish(&polished, s->config, &s->settings, scene, (uint64_t)number, err);
    if (ok) {
        s->alone += alone;
        s->photographs += photographs;
        s->polished += sum_of(s, scene, &polished, &photographs);
    }
    ffp_gaussians_free(&polished);
    return ok;
}

bool ffp_captures_score(const FfpModel *model, const FfpTrainConfig *config, const FfpCaptureSet *set,
                        FfpHeldOut *result, FfpError *err) {
    Scoring s = {.config = config,
                 .settings =
                     ffp_render_settings(ffp_model_is_paper_form(&config->model), config->model.samples)};
    s.pass = ffp_view_pass_new(&s.settings);
    FfpRun *run = ffp_run_new(false);
    bool ok = true;
    for (int i = 0; ok && i < ffp_captures_count(set, true); i++) {
        FfpScene scene;
        ok = ffp_captures_held_scene(&scene, config, set, i, err);
        if (!ok) break;
        ok = score_scene(&s, model, run, &scene, i, err);
        ffp_scene_close(&scene);
    }
    const int n = s.photographs > 0 ? s.photographs : 1;
    *result = (FfpHeldOut){s.alone / n, s.polished / n, s.photographs};
    ffp_run_free(run);
    ffp_view_pass_free(s.pass);
    return ok;
}
