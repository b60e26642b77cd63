// A protocol on one capture: which pictures it asks for, their predictions, and what these score.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "engine/loss/metrics.h"
#include "engine/match/match.h"
#include "lab/eval/scores.h"
#include "lab/eval/subject.h"

#define PATTERN_BLOCK 16   // patterns whose summed areas are held at once (15 MB each at 800 x 800)
#define REPORT_PICTURES 12 // predictions shown for each protocol

typedef struct Protocol {
    const char *name;
    const FfpCapture *views; // the capture itself, or its targets
    bool *wanted;            // [views->n_patterns]
    int total;               // pictures there are
} Protocol;

typedef struct Figures { // of a picture; NAN: none
    double psnr, foreground, gloss, ssim, lpips;
} Figures;

typedef struct Means { // sums, until they are divided by their numbers
    Figures sum;
    int images, images_foreground, images_gloss;
} Means;

// The pictures of a protocol, and of "rendering" those apart that the predictor was not given, and was.
enum { ALL, UNSEEN, GIVEN, SETS };

// --- Which pictures a protocol asks for. ---

static bool is_rendering(const char *protocol) {
    return strcmp(protocol, "rendering") == 0;
}

// Black, white, lollipops, and whatever else the capture does not hold back.
static bool is_input(const FfpSubject *subject, const FfpCapture *views, int pattern) {
    return ffp_subject_given(subject, pattern) || !views->patterns[pattern].novel;
}

static Protocol protocol_new(const char *name, const FfpSubject *subject) {
    Protocol protocol = {name, subject->capture, NULL, 0};
    const bool poses = strcmp(name, "novel_pose") == 0, rendering = is_rendering(name);
    if (poses) protocol.views = &subject->targets;
    const FfpCapture *views = protocol.views;
    protocol.wanted = ffp_alloc(views->n_patterns, sizeof *protocol.wanted);
    for (int p = 0; p < views->n_patterns; p++) {
        const bool input = is_input(subject, views, p);
        const bool code = p >= ffp_patterns_shown(views) && !ffp_subject_given(subject, p);
        protocol.wanted[p] = !code && (poses || input == rendering);
        for (int v = 0; protocol.wanted[p] && v < views->n_views; v++)
            protocol.total += views->views[v].images[p].data != NULL;
    }
    return protocol;
}

static FfpImage predict(FfpSubject *subject, int view, int pattern, const FfpSummed *summed) {
    if (ffp_subject_draws(subject)) return ffp_subject_relight(subject, summed);
    FfpImage picture = ffp_predict_by_lookup(&subject->normalised, view, pattern, subject->depth[view]);
    ffp_quantise(&picture);
    return picture;
}

// --- Scoring one picture. ---

static FfpImage foreground_mask(const FfpView *view) {
    FfpImage mask = ffp_image_copy(&view->coverage);
    for (int i = 0; i < mask.width * mask.height; i++) mask.data[i] = mask.data[i] > 0;
    return mask;
}

static double gloss(const FfpSubject *subject, const FfpView *view, const FfpImage *truth,
                    const FfpImage *prediction) {
    FfpImage mask = ffp_gloss_mask(view, subject->capture->intensity);
    const double psnr = ffp_psnr_masked(prediction, truth, &mask);
    ffp_image_free(&mask);
    return psnr;
}

static Figures measure(const FfpSubject *subject, const FfpView *view, bool white, const FfpImage *truth,
                       const FfpImage *prediction) {
    FfpImage mask = foreground_mask(view);
    const FfpPerceptual *lpips = subject->shared->lpips;
    const Figures figures = {.psnr = ffp_psnr(prediction, truth),
                             .foreground = ffp_psnr_masked(prediction, truth, &mask),
                             .gloss = white ? gloss(subject, view, truth, prediction) : NAN,
                             .ssim = ffp_ssim(prediction, truth),
                             .lpips = lpips ? ffp_perceptual_loss(lpips, prediction, truth, 1, NULL) : NAN};
    ffp_image_free(&mask);
    return figures;
}

static void add_figures(Means *means, const Figures *of) {
    means->images++;
    means->sum.psnr += of->psnr;
    means->sum.ssim += of->ssim;
    means->sum.lpips += of->lpips;
    if (isfinite(of->foreground)) means->sum.foreground += of->foreground, means->images_foreground++;
    if (isfinite(of->gloss)) means->sum.gloss += of->gloss, means->images_gloss++;
}

