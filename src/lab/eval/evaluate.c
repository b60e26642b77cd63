// The three protocols on any number of captures: predictions against the pictures themselves.
#include "lab/eval/evaluate.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/capture/node.h"
#include "engine/match/match.h"
#include "engine/pipeline/normalised.h"
#include "engine/pipeline/reconstruct.h"
#include "lab/eval/scores.h"
#include "lab/eval/subject.h"
#include "rig/checks/checks.h"

#define REPORT_MAPS 2     // views whose G-buffers are shown
#define REPORT_LARGE 3    // views that are drawn large
#define LARGE_WIDTH 768   // pixels
#define LARGE_SCALE_MAX 8 // of its photographs

// --- What predicts. ---

static bool prepare_field(FfpSubject *subject, const char *path, FfpError *err) {
    FfpNeuralField *field = ffp_alloc(1, sizeof *field);
    if (!ffp_neural_field_read(field, path, err)) {
        ffp_free(field);
        return false;
    }
    subject->field = field;
    subject->field_pass = ffp_field_pass_new();
    return true;
}

static bool prepare_gaussians(FfpSubject *subject, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    subject->reconstruct_s = NAN;
    if (options->field) return prepare_field(subject, options->field, err);
    if (options->gaussians) {
        subject->gaussians = ffp_gaussians_load(options->gaussians, err);
    } else {
        const FfpReconstruction how = {.model = options->model,
                                       .patterns = options->patterns,
                                       .n_patterns = options->n_patterns,
                                       .polish = options->polish,
                                       .noise = options->noise,
                                       .layers = options->layers,
                                       .drawing = options->drawing};
        if (!options->force && !ffp_rig_suspect(subject->capture, err)) return false;
        const double begin = ffp_seconds();
        subject->gaussians = ffp_reconstruction_run(subject->capture, &how, &subject->stats, err);
        subject->reconstruct_s = ffp_seconds() - begin;
    }
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, options->model);
    subject->pass = ffp_view_pass_new(&settings);
    return subject->gaussians != NULL;
}

static void prepare_lookup(FfpSubject *subject) {
    const bool match = subject->shared->options->predictor == FFP_PREDICT_MATCH;
    const FfpMatchSettings settings = ffp_match_defaults();
    subject->normalised = ffp_normalised_alias(subject->capture);
    subject->depth = ffp_alloc(subject->capture->n_views, sizeof *subject->depth);
    const double begin = ffp_seconds();
    for (int v = 0; v < subject->capture->n_views; v++) {
        const FfpView *view = &subject->normalised.views[v];
        const size_t pixels = (size_t)view->camera.width * view->camera.height;
        subject->depth[v] = ffp_alloc(pixels, sizeof(real));
        if (match)
            ffp_match_depth(&subject->normalised, v, subject->given + FFP_FIRST_GIVEN,
                            subject->n_given - FFP_FIRST_GIVEN, &settings, subject->depth[v]);
        else
            memcpy(subject->depth[v], view->depth.data, pixels * sizeof(real));
    }
    subject->reconstruct_s = match ? ffp_seconds() - begin : NAN;
}

// --- What only the report shows. ---

static void report_maps(FfpSubject *subject) {
    if (!ffp_subject_draws(subject)) return;
    ffp_report_heading(
        subject->shared->report, "G-buffers",
        "What the Gaussians hold, seen from an input view: nothing here depends on a pattern.");
    const int n = subject->capture->n_views, shown = n < REPORT_MAPS ? n : REPORT_MAPS;
    for (int i = 0; i < shown; i++) {
        const FfpView *view = &subject->capture->views[i * n / shown];
        ffp_subject_draw(subject, &view->camera, &view->projector);
        ffp_report_maps(subject->shared->report, view->id, ffp_subject_gbuffer(subject));
    }
}

static void report_relit_views(FfpSubject *subject, const FfpCapture *views, const FfpSummed *summed) {
    for (int v = 0; v < views->n_views && v < 8; v++) {
        const FfpView *view = &views->views[v];
        ffp_subject_draw(subject, &view->camera, &view->projector);
        FfpImage picture = ffp_subject_relight(subject, summed);
        ffp_report_picture(subject->shared->report, &picture, view->id);
        ffp_image_free(&picture);
    }
}

