#include <stdio.h>
#include <string.h>
#include "cli.h"

typedef struct Arguments {
    const char *capture, *output, *model, *device;
    FfpList patterns;
    FfpReconstruction how;
} Arguments;

// Black, white and these patterns it was made from.
static void tell(const char *output, const FfpList *patterns, const FfpReconstructionStats *stats) {
    printf("%s: %lld Gaussians from %s", output, (long long)stats->gaussians, stats->pattern);
    for (int i = 1; i < patterns->count; i++) printf(", %s", patterns->values[i]);
    printf(
        " in %.2f s (noise of %.2f %% taken away %.2f s, matching %.2f s, network %.2f s, polish %.2f s)\n",
        stats->denoise_s + stats->start_s + stats->network_s + stats->polish_s, 100 * stats->noise,
        stats->denoise_s, stats->start_s, stats->network_s, stats->polish_s);
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpError err = {0};
    FfpReconstructionStats stats;
    FfpGaussians *gaussians = NULL;
    FfpModel *model = NULL;
    const bool none = arguments->model && strcmp(arguments->model, "none") == 0;
    bool ok = ffp_can_write(arguments->output, &err) && ffp_cli_use_device(arguments->device, &err);
    FfpCapture *capture = ok ? ffp_capture_open(ffp_cli_context(), arguments->capture, &err) : NULL;
    ok = capture && (none || (model = ffp_model_open(ffp_cli_context(), arguments->model, &err)));
    if (ok) {
        arguments->how.model = model;
        arguments->how.patterns = arguments->patterns.values;
        arguments->how.n_patterns = arguments->patterns.count;
        gaussians = ffp_reconstruct(ffp_cli_context(), capture, &arguments->how, &stats, &err);
        ok = gaussians && ffp_gaussians_save(ffp_cli_context(), gaussians, arguments->output, &err);
    }
    if (ok) tell(arguments->output, &arguments->patterns, &stats);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail_patterns(&err, &arguments->patterns);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->how = ffp_reconstruction_defaults();
}

static const FfpOption options[] = {
    {.name = "output",
     .letter = 'o',
     .argument = "FILE.ply",
     .type = FFP_OPTION_FILE,
     .required = true,
     .offset = offsetof(Arguments, output),
     .help = "where the Gaussians go (binary PLY, opens in splat viewers too)"},
    {.name = "model",
     .letter = 'm',
     .argument = "FILE|none",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, model),
     .words = ffp_cli_none,
     .help = "weights (safetensors); `none` for the classical start alone, which needs no weights. Default: "
             "models/small.safetensors beside the program's folder or in the current one"},
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, patterns),
     .help =
         "a structured-light pattern to use, again for more: matching and fit look at all that a view was "
         "photographed under, the network at the first. Default: the first that is in every view and not "
         "held back"},
    FFP_CLI_POLISH(
        offsetof(Arguments, how.polish),
        "steps of the fit, of one view each; of pictures above 192 pixels, steps on the smallest of "
        "several sizes, with fewer on larger ones. 0: the forward pass alone. Default: auto, 88, "
        "and of more than 8 views 11 for each"),
    FFP_CLI_NOISE(
        offsetof(Arguments, how.noise),
        "standard deviation of the photographs' noise, which is taken away first: linear, of values "
        "up to 1. 0: they stay as they are. Default: auto, estimated from what the photographs of a "
        "view do not have in common"),
    FFP_CLI_LAYERS(
        offsetof(Arguments, how.layers),
        "how many times splats may describe a place of the surface, those of the views that see it "
        "finest: a number from 0.5 on, or `all` for a splat for every pixel of every view. Default: "
        "auto, all of up to 200,000 splats, else 2"),
    FFP_CLI_SAMPLES(offsetof(Arguments, how.drawing.samples),
                    "samples a side of a pixel while fitting, 1 to 4. Default: as the model has it, else 2"),
    FFP_CLI_DEVICE(offsetof(Arguments, device),
                   "what network and fit are computed on: cpu, or cuda, the first NVIDIA GPU. Default: cpu"),
    {0},
};

const FfpCommand ffp_cli_reconstruct = {
    .name = "reconstruct",
    .group = FFP_CLI_RECONSTRUCT,
    .purpose = "turns a capture into relightable 3D Gaussians (PLY)",
    .prose =
        "One forward pass and a short fit to the same photographs give geometry (centre, scale, rotation, "
        "opacity) and material (albedo, roughness, ambient colour), in the capture's own units.",
    .positional = {.name = "CAPTURE",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, capture),
                   .help =
                       "folder with scene.json or render_poses.json, or such a file: views of one object, "
                       "each under a black, a white and at least one coloured pattern"},
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams reconstruct data/sample -o spot.ply --pattern lollipop_0\n"
                        "ffprocams reconstruct data/sample -o spot.ply -p lollipop_0 -p lollipop_3"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
