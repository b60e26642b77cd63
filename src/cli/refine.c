#include <stdio.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams refine FILE.ply --capture CAPTURE -o BETTER.ply [--seconds S] [--steps N]\n"
    "                        [--pattern NAME].. [--noise S] [--metrics FILE] [--seed N]\n"
    "                        [--drawing D] [--samples N]\n"
    "       ffprocams refine --from-scratch --capture CAPTURE -o FILE.ply ...\n"
    "\n"
    "Fits Gaussians to the photographs they come from: centres, shapes, opacities, albedo, roughness\n"
    "and ambient colour, so that the input views under black, white and the structured light are\n"
    "drawn better. Everything is held near to where it was, for the sake of poses that nobody\n"
    "photographed. Ctrl-C ends the work and keeps the best state so far.\n"
    "\n"
    "  FILE.ply               Gaussians that `ffprocams reconstruct` wrote\n"
    "      --from-scratch     without a prediction, the way GS-ProCams does it: points in the visual\n"
    "                         hull that grow, divide and vanish. Takes far longer\n"
    "  -c, --capture CAPTURE  the capture they come from\n"
    "  -o, --output FILE      where the better Gaussians go\n"
    "  -s, --seconds S        stop after so many seconds. Default: 30\n"
    "  -n, --steps N          stop after so many steps, of one view each; with it alone the result is\n"
    "                         the same every time. Default from scratch: 20000\n"
    "  -p, --pattern NAME     a structured-light pattern to fit to beside black and white, again for\n"
    "                         more. Default: the one that `reconstruct` takes\n"
    "      --noise S          as in `reconstruct`; 0: photographs as they are. Default: auto\n"
    "      --metrics FILE     a line of JSON a round of all views: step, seconds, loss, psnr, gaussians\n"
    "      --seed N           of the order of views and of the points from scratch. Default: 1\n"
    "      --drawing D        ours (default), or paper for Gaussians of a model in the paper's "
    "form\n" FFP_CLI_SAMPLES_HELP "\n"
    "example: ffprocams reconstruct data/sample -o spot.ply\n"
    "         ffprocams refine spot.ply --capture data/sample -o better.ply --seconds 30\n";

typedef struct Arguments {
    const char *gaussians, *capture, *output;
    bool scratch;
    FfpRefinement refinement;
} Arguments;

static void tell(const Arguments *arguments, const FfpRefinementStory *story) {
    printf("%s: %lld Gaussians, %.2f -> %.2f dB on the pictures fitted, %lld steps in %.1f s%s\n",
           arguments->output, (long long)story->gaussians, story->psnr_before, story->psnr_after,
           (long long)story->steps, story->seconds,
           story->dropped   ? ": the fit made them worse and was left out"
           : story->stopped ? ", interrupted"
                            : "");
}

static int run(const Arguments *arguments) {
    FfpError err = {0};
    FfpRefinementStory story = {0};
    FfpGaussians *gaussians = NULL;
    FfpCapture *capture =
        ffp_can_write(arguments->output, &err) ? ffp_capture_open(arguments->capture, &err) : NULL;
    bool ok = capture != NULL;
    if (ok && arguments->scratch)
        gaussians = ffp_fit_from_scratch(capture, &arguments->refinement, &story, &err);
    else if (ok && (gaussians = ffp_gaussians_open(arguments->gaussians, &err)))
        ok = ffp_refine_gaussians(gaussians, capture, &arguments->refinement, &story, &err);
    ok = ok && gaussians && ffp_gaussians_save(gaussians, arguments->output, &err);
    if (ok) tell(arguments, &story);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static int check(int argc, char **argv, Arguments *arguments) {
    const int files = argc - optind;
    if (arguments->scratch && files)
        return ffp_cli_usage(argv[0], "--from-scratch takes no FILE.ply: %s", argv[optind]);
    if (!arguments->scratch && files != 1) return ffp_cli_usage(argv[0], "give exactly one FILE.ply");
    if (!arguments->capture) return ffp_cli_usage(argv[0], "--capture CAPTURE is missing");
    if (!arguments->output) return ffp_cli_usage(argv[0], "-o FILE is missing");
    arguments->gaussians = arguments->scratch ? NULL : argv[optind];
    return -1;
}

// Fills everything but the patterns; -1 to go on, else the exit code.
static int parse(int argc, char **argv, Arguments *arguments, FfpList *patterns) {
    enum { SCRATCH = 256, METRICS, SEED, DRAWING, SAMPLES, NOISE };
    static const struct option options[] = {{"capture", required_argument, NULL, 'c'},
                                            {"output", required_argument, NULL, 'o'},
                                            {"seconds", required_argument, NULL, 's'},
                                            {"steps", required_argument, NULL, 'n'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"from-scratch", no_argument, NULL, SCRATCH},
                                            {"noise", required_argument, NULL, NOISE},
                                            {"metrics", required_argument, NULL, METRICS},
                                            {"seed", required_argument, NULL, SEED},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    FfpRefinement *refinement = &arguments->refinement;
    int64_t number;
    for (int option; (option = ffp_cli_next(argc, argv, ":c:o:s:n:p:h", options)) != -1;) {
        switch (option) {
        case 'c':
            arguments->capture = optarg;
            break;
        case 'o':
            arguments->output = optarg;
            break;
        case 's':
            if (!ffp_cli_number(optarg, 1, 10000000, &number))
                return ffp_cli_usage(argv[0], "--seconds is a number from 1 to 10000000, not %s", optarg);
            refinement->seconds = (double)number;
            break;
        case 'n':
            if (ffp_cli_number(optarg, 1, 1000000000, &refinement->steps)) break;
            return ffp_cli_usage(argv[0], "--steps is a number from 1 to 1000000000, not %s", optarg);
        case 'p':
            ffp_cli_append(patterns, optarg);
            break;
        case SCRATCH:
            arguments->scratch = true;
            break;
        case METRICS:
            refinement->metrics = optarg;
            break;
        case SEED:
            if (!ffp_cli_number(optarg, 0, INT64_MAX, &number))
                return ffp_cli_usage(argv[0], "--seed is a number from 0 up, not %s", optarg);
            refinement->seed = (uint64_t)number;
            break;
        case NOISE:
            if (!ffp_cli_noise(argv[0], optarg, &refinement->noise)) return FFP_EXIT_USAGE;
            break;
        case DRAWING:
            if (!ffp_cli_drawing(argv[0], optarg, &refinement->drawing)) return FFP_EXIT_USAGE;
            break;
        case SAMPLES:
            if (!ffp_cli_samples(argv[0], optarg, &refinement->drawing)) return FFP_EXIT_USAGE;
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    return check(argc, argv, arguments);
}

int ffp_cli_refine(int argc, char **argv) {
    Arguments arguments = {.refinement = {.seed = 1, .noise = FFP_NOISE_ESTIMATED}};
    FfpList patterns = {0};
    int status = parse(argc, argv, &arguments, &patterns);
    if (status < 0) {
        arguments.refinement.patterns = patterns.values;
        arguments.refinement.n_patterns = patterns.count;
        status = run(&arguments);
    }
    ffp_cli_list_free(&patterns);
    return status;
}
