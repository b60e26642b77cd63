#include <stdio.h>
#include <string.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams reconstruct CAPTURE -o FILE.ply [--model FILE|none] [--pattern NAME]\n"
    "\n"
    "Turns a capture into relightable 3D Gaussians in one forward pass: geometry (centre, scale,\n"
    "rotation, opacity) and material (albedo, roughness, ambient colour), in the capture's own units.\n"
    "\n"
    "  CAPTURE             folder with scene.json or render_poses.json, or such a file: views of one\n"
    "                      object, each under a black, a white and at least one coloured pattern\n"
    "  -o, --output FILE   where the Gaussians go (binary PLY, opens in splat viewers too)\n"
    "  -m, --model FILE    weights (safetensors); `none` for the classical start alone, which needs\n"
    "                      no weights. Default: models/small.safetensors beside the program's folder\n"
    "                      or in the current one\n"
    "  -p, --pattern NAME  the structured-light pattern to use. Default: the first that is in every\n"
    "                      view and not held back\n"
    "\n"
    "example: ffprocams reconstruct data/sample -o spot.ply --pattern lollipop_0\n";

static int run(const char *capture_path, const char *output, const char *model_path, const char *pattern) {
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
        const FfpReconstruction how = {model, pattern};
        gaussians = ffp_reconstruct(capture, &how, &story, &err);
        ok = gaussians && ffp_gaussians_save(gaussians, output, &err);
    }
    if (ok)
        printf("%s: %lld Gaussians from %s in %.2f s (matching %.2f s, network %.2f s)\n", output,
               (long long)story.gaussians, story.pattern, story.start_s + story.network_s, story.start_s,
               story.network_s);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

int ffp_cli_reconstruct(int argc, char **argv) {
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"model", required_argument, NULL, 'm'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    const char *output = NULL, *model = NULL, *pattern = NULL;
    for (int option; (option = ffp_cli_next(argc, argv, ":o:m:p:h", options)) != -1;) {
        switch (option) {
        case 'o':
            output = optarg;
            break;
        case 'm':
            model = optarg;
            break;
        case 'p':
            pattern = optarg;
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one CAPTURE");
    if (!output) return ffp_cli_usage(argv[0], "-o FILE.ply is missing");
    return run(argv[optind], output, model, pattern);
}
