// Compensation: views and targets in, patterns and predicted pictures out.
#include "engine/pipeline/compensate.h"
#include <stdio.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/capture/panel.h"
#include "core/capture/photographs.h"
#include "core/capture/reduce.h"
#include "core/image/framing.h"
#include "engine/apply/choose.h"
#include "engine/apply/solve.h"
#include "engine/pipeline/elsewhere.h"
#include "engine/pipeline/need.h"
#include "engine/pipeline/relight.h"

#define STEPS_MAX 100000
#define SOLVED_PIXELS (4096.0 * 4096) // of a camera's picture, for which patterns are solved at most
#define BLACK_MOST 0.1                // of a projector's white
#define DEVICE "projector.device"

typedef struct Job {
    const FfpCompensation *options;
    const FfpRaw *pictures; // [n_targets] of the caller's memory; NULL: files
    const FfpCapture *capture;
    FfpChosen chosen;
    FfpView *reduced;           // [n_views] that stand in for larger ones; NULL: there are none
    FfpImage *targets, *alphas; // [n_targets]; an alpha is empty where the file has none
    FfpProCams procams;
    int times;         // as many pixels a side have
    FfpView *enlarged; // [n_views], the views of
    FfpProCams finer;  // for the closed form; times 1: there is none
} Job;

static bool check_options(const FfpCompensation *options, const FfpCapture *capture, FfpError *err) {
    if (options->n_targets < 1) return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "no target to compensate for");
    if (!(options->gain >= 0) || !isfinite(options->gain))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "a gain of %g is not above zero", options->gain);
    if (options->steps < 0 || options->steps > STEPS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "%d steps are not in 0 to %d", options->steps,
                        STEPS_MAX);
    if (!(options->black_level >= 0 && options->black_level <= BLACK_MOST))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "a black level of %g is not in 0 to %g",
                        options->black_level, BLACK_MOST);
    if (!ffp_framing_check(options->framing, err)) return false;
    return !options->for_device || capture->panel.known ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                    "the capture does not describe the real projector (scene.json: " DEVICE
                    "): its projector is the ideal one of a generated or older capture; import it again from "
                    "the calibration");
}

// --- Views of more pixels than a pattern has use for. ---

static int reduction_of(const FfpCamera *camera) {
    int factor = 1;
    while ((double)camera->width * camera->height > SOLVED_PIXELS * factor * factor) factor++;
    return factor;
}

// The size that a camera's picture is reduced to, with a note where it is smaller.
static void reduced_size(const FfpView *view, int *width, int *height) {
    const int factor = reduction_of(&view->camera);
    *width = (view->camera.width + factor - 1) / factor;
    *height = (view->camera.height + factor - 1) / factor;
    if (factor > 1)
        ffp_note("%s: %d x %d camera pixels are more than patterns are solved for; they are taken as %d x %d",
                 view->id, view->camera.width, view->camera.height, *width, *height);
}

static FfpView resized_view(const Job *job, const FfpView *view, int width, int height) {
    const FfpCapture *capture = job->capture;
    const int plain[2] = {capture->black, capture->white};
    const bool pictures = !job->options->gaussians_only && view->images && view->coverage.data;
    FfpView bare = *view;
    bare.correspondence = (FfpImage){0};
    if (!pictures) bare.images = NULL;
    if (!pictures) bare.coverage = (FfpImage){0};
    return ffp_view_reduced(&bare, capture->n_patterns, plain, pictures ? 2 : 0, width, height);
}

// From here on all work is for the smaller cameras; the predicted pictures have their sizes.
static void reduce_views(Job *job) {
    int most = 1;
    for (int v = 0; v < job->chosen.n_views; v++) {
        const int factor = reduction_of(&job->chosen.views[v]->camera);
        most = factor > most ? factor : most;
    }
    if (most == 1) return;
    job->reduced = ffp_alloc((size_t)job->chosen.n_views, sizeof *job->reduced);
    for (int v = 0; v < job->chosen.n_views; v++) {
        const FfpView *view = job->chosen.views[v];
        int width, height;
        reduced_size(view, &width, &height);
        job->reduced[v] = resized_view(job, view, width, height);
        job->chosen.views[v] = &job->reduced[v];
    }
}

// --- Photographs that are still in their files. ---

static bool reads_photographs(const FfpCapture *capture, const FfpCompensation *options) {
    return capture->files && !options->gaussians_only && !options->poses;
}

