// The protocols of evaluation on captures, or rows of earlier ones; and LPIPS of given pictures.
#include "lab/eval/evaluate.h"
#include <math.h>
#include <stdio.h>
#include "core/base/call.h"
#include "ffprocams/lab.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

void ffp_evaluation_defaults_into(FfpEvaluation *options, size_t size) {
    ffp_give_defaults(
        options, size,
        &(FfpEvaluation){.polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO},
        sizeof(FfpEvaluation));
}

typedef struct Call {
    const FfpEvaluation *options;
    int *n_scores;
    FfpScore *scores;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->scores = ffp_evaluation_run(call->options, call->n_scores, err);
    return call->scores != NULL;
}

FfpScore *ffp_evaluate(FfpContext *context, const FfpEvaluation *options, int *n_scores, FfpError *err) {
    FfpEvaluation own = ffp_evaluation_defaults();
    Call call = {&own, n_scores, NULL};
    if (n_scores) *n_scores = 0;
    if (!ffp_take_options(&own, options, "FfpEvaluation", err) || !ffp_need(n_scores, "n_scores", err) ||
        !ffp_need_texts(own.captures, own.n_captures, "captures", err) ||
        !ffp_need_texts(own.targets, own.n_targets, "targets", err) ||
        !ffp_need_texts(own.merged, own.n_merged, "merged", err) ||
        !ffp_check_reconstruction(&(FfpReconstruction){.patterns = own.patterns,
                                                       .n_patterns = own.n_patterns,
                                                       .polish = own.polish,
                                                       .noise = own.noise,
                                                       .layers = own.layers,
                                                       .drawing = own.drawing},
                                  err))
        return NULL;
    return ffp_call_run(context, work, &call, err) ? call.scores : NULL;
}

// --- LPIPS of given pictures. ---

typedef struct LpipsCall {
    const char *weights;
    const FfpPicture *a, *b;
    int n;
    double *distances;
} LpipsCall;

// sRGB-encoded RGB over black.
static bool take_picture(FfpImage *to, const FfpPicture *from, const char *list, int i, FfpError *err) {
    const FfpRaw raw = ffp_raw_of(from);
    char place[32];
    snprintf(place, sizeof place, "%s[%d]", list, i);
    if (!ffp_need(raw.data, place, err) || !ffp_raw_over_black(to, NULL, &raw, place, err)) return false;
    ffp_image_to_srgb(to);
    return true;
}

static bool compare(const FfpPerceptual *net, const LpipsCall *call, int i, FfpError *err) {
    FfpImage a, b;
    if (!take_picture(&a, &call->a[i], "a", i, err) || !take_picture(&b, &call->b[i], "b", i, err))
        return false;
    char place[32];
    snprintf(place, sizeof place, "b[%d]", i);
    if (a.width != b.width || a.height != b.height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, place, "%d x %d pixels; its counterpart has %d x %d",
                        b.width, b.height, a.width, a.height);
    const int side = ffp_perceptual_least_side(net);
    const bool large = a.width >= side && a.height >= side;
    call->distances[i] = large ? (double)ffp_perceptual_loss(net, &a, &b, 1, NULL) : (double)NAN;
    ffp_image_free(&a);
    ffp_image_free(&b);
    return true;
}

static bool lpips_work(void *argument, FfpError *err) {
    const LpipsCall *call = argument;
    FfpPerceptual *net = ffp_lpips_read(call->weights, err);
    bool ok = net != NULL;
    for (int i = 0; ok && i < call->n; i++) {
        ffp_cancel_point();
        ok = compare(net, call, i, err);
    }
    ffp_perceptual_free(net);
    return ok;
}

bool ffp_lpips(FfpContext *context, const char *weights, const FfpPicture *a, const FfpPicture *b, int n,
               double *distances, FfpError *err) {
    LpipsCall call = {weights, a, b, n, distances};
    if (n < 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, "n", "%d is below 0", n);
    return ffp_need(weights, "weights", err) && (n == 0 || ffp_need(a, "a", err)) &&
           (n == 0 || ffp_need(b, "b", err)) && (n == 0 || ffp_need(distances, "distances", err)) &&
           ffp_call_run(context, lpips_work, &call, err);
}