// Some input views, drawn finer than they were photographed.
static void report_large_views(FfpSubject *subject, const FfpPattern *pattern, const FfpSummed *summed) {
    const int n = subject->capture->n_views, shown = n < REPORT_LARGE ? n : REPORT_LARGE;
    for (int i = 0; i < shown; i++) {
        const FfpView *view = &subject->capture->views[i * n / shown];
        FfpCamera camera = view->camera;
        char caption[2 * FFP_NAME_MAX + 32];
        const real scale = fmin(fmax((real)LARGE_WIDTH / (real)camera.width, (real)1), (real)LARGE_SCALE_MAX);
        camera.width = (int)((real)camera.width * scale);
        camera.height = (int)((real)camera.height * scale);
        camera.fx *= scale;
        camera.fy *= scale;
        camera.cx *= scale;
        camera.cy *= scale;
        ffp_subject_draw(subject, &camera, &view->projector);
        FfpImage picture = ffp_subject_relight(subject, summed);
        snprintf(caption, sizeof caption, "Predicted: %s under %s", view->id, pattern->name);
        ffp_report_large(subject->shared->report, &picture, caption);
        ffp_image_free(&picture);
    }
}

static void report_shown_pattern(FfpSubject *subject, const FfpPattern *pattern, const FfpSummed *summed) {
    ffp_report_heading(
        subject->shared->report, "Relit by a pattern that nobody photographed",
        "Without truth for comparison. First the pattern, then every input view, then new poses.");
    FfpImage encoded = ffp_image_copy(&pattern->image);
    ffp_image_to_srgb(&encoded);
    ffp_report_picture(subject->shared->report, &encoded, pattern->name);
    ffp_image_free(&encoded);
    report_relit_views(subject, subject->capture, summed);
    if (subject->has_targets) report_relit_views(subject, &subject->targets, summed);
}

// The beginning of the page: large pictures under the pattern that is to be shown, otherwise under the one
// that the reconstruction was made from.
static bool report_pictures(FfpSubject *subject, FfpError *err) {
    const char *path = subject->shared->options->show_pattern;
    const FfpCamera *projector = &subject->capture->views[0].projector;
    FfpPattern pattern = subject->capture->patterns[subject->given[FFP_FIRST_GIVEN]];
    ffp_report_title(subject->shared->report, subject->capture->name);
    if (!ffp_subject_draws(subject)) return true;
    if (path && !ffp_pattern_read(&pattern, path, projector, FFP_FRAMING_COVER, err)) return false;
    FfpSummed summed = ffp_summed_new(&pattern.image);
    report_large_views(subject, &pattern, &summed);
    if (path) report_shown_pattern(subject, &pattern, &summed);
    ffp_summed_free(&summed);
    if (path) ffp_image_free(&pattern.image);
    return true;
}

static void report_making(FfpSubject *subject) {
    FfpReport *report = subject->shared->report;
    report_maps(subject);
    ffp_report_input(report, subject->capture, subject->given, subject->n_given);
    if (subject->gaussians && isfinite(subject->reconstruct_s)) ffp_report_stats(report, &subject->stats);
}

// --- One capture. ---

static bool open_save_folder(FfpSubject *subject, FfpError *err) {
    const char *save = subject->shared->options->save;
    if (!save) return true;
    if (!ffp_join_path(subject->folder, save, subject->capture->name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, save, "path is too long");
    return ffp_make_folders(subject->folder, err);
}

static bool run_subject(FfpSubject *subject, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    FfpReport *report = subject->shared->report;
    const bool lookup = options->predictor != FFP_PREDICT_GAUSSIANS;
    if (lookup)
        prepare_lookup(subject);
    else if (!prepare_gaussians(subject, err))
        return false;
    const bool ok =
        (!report || report_pictures(subject, err)) && open_save_folder(subject, err) &&
        ffp_run_protocol(subject, "novel_pattern",
                         "Input poses under other patterns. Each: prediction, truth, error times 4.", err) &&
        (!subject->has_targets || lookup ||
         ffp_run_protocol(subject, "novel_pose",
                          "New camera and projector poses. Each: prediction, truth, error times 4.", err)) &&
        ffp_run_protocol(
            subject, "rendering",
            "Input poses under black, white and lollipops. Each: prediction, truth, error times 4.", err);
    if (ok && report) report_making(subject);
    return ok;
}

static void free_subject(FfpSubject *subject) {
    for (int v = 0; subject->depth && v < subject->capture->n_views; v++) ffp_free(subject->depth[v]);
    ffp_free(subject->depth);
    if (subject->normalised.views) ffp_normalised_alias_free(&subject->normalised);
    ffp_subject_free_drawing(subject);
    if (subject->has_targets) ffp_capture_free(&subject->targets);
    if (subject->capture) ffp_capture_free(subject->capture);
    ffp_free(subject->capture);
}

// A relative path is looked up in the capture's own folder first, so that one serves many captures.
static bool open_targets(FfpSubject *subject, int index, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    if (!options->n_targets) return true;
    const char *path = options->targets[options->n_targets == 1 ? 0 : index];
    char beside[FFP_PATH_MAX];
    if (path[0] != '/' && ffp_join_path(beside, subject->capture->folder, path) && ffp_is_file(beside))
        path = beside;
    if (!ffp_capture_read_targets(&subject->targets, path, subject->capture, err)) return false;
    subject->has_targets = true;
    if (strcmp(subject->targets.name, subject->capture->name) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "these poses belong to %s, not to %s",
                        subject->targets.name, subject->capture->name);
    return true;
}

static bool check_depth(const FfpCapture *capture, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++)
        if (!capture->views[v].depth.data)
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(capture->folder, "depth").text,
                            "view %s has no true depth to look the pattern up at", capture->views[v].id);
    return true;
}

