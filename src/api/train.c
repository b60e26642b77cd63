// Training: the public options as the trainer's.
#include "api/arguments.h"
#include "ffprocams.h"
#include "api/weights.h"
#include "base/call.h"
#include "train/train.h"

FfpTraining ffp_training_defaults(void) {
    return (FfpTraining){.steps = -1};
}

static bool train(void *argument, FfpError *err) {
    const FfpTraining *options = *(const FfpTraining *const *)argument;
    char shipped[FFP_PATH_MAX];
    FfpTrainRun run = {.out = options->out,
                       .config = options->config,
                       .initial = options->initial,
                       .captures = options->captures,
                       .perceptual = options->perceptual,
                       .steps = options->steps,
                       .stop_at = options->stop_at,
                       .resume = options->resume};
    if (run.captures && run.resume)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "captures",
                        "a resumed run has those of its checkpoint: it takes no others");
    if (run.captures && !run.initial) {
        if (!ffp_find_weights(shipped, err)) return false;
        run.initial = shipped;
    }
    return ffp_train_run(&run, err);
}

bool ffp_train_model(FfpContext *context, const FfpTraining *options, FfpError *err) {
    if (!ffp_need(options, "options", err) || !ffp_need(options->out, "out", err)) return false;
    return ffp_call_run(context, train, &options, err);
}
