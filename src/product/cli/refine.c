#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include "cli.h"
#include "ffprocams/lab.h"

enum { FROM_GAUSSIANS = 1, FROM_FIELD }; // what is fitted from scratch

typedef struct Arguments {
    const char *gaussians, *capture, *output, *checkpoint;
    int scratch, form; // form -1: not given
    FfpList patterns;
    FfpRefinement refinement;
    int up;
} Arguments;

static void tell(const Arguments *arguments, const FfpRefinementStats *stats) {
    printf("%s: %lld Gaussians, %.2f -> %.2f dB on the fitted pictures, %lld steps in %.1f s%s\n",
           arguments->output, (long long)stats->gaussians, stats->psnr_before, stats->psnr_after,
           (long long)stats->steps, stats->elapsed_s,
           stats->dropped   ? ": the fit made them worse and was discarded"
           : stats->stopped ? ", interrupted"
                            : "");
}

// A field instead of Gaussians, into a file of its own kind.
static bool run_field(const Arguments *arguments, const FfpCapture *capture, FfpError *err) {
    FfpRefinementStats stats = {0};
    FfpNeuralField *field = ffp_fit_neural_field(ffp_cli_context(), capture, &arguments->refinement,
                                                 arguments->checkpoint, &stats, err);
    if (stats.stopped) ffp_cli_clear_interrupt();
    const bool ok = field && ffp_neural_field_save(ffp_cli_context(), field, arguments->output, err);
    if (ok && arguments->checkpoint && !stats.stopped) remove(arguments->checkpoint);
    if (ok)
        printf("%s: a neural field, %.2f dB on the fitted pictures, %lld steps in %.1f s%s\n",
               arguments->output, stats.psnr_after, (long long)stats.steps, stats.elapsed_s,
               stats.stopped ? ", interrupted" : "");
    ffp_neural_field_close(field);
    return ok;
}

static bool run_gaussians(const Arguments *arguments, const FfpCapture *capture, FfpError *err) {
    FfpRefinementStats stats = {0};
    FfpGaussians *gaussians = NULL;
    bool ok = true;
    if (arguments->gaussians &&
        !(gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, err)))
        return false;
    if (gaussians && !ffp_cli_turn(gaussians, arguments->gaussians, capture, arguments->up, err)) {
        ffp_gaussians_close(gaussians);
        return false;
    }
    if (arguments->scratch) {
        FfpGaussians *points = gaussians;
        gaussians =
            ffp_fit_from_scratch(ffp_cli_context(), capture, points, &arguments->refinement, &stats, err);
        ffp_gaussians_close(points);
    } else
        ok = ffp_refine_gaussians(ffp_cli_context(), gaussians, capture, &arguments->refinement, &stats, err);
    if (stats.stopped) ffp_cli_clear_interrupt(); // the best so far is to be saved
    ok = ok && gaussians && ffp_gaussians_save(ffp_cli_context(), gaussians, arguments->output, err);
    if (ok) tell(arguments, &stats);
    ffp_gaussians_close(gaussians);
    return ok;
}

static bool ends(const char *path, const char *ending) {
    const size_t length = strlen(path), n = strlen(ending);
    return length > n && strcasecmp(path + length - n, ending) == 0;
}

// An exit code, or -1: all options go together.
static int check(const Arguments *arguments) {
    const bool field = arguments->scratch == FROM_FIELD;
    if (field && arguments->gaussians)
        return ffp_cli_usage("refine", "--from-scratch=field takes no FILE.ply: %s", arguments->gaussians);
    if (!arguments->scratch && !arguments->gaussians)
        return ffp_cli_usage("refine", "give exactly one FILE.ply");
    if (arguments->checkpoint && !field)
        return ffp_cli_usage("refine", "--checkpoint requires --from-scratch=field");
    if (field && ends(arguments->output, ".ply"))
        return ffp_cli_usage("refine", "a field is not a PLY file: name %s with .field, not .ply",
                             arguments->output);
    if (!field && ends(arguments->output, ".field"))
        return ffp_cli_usage("refine", "Gaussians are not a field: name %s with .ply, not .field",
                             arguments->output);
    if (field && (arguments->form >= 0 || arguments->refinement.drawing.samples > 0))
        return ffp_cli_usage("refine", "--%s applies to Gaussians only, not to a field",
                             arguments->form >= 0 ? "drawing" : "samples");
    return -1;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpError err = {0};
    if (check(arguments) >= 0) return FFP_EXIT_USAGE;
    if (arguments->form >= 0) arguments->refinement.drawing.form = (FfpForm)arguments->form;
    arguments->refinement.patterns = arguments->patterns.values;
    arguments->refinement.n_patterns = arguments->patterns.count;
    FfpCapture *capture = ffp_can_write(arguments->output, &err)
                              ? ffp_capture_open(ffp_cli_context(), arguments->capture, NULL, &err)
                              : NULL;
    const bool ok = capture && (arguments->scratch == FROM_FIELD ? run_field(arguments, capture, &err)
                                                                 : run_gaussians(arguments, capture, &err));
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail_patterns(&err, &arguments->patterns);
}