// Black, white and the patterns that the predictor was given: those named, of Gaussians that exist
// already those that their file names, otherwise the default.
static bool find_given(FfpSubject *subject, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    const char *const *names = options->patterns;
    const char *known[FFP_PATTERNS_MAX];
    char made_from[FFP_MADE_FROM] = "";
    int n = options->n_patterns;
    const bool by_file = options->gaussians && n == 0;
    if (by_file && !ffp_gaussians_read_made_from(made_from, options->gaussians, err)) return false;
    for (char *at = made_from; *at && n < FFP_PATTERNS_MAX;) {
        char *end = strchr(at, '\n');
        *end = 0;
        const int found = ffp_capture_find_pattern(subject->capture, at);
        if (found >= 0 && found != subject->capture->black && found != subject->capture->white)
            known[n++] = at;
        at = end + 1;
    }
    if (by_file && n > 0) names = known;
    if (by_file && n == 0)
        ffp_note("%s does not say from which pattern of this capture it was made: assuming the default",
                 options->gaussians);
    subject->n_given = ffp_capture_photographs(subject->capture, names, n, subject->given, err);
    return subject->n_given >= 0;
}

// Everything about a capture that can be wrong shows here, before anything is written.
static bool open_subject(FfpSubject *subject, int index, FfpError *err) {
    const FfpEvaluation *options = subject->shared->options;
    subject->capture = ffp_capture_load(options->captures[index], err);
    if (!subject->capture) return false;
    if (!find_given(subject, err) || !open_targets(subject, index, err)) return false;
    if (options->predictor == FFP_PREDICT_DEPTH) return check_depth(subject->capture, err);
    return true;
}

static bool evaluate_capture(FfpEvaluating *shared, int index, FfpError *err) {
    FfpSubject subject = {.shared = shared};
    const bool ok = open_subject(&subject, index, err) && run_subject(&subject, err);
    free_subject(&subject);
    return ok;
}

// --- All of them. ---

FfpPerceptual *ffp_lpips_read(const char *path, FfpError *err) {
    FfpPerceptual *net = ffp_perceptual_read(path, err);
    if (!net || ffp_perceptual_is_lpips(net)) return net;
    ffp_perceptual_free(net);
    ffp_fail(err, FFP_ERROR_FILE, path, "holds no LPIPS weights");
    return NULL;
}

static bool open_perceptual(FfpEvaluating *shared, FfpError *err) {
    const char *path = shared->options->perceptual, *folder = getenv("FFPROCAMS_PERCEPTUAL");
    char found[FFP_PATH_MAX];
    if (!path && folder && *folder) {
        if (!ffp_join_path(found, folder, "lpips_alex.safetensors"))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "path is too long");
        path = found;
    }
    if (!path) {
        ffp_note(
            "LPIPS is not computed: no weights file given, and FFPROCAMS_PERCEPTUAL does not name a folder");
        return true;
    }
    shared->lpips = ffp_lpips_read(path, err);
    return shared->lpips != NULL;
}

// A name among those of the captures before it, and fit for a folder.
static bool check_name(const char *name, char (*names)[FFP_NAME_MAX], int count, const char *save,
                       FfpError *err) {
    if (!*name || *name == '.' || strchr(name, '/'))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, save, "%s is not a valid folder name", name);
    for (int i = 0; i < count; i++)
        if (strcmp(names[i], name) == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, save,
                            "two captures are called %s: their pictures would share a folder", name);
    snprintf(names[count], FFP_NAME_MAX, "%s", name);
    return true;
}

