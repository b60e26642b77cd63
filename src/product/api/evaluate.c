// The protocols of evaluation on captures, or rows of earlier ones.
#include "lab/eval/evaluate.h"
#include "core/base/call.h"
#include "product/api/arguments.h"

FfpEvaluation ffp_evaluation_defaults(void) {
    return (FfpEvaluation){
        .polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO};
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
    Call call = {options, n_scores, NULL};
    if (n_scores) *n_scores = 0;
    if (!ffp_need(options, "options", err) || !ffp_need(n_scores, "n_scores", err) ||
        !ffp_need_texts(options->captures, options->n_captures, "captures", err) ||
        !ffp_need_texts(options->targets, options->n_targets, "targets", err) ||
        !ffp_need_texts(options->merged, options->n_merged, "merged", err) ||
        !ffp_check_drawing(options->drawing, err))
        return NULL;
    return ffp_call_run(context, work, &call, err) ? call.scores : NULL;
}
