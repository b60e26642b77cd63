// Training: the public options as the trainer's.
#include "lab/train/train.h"
#include "core/base/call.h"
#include "ffprocams.h"
#include "product/api/arguments.h"

FfpTraining ffp_training_defaults(void) {
    return (FfpTraining){.steps = -1};
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
    if (!ffp_need(options, "options", err) || !ffp_need(options->out, "out", err)) return false;
    return ffp_call_run(context, train, &options, err);
}
