#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"

typedef struct Arguments {
    const char *model, *device;
    FfpList captures, targets, merged, patterns;
    FfpEvaluation evaluation;
} Arguments;

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

// Opens the weights, when what is evaluated takes any.
static bool open_model(FfpEvaluation *evaluation, const char *path, FfpModel **model, FfpError *err) {
    const bool none = path && strcmp(path, "none") == 0;
    if (none || evaluation->n_merged || evaluation->gaussians || evaluation->field ||
        evaluation->predictor != FFP_PREDICT_GAUSSIANS)
        return true;
    *model = ffp_model_open(ffp_cli_context(), path, err);
    evaluation->model = *model;
    return *model != NULL;
}

static int check(const FfpEvaluation *evaluation, const char *model) {
    const int ways = (model != NULL) + (evaluation->gaussians != NULL) + (evaluation->field != NULL) +
                     (evaluation->predictor != FFP_PREDICT_GAUSSIANS);
    if (ways > 1)
        return ffp_cli_usage("evaluate", "give only one of --model, --gaussians, --field and --predictor");
    if (evaluation->n_merged && evaluation->n_captures)
        return ffp_cli_usage("evaluate", "--merge takes the rows of files, and no CAPTURE");
    if (!evaluation->n_merged && !evaluation->n_captures)
        return ffp_cli_usage("evaluate", "give at least one CAPTURE");
    if ((evaluation->gaussians || evaluation->field) && evaluation->n_captures > 1)
        return ffp_cli_usage("evaluate", "%s goes with one CAPTURE",
                             evaluation->field ? "--field" : "--gaussians");
    if (evaluation->n_targets > 1 && evaluation->n_targets != evaluation->n_captures)
        return ffp_cli_usage("evaluate", "give --targets once, or once for each CAPTURE");
    return -1;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpEvaluation *evaluation = &arguments->evaluation;
    FfpError err = {0};
    int n_scores = 0;
    FfpScore *scores = NULL;
    FfpModel *model = NULL;
    evaluation->captures = arguments->captures.values, evaluation->n_captures = arguments->captures.count;
    evaluation->targets = arguments->targets.values, evaluation->n_targets = arguments->targets.count;
    evaluation->merged = arguments->merged.values, evaluation->n_merged = arguments->merged.count;
    evaluation->patterns = arguments->patterns.values, evaluation->n_patterns = arguments->patterns.count;
    if (check(evaluation, arguments->model) >= 0) return FFP_EXIT_USAGE;
    bool ok = ffp_cli_use_device(arguments->device, &err) && ffp_cli_use_ranks(&err);
    ok = ok && open_model(evaluation, arguments->model, &model, &err);
    if (ok) ok = (scores = ffp_evaluate(ffp_cli_context(), evaluation, &n_scores, &err)) != NULL;
    if (ok && (!ffp_cli_ranks() || ffp_cli_ranks()->rank == 0)) put_table(scores, n_scores);
    ffp_free(scores);
    ffp_model_close(model);
    return ok ? FFP_EXIT_OK : ffp_cli_fail_patterns(&err, &arguments->patterns);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->evaluation = ffp_evaluation_defaults();
}