static void set_defaults(void *data) {
    FfpRefinement *refinement = &((Arguments *)data)->refinement;
    ((Arguments *)data)->form = -1;
    *refinement = ffp_refinement_defaults();
    refinement->seed = 1;
}

static const FfpOption options[] = {
    FFP_CLI_CAPTURE_OPTION(offsetof(Arguments, capture), "the capture they come from"),
    FFP_CLI_FILE(offsetof(Arguments, output), "FILE",
                 "output file for the refined Gaussians (.ply) or the field (.field)"),
    {.name = "from-scratch",
     .argument = "KIND",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, scratch),
     .words = (const FfpWord[]){{"gaussians", FROM_GAUSSIANS}, {"field", FROM_FIELD}, {0}},
     .help = "fit without a prediction. gaussians: as GS-ProCams does, with points that grow, divide and "
             "vanish; they are the centres of FILE.ply if it is given, otherwise drawn in the visual hull. "
             "field: as Nepmap does, with a neural reflectance field, whose file only `info` and `evaluate "
             "--field` read. Both take far longer"},
    {.name = "seconds",
     .letter = 's',
     .argument = "S",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, refinement.limit_s),
     .least = 1,
     .most = 1e7,
     .takes = "a number from 1 to 10000000",
     .help = "stop after this many seconds. Default: 30, or 300 for a field"},
    {.name = "steps",
     .letter = 'n',
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, refinement.steps),
     .low = 1,
     .high = 1000000000,
     .help = "stop after this many steps, one view per step; given without --seconds, the result is "
             "reproducible. Default for Gaussians from scratch: 20000"},
    FFP_CLI_PATTERNS(
        offsetof(Arguments, patterns),
        "a structured-light pattern to fit to in addition to black and white; may be repeated. Default: "
        "the one that `reconstruct` uses"),
    FFP_CLI_NOISE(offsetof(Arguments, refinement.noise),
                  "as for `reconstruct`; 0: no filtering. Default: auto"),
    {.name = "metrics",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, refinement.metrics),
     .help = "one line of JSON per pass over all views (for a field: every 100 steps): step, seconds, loss, "
             "psnr, gaussians"},
    {.name = "checkpoint",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, checkpoint),
     .help = "checkpoint of a field, written every two minutes. If it exists, the fit resumes from it, with "
             "the same limits and patterns; removed once the field is complete"},
    {.name = "seed",
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, refinement.seed),
     .high = INT64_MAX,
     .help = "random seed for the order of views and for the initial points from scratch. Default: 1"},
    FFP_CLI_UP(offsetof(Arguments, up)),
    FFP_CLI_DRAWING(offsetof(Arguments, form), FFP_CLI_FORM_HELP),
    FFP_CLI_SAMPLES(offsetof(Arguments, refinement.drawing.samples), FFP_CLI_SAMPLES_HELP),
    FFP_CLI_FORCE(offsetof(Arguments, refinement.force)),
    {0},
};

const FfpCommand ffp_cli_refine = {
    .name = "refine",
    .group = FFP_CLI_RECONSTRUCT,
    .purpose = "fits Gaussians further to the photographs that they come from",
    .prose = "Adjusts centres, shapes, opacities, albedo, roughness and ambient colour so that the input "
             "views under black, white and the structured light are reproduced better. All values are kept "
             "close to where they started, for the sake of poses that were not photographed. Ctrl-C stops "
             "the fit and keeps the best state so far.",
    .positional = {.name = "FILE.ply",
                   .least = 0,
                   .most = 1,
                   .offset = offsetof(Arguments, gaussians),
                   .help = "Gaussians written by `ffprocams reconstruct`; with --from-scratch=gaussians the "
                           "points to begin with"},
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams reconstruct data/sample -o spot.ply\n"
                        "ffprocams refine spot.ply --capture data/sample -o better.ply --seconds 30"},
            {.command =
                 "ffprocams refine --from-scratch=gaussians --capture data/sample -o scratch.ply --steps "
                 "2000\n"
                 "ffprocams refine --from-scratch=field --capture data/sample -o spot.field --seconds 60"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