static bool hold_view(FfpCapture *held, const FfpCapture *capture, int v, FfpError *err) {
    const int plain[2] = {capture->black, capture->white};
    int width, height;
    if (v < 0 || held->views[v].images[capture->black].data) return true; // choosing the views refuses them
    reduced_size(&capture->views[v], &width, &height);
    FfpView read;
    if (!ffp_photographs_read(&read, capture, v, plain, 2, width, height, err)) return false;
    held->views[v] = read;
    return true;
}

bool ffp_compensation_hold(FfpCapture *held, const FfpCapture *capture, const FfpCompensation *options,
                           FfpError *err) {
    *held = *capture;
    held->files = NULL;
    held->views = ffp_alloc((size_t)capture->n_views, sizeof *held->views);
    memcpy(held->views, capture->views, (size_t)capture->n_views * sizeof *held->views);
    bool ok = true;
    const int n = !reads_photographs(capture, options) ? 0
                  : options->n_views                   ? options->n_views
                                                       : capture->n_views;
    for (int i = 0; ok && i < n; i++)
        ok = hold_view(held, capture,
                       options->n_views ? ffp_capture_find_view(capture, options->views[i]) : i, err);
    if (!ok) ffp_compensation_release(held, capture);
    return ok;
}

void ffp_compensation_release(FfpCapture *held, const FfpCapture *capture) {
    for (int v = 0; v < held->n_views; v++)
        if (held->views[v].images != capture->views[v].images)
            ffp_view_reduced_free(&held->views[v], held->n_patterns);
    ffp_free(held->views);
}

static int target_of(const Job *job, int v) {
    return job->options->n_targets == 1 ? 0 : v;
}

static bool read_target(Job *job, int t, FfpError *err) {
    const FfpCompensation *options = job->options;
    const FfpCamera *camera = &job->chosen.views[t]->camera; // its frame, or one of those
    if (!job->pictures)
        return ffp_framed_check(options->targets[t], camera->width, camera->height, err) &&
               ffp_image_read_over_black(&job->targets[t], &job->alphas[t], options->targets[t], err);
    const FfpRaw *raw = &job->pictures[t];
    char name[32];
    snprintf(name, sizeof name, "target %d", t);
    if (!raw->data) return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "the target has no pixels");
    return ffp_raw_over_black(&job->targets[t], &job->alphas[t], raw, name, err);
}

static bool read_targets(Job *job, FfpError *err) {
    const FfpCompensation *options = job->options;
    const int n = options->n_targets, n_views = job->chosen.n_views;
    if (n != 1 && n != n_views)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "%d targets for %d views: give one for all views, or one for each", n, n_views);
    job->targets = ffp_alloc((size_t)n, sizeof *job->targets);
    job->alphas = ffp_alloc((size_t)n, sizeof *job->alphas);
    for (int t = 0; t < n; t++)
        if (!read_target(job, t, err)) return false;
    return true;
}

static void aim(const Job *job, FfpProCams *procams, bool note) {
    const FfpCompensation *options = job->options;
    ffp_procams_black_level(procams, (real)options->black_level);
    for (int v = 0; v < procams->n_camera_views; v++) {
        const FfpCamera *camera = &procams->camera_views[v].view->camera;
        const int t = target_of(job, v), width = camera->width, height = camera->height;
        if (!job->pictures && note)
            ffp_framing_note(options->targets[t], &job->targets[t], width, height, options->framing);
        FfpImage target = ffp_image_framed(&job->targets[t], width, height, options->framing), alpha = {0};
        if (options->transparent_free && job->alphas[t].data)
            alpha = ffp_image_framed(&job->alphas[t], width, height, options->framing);
        ffp_procams_aim(procams, v, &target, alpha.data ? &alpha : NULL);
        ffp_image_free(&target);
        ffp_image_free(&alpha);
    }
}

// --- Edges finer than a camera's pixels. ---

#define TIMES_MOST 4
#define FINER_PIXELS 4e6 // of all views together, at most

