// The three protocols: predictions of a capture's pictures against the pictures themselves.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"
#include "eval/reconstruct.h"
#include "eval/relight.h"
#include "eval/report.h"
#include "eval/scores.h"
#include "loss/loss.h"
#include "loss/metrics.h"

#define PATTERN_BLOCK 16   // patterns whose summed areas are held at once (15 MB each at 800 x 800)
#define REPORT_PICTURES 12 // predictions shown for each protocol
#define REPORT_MAPS 2      // views whose G-buffers are shown

typedef struct Evaluation { // what all captures share
    const FfpEvaluation *options;
    FfpPerceptual *lpips;
    FfpReport *report;
    FfpScore *scores;
    int n_scores;
} Evaluation;

typedef struct Subject { // one capture under evaluation
    Evaluation *shared;
    FfpCapture *capture;
    FfpCapture normalised; // lookup predictors only
    FfpCapture targets;
    bool has_targets;
    int active;
    FfpGaussians *gaussians; // NULL for the lookup predictors
    FfpRelight relight;
    real **depth; // lookup predictors: [n_views] camera z in the normalised capture
    double reconstruct_s;
    char folder[FFP_PATH_MAX]; // where predictions are saved
} Subject;

typedef struct Protocol {
    const char *name;
    const FfpCapture *views; // the capture itself, or its targets
    bool *wanted;            // [views->n_patterns]
    int total;               // pictures there are
} Protocol;

typedef struct Means {
    double psnr, foreground, ssim, lpips, unseen;
    int images, images_foreground, images_unseen;
} Means;

// --- Which pictures a protocol asks for. ---

// Black, white, lollipops, and whatever else the capture does not hold back.
static bool is_input(const Subject *subject, const FfpCapture *views, int pattern) {
    return pattern == subject->active || !views->patterns[pattern].novel;
}

static Protocol protocol_new(const char *name, const Subject *subject) {
    Protocol protocol = {name, subject->capture, NULL, 0};
    const bool poses = strcmp(name, "novel_pose") == 0, rendering = strcmp(name, "rendering") == 0;
    if (poses) protocol.views = &subject->targets;
    const FfpCapture *views = protocol.views;
    protocol.wanted = ffp_alloc(views->n_patterns, sizeof *protocol.wanted);
    for (int p = 0; p < views->n_patterns; p++) {
        const bool input = is_input(subject, views, p);
        protocol.wanted[p] = poses || input == rendering;
        for (int v = 0; protocol.wanted[p] && v < views->n_views; v++)
            protocol.total += views->views[v].images[p].data != NULL;
    }
    return protocol;
}

// --- Predicting. ---

static FfpImage predict(Subject *subject, const Protocol *protocol, int view, int pattern,
                        const FfpSummed *summed) {
    if (subject->gaussians)
        return ffp_relight_shade(&subject->relight, &protocol->views->views[view],
                                 subject->capture->intensity, summed);
    FfpImage picture = ffp_predict_by_lookup(&subject->normalised, view, pattern, subject->depth[view]);
    ffp_quantise(&picture);
    return picture;
}

static bool prepare_gaussians(Subject *subject, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    FfpReconstructionStory story = {0};
    subject->reconstruct_s = NAN;
    if (options->gaussians) {
        subject->gaussians = ffp_gaussians_open(options->gaussians, err);
    } else {
        const FfpReconstruction how = {options->model, options->pattern};
        const double begin = ffp_seconds();
        subject->gaussians = ffp_reconstruct(subject->capture, &how, &story, err);
        subject->reconstruct_s = ffp_seconds() - begin;
        if (subject->gaussians && subject->shared->report) ffp_report_story(subject->shared->report, &story);
    }
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, options->model);
    subject->relight = ffp_relight_new(&settings);
    return subject->gaussians != NULL;
}

static bool prepare_lookup(Subject *subject, FfpError *err) {
    const bool match = subject->shared->options->predictor == FFP_PREDICT_MATCH;
    const FfpMatchSettings settings = ffp_match_defaults();
    subject->normalised = ffp_normalised_alias(subject->capture);
    subject->depth = ffp_alloc(subject->capture->n_views, sizeof *subject->depth);
    const double begin = ffp_seconds();
    for (int v = 0; v < subject->capture->n_views; v++) {
        const FfpView *view = &subject->normalised.views[v];
        const size_t pixels = (size_t)view->camera.width * view->camera.height;
        if (!match && !view->depth.data)
            return ffp_fail(err, subject->capture->folder,
                            "view %s has no depth, which --predictor depth needs", view->id);
        subject->depth[v] = ffp_alloc(pixels, sizeof(real));
        if (match)
            ffp_match_depth(&subject->normalised, v, subject->active, &settings, subject->depth[v]);
        else
            memcpy(subject->depth[v], view->depth.data, pixels * sizeof(real));
    }
    subject->reconstruct_s = match ? ffp_seconds() - begin : NAN;
    return true;
}

