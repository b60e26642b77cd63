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
        put_cell(score->depth_lit_median, 2);
        put_cell(score->depth_lit_p90, 2);
        put_cell(score->depth_unlit_median, 2);
        put_cell(score->depth_unlit_p90, 2);
        put_cell(score->albedo_mse, 5);
        putchar('\n');
    }
}

static void put_table(const FfpScore *scores, int n_scores) {
    printf("%-20s %-14s %6s %8s %8s %8s %8s %8s %8s %8s\n", "capture", "protocol", "images", "PSNR", "object",
           "gloss", "SSIM", "LPIPS", "rec. s", "ms/image");
    for (int i = 0; i < n_scores; i++) {
        const FfpScore *score = &scores[i];
        printf("%-20s %-14s %6d", score->capture, score->protocol, score->images);
        put_cell(score->psnr, 2);
        put_cell(score->psnr_foreground, 2);
        put_cell(score->psnr_gloss, 2);
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
    *model = ffp_model_open(ffp_cli_context(), path, NULL, err);
    evaluation->model = *model;
    return *model != NULL;
}

static int check(const FfpEvaluation *evaluation, const char *model) {
    const int ways = (model != NULL) + (evaluation->gaussians != NULL) + (evaluation->field != NULL) +
                     (evaluation->predictor != FFP_PREDICT_GAUSSIANS);
    if (ways > 1)
        return ffp_cli_usage("evaluate", "--model, --gaussians, --field and --predictor exclude each other");
    if (evaluation->n_merged && evaluation->n_captures)
        return ffp_cli_usage("evaluate", "--merge takes no CAPTURE");
    if (!evaluation->n_merged && !evaluation->n_captures)
        return ffp_cli_usage("evaluate", "give at least one CAPTURE");
    if ((evaluation->gaussians || evaluation->field) && evaluation->n_captures > 1)
        return ffp_cli_usage("evaluate", "%s requires exactly one CAPTURE",
                             evaluation->field ? "--field" : "--gaussians");
    if (evaluation->n_targets > 1 && evaluation->n_targets != evaluation->n_captures)
        return ffp_cli_usage("evaluate", "give --targets once, or once per CAPTURE");
    return -1;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpEvaluation *evaluation = &arguments->evaluation;
    FfpError err = {0};
    int n_scores = 0;
    FfpScore *scores = NULL;
    FfpModel *model = NULL;
    evaluation->captures = arguments->captures.values;
    evaluation->n_captures = arguments->captures.count;
    evaluation->targets = arguments->targets.values;
    evaluation->n_targets = arguments->targets.count;
    evaluation->merged = arguments->merged.values;
    evaluation->n_merged = arguments->merged.count;
    evaluation->patterns = arguments->patterns.values;
    evaluation->n_patterns = arguments->patterns.count;
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
    FFP_CLI_MODEL(offsetof(Arguments, model),
                  "weights, or `none` for the classical initialisation. Default: the shipped "
                  "models/small.safetensors"),
    {.name = "gaussians",
     .letter = 'g',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.gaussians),
     .help = "render this PLY instead of reconstructing (one CAPTURE)"},
    {.name = "field",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.field),
     .help = "render this neural field, written by `refine --from-scratch=field`, instead of reconstructing "
             "(one CAPTURE)"},
    {.name = "predictor",
     .argument = "depth|match",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, evaluation.predictor),
     .words = (const FfpWord[]){{"depth", FFP_PREDICT_DEPTH}, {"match", FFP_PREDICT_MATCH}, {0}},
     .help = "predict without Gaussians: black + (white - black) * pattern, with the pattern looked up at "
             "the true depth (depth) or at the depth found by matching (match)"},
    {.name = "targets",
     .letter = 't',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, targets),
     .help = "poses and pictures for novel_pose (targets.json or scene.json): one for all captures, or one "
             "for each; a relative path is looked up in each capture's folder first"},
    FFP_CLI_PATTERNS(
        offsetof(Arguments, patterns),
        "a structured-light pattern to use, may be repeated, as for `reconstruct`. Default: the first "
        "that every view has and that is not held out. With --gaussians: the patterns that the PLY was "
        "made from, which then do not count as `unseen`"),
    FFP_CLI_POLISH(offsetof(Arguments, evaluation.polish),
                   "as for `reconstruct`; 0: the forward pass only. Default: auto"),
    FFP_CLI_NOISE(offsetof(Arguments, evaluation.noise),
                  "as for `reconstruct`; 0: no filtering. Default: auto"),
    FFP_CLI_LAYERS(offsetof(Arguments, evaluation.layers), "as for `reconstruct`. Default: auto"),
    FFP_CLI_DRAWING(offsetof(Arguments, evaluation.drawing.form),
                    "form in which Gaussians are fitted and drawn: ours (default), paper or gs-procams"),
    FFP_CLI_SAMPLES(offsetof(Arguments, evaluation.drawing.samples), FFP_CLI_SAMPLES_HELP),
    FFP_CLI_FORCE(offsetof(Arguments, evaluation.force)),
    FFP_CLI_DEVICE(offsetof(Arguments, device),
                   "where matching, network and fit run: cpu (default), or cuda, the first NVIDIA GPU"),
    {.name = "perceptual",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.perceptual),
     .help = "LPIPS weights (safetensors). Default: lpips_alex.safetensors in the folder named by the "
             "environment variable FFPROCAMS_PERCEPTUAL; without either, LPIPS is not computed"},
    {.name = "save",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, evaluation.save),
     .group = "results",
     .help = "write every prediction to DIR/<capture>/<view>_<pattern>.png"},
    {.name = "json",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, evaluation.json),
     .group = "results",
     .help = "write the rows as JSON: psnr, psnr_foreground, psnr_gloss, psnr_unseen_lollipops, ssim, lpips, "
             "images, reconstruct_s (per capture), render_s (total for the pictures of the row)"},
    {.name = "merge",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, merged),
     .group = "results",
     .help = "a file written by an earlier --json; may be repeated. Prints the rows of all files with their "
             "means and evaluates nothing. For captures divided among several processes"},
    {.name = "report",
     .argument = "FILE.html",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, evaluation.report),
     .group = "results",
     .help = "write an HTML page: large pictures, predictions beside truth and error, G-buffers, input, "
             "figures, times"},
    {.name = "show-pattern",
     .needs = "report",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.show_pattern),
     .group = "results",
     .help = "image file; the report begins with large pictures under it and shows the views relit by it"},
    {.name = "viewer",
     .needs = "report",
     .argument = "PAGE.html",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, evaluation.viewer),
     .group = "results",
     .help = "page for the report to link to, relative to the report"},
    {0},
};

const FfpCommand ffp_cli_evaluate = {
    .name = "evaluate",
    .group = FFP_CLI_EVALUATE,
    .purpose = "compares predictions with a capture's photographs, in tables, pictures and a report",
    .prose = "The capture's pictures are predicted by a model (--model), by given Gaussians or a given field "
             "(--gaussians, --field), or by pattern lookup (--predictor). Protocols:\n"
             "novel_pattern\theld-out patterns at the input poses\n"
             "novel_pose\tall pictures of --targets: new poses of camera and projector\n"
             "rendering\tblack, white and lollipop patterns at the input poses, and of these\n"
             "unseen\tthe lollipops that were not given to the predictor\n"
             "given\tthe photographs that were given: how well they are reproduced says little about others\n"
             "PSNR is computed over all pixels and channels of 8-bit sRGB predictions against the truth over "
             "black, then averaged over the pictures; `object` counts only pixels covered by the object. "
             "Identical pictures count as 100 dB.",
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
