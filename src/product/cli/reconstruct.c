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
    const double seconds =
        stats->denoise_s + stats->initialisation_s + stats->network_s + stats->polish_s + stats->score_s;
    printf("%s: %lld Gaussians from %s", output, (long long)stats->gaussians, stats->pattern);
    for (int i = 1; i < patterns->count; i++) printf(", %s", patterns->values[i]);
    printf(": %.2f dB on its photographs (least: %s, %.2f dB), %.2f s (%.2f %% noise filtered %.2f s, "
           "matching %.2f s, network %.2f s, polish %.2f s, comparing %.2f s)\n",
           stats->psnr, stats->least_view, stats->least_psnr, seconds, 100 * stats->noise, stats->denoise_s,
           stats->initialisation_s, stats->network_s, stats->polish_s, stats->score_s);
    if (stats->unseen > 0)
        printf("on patterns that no fit has seen: %.2f dB (where lit: %.2f dB, and %.2f dB on its own "
               "photographs)\n",
               stats->unseen_psnr, stats->unseen_lit_psnr, stats->lit_psnr);
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpError err = {0};
    FfpReconstructionStats stats;
    FfpGaussians *gaussians = NULL;
    FfpModel *model = NULL;
    const bool none = arguments->model && strcmp(arguments->model, "none") == 0;
    bool ok = ffp_can_write(arguments->output, &err) && ffp_cli_use_device(arguments->device, &err);
    FfpOpening opening = ffp_opening_defaults();
    opening.photographs = FFP_READ_WANTED;
    opening.patterns = arguments->patterns.values;
    opening.n_patterns = arguments->patterns.count;
    FfpCapture *capture = ok ? ffp_capture_open(ffp_cli_context(), arguments->capture, &opening, &err) : NULL;
    ok = capture && (none || (model = ffp_model_open(ffp_cli_context(), arguments->model, NULL, &err)));
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
    FFP_CLI_FILE(offsetof(Arguments, output), "FILE.ply",
                 "output file for the Gaussians (binary PLY, which splat viewers open too)"),
    FFP_CLI_MODEL(
        offsetof(Arguments, model),
        "weights (safetensors), or `none` for the classical initialisation alone, which needs no "
        "weights. Default: models/small.safetensors beside the program's folder or in the current one"),
    FFP_CLI_PATTERNS(
        offsetof(Arguments, patterns),
        "a structured-light pattern to use; may be repeated: matching and fit use all those that a view "
        "was photographed under, the network uses the first. Default: the first that every view has and "
        "that is not held out"),
    FFP_CLI_POLISH(offsetof(Arguments, how.polish),
                   "steps of the fit, one view per step; for pictures above 192 pixels, steps at the "
                   "smallest of several sizes, with fewer at larger ones. 0: the forward pass only. Default: "
                   "auto, which is 72, or 9 per view with more than 8 views; for scenes 2.5 times that"),
    FFP_CLI_NOISE(
        offsetof(Arguments, how.noise),
        "standard deviation of the noise that is first filtered from the photographs, in linear values from "
        "0 to 1. 0: no filtering. Default: auto, estimated from the differences among a view's photographs"),
    FFP_CLI_LAYERS(
        offsetof(Arguments, how.layers),
        "how many splats may cover the same place of the surface, keeping those of the views with "
        "the finest resolution there: a number of at least 0.5, or `all` for a splat for every "
        "pixel of every view. Default: auto: all for up to 200,000 splats, otherwise 2; 1 for whole scenes"),
    {.name = "width",
     .letter = 'w',
     .argument = "W",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, how.width),
     .low = 8,
     .high = 16384,
     .help = "a draft: reduce the pictures to W pixels wide first; it is compared with those of the capture "
             "all the same"},
    FFP_CLI_SAMPLES(
        offsetof(Arguments, how.drawing.samples),
        "samples per side of a pixel while fitting, 1 to 4. Default: the model's setting, otherwise 2"),
    FFP_CLI_FORCE(offsetof(Arguments, how.force)),
    FFP_CLI_DEVICE(offsetof(Arguments, device),
                   "where matching, network and fit run: cpu, or cuda, the first NVIDIA GPU. Default: cpu"),
    {0},
};

const FfpCommand ffp_cli_reconstruct = {
    .name = "reconstruct",
    .group = FFP_CLI_RECONSTRUCT,
    .purpose = "turns a capture into relightable 3D Gaussians (PLY)",
    .prose = "One forward pass and a short fit to the same photographs give geometry (centre, scale, "
             "rotation, opacity) and material (albedo, roughness, ambient colour), in the capture's units.",
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