// --- Scoring one picture. ---

static FfpImage foreground_mask(const FfpView *view) {
    FfpImage mask = ffp_image_copy(&view->coverage);
    for (int i = 0; i < mask.width * mask.height; i++) mask.data[i] = mask.data[i] > 0;
    return mask;
}

static double score_picture(Subject *subject, const Protocol *protocol, int view, int pattern,
                            const FfpImage *truth, const FfpImage *prediction, Means *means) {
    const double psnr = ffp_psnr(prediction, truth);
    FfpImage mask = foreground_mask(&protocol->views->views[view]);
    const double foreground = ffp_psnr_masked(prediction, truth, &mask);
    ffp_image_free(&mask);
    means->images++;
    means->psnr += psnr;
    means->ssim += ffp_ssim(prediction, truth);
    if (isfinite(foreground)) means->foreground += foreground, means->images_foreground++;
    if (subject->shared->lpips)
        means->lpips += ffp_perceptual_loss(subject->shared->lpips, prediction, truth, 1, NULL);
    const FfpCapture *views = protocol->views;
    const bool given = pattern == subject->active || pattern == views->black || pattern == views->white;
    if (strcmp(protocol->name, "rendering") == 0 && !given) means->unseen += psnr, means->images_unseen++;
    return psnr;
}

static bool save_prediction(const Subject *subject, const FfpView *view, const char *pattern,
                            const FfpImage *prediction, FfpError *err) {
    char path[FFP_PATH_MAX], rest[FFP_NAME_MAX + 8];
    snprintf(rest, sizeof rest, "%s.png", pattern);
    return ffp_picture_path(path, sizeof path, subject->folder, view->id, rest, err) &&
           ffp_image_write_png(prediction, path, err);
}

// Evenly spread over the protocol's pictures.
static bool shown_in_report(const Protocol *protocol, int index) {
    if (protocol->total <= REPORT_PICTURES) return true;
    return (int64_t)index * REPORT_PICTURES / protocol->total !=
               ((int64_t)index - 1) * REPORT_PICTURES / protocol->total ||
           index == 0;
}

static bool handle_picture(Subject *subject, const Protocol *protocol, int v, int p,
                           const FfpImage *prediction, Means *means, FfpError *err) {
    const FfpView *view = &protocol->views->views[v];
    const char *name = protocol->views->patterns[p].name;
    FfpImage truth = ffp_image_copy(&view->images[p]);
    ffp_image_to_srgb(&truth);
    const int index = means->images;
    const double psnr = score_picture(subject, protocol, v, p, &truth, prediction, means);
    if (subject->shared->report && shown_in_report(protocol, index))
        ffp_report_prediction(subject->shared->report, view->id, name, &truth, prediction, psnr);
    ffp_image_free(&truth);
    return !subject->shared->options->save || save_prediction(subject, view, name, prediction, err);
}

// --- One protocol. ---

static bool run_view(Subject *subject, const Protocol *protocol, int v, int first, const FfpSummed *sums,
                     Means *means, double *seconds, FfpError *err) {
    const FfpView *view = &protocol->views->views[v];
    double begin = ffp_seconds();
    if (subject->gaussians) ffp_relight_view(&subject->relight, subject->gaussians, view);
    *seconds += ffp_seconds() - begin;
    bool ok = true;
    for (int p = first; ok && p < first + PATTERN_BLOCK && p < protocol->views->n_patterns; p++) {
        if (!protocol->wanted[p] || !view->images[p].data) continue;
        begin = ffp_seconds();
        FfpImage prediction = predict(subject, protocol, v, p, &sums[p - first]);
        *seconds += ffp_seconds() - begin;
        ok = handle_picture(subject, protocol, v, p, &prediction, means, err);
        ffp_image_free(&prediction);
    }
    return ok;
}

static void add_score(Subject *subject, const Protocol *protocol, const Means *means, double seconds) {
    FfpScore *score = &subject->shared->scores[subject->shared->n_scores++];
    *score = (FfpScore){
        .protocol = protocol->name, .images = means->images, .images_unseen = means->images_unseen};
    snprintf(score->capture, sizeof score->capture, "%s", subject->capture->name);
    score->psnr = means->psnr / means->images;
    score->psnr_foreground = means->images_foreground ? means->foreground / means->images_foreground : NAN;
    score->ssim = means->ssim / means->images;
    score->lpips = subject->shared->lpips ? means->lpips / means->images : NAN;
    score->psnr_unseen_lollipops = means->images_unseen ? means->unseen / means->images_unseen : NAN;
    score->reconstruct_s = subject->reconstruct_s;
    score->render_s = seconds;
}

