#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams evaluate CAPTURE.. [--model FILE|none | --gaussians FILE |\n"
    "                          --predictor depth|match] [--targets FILE].. [--pattern NAME]\n"
    "                          [--polish STEPS] [--noise S] [--layers N] [--save DIR]\n"
    "                          [--json FILE] [--report FILE.html]\n"
    "\n"
    "Predicts the pictures of captures and compares. Protocols:\n"
    "  rendering      black, white and lollipop patterns at the input poses (`unseen`: the lollipops\n"
    "                 that the predictor was not given)\n"
    "  novel_pattern  every other pattern at the input poses\n"
    "  novel_pose     all pictures of --targets: new poses of camera and projector\n"
    "PSNR is over all pixels and channels of 8-bit sRGB predictions against the truth over black,\n"
    "mean over the pictures; `object` over the pixels that the object covers only. Identical pictures\n"
    "count as 100 dB.\n"
    "\n"
    "  CAPTURE..              folders or JSON files\n"
    "  -m, --model FILE       weights; `none` for the classical start. Default: the shipped\n"
    "                         models/small.safetensors\n"
    "  -g, --gaussians FILE   a PLY to draw instead of reconstructing (one CAPTURE)\n"
    "      --predictor P      no Gaussians at all: black + (white - black) * the pattern looked up at\n"
    "                         the true depth (depth) or at the one that matching finds (match)\n"
    "  -t, --targets FILE     poses and pictures for novel_pose (targets.json or scene.json): one for\n"
    "                         all captures, or given once for each; a relative path is looked up in\n"
    "                         each capture's folder first\n"
    "  -p, --pattern NAME     the structured-light pattern to use. Default: the first that is in\n"
    "                         every view and not held back\n"
    "      --polish STEPS     as in `reconstruct`; 0: the forward pass alone. Default: auto\n"
    "      --noise S          as in `reconstruct`; 0: photographs as they are. Default: auto\n"
    "      --layers N         as in `reconstruct`. Default: auto\n"
    "      --save DIR         every prediction as DIR/<capture>/<view>_<pattern>.png\n"
    "      --json FILE        the rows as JSON: psnr, psnr_foreground, psnr_gloss,\n"
    "                         psnr_unseen_lollipops, ssim, lpips, images, reconstruct_s (of the\n"
    "                         capture), render_s (of all the row's pictures together)\n"
    "      --report FILE      one HTML page with input, G-buffers, predictions beside truth and\n"
    "                         error, figures, times\n"
    "      --show-pattern F   image file: the report also shows the views relit by it\n"
    "      --perceptual FILE  LPIPS weights (safetensors). Default: lpips_alex.safetensors in the\n"
    "                         folder that the environment variable FFPROCAMS_PERCEPTUAL names;\n"
    "                         without either there is no LPIPS\n"
    "      --drawing D        with --gaussians: ours (default) or paper\n" FFP_CLI_SAMPLES_HELP
    "      --device NAME      what network and fit are computed on: cpu (default), or cuda\n"
    "\n"
    "example: ffprocams evaluate data/sample --targets targets.json --report report.html\n";

static void put_cell(double value, int digits) {
    if (isfinite(value))
        printf(" %8.*f", digits, value);
    else
        printf(" %8s", "-");
}

// Medians and 90th percentiles of the depth error, and the albedo's mean squared error, where a capture holds
// its truth.
static void put_truth(const FfpScore *scores, int n_scores) {
    bool any = false;
    for (int i = 0; i < n_scores; i++) {
        const FfpScore *score = &scores[i];
        if (!isfinite(score->depth_lit_median) && !isfinite(score->albedo_mse)) continue;
        if (!any)
            printf("\n%-20s %8s %8s %8s %8s %8s\n", "depth error, % of r", "lit", "90 %", "unlit", "90 %",
                   "albedo");
        any = true;
        printf("%-20s", score->capture);
        put_cell(score->depth_lit_median, 2), put_cell(score->depth_lit_p90, 2);
        put_cell(score->depth_unlit_median, 2), put_cell(score->depth_unlit_p90, 2);
        put_cell(score->albedo_mse, 5);
        putchar('\n');
    }
}

static void put_table(const FfpScore *scores, int n_scores) {
    printf("%-20s %-14s %6s %8s %8s %8s %8s %8s %8s %8s %8s\n", "capture", "protocol", "images", "PSNR",
           "object", "gloss", "unseen", "SSIM", "LPIPS", "rec. s", "ms/image");
    for (int i = 0; i < n_scores; i++) {
        const FfpScore *score = &scores[i];
        printf("%-20s %-14s %6d", score->capture, score->protocol, score->images);
        put_cell(score->psnr, 2);
        put_cell(score->psnr_foreground, 2);
        put_cell(score->psnr_gloss, 2);
        put_cell(score->psnr_unseen_lollipops, 2);
        put_cell(score->ssim, 4);
        put_cell(score->lpips, 4);
        put_cell(score->reconstruct_s, 2);
        put_cell(1000 * score->render_s / score->images, 1);
        putchar('\n');
    }
    put_truth(scores, n_scores);
}