// A projector with many pixels for one of the camera's would show that one's outline at every edge: so
// targets are asked for at up to TIMES_MOST as many pixels a side, where the Gaussians say where they lie.
// The descent goes on from there.
static void begin_finer(Job *job, const FfpGaussians *gaussians, const FfpRenderSettings *settings) {
    const int n = job->chosen.n_views;
    double pixels = 0;
    for (int k = 0; k < job->procams.n_projections; k++) {
        const int footprint = ffp_procams_footprint(&job->procams, k);
        job->times = footprint > job->times ? footprint : job->times;
    }
    for (int v = 0; v < n; v++)
        pixels += (double)job->chosen.views[v]->camera.width * job->chosen.views[v]->camera.height;
    job->times = job->times > TIMES_MOST ? TIMES_MOST : job->times;
    const double bytes =
        ffp_compensation_bytes((double)gaussians->count, job->chosen.views, n, settings->samples);
    FfpError none; // where it does not fit, fewer pixels will do
    while (job->times > 1 && pixels * job->times * job->times > FINER_PIXELS) job->times--;
    const int asked = job->times;
    while (job->times > 1 && !ffp_memory_suffices(bytes * job->times * job->times, "", "", "", &none))
        job->times--;
    if (job->times < asked)
        ffp_note("memory is short: edges are made at %d instead of %d times the camera's pixels a side",
                 job->times, asked);
    if (job->times == 1) return;
    const FfpView **views = ffp_alloc((size_t)n, sizeof *views);
    job->enlarged = ffp_alloc((size_t)n, sizeof *job->enlarged);
    for (int v = 0; v < n; v++) {
        const FfpView *view = job->chosen.views[v];
        job->enlarged[v] =
            resized_view(job, view, job->times * view->camera.width, job->times * view->camera.height);
        views[v] = &job->enlarged[v];
    }
    job->finer = ffp_procams_new(gaussians, job->capture, views, n, settings, !job->options->gaussians_only);
    job->finer.blur = job->procams.blur;
    ffp_free(views);
    aim(job, &job->finer, false);
}

// Targets as they are to be seen.
static void reach(FfpProCams *procams, bool paint, real gain) {
    if (paint) {
        ffp_procams_paint(procams);
        return;
    }
    ffp_procams_scale(procams, gain);
    ffp_procams_lift(procams);
}

// The closed form, of which the descent then starts at the camera's own pixels.
static void solve_finely(Job *job, real gain) {
    if (job->times == 1) {
        ffp_procams_closed_form(&job->procams, 1);
        return;
    }
    reach(&job->finer, job->options->paint, gain);
    ffp_procams_closed_form(&job->finer, job->times);
    for (int k = 0; k < job->procams.n_projections; k++) {
        const FfpImage kept = job->procams.projections[k].pattern;
        job->procams.projections[k].pattern = job->finer.projections[k].pattern;
        job->finer.projections[k].pattern = kept;
    }
    ffp_procams_free(&job->finer);
}

// Before the work: that all views fit into memory.
static bool check_memory(const Job *job, const FfpGaussians *gaussians, int samples, FfpError *err) {
    return ffp_memory_suffices(
        ffp_compensation_bytes((double)gaussians->count, job->chosen.views, job->chosen.n_views, samples),
        "compensating for pictures of this size", "use fewer views or a smaller camera picture",
        job->chosen.views[0]->id, err);
}

// A view without a lit pixel cannot be helped by any pattern.
static bool check_light(const Job *job, FfpError *err) {
    for (int s = 0; s < job->procams.n_camera_views; s++) {
        FfpImage lit = ffp_procams_lit(&job->procams, s);
        bool any = false;
        for (int p = 0; p < lit.width * lit.height; p++) any |= lit.data[p] > 0;
        ffp_image_free(&lit);
        if (!any)
            return ffp_fail(
                err, FFP_ERROR_ARGUMENT, job->procams.camera_views[s].view->id,
                "no projector lights anything that this view's camera sees and the target asks for");
    }
    return true;
}

// The projector's blur where patterns are to be sharpened for it.
static real blur_of(const Job *job) {
    if (!job->options->sharpen) return 0;
    if (!(job->capture->panel.blur > 0))
        ffp_note("the capture knows no blur of its projector: there is nothing to sharpen for");
    return job->capture->panel.blur;
}

static void solve(Job *job, FfpCompensationStats *stats) {
    const FfpCompensation *options = job->options;
    FfpProCams *procams = &job->procams;
    stats->gain = options->paint      ? 1
                  : options->gain > 0 ? options->gain
                                      : (double)ffp_procams_brightest(procams);
    reach(procams, options->paint, (real)stats->gain);
    stats->psnr_dark = ffp_procams_psnr(procams);
    solve_finely(job, (real)stats->gain);
    // Where patterns scatter light, what is too dark depends on them.
    const FfpGamut gamut = ffp_procams_gamut(procams);
    stats->unlit = gamut.unlit;
    stats->too_dark = gamut.too_dark;
    stats->too_bright = gamut.too_bright;
    stats->psnr_closed = ffp_procams_psnr(procams);
    ffp_procams_descend(procams, options->steps);
    ffp_procams_quantise(procams);
    stats->psnr = ffp_procams_psnr(procams);
    stats->patterns = procams->n_projections;
}