static bool run_protocol(Subject *subject, const char *name, const char *explanation, FfpError *err) {
    Protocol protocol = protocol_new(name, subject);
    const FfpCapture *views = protocol.views;
    Means means = {0};
    double seconds = 0;
    bool ok = true;
    if (protocol.total && subject->shared->report)
        ffp_report_heading(subject->shared->report, name, explanation);
    for (int first = 0; ok && protocol.total && first < views->n_patterns; first += PATTERN_BLOCK) {
        FfpSummed sums[PATTERN_BLOCK] = {0};
        for (int p = first; p < first + PATTERN_BLOCK && p < views->n_patterns; p++)
            if (subject->gaussians && protocol.wanted[p])
                sums[p - first] = ffp_summed_new(&views->patterns[p].image);
        for (int v = 0; ok && v < views->n_views; v++)
            ok = run_view(subject, &protocol, v, first, sums, &means, &seconds, err);
        for (int p = 0; p < PATTERN_BLOCK; p++) ffp_summed_free(&sums[p]);
    }
    if (ok && means.images) add_score(subject, &protocol, &means, seconds);
    free(protocol.wanted);
    return ok;
}

// --- What only the report shows. ---

static void report_maps(Subject *subject) {
    if (!subject->gaussians) return;
    ffp_report_heading(
        subject->shared->report, "G-buffers",
        "What the Gaussians hold, seen from an input view: nothing here depends on a pattern.");
    const int n = subject->capture->n_views, shown = n < REPORT_MAPS ? n : REPORT_MAPS;
    for (int i = 0; i < shown; i++) {
        const FfpView *view = &subject->capture->views[i * n / shown];
        ffp_relight_view(&subject->relight, subject->gaussians, view);
        ffp_report_maps(subject->shared->report, view->id, &subject->relight.gbuffer);
    }
}

static void report_relit_views(Subject *subject, const FfpCapture *views, const FfpSummed *summed) {
    for (int v = 0; v < views->n_views && v < 8; v++) {
        ffp_relight_view(&subject->relight, subject->gaussians, &views->views[v]);
        FfpImage picture =
            ffp_relight_shade(&subject->relight, &views->views[v], subject->capture->intensity, summed);
        ffp_report_picture(subject->shared->report, &picture, views->views[v].id);
        ffp_image_free(&picture);
    }
}

static bool report_shown_pattern(Subject *subject, const char *path, FfpError *err) {
    FfpPattern pattern;
    const FfpCamera *projector = &subject->capture->views[0].projector;
    if (!subject->gaussians) return true;
    if (!ffp_pattern_read(&pattern, path, projector->width, projector->height, err)) return false;
    ffp_report_heading(
        subject->shared->report, "Relit by a pattern that nobody photographed",
        "There is no truth to compare with. First the pattern, then every input view, then new poses.");
    FfpImage encoded = ffp_image_copy(&pattern.image);
    ffp_image_to_srgb(&encoded);
    ffp_report_picture(subject->shared->report, &encoded, pattern.name);
    ffp_image_free(&encoded);
    FfpSummed summed = ffp_summed_new(&pattern.image);
    report_relit_views(subject, subject->capture, &summed);
    if (subject->has_targets) report_relit_views(subject, &subject->targets, &summed);
    ffp_summed_free(&summed);
    ffp_image_free(&pattern.image);
    return true;
}

// --- One capture. ---

static bool run_subject(Subject *subject, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    FfpReport *report = subject->shared->report;
    if (report) ffp_report_capture(report, subject->capture, subject->active);
    const bool lookup = options->predictor != FFP_PREDICT_GAUSSIANS;
    if (!(lookup ? prepare_lookup(subject, err) : prepare_gaussians(subject, err))) return false;
    if (report) report_maps(subject);
    return run_protocol(
               subject, "rendering",
               "Input poses under black, white and lollipops. Each: prediction, truth, error times 4.",
               err) &&
           run_protocol(subject, "novel_pattern",
                        "Input poses under other patterns. Each: prediction, truth, error times 4.", err) &&
           (!subject->has_targets || lookup ||
            run_protocol(subject, "novel_pose",
                         "New camera and projector poses. Each: prediction, truth, error times 4.", err)) &&
           (!report || !options->show_pattern || report_shown_pattern(subject, options->show_pattern, err));
}

static void free_subject(Subject *subject) {
    for (int v = 0; subject->depth && v < subject->capture->n_views; v++) free(subject->depth[v]);
    free(subject->depth);
    if (subject->normalised.views) ffp_normalised_alias_free(&subject->normalised);
    if (subject->relight.raster) ffp_relight_free(&subject->relight);
    if (subject->has_targets) ffp_capture_free(&subject->targets);
    ffp_gaussians_close(subject->gaussians);
    ffp_capture_close(subject->capture);
}