// With --save pictures are written capture by capture: the last one's faults must show before the first one's
// pictures exist.
static bool check_captures(FfpEvaluating *shared, FfpError *err) {
    const FfpEvaluation *options = shared->options;
    if (!options->save) return true;
    char(*names)[FFP_NAME_MAX] = ffp_alloc((size_t)options->n_captures, sizeof *names);
    bool ok = true;
    for (int i = 0; ok && i < options->n_captures; i++) {
        FfpSubject subject = {.shared = shared};
        ok =
            open_subject(&subject, i, err) && check_name(subject.capture->name, names, i, options->save, err);
        free_subject(&subject);
    }
    ffp_free(names);
    return ok;
}

static bool check_shown_pattern(const char *path, FfpError *err) {
    FfpImage image = {0};
    const bool ok =
        !path || (ffp_framed_check(path, 1, 1, err) && ffp_image_read_over_black(&image, NULL, path, err));
    ffp_image_free(&image);
    return ok;
}

static bool check_options(const FfpEvaluation *options, FfpError *err) {
    if (options->n_captures < 1) return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "no capture to evaluate");
    if (options->n_targets > 1 && options->n_targets != options->n_captures)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "%d target files for %d captures: give one for all, or one for each",
                        options->n_targets, options->n_captures);
    if (options->n_targets && options->predictor != FFP_PREDICT_GAUSSIANS)
        ffp_note("this predictor sees only the input poses: novel_pose is left out");
    if (options->json && options->model_name && !ffp_is_utf8(options->model_name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "model_name",
                        "'%.200s' is not UTF-8, the encoding of %s: choose another name", options->model_name,
                        options->json);
    return ffp_output_prepare(options->json, err) && ffp_output_prepare(options->report, err) &&
           check_shown_pattern(options->show_pattern, err);
}

// A row a protocol, called "mean", behind those of the captures.
static void append_means(FfpEvaluating *shared) {
    const int rows = shared->n_scores;
    for (int i = 0; i < FFP_PROTOCOLS; i++) {
        FfpScore *mean = &shared->scores[shared->n_scores];
        if (!ffp_scores_mean(mean, shared->scores, rows, ffp_protocols[i])) continue;
        snprintf(mean->capture, sizeof mean->capture, "mean");
        shared->n_scores++;
    }
}

// --- Shared by ranks, or by runs one after the other. ---

static const FfpRanks *ranks_at_work(void) {
    const FfpContext *context = ffp_call_context();
    const FfpRanks *ranks = context ? context->settings.ranks : NULL;
    return ranks && ranks->count > 1 ? ranks : NULL;
}

static int protocol_number(const char *name) {
    int i = 0;
    while (i < FFP_PROTOCOLS - 1 && strcmp(name, ffp_protocols[i]) != 0) i++;
    return i;
}

// The rows of capture `index`, from the rank that has them (`own`, `count` of them) to all.
static bool exchange(FfpEvaluating *shared, const FfpRanks *ranks, int index, const FfpScore *own, int count,
                     FfpError *err) {
    struct {
        FfpScore score;
        int protocol;
    } rows[FFP_PROTOCOLS] = {0};
    const int from = index % ranks->count;
    for (int i = 0; from == ranks->rank && i < count; i++) {
        rows[i].score = own[i];
        rows[i].protocol = protocol_number(own[i].protocol);
    }
    if (!ranks->broadcast(ranks->user, &count, sizeof count, from, err) ||
        !ranks->broadcast(ranks->user, rows, sizeof rows, from, err))
        return false;
    for (int i = 0; i < count; i++) {
        FfpScore *score = &shared->scores[shared->n_scores++];
        *score = rows[i].score;
        score->protocol = ffp_protocols[rows[i].protocol];
    }
    return true;
}

// Each rank's captures, then all rows to all ranks, in the captures' order.
static bool evaluate_together(FfpEvaluating *shared, const FfpRanks *ranks, FfpError *err) {
    const int n = shared->options->n_captures;
    FfpEvaluating own = *shared;
    own.scores = ffp_alloc(FFP_PROTOCOLS * ((size_t)n + 1), sizeof *own.scores);
    int *first = ffp_alloc((size_t)n + 1, sizeof *first);
    bool ok = true;
    for (int i = 0; i < n; i++) {
        first[i] = own.n_scores;
        if (ok && i % ranks->count == ranks->rank) ok = evaluate_capture(&own, i, err);
    }
    first[n] = own.n_scores;
    double failed = !ok;
    const bool mine = failed > 0;
    ok = ranks->sum(ranks->user, &failed, 1, mine ? NULL : err);
    if (ok && failed > 0 && !mine) ffp_fail(err, FFP_ERROR_IO, NULL, "another rank's captures failed");
    ok = ok && failed == 0;
    for (int i = 0; ok && i < n; i++)
        ok = exchange(shared, ranks, i, own.scores + first[i], first[i + 1] - first[i], err);
    ffp_free(first);
    ffp_free(own.scores);
    return ok;
}

