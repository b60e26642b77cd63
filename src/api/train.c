// Training: the public options as the trainer's.
#include "ffprocams.h"
#include "base/call.h"
#include "train/train.h"

FfpTraining ffp_training_defaults(void) {
    return (FfpTraining){.steps = -1};
}

static bool train(void *argument, FfpError *err) {
    const FfpTraining *options = *(const FfpTraining *const *)argument;
    const FfpTrainRun run = {.out = options->out,
                             .config = options->config,
                             .initial = options->initial,
                             .perceptual = options->perceptual,
                             .steps = options->steps,
                             .stop_at = options->stop_at,
                             .resume = options->resume};
    if (!run.out) return ffp_fail(err, FFP_ERROR_ARGUMENT, "out", "no folder to write to is given");
    return ffp_train_run(&run, err);
}

bool ffp_train_model(FfpContext *context, const FfpTraining *options, FfpError *err) {
    return ffp_call_run(context, train, &options, err);
}