// A relative path is looked up in the capture's own folder first, so that one serves many captures.
static bool open_targets(Subject *subject, int index, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    if (!options->n_targets) return true;
    const char *path = options->targets[options->n_targets == 1 ? 0 : index];
    char beside[FFP_PATH_MAX];
    if (path[0] != '/' && ffp_join_path(beside, subject->capture->folder, path) && ffp_is_file(beside))
        path = beside;
    if (!ffp_capture_read_targets(&subject->targets, path, subject->capture, err)) return false;
    subject->has_targets = true;
    if (strcmp(subject->targets.name, subject->capture->name) != 0)
        return ffp_fail(err, path, "these poses belong to %s, not to %s", subject->targets.name,
                        subject->capture->name);
    return true;
}

static bool open_save_folder(Subject *subject, FfpError *err) {
    const char *save = subject->shared->options->save, *name = subject->capture->name;
    for (int i = 0; i < subject->shared->n_scores; i++)
        if (save && strcmp(subject->shared->scores[i].capture, name) == 0)
            return ffp_fail(err, save, "two captures are called %s: their pictures would share a folder",
                            name);
    if (!save) return true;
    if (!*name || *name == '.' || strchr(name, '/'))
        return ffp_fail(err, save, "%s is no name for a folder", name);
    if (!ffp_join_path(subject->folder, save, name)) return ffp_fail(err, save, "path is too long");
    return ffp_make_folders(subject->folder, err);
}

static bool evaluate_capture(Evaluation *shared, int index, FfpError *err) {
    Subject subject = {.shared = shared};
    subject.capture = ffp_capture_open(shared->options->captures[index], err);
    bool ok = subject.capture != NULL;
    if (ok) {
        subject.active = ffp_capture_active_pattern(subject.capture, shared->options->pattern, err);
        ok = subject.active >= 0 && open_targets(&subject, index, err) && open_save_folder(&subject, err) &&
             run_subject(&subject, err);
    }
    free_subject(&subject);
    return ok;
}

// --- All of them. ---

// Fails before the work rather than after it.
static bool probe_output(const char *path, FfpError *err) {
    FfpOutput out;
    if (!path) return true;
    const bool ok = ffp_output_open(&out, path, err);
    ffp_output_abort(&out);
    return ok;
}

static bool open_perceptual(Evaluation *shared, FfpError *err) {
    const char *path = shared->options->perceptual, *folder = getenv("FFPROCAMS_PERCEPTUAL");
    char found[FFP_PATH_MAX];
    if (!path && folder && *folder) {
        if (!ffp_join_path(found, folder, "lpips_alex.safetensors"))
            return ffp_fail(err, folder, "path is too long");
        path = found;
    }
    if (!path) {
        ffp_note("no LPIPS: neither --perceptual nor FFPROCAMS_PERCEPTUAL names its weights");
        return true;
    }
    shared->lpips = ffp_perceptual_read(path, err);
    if (shared->lpips && !ffp_perceptual_is_lpips(shared->lpips))
        return ffp_fail(err, path, "holds no LPIPS weights");
    return shared->lpips != NULL;
}

static bool check_options(const FfpEvaluation *options, FfpError *err) {
    if (options->n_captures < 1) return ffp_fail(err, NULL, "no capture to evaluate");
    if (options->n_targets > 1 && options->n_targets != options->n_captures)
        return ffp_fail(err, NULL, "%d target files for %d captures: give one for all, or one for each",
                        options->n_targets, options->n_captures);
    if (options->n_targets && options->predictor != FFP_PREDICT_GAUSSIANS)
        ffp_note("this predictor sees only the input poses: novel_pose is left out");
    return probe_output(options->json, err) && probe_output(options->report, err);
}

FfpScore *ffp_evaluate(const FfpEvaluation *options, int *n_scores, FfpError *err) {
    Evaluation shared = {.options = options};
    *n_scores = 0;
    if (!check_options(options, err)) return NULL;
    bool ok = open_perceptual(&shared, err);
    if (options->report)
        shared.report = ffp_report_new(options->model_name ? options->model_name : "unnamed");
    shared.scores = ffp_alloc(3 * (size_t)options->n_captures, sizeof *shared.scores);
    for (int i = 0; ok && i < options->n_captures; i++) ok = evaluate_capture(&shared, i, err);
    if (ok && options->json) ok = ffp_scores_write(shared.scores, shared.n_scores, options, err);
    if (ok && options->report)
        ok = ffp_report_write(shared.report, shared.scores, shared.n_scores, options->report, err);
    ffp_report_free(shared.report);
    ffp_perceptual_free(shared.lpips);
    if (!ok) {
        free(shared.scores);
        return NULL;
    }
    *n_scores = shared.n_scores;
    return shared.scores;
}
