// Compensation from files to files: views and targets in, patterns and predicted pictures out.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "apply/choose.h"
#include "apply/solve.h"
#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"

#define STEPS_MAX 100000

typedef struct Job {
    const FfpCompensation *options;
    const FfpCapture *capture;
    FfpChosen chosen;
    FfpImage *targets, *alphas; // [n_targets]; an alpha is empty where the file has none
    FfpStage stage;
} Job;

static bool check_options(const FfpCompensation *options, FfpError *err) {
    if (options->n_targets < 1) return ffp_fail(err, NULL, "no target to compensate for");
    if (!(options->gain >= 0) || !isfinite(options->gain))
        return ffp_fail(err, NULL, "a gain of %g is not above zero", options->gain);
    if (options->steps < 0 || options->steps > STEPS_MAX)
        return ffp_fail(err, NULL, "%d steps are not in 0 to %d", options->steps, STEPS_MAX);
    FfpOutput out; // fails before the work rather than after it
    const bool ok = ffp_output_open(&out, options->pattern, err);
    ffp_output_abort(&out);
    return ok;
}

// A target is a picture in the camera's frame: of its shape, if not of its size.
static bool check_shape(const FfpImage *target, const FfpView *view, const char *path, FfpError *err) {
    const double ratio = (double)target->width / target->height,
                 wanted = (double)view->camera.width / view->camera.height;
    if (fabs(ratio / wanted - 1) <= 0.01) return true;
    return ffp_fail(err, path, "a target of %d x %d has not the shape of view %s's camera of %d x %d",
                    target->width, target->height, view->id, view->camera.width, view->camera.height);
}

static const char *target_of(const Job *job, int v, int *index) {
    *index = job->options->n_targets == 1 ? 0 : v;
    return job->options->targets[*index];
}

static bool read_targets(Job *job, FfpError *err) {
    const FfpCompensation *options = job->options;
    const int n = options->n_targets, n_views = job->chosen.n_views;
    if (n != 1 && n != n_views)
        return ffp_fail(err, NULL, "%d targets for %d views: give one for all, or one for each", n, n_views);
    job->targets = ffp_alloc((size_t)n, sizeof *job->targets);
    job->alphas = ffp_alloc((size_t)n, sizeof *job->alphas);
    for (int t = 0; t < n; t++)
        if (!ffp_image_read_over_black(&job->targets[t], &job->alphas[t], options->targets[t], err))
            return false;
    for (int v = 0, t; v < n_views; v++) {
        const char *path = target_of(job, v, &t);
        if (!check_shape(&job->targets[t], job->chosen.views[v], path, err)) return false;
    }
    return true;
}

static void aim(Job *job) {
    for (int v = 0, t; v < job->chosen.n_views; v++) {
        const FfpCamera *camera = &job->chosen.views[v]->camera;
        target_of(job, v, &t);
        FfpImage target = ffp_image_resize(&job->targets[t], camera->width, camera->height), alpha = {0};
        if (job->alphas[t].data) alpha = ffp_image_resize(&job->alphas[t], camera->width, camera->height);
        ffp_stage_aim(&job->stage, v, &target, alpha.data ? &alpha : NULL);
        ffp_image_free(&target);
        ffp_image_free(&alpha);
    }
}

// A view without a lit pixel cannot be helped by any pattern.
static bool check_light(const Job *job, FfpError *err) {
    for (int s = 0; s < job->stage.n_sights; s++) {
        FfpImage lit = ffp_stage_lit(&job->stage, s);
        bool any = false;
        for (int p = 0; p < lit.width * lit.height; p++) any |= lit.data[p] > 0;
        ffp_image_free(&lit);
        if (!any)
            return ffp_fail(
                err, job->stage.sights[s].view->id,
                "no projector lights anything that this view's camera sees and the target asks for");
    }
    return true;
}

