#include <stdio.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams train --out DIR [--config FILE] [--steps N] [--resume] [--initial FILE]\n"
    "                       [--perceptual FILE] [--stop-at N] [--device cpu|cuda]\n"
    "\n"
    "Trains weights on scenes that are generated as training goes, or read from a folder made by\n"
    "`generate` (`scenes` of the configuration). DIR receives checkpoint.safetensors (everything\n"
    "needed to go on bit for bit), weights.safetensors (what `--model` takes) and metrics.jsonl.\n"
    "Ctrl-C writes a checkpoint first.\n"
    "\n"
    "  -o, --out DIR          folder of the run; made when it is not there\n"
    "  -c, --config FILE      JSON with the fields that differ from the defaults (docs/formats.md)\n"
    "  -n, --steps N          length of the run (and of its schedule) instead of the configuration's\n"
    "      --stop-at N        stop at step N with a checkpoint, to go on later with --resume\n"
    "  -r, --resume           go on from DIR/checkpoint.safetensors, which holds the configuration too\n"
    "      --initial FILE     start from these weights, with a fresh optimiser\n"
    "      --perceptual FILE  network of the perceptual term (safetensors); without it that term is\n"
    "                         off\n"
    "      --device NAME      what steps are computed on: cpu, or cuda, the first NVIDIA GPU (scenes are\n"
    "                         made by the CPU in both cases). Default: cpu\n"
    "\n"
    "example: ffprocams train --out run --steps 20000\n"
    "         ffprocams train --out run --resume\n";

int ffp_cli_train(int argc, char **argv) {
    enum { INITIAL = 256, PERCEPTUAL, STOP_AT, DEVICE };
    static const struct option options[] = {{"out", required_argument, NULL, 'o'},
                                            {"config", required_argument, NULL, 'c'},
                                            {"steps", required_argument, NULL, 'n'},
                                            {"resume", no_argument, NULL, 'r'},
                                            {"initial", required_argument, NULL, INITIAL},
                                            {"perceptual", required_argument, NULL, PERCEPTUAL},
                                            {"stop-at", required_argument, NULL, STOP_AT},
                                            {"device", required_argument, NULL, DEVICE},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    FfpTraining training = {.steps = -1};
    int status;
    for (int option; (option = ffp_cli_next(argc, argv, ":o:c:n:rh", options)) != -1;) {
        switch (option) {
        case 'o':
            training.out = optarg;
            break;
        case 'c':
            training.config = optarg;
            break;
        case 'n':
            if (ffp_cli_number(optarg, 0, 1000000000, &training.steps)) break;
            return ffp_cli_usage(argv[0], "--steps is a number from 0 to 1000000000, not %s", optarg);
        case 'r':
            training.resume = true;
            break;
        case STOP_AT:
            if (ffp_cli_number(optarg, 1, 1000000000, &training.stop_at)) break;
            return ffp_cli_usage(argv[0], "--stop-at is a number from 1 to 1000000000, not %s", optarg);
        case INITIAL:
            training.initial = optarg;
            break;
        case PERCEPTUAL:
            training.perceptual = optarg;
            break;
        case DEVICE:
            if ((status = ffp_cli_device(argv[0], optarg)) == FFP_EXIT_OK) break;
            return status;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (optind != argc) return ffp_cli_usage(argv[0], "%s is one argument too many", argv[optind]);
    if (!training.out) return ffp_cli_usage(argv[0], "--out DIR is missing");
    if (training.resume && (training.initial || training.config))
        return ffp_cli_usage(argv[0], "--resume takes configuration and weights from the checkpoint alone");
    FfpError err = {0};
    return ffp_train_model(&training, &err) ? FFP_EXIT_OK : ffp_cli_fail(&err);
}
