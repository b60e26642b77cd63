// Training: the public options as the trainer's.
#include "lab/train/train.h"
#include "core/base/call.h"
#include "ffprocams.h"
#include "product/api/arguments.h"

void ffp_training_defaults_into(FfpTraining *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpTraining){.steps = -1}, sizeof(FfpTraining));
}

static bool train(void *argument, FfpError *err) {
    const FfpTraining *options = *(const FfpTraining *const *)argument;
    const FfpTrainRun run = {.out = options->out,
                             .config = options->config,
                             .initial = options->initial,
                             .captures = options->captures,
                             .perceptual = options->perceptual,
                             .steps = options->steps,
                             .stop_at = options->stop_at,
                             .resume = options->resume};
    return ffp_train_run(&run, err);
}

bool ffp_train_model(FfpContext *context, const FfpTraining *options, FfpError *err) {
    FfpTraining own = ffp_training_defaults();
    if (!ffp_take_options(&own, options, "FfpTraining", err) || !ffp_need(own.out, "out", err)) return false;
    options = &own;
    return ffp_call_run(context, train, &options, err);
}