static bool evaluate_all(FfpEvaluating *shared, FfpError *err) {
    const FfpEvaluation *options = shared->options;
    const FfpRanks *ranks = ranks_at_work();
    shared->scores = ffp_alloc(FFP_PROTOCOLS * ((size_t)options->n_captures + 1), sizeof *shared->scores);
    if (ranks) return evaluate_together(shared, ranks, err);
    for (int i = 0; i < options->n_captures; i++)
        if (!evaluate_capture(shared, i, err)) return false;
    return true;
}

// The rows of earlier evaluations of one predictor, whose name goes into *name.
static bool merge(FfpEvaluating *shared, char **name, FfpError *err) {
    const FfpEvaluation *options = shared->options;
    for (int i = 0; i < options->n_merged; i++) {
        char *other = NULL;
        if (!ffp_scores_read(&shared->scores, &shared->n_scores, i ? &other : name, options->merged[i], err))
            return false;
        const bool same = !i || strcmp(*name, other) == 0;
        if (!same)
            ffp_fail(err, FFP_ERROR_FILE, ffp_place(options->merged[i], "predictor").text,
                     "is %s, but that of the files before it is %s", other, *name);
        ffp_free(other);
        if (!same) return false;
    }
    shared->scores =
        ffp_grow(shared->scores, (size_t)shared->n_scores + FFP_PROTOCOLS, sizeof *shared->scores);
    return true;
}

static bool check_merging(const FfpEvaluation *options, FfpError *err) {
    if (options->n_captures > 0 || options->report || options->save)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "merging rows cannot be combined with captures, a report or saved pictures");
    return ffp_output_prepare(options->json, err);
}

static bool merge_and_write(FfpEvaluating *shared, FfpError *err) {
    char *name = NULL;
    bool ok = check_merging(shared->options, err) && merge(shared, &name, err);
    FfpEvaluation named = *shared->options;
    named.model_name = name;
    if (ok && named.json) ok = ffp_scores_write(shared->scores, shared->n_scores, &named, err);
    ffp_free(name);
    return ok;
}

static bool evaluate_and_write(FfpEvaluating *shared, FfpError *err) {
    const FfpEvaluation *options = shared->options;
    const FfpRanks *ranks = ranks_at_work();
    if (!check_options(options, err)) return false;
    if (ranks && options->report)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "report", "requires a single process, but there are %d",
                        ranks->count);
    if (options->report) shared->report = ffp_report_new(options->model_name);
    bool ok = open_perceptual(shared, err) && check_captures(shared, err) && evaluate_all(shared, err);
    const bool writes = !ranks || ranks->rank == 0;
    if (ok && writes && options->json) ok = ffp_scores_write(shared->scores, shared->n_scores, options, err);
    if (ok && options->report)
        ok = ffp_report_write(shared->report, shared->scores, shared->n_scores, options->viewer,
                              options->report, err);
    ffp_report_free(shared->report);
    ffp_perceptual_free(shared->lpips);
    return ok;
}

// The evaluated predictor's name in JSON and report.
static const char *predictor_name(const FfpEvaluation *options) {
    if (options->model_name) return options->model_name;
    if (options->predictor == FFP_PREDICT_DEPTH) return "pattern lookup at the true depth";
    if (options->predictor == FFP_PREDICT_MATCH) return "pattern lookup at the matched depth";
    if (options->field) return options->field;
    if (options->gaussians) return options->gaussians;
    if (!options->model) return "the classical initialisation, without weights";
    return options->model->file ? options->model->file : "the shipped weights";
}

FfpScore *ffp_evaluation_run(const FfpEvaluation *settings, int *n_scores, FfpError *err) {
    FfpEvaluation named = *settings;
    named.model_name = predictor_name(settings);
    const FfpEvaluation *options = &named;
    FfpEvaluating shared = {.options = options};
    *n_scores = 0;
    const bool ok = options->n_merged > 0 ? merge_and_write(&shared, err) : evaluate_and_write(&shared, err);
    if (!ok) {
        ffp_free(shared.scores);
        return NULL;
    }
    if (options->n_merged > 1 || options->n_captures > 1) append_means(&shared);
    *n_scores = shared.n_scores;
    return shared.scores;
}
