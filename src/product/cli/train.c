#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *device;
    FfpTraining training;
} Arguments;

static int run(void *data) {
    const Arguments *arguments = data;
    const FfpTraining *training = &arguments->training;
    FfpError err = {0};
    if (training->resume && training->captures)
        return ffp_cli_usage("train", "--resume takes the captures from the checkpoint");
    if (training->resume && (training->initial || training->config))
        return ffp_cli_usage("train", "--resume takes configuration and weights from the checkpoint");
    if (!ffp_cli_use_device(arguments->device, &err) || !ffp_cli_use_ranks(&err) ||
        !ffp_train_model(ffp_cli_context(), training, &err))
        return ffp_cli_fail(&err);
    ffp_cli_clear_interrupt(); // a run that was stopped has written its checkpoint
    return FFP_EXIT_OK;
}

static void set_defaults(void *data) {
    ((Arguments *)data)->training = ffp_training_defaults();
}

static const FfpOption options[] = {
    {.name = "out",
     .letter = 'o',
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .required = true,
     .offset = offsetof(Arguments, training.out),
     .help = "folder of the run; created if it does not exist"},
    {.name = "config",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.config),
     .help = "JSON with the fields that differ from the defaults (docs/reference/training.md)"},
    {.name = "steps",
     .letter = 'n',
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, training.steps),
     .high = 1000000000,
     .help = "length of the run and of its schedule, instead of the configuration's"},
    {.name = "stop-at",
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, training.stop_at),
     .low = 1,
     .high = 1000000000,
     .help = "stop at step N with a checkpoint, to be continued with --resume"},
    {.name = "resume",
     .letter = 'r',
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, training.resume),
     .help = "continue from DIR/checkpoint.safetensors, which also holds the configuration"},
    {.name = "initial",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.initial),
     .help = "start from these weights, with a fresh optimiser"},
    {.name = "captures",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, training.captures),
     .help = "fine-tune weights to your own devices: learn from the photographs of the captures in FOLDER "
             "(as written by `import`, at least two), starting from --initial or the shipped weights. Every "
             "fourth capture is held out and decides when to stop: weights.safetensors are those that "
             "predict its photographs best, the initial ones included"},
    {.name = "perceptual",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.perceptual),
     .help = "network for the perceptual loss (safetensors); without it that term is off"},
    FFP_CLI_DEVICE(offsetof(Arguments, device),
                   "where training steps run: cpu, or cuda, the first NVIDIA GPU (scenes are generated on "
                   "the CPU either way). Default: cpu"),
    {0},
};

const FfpCommand ffp_cli_train = {
    .name = "train",
    .group = FFP_CLI_TRAIN,
    .purpose = "trains weights on scenes generated on the fly",
    .prose =
        "Or on scenes read from a folder made by `generate` (`scenes` of the configuration). DIR receives "
        "checkpoint.safetensors (everything needed to go on bit for bit), weights.safetensors (what "
        "`--model` takes) and metrics.jsonl. Ctrl-C writes a checkpoint first. "
        "`mpirun -n N ffprocams train ...` shares the scenes of every step (`batch`) among N processes "
        "(docs/lab/cluster.md).",
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams train --out run --steps 20000\n"
                                         "ffprocams train --out run --resume\n"
                                         "mpirun -n 4 ffprocams train --out run --config batch-8.json"},
                             {.about = "For your own camera and projector:",
                              .command =
                                  "ffprocams train --out mine --captures captures\n"
                                  "ffprocams reconstruct captures/vase --model mine/weights.safetensors "
                                  "-o vase.ply"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