// The pattern of a projection as it is to be sent: to the ideal projector, or to the real one.
static bool sent(const Job *job, int k, FfpImage *out, FfpError *err) {
    const FfpProjection *projection = &job->procams.projections[k];
    if (job->options->for_device)
        return ffp_panel_picture(out, &job->capture->panel, &projection->view->projector,
                                 &projection->pattern, DEVICE, err);
    *out = ffp_image_copy(&projection->pattern);
    return true;
}

static bool collect(const Job *job, FfpImages *images, FfpError *err) {
    const FfpProCams *procams = &job->procams;
    for (int k = 0; k < procams->n_projections; k++) {
        FfpImage pattern;
        if (!sent(job, k, &pattern, err)) return false;
        ffp_images_add(images, pattern, "pattern", procams->projections[k].view->id);
    }
    for (int s = 0; s < procams->n_camera_views; s++) {
        const char *id = procams->camera_views[s].view->id;
        ffp_images_add(images, ffp_procams_picture(procams, s), "seen", id);
        ffp_images_add(images, ffp_image_copy(&procams->camera_views[s].target), "target", id);
    }
    return true;
}

static void free_job(Job *job) {
    for (int t = 0; job->targets && t < job->options->n_targets; t++) {
        ffp_image_free(&job->targets[t]);
        ffp_image_free(&job->alphas[t]);
    }
    ffp_free(job->targets);
    ffp_free(job->alphas);
    ffp_procams_free(&job->procams);
    ffp_procams_free(&job->finer);
    for (int v = 0; job->enlarged && v < job->chosen.n_views; v++)
        ffp_view_reduced_free(&job->enlarged[v], job->capture->n_patterns);
    ffp_free(job->enlarged);
    for (int v = 0; job->reduced && v < job->chosen.n_views; v++)
        ffp_view_reduced_free(&job->reduced[v], job->capture->n_patterns);
    ffp_free(job->reduced);
    ffp_chosen_free(&job->chosen);
}

static FfpImages *run(const FfpGaussians *gaussians, const FfpCapture *capture,
                      const FfpCompensation *options, const FfpRaw *pictures, FfpCompensationStats *stats,
                      FfpError *err) {
    Job job = {.options = options, .pictures = pictures, .capture = capture, .times = 1};
    FfpCompensationStats found = {0};
    FfpImages *images = NULL;
    const double begin = ffp_seconds();
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, NULL);
    bool ok = check_options(options, capture, err) &&
              ffp_choose_views(&job.chosen, capture, options->poses, options->views, options->n_views, err);
    if (ok) {
        ffp_note_elsewhere(gaussians, capture);
        reduce_views(&job);
    }
    ok = ok && check_memory(&job, gaussians, settings.samples, err) && read_targets(&job, err);
    if (ok) {
        job.procams = ffp_procams_new(gaussians, capture, job.chosen.views, job.chosen.n_views, &settings,
                                      !options->gaussians_only);
        job.procams.blur = blur_of(&job);
        aim(&job, &job.procams, true);
        ok = check_light(&job, err);
    }
    if (ok) {
        if (options->steps > 0) begin_finer(&job, gaussians, &settings);
        solve(&job, &found);
        images = ffp_images_new();
        ok = collect(&job, images, err);
        found.elapsed_s = ffp_seconds() - begin;
        if (stats) *stats = found;
    }
    free_job(&job);
    if (ok) return images;
    ffp_images_free(images);
    return NULL;
}

FfpImages *ffp_compensation_run(const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpCompensation *options, const FfpRaw *pictures,
                                FfpCompensationStats *stats, FfpError *err) {
    FfpCapture held;
    if (!reads_photographs(capture, options)) return run(gaussians, capture, options, pictures, stats, err);
    if (!ffp_compensation_hold(&held, capture, options, err)) return NULL;
    FfpImages *images = run(gaussians, &held, options, pictures, stats, err);
    ffp_compensation_release(&held, capture);
    return images;
}