static int run(FfpEvaluation *evaluation, const char *model_path) {
    FfpError err = {0};
    int n_scores = 0;
    FfpScore *scores = NULL;
    FfpModel *model = NULL;
    bool ok = true;
    const bool none = model_path && strcmp(model_path, "none") == 0;
    if (evaluation->predictor == FFP_PREDICT_DEPTH)
        evaluation->model_name = "pattern lookup at the true depth";
    else if (evaluation->predictor == FFP_PREDICT_MATCH)
        evaluation->model_name = "pattern lookup at the matched depth";
    else if (evaluation->gaussians)
        evaluation->model_name = evaluation->gaussians;
    else if (none)
        evaluation->model_name = "the classical start, without weights";
    else {
        evaluation->model_name = model_path ? model_path : "the shipped weights";
        ok = (model = ffp_model_open(model_path, &err)) != NULL;
    }
    evaluation->model = model;
    if (ok) ok = (scores = ffp_evaluate(evaluation, &n_scores, &err)) != NULL;
    if (ok) put_table(scores, n_scores);
    free(scores);
    ffp_model_close(model);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static bool set_predictor(FfpEvaluation *evaluation, const char *name) {
    evaluation->predictor = strcmp(name, "depth") == 0 ? FFP_PREDICT_DEPTH : FFP_PREDICT_MATCH;
    return evaluation->predictor == FFP_PREDICT_DEPTH || strcmp(name, "match") == 0;
}

// -1 to go on, else the exit code.
static int parse(int argc, char **argv, FfpEvaluation *evaluation, FfpList *targets, const char **model) {
    enum {
        PREDICTOR = 256,
        SAVE,
        JSON,
        REPORT,
        SHOW,
        PERCEPTUAL,
        DRAWING,
        SAMPLES,
        POLISH,
        NOISE,
        LAYERS,
        DEVICE
    };
    static const struct option options[] = {{"model", required_argument, NULL, 'm'},
                                            {"gaussians", required_argument, NULL, 'g'},
                                            {"predictor", required_argument, NULL, PREDICTOR},
                                            {"targets", required_argument, NULL, 't'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"polish", required_argument, NULL, POLISH},
                                            {"noise", required_argument, NULL, NOISE},
                                            {"layers", required_argument, NULL, LAYERS},
                                            {"save", required_argument, NULL, SAVE},
                                            {"json", required_argument, NULL, JSON},
                                            {"report", required_argument, NULL, REPORT},
                                            {"show-pattern", required_argument, NULL, SHOW},
                                            {"perceptual", required_argument, NULL, PERCEPTUAL},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"device", required_argument, NULL, DEVICE},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    int status;
    for (int option; (option = ffp_cli_next(argc, argv, ":m:g:t:p:h", options)) != -1;) {
        switch (option) {
        case 'm':
            *model = optarg;
            break;
        case 'g':
            evaluation->gaussians = optarg;
            break;
        case PREDICTOR:
            if (set_predictor(evaluation, optarg)) break;
            return ffp_cli_usage(argv[0], "--predictor is depth or match, not %s", optarg);
        case 't':
            ffp_cli_append(targets, optarg);
            break;
        case 'p':
            evaluation->pattern = optarg;
            break;
        case POLISH:
            if (!ffp_cli_polish(argv[0], optarg, &evaluation->polish)) return FFP_EXIT_USAGE;
            break;
        case NOISE:
            if (!ffp_cli_noise(argv[0], optarg, &evaluation->noise)) return FFP_EXIT_USAGE;
            break;
        case LAYERS:
            if (!ffp_cli_layers(argv[0], optarg, &evaluation->layers)) return FFP_EXIT_USAGE;
            break;
        case SAVE:
            evaluation->save = optarg;
            break;
        case JSON:
            evaluation->json = optarg;
            break;
        case REPORT:
            evaluation->report = optarg;
            break;
        case SHOW:
            evaluation->show_pattern = optarg;
            break;
        case PERCEPTUAL:
            evaluation->perceptual = optarg;
            break;
        case DRAWING:
            if (!ffp_cli_drawing(argv[0], optarg, &evaluation->drawing)) return FFP_EXIT_USAGE;
            break;
        case SAMPLES:
            if (!ffp_cli_samples(argv[0], optarg, &evaluation->drawing)) return FFP_EXIT_USAGE;
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
    return -1;
}

static int check(const char *command, const FfpEvaluation *evaluation, const FfpList *targets,
                 const char *model) {
    const int ways =
        (model != NULL) + (evaluation->gaussians != NULL) + (evaluation->predictor != FFP_PREDICT_GAUSSIANS);
    if (evaluation->n_captures < 1) return ffp_cli_usage(command, "give at least one CAPTURE");
    if (ways > 1) return ffp_cli_usage(command, "give only one of --model, --gaussians and --predictor");
    if (evaluation->gaussians && evaluation->n_captures > 1)
        return ffp_cli_usage(command, "--gaussians goes with one CAPTURE");
    if (targets->count > 1 && targets->count != evaluation->n_captures)
        return ffp_cli_usage(command, "give --targets once, or once for each CAPTURE");
    if (evaluation->show_pattern && !evaluation->report)
        return ffp_cli_usage(command, "--show-pattern needs --report");
    return -1;
}

int ffp_cli_evaluate(int argc, char **argv) {
    FfpEvaluation evaluation = {
        .polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO};
    FfpList targets = {0};
    const char *model = NULL;
    int status = parse(argc, argv, &evaluation, &targets, &model);
    if (status < 0) {
        evaluation.captures = (const char *const *)(argv + optind);
        evaluation.n_captures = argc - optind;
        evaluation.targets = targets.values, evaluation.n_targets = targets.count;
        status = check(argv[0], &evaluation, &targets, model);
    }
    if (status < 0) status = run(&evaluation, model);
    ffp_cli_list_free(&targets);
    return status;
}