static const FfpOption options[] = {
    {.name = "model",
     .letter = 'm',
     .argument = "FILE|none",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, model),
     .words = ffp_cli_none,
     .help = "weights; `none` for the classical start. Default: the shipped models/small.safetensors"},
    {.name = "gaussians",
     .letter = 'g',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.gaussians),
     .help = "a PLY to draw instead of reconstructing (one CAPTURE)"},
    {.name = "field",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.field),
     .help = "a neural field that `refine --from-scratch=field` wrote to draw instead of reconstructing (one "
             "CAPTURE)"},
    {.name = "predictor",
     .argument = "depth|match",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, evaluation.predictor),
     .words = (const FfpWord[]){{"depth", FFP_PREDICT_DEPTH}, {"match", FFP_PREDICT_MATCH}, {0}},
     .help = "no Gaussians at all: black + (white - black) * the pattern looked up at the true depth (depth) "
             "or at the one that matching finds (match)"},
    {.name = "targets",
     .letter = 't',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, targets),
     .help = "poses and pictures for novel_pose (targets.json or scene.json): one for all captures, or given "
             "once for each; a relative path is looked up in each capture's folder first"},
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, patterns),
     .help =
         "a structured-light pattern to use, again for more, as in `reconstruct`. Default: the first that "
         "is in every view and not held back; of --gaussians those that the PLY was made from, which are not "
         "`unseen`"},
    FFP_CLI_POLISH(offsetof(Arguments, evaluation.polish),
                   "as in `reconstruct`; 0: the forward pass alone. Default: auto"),
    FFP_CLI_NOISE(offsetof(Arguments, evaluation.noise),
                  "as in `reconstruct`; 0: photographs as they are. Default: auto"),
    FFP_CLI_LAYERS(offsetof(Arguments, evaluation.layers), "as in `reconstruct`. Default: auto"),
    FFP_CLI_DRAWING(offsetof(Arguments, evaluation.drawing.form),
                    "the form in which Gaussians are fitted and drawn: ours (default), paper or gs-procams"),
    FFP_CLI_SAMPLES(offsetof(Arguments, evaluation.drawing.samples), FFP_CLI_SAMPLES_HELP),
    FFP_CLI_DEVICE(offsetof(Arguments, device),
                   "what network and fit are computed on: cpu (default), or cuda, the first NVIDIA GPU"),
    {.name = "perceptual",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.perceptual),
     .help =
         "LPIPS weights (safetensors). Default: lpips_alex.safetensors in the folder that the environment "
         "variable FFPROCAMS_PERCEPTUAL names; without either there is no LPIPS"},
    {.name = "save",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, evaluation.save),
     .group = "results",
     .help = "every prediction as DIR/<capture>/<view>_<pattern>.png"},
    {.name = "json",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.json),
     .group = "results",
     .help = "the rows as JSON: psnr, psnr_foreground, psnr_gloss, psnr_unseen_lollipops, ssim, lpips, "
             "images, reconstruct_s (of the capture), render_s (of all the row's pictures together)"},
    {.name = "merge",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, merged),
     .group = "results",
     .help =
         "a file that an earlier --json wrote, given once for each: the rows of all with their means, and "
         "no CAPTURE is evaluated. For captures that several processes have shared out"},
    {.name = "report",
     .argument = "FILE.html",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.report),
     .group = "results",
     .help = "one HTML page: large pictures, predictions beside truth and error, G-buffers, input, figures, "
             "times"},
    {.name = "show-pattern",
     .needs = "report",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.show_pattern),
     .group = "results",
     .help = "image file: the report begins with large pictures under it, and shows the views relit by it"},
    {.name = "viewer",
     .needs = "report",
     .argument = "PAGE.html",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.viewer),
     .group = "results",
     .help = "a page that the report links to, as seen from where the report is"},
    {0},
};

const FfpCommand ffp_cli_evaluate = {
    .name = "evaluate",
    .group = FFP_CLI_EVALUATE,
    .purpose = "compares predictions with a capture's photographs: tables, pictures, a report",
    .prose =
        "Predicted are its pictures, by a model (--model), by Gaussians or a field that are there "
        "(--gaussians, --field) or by a lookup of the pattern (--predictor). Protocols:\n"
        "rendering\tblack, white and lollipop patterns at the input poses (`unseen`: the lollipops that the "
        "predictor was not given)\n"
        "novel_pattern\tevery other pattern at the input poses\n"
        "novel_pose\tall pictures of --targets: new poses of camera and projector\n"
        "PSNR is over all pixels and channels of 8-bit sRGB predictions against the truth over black, mean "
        "over the pictures; `object` over the pixels that the object covers only. Identical pictures count "
        "as "
        "100 dB.",
    .positional = {.name = "CAPTURE",
                   .least = 0,
                   .most = INT_MAX,
                   .offset = offsetof(Arguments, captures),
                   .help = "folders or JSON files"},
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams evaluate data/sample --targets targets.json --report report.html\n"
                        "ffprocams evaluate --merge part-0.json --merge part-1.json --json all.json"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
