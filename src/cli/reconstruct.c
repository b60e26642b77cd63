#include <stdio.h>
#include <string.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams reconstruct CAPTURE -o FILE.ply [--model FILE|none] [--pattern NAME]\n"
    "                             [--polish STEPS] [--noise S] [--layers N] [--samples N]\n"
    "                             [--device cpu|cuda]\n"
    "\n"
    "Turns a capture into relightable 3D Gaussians in one forward pass and a short fit to the same\n"
    "photographs: geometry (centre, scale, rotation, opacity) and material (albedo, roughness, ambient\n"
    "colour), in the capture's own units.\n"
    "\n"
    "  CAPTURE             folder with scene.json or render_poses.json, or such a file: views of one\n"
    "                      object, each under a black, a white and at least one coloured pattern\n"
    "  -o, --output FILE   where the Gaussians go (binary PLY, opens in splat viewers too)\n"
    "  -m, --model FILE    weights (safetensors); `none` for the classical start alone, which needs\n"
    "                      no weights. Default: models/small.safetensors beside the program's folder\n"
    "                      or in the current one\n"
    "  -p, --pattern NAME  the structured-light pattern to use. Default: the first that is in every\n"
    "                      view and not held back\n"
    "      --polish STEPS  steps of the fit, of one view each; of pictures above 192 pixels, steps on the\n"
    "                      smallest of several sizes, with fewer on larger ones. 0: the forward pass\n"
    "                      alone. Default: auto, 100, and of more than 8 views 12.5 for each\n"
    "      --noise S       standard deviation of the photographs' noise, which is taken away first:\n"
    "                      linear, of values up to 1. 0: they stay as they are. Default: auto, estimated\n"
    "                      from what the photographs of a view do not have in common\n"
    "      --layers N      how many times splats may describe a place of the surface, those of the views\n"
    "                      that see it finest: a number from 0.5 on, or `all` for a splat for every pixel "
    "of\n"
    "                      every view. Default: auto, all of up to 200,000 splats, else 2\n"
    "      --samples N     samples a side of a pixel while fitting, 1 to 4. Default: as the model has it,\n"
    "                      else 2\n"
    "      --device NAME   what network and fit are computed on: cpu, or cuda, the first NVIDIA GPU.\n"
    "                      Default: cpu\n"
    "\n"
    "example: ffprocams reconstruct data/sample -o spot.ply --pattern lollipop_0\n";

static int run(const char *capture_path, const char *output, const char *model_path, FfpReconstruction *how) {
    FfpError err = {0};
    FfpReconstructionStory story;
    FfpGaussians *gaussians = NULL;
    FfpModel *model = NULL;
    bool ok = true;
    FfpCapture *capture = ffp_capture_open(capture_path, &err);
    if (!capture) ok = false;
    if (ok && !(model_path && strcmp(model_path, "none") == 0))
        ok = (model = ffp_model_open(model_path, &err)) != NULL;
    if (ok) {
        how->model = model;
        gaussians = ffp_reconstruct(capture, how, &story, &err);
        ok = gaussians && ffp_gaussians_save(gaussians, output, &err);
    }
    if (ok)
        printf("%s: %lld Gaussians from %s in %.2f s (noise of %.2f %% taken away %.2f s, matching %.2f s, "
               "network %.2f s, polish %.2f s)\n",
               output, (long long)story.gaussians, story.pattern,
               story.denoise_s + story.start_s + story.network_s + story.polish_s, 100 * story.noise,
               story.denoise_s, story.start_s, story.network_s, story.polish_s);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

int ffp_cli_reconstruct(int argc, char **argv) {
    enum { POLISH = 256, NOISE, LAYERS, SAMPLES, DEVICE };
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"model", required_argument, NULL, 'm'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"polish", required_argument, NULL, POLISH},
                                            {"noise", required_argument, NULL, NOISE},
                                            {"layers", required_argument, NULL, LAYERS},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"device", required_argument, NULL, DEVICE},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    const char *output = NULL, *model = NULL;
    FfpReconstruction how = {
        .polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO};
    int status;
    for (int option; (option = ffp_cli_next(argc, argv, ":o:m:p:h", options)) != -1;) {
        switch (option) {
        case 'o':
            output = optarg;
            break;
        case 'm':
            model = optarg;
            break;
        case 'p':
            how.pattern = optarg;
            break;
        case POLISH:
            if (!ffp_cli_polish(argv[0], optarg, &how.polish)) return FFP_EXIT_USAGE;
            break;
        case NOISE:
            if (!ffp_cli_noise(argv[0], optarg, &how.noise)) return FFP_EXIT_USAGE;
            break;
        case LAYERS:
            if (!ffp_cli_layers(argv[0], optarg, &how.layers)) return FFP_EXIT_USAGE;
            break;
        case SAMPLES:
            if (!ffp_cli_samples(argv[0], optarg, &how.drawing)) return FFP_EXIT_USAGE;
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
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one CAPTURE");
    if (!output) return ffp_cli_usage(argv[0], "-o FILE.ply is missing");
    return run(argv[optind], output, model, &how);
}
