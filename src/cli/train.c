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
        return ffp_cli_usage("train", "--resume takes the captures from the checkpoint alone");
    if (training->resume && (training->initial || training->config))
        return ffp_cli_usage("train", "--resume takes configuration and weights from the checkpoint alone");
    if (!ffp_cli_use_device(arguments->device, &err) || !ffp_cli_use_ranks(&err) ||
        !ffp_train_model(ffp_cli_context(), training, &err))
        return ffp_cli_fail(&err);
    ffp_cli_go_on(); // a run that was stopped has written its checkpoint
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
     .help = "folder of the run; made when it is not there"},
    {.name = "config",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.config),
     .help = "JSON with the fields that differ from the defaults (docs/formats.md)"},
    {.name = "steps",
     .letter = 'n',
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, training.steps),
     .high = 1000000000,
     .help = "length of the run (and of its schedule) instead of the configuration's"},
    {.name = "stop-at",
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, training.stop_at),
     .low = 1,
     .high = 1000000000,
     .help = "stop at step N with a checkpoint, to go on later with --resume"},
    {.name = "resume",
     .letter = 'r',
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, training.resume),
     .help = "go on from DIR/checkpoint.safetensors, which holds the configuration too"},
    {.name = "initial",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.initial),
     .help = "start from these weights, with a fresh optimiser"},
    {.name = "captures",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, training.captures),
     .help =
         "fine-tune weights to your own devices: learn from the photographs of the captures in FOLDER (what "
         "`import` writes, two at least), beginning with --initial or the shipped weights. Every fourth "
         "capture is held out: it says when to stop, and weights.safetensors are those that predict its "
         "photographs best, the first included"},
    {.name = "perceptual",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, training.perceptual),
     .help = "network of the perceptual term (safetensors); without it that term is off"},
    FFP_CLI_DEVICE(
        offsetof(Arguments, device),
        "what steps are computed on: cpu, or cuda, the first NVIDIA GPU (scenes are made by the CPU "
        "in both cases). Default: cpu"),
    {0},
};

const FfpCommand ffp_cli_train = {
    .name = "train",
    .group = FFP_CLI_TRAIN,
    .purpose = "trains weights on scenes that are generated as training goes",
    .prose =
        "Or on scenes read from a folder made by `generate` (`scenes` of the configuration). DIR receives "
        "checkpoint.safetensors (everything needed to go on bit for bit), weights.safetensors (what "
        "`--model` takes) and metrics.jsonl. Ctrl-C writes a checkpoint first. "
        "`mpirun -n N ffprocams train ...` shares the scenes of every step (`batch`) among N processes "
        "(docs/cluster.md).",
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams train --out run --steps 20000\n"
                                         "ffprocams train --out run --resume\n"
                                         "mpirun -n 4 ffprocams train --out run --config batch-8.json"},
                             {.about = "For a camera and a projector of one's own:",
                              .command =
                                  "ffprocams train --out mine --captures captures\n"
                                  "ffprocams reconstruct captures/vase --model mine/weights.safetensors "
                                  "-o vase.ply"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