static bool save_prediction(const FfpSubject *subject, const FfpView *view, const char *pattern,
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

static bool handle_picture(FfpSubject *subject, const Protocol *protocol, int v, int p,
                           const FfpImage *prediction, Means *means, FfpError *err) {
    const FfpView *view = &protocol->views->views[v];
    const char *name = protocol->views->patterns[p].name;
    FfpImage truth = ffp_image_copy(&view->images[p]);
    ffp_image_to_srgb(&truth);
    const int index = means[ALL].images;
    const Figures figures = measure(subject, view, p == protocol->views->white, &truth, prediction);
    add_figures(&means[ALL], &figures);
    if (is_rendering(protocol->name))
        add_figures(&means[ffp_subject_given(subject, p) ? GIVEN : UNSEEN], &figures);
    if (subject->shared->report && shown_in_report(protocol, index))
        ffp_report_prediction(subject->shared->report, view->id, name, &truth, prediction, figures.psnr);
    ffp_image_free(&truth);
    return !subject->shared->options->save || save_prediction(subject, view, name, prediction, err);
}

// --- One protocol. ---

static bool run_view(FfpSubject *subject, const Protocol *protocol, int v, int first, const FfpSummed *sums,
                     Means *means, double *seconds, FfpError *err) {
    const FfpView *view = &protocol->views->views[v];
    double begin = ffp_seconds();
    if (ffp_subject_draws(subject)) ffp_subject_draw(subject, &view->camera, &view->projector);
    *seconds += ffp_seconds() - begin;
    bool ok = true;
    for (int p = first; ok && p < first + PATTERN_BLOCK && p < protocol->views->n_patterns; p++) {
        if (!protocol->wanted[p] || !view->images[p].data) continue;
        ffp_cancel_point();
        begin = ffp_seconds();
        FfpImage prediction = predict(subject, v, p, &sums[p - first]);
        *seconds += ffp_seconds() - begin;
        ok = handle_picture(subject, protocol, v, p, &prediction, means, err);
        ffp_image_free(&prediction);
    }
    return ok;
}

// A row of its own for the pictures of a set, if there are any.
static FfpScore *add_score(FfpSubject *subject, const char *protocol, const Means *means, double seconds) {
    if (!means->images) return NULL;
    FfpScore *score = &subject->shared->scores[subject->shared->n_scores++];
    const Figures *sum = &means->sum;
    *score = (FfpScore){.protocol = protocol, .images = means->images};
    snprintf(score->capture, sizeof score->capture, "%s", subject->capture->name);
    score->psnr = sum->psnr / means->images;
    score->psnr_foreground = means->images_foreground ? sum->foreground / means->images_foreground : NAN;
    score->psnr_gloss = means->images_gloss ? sum->gloss / means->images_gloss : NAN;
    score->ssim = sum->ssim / means->images;
    score->lpips = sum->lpips / means->images;
    score->psnr_unseen_lollipops = NAN;
    score->reconstruct_s = subject->reconstruct_s;
    score->render_s = seconds;
    score->depth_lit_median = score->depth_lit_p90 = score->depth_unlit_median = score->depth_unlit_p90 = NAN;
    score->albedo_mse = score->albedo_lit_mse = score->albedo_unlit_mse = NAN;
    return score;
}

// Of "rendering" first what the predictor did not know, last what it was given. The time for drawing is
// shared out by the number of pictures.
static void add_scores(FfpSubject *subject, const char *protocol, const Means means[SETS], double seconds) {
    const double each = seconds / means[ALL].images;
    const Means *unseen = &means[UNSEEN], *given = &means[GIVEN];
    add_score(subject, FFP_UNSEEN, unseen, each * unseen->images);
    FfpScore *all = add_score(subject, protocol, &means[ALL], seconds);
    all->images_unseen = unseen->images;
    if (unseen->images) all->psnr_unseen_lollipops = unseen->sum.psnr / unseen->images;
    if (ffp_subject_draws(subject) && is_rendering(protocol)) ffp_measure_truth(subject, all);
    add_score(subject, FFP_GIVEN, given, each * given->images);
}

bool ffp_run_protocol(FfpSubject *subject, const char *name, const char *explanation, FfpError *err) {
    Protocol protocol = protocol_new(name, subject);
    const FfpCapture *views = protocol.views;
    Means means[SETS] = {0};
    double seconds = 0;
    bool ok = true;
    if (protocol.total && subject->shared->report)
        ffp_report_heading(subject->shared->report, name, explanation);
    for (int first = 0; ok && protocol.total && first < views->n_patterns; first += PATTERN_BLOCK) {
        FfpSummed sums[PATTERN_BLOCK] = {0};
        for (int p = first; p < first + PATTERN_BLOCK && p < views->n_patterns; p++)
            if (ffp_subject_draws(subject) && protocol.wanted[p])
                sums[p - first] = ffp_summed_new(&views->patterns[p].image);
        for (int v = 0; ok && v < views->n_views; v++)
            ok = run_view(subject, &protocol, v, first, sums, means, &seconds, err);
        for (int p = 0; p < PATTERN_BLOCK; p++) ffp_summed_free(&sums[p]);
    }
    if (ok && means[ALL].images) add_scores(subject, protocol.name, means, seconds);
    ffp_free(protocol.wanted);
    return ok;
}