static void solve(Job *job, FfpCompensationStory *story) {
    const FfpCompensation *options = job->options;
    FfpStage *stage = &job->stage;
    story->gain = options->paint ? 1 : options->gain > 0 ? options->gain : (double)ffp_stage_brightest(stage);
    if (options->paint)
        ffp_stage_paint(stage);
    else
        ffp_stage_scale(stage, (real)story->gain);
    const FfpGamut gamut = ffp_stage_gamut(stage);
    story->unlit = gamut.unlit, story->too_dark = gamut.too_dark, story->too_bright = gamut.too_bright;
    story->psnr_dark = ffp_stage_psnr(stage);
    ffp_stage_closed_form(stage);
    story->psnr_closed = ffp_stage_psnr(stage);
    ffp_stage_descend(stage, options->steps);
    ffp_stage_quantise(stage);
    story->psnr = ffp_stage_psnr(stage);
    story->patterns = stage->n_beams;
}

// "<pattern without .png><between><id>.png"
static bool name_beside(char out[FFP_PATH_MAX], const char *pattern, const char *between, const char *id,
                        FfpError *err) {
    const char *base = ffp_basename(pattern), *dot = strrchr(base, '.');
    const int stem = (int)(dot && dot != base ? dot - pattern : (ptrdiff_t)strlen(pattern));
    if (strchr(id, '/')) return ffp_fail(err, pattern, "view %s is no name for a file", id);
    if (snprintf(out, FFP_PATH_MAX, "%.*s%s%s.png", stem, pattern, between, id) >= FFP_PATH_MAX)
        return ffp_fail(err, pattern, "the path is too long");
    return true;
}

static bool write_encoded(FfpImage *linear, const char *path, FfpError *err) {
    ffp_image_to_srgb(linear);
    return ffp_image_write_png(linear, path, err);
}

static bool write_results(const Job *job, FfpError *err) {
    const FfpStage *stage = &job->stage;
    const char *file = job->options->pattern;
    char path[FFP_PATH_MAX];
    bool ok = true;
    for (int s = 0; ok && s < stage->n_sights; s++) {
        FfpImage picture = ffp_stage_picture(stage, s), target = ffp_image_copy(&stage->sights[s].target);
        const char *id = stage->sights[s].view->id;
        ok = name_beside(path, file, "_seen_", id, err) && write_encoded(&picture, path, err) &&
             name_beside(path, file, "_target_", id, err) && write_encoded(&target, path, err);
        ffp_image_free(&picture);
        ffp_image_free(&target);
    }
    for (int k = 0; ok && k < stage->n_beams; k++) {
        FfpImage pattern = ffp_image_copy(&stage->beams[k].pattern);
        ok = stage->n_beams == 1 || name_beside(path, file, "_", stage->beams[k].view->id, err);
        ok = ok && write_encoded(&pattern, stage->n_beams == 1 ? file : path, err);
        ffp_image_free(&pattern);
    }
    return ok;
}

static void free_job(Job *job) {
    for (int t = 0; job->targets && t < job->options->n_targets; t++) {
        ffp_image_free(&job->targets[t]);
        ffp_image_free(&job->alphas[t]);
    }
    free(job->targets);
    free(job->alphas);
    ffp_stage_free(&job->stage);
    ffp_chosen_free(&job->chosen);
}

bool ffp_compensate(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpCompensation *options,
                    FfpCompensationStory *story, FfpError *err) {
    Job job = {.options = options, .capture = capture};
    FfpCompensationStory told = {0};
    const double begin = ffp_seconds();
    bool ok = check_options(options, err) &&
              ffp_choose_views(&job.chosen, capture, options->poses, options->views, options->n_views, err) &&
              read_targets(&job, err);
    if (ok) {
        const FfpRenderSettings settings = ffp_render_settings(options->drawing);
        job.stage = ffp_stage_new(gaussians, capture, job.chosen.views, job.chosen.n_views, &settings,
                                  !options->gaussians_only);
        aim(&job);
        ok = check_light(&job, err);
    }
    if (ok) solve(&job, &told);
    ok = ok && write_results(&job, err);
    told.seconds = ffp_seconds() - begin;
    if (ok && story) *story = told;
    free_job(&job);
    return ok;
}
