#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/cli.h"

#define STEPS 30

static const char help[] =
    "usage: ffprocams compensate FILE.ply --capture CAPTURE [--poses FILE] --view ID..\n"
    "                            --target IMAGE.. -o PATTERN.png\n"
    "                            [--gain G|auto] [--paint] [--steps N] [--gaussians-only]\n"
    "\n"
    "Finds the pattern that makes the camera see the target on the object, as nearly as light allows: it\n"
    "undoes the object's shape, its colours, the angles and distances of the light, and the ambient light.\n"
    "First in closed form, then by gradient descent through the renderer.\n"
    "\n"
    "A projector can only add light. What the target wants darker than the object is in the black picture,\n"
    "or brighter than in the white one, cannot be had: the command says how many per cent of the pixels\n"
    "that is. On a dark or coloured object in a bright room that may be most of them; then use --paint.\n"
    "\n"
    "  FILE.ply               Gaussians that `ffprocams reconstruct` wrote\n"
    "  -c, --capture CAPTURE  the capture they come from: poses, patterns, photographs\n"
    "      --poses FILE       other poses of camera and projector (targets.json or scene.json)\n"
    "  -v, --view ID          the view whose camera is to see the target; again for more: all their\n"
    "                         projectors shine at once, and where they overlap they share the work,\n"
    "                         each fading out towards the edge of what it lights\n"
    "  -t, --target IMAGE     what the camera is to see: an image of the shape of the camera's frame,\n"
    "                         sRGB. Where it is transparent anything will do. Again: one for each view\n"
    "  -o, --output FILE.png  the pattern to project. Of several projectors: FILE_<view>.png. Beside it\n"
    "                         FILE_seen_<view>.png, what the camera will see, and FILE_target_<view>.png,\n"
    "                         what it was to see\n"
    "  -g, --gain G           multiplies the target's linear light (default 1); auto: the brightest of the\n"
    "                         gains that bring the target nearest to what light allows\n"
    "      --paint            the target is light on the object instead: black stands for the look of each\n"
    "                         pixel under a dark projector, white for that under full light. Always within\n"
    "                         reach; the object's own colours stay\n"
    "  -s, --steps N          steps of gradient descent (default 30); 0: the closed form alone. More of\n"
    "                         them fit the Gaussians better, and where these err the object no more\n"
    "      --gaussians-only   do not use the view's photographs under black and white, which otherwise say\n"
    "                         how bright each pixel gets\n"
    "      --drawing D        ours (default), or paper for Gaussians of a model in the paper's "
    "form\n" FFP_CLI_SAMPLES_HELP "\n"
    "example: ffprocams compensate spot.ply -c data/sample -v 000 -t picture.png --paint -o pattern.png\n"
    "         ffprocams compensate spot.ply -c data/sample -v 000 -v 090 -t grey.png -g auto -o both.png\n";

enum { POSES = 256, PAINT, GAUSSIANS_ONLY, DRAWING, SAMPLES }; // options without a letter

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpCompensation how;
} Arguments;

static void tell(const FfpCompensation *how, const FfpCompensationStory *story) {
    printf("patterns       %d\n", story->patterns);
    if (!how->paint) printf("gain           %.3f\n", story->gain);
    printf("not lit        %.1f %% of the object's pixels\n", 100 * story->unlit);
    printf("out of gamut   %.1f %% too dark to reach, %.1f %% too bright\n", 100 * story->too_dark,
           100 * story->too_bright);
    printf("PSNR           %.2f dB dark, %.2f dB in closed form, %.2f dB after %d steps (predicted, lit "
           "pixels)\n",
           story->psnr_dark, story->psnr_closed, story->psnr, how->steps);
    printf("time           %.1f s\n", story->seconds);
}

static int run(const Arguments *arguments) {
    FfpError err = {0};
    FfpCompensationStory story;
    bool ok = false;
    FfpGaussians *gaussians = ffp_gaussians_open(arguments->gaussians, &err);
    FfpCapture *capture = gaussians ? ffp_capture_open(arguments->capture, &err) : NULL;
    if (capture) ok = ffp_compensate(gaussians, capture, &arguments->how, &story, &err);
    if (ok) tell(&arguments->how, &story);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

// "auto" or a number above 0; false otherwise.
static bool read_gain(const char *text, double *gain) {
    if (strcmp(text, "auto") != 0) return ffp_cli_real(text, DBL_MIN, DBL_MAX, gain);
    *gain = 0;
    return true;
}

static int check(const Arguments *arguments, const char *command) {
    const FfpCompensation *how = &arguments->how;
    if (!arguments->capture) return ffp_cli_usage(command, "--capture CAPTURE is missing");
    if (!how->n_views) return ffp_cli_usage(command, "--view ID is missing");
    if (!how->n_targets) return ffp_cli_usage(command, "--target IMAGE is missing");
    if (!how->pattern) return ffp_cli_usage(command, "-o PATTERN.png is missing");
    if (how->n_targets > 1 && how->n_targets != how->n_views)
        return ffp_cli_usage(command, "%d targets for %d views: give one for all, or one for each",
                             how->n_targets, how->n_views);
    return -1;
}

// Takes one option; -1 to go on, else the exit code.
static int take(int option, const char *command, Arguments *arguments, FfpList *views, FfpList *targets) {
    FfpCompensation *how = &arguments->how;
    int64_t steps;
    switch (option) {
    case 'c':
        arguments->capture = optarg;
        return -1;
    case POSES:
        how->poses = optarg;
        return -1;
    case 'v':
        ffp_cli_append(views, optarg);
        return -1;
    case 't':
        ffp_cli_append(targets, optarg);
        return -1;
    case 'o':
        how->pattern = optarg;
        return -1;
    case 'g':
        if (read_gain(optarg, &how->gain)) return -1;
        return ffp_cli_usage(command, "--gain is auto or a number above 0, not %s", optarg);
    case PAINT:
        how->paint = true;
        return -1;
    case 's':
        if (!ffp_cli_number(optarg, 0, 100000, &steps))
            return ffp_cli_usage(command, "--steps is 0 to 100000, not %s", optarg);
        how->steps = (int)steps;
        return -1;
    case GAUSSIANS_ONLY:
        how->gaussians_only = true;
        return -1;
    case DRAWING:
        if (!ffp_cli_drawing(command, optarg, &how->drawing)) return FFP_EXIT_USAGE;
        return -1;
    case SAMPLES:
        if (!ffp_cli_samples(command, optarg, &how->drawing)) return FFP_EXIT_USAGE;
        return -1;
    case 'h':
        fputs(help, stdout);
        return FFP_EXIT_OK;
    default:
        return FFP_EXIT_USAGE;
    }
}

// Fills the arguments; -1 to go on, else the exit code.
static int parse(int argc, char **argv, Arguments *arguments, FfpList *views, FfpList *targets) {
    static const struct option options[] = {{"capture", required_argument, NULL, 'c'},
                                            {"poses", required_argument, NULL, POSES},
                                            {"view", required_argument, NULL, 'v'},
                                            {"target", required_argument, NULL, 't'},
                                            {"output", required_argument, NULL, 'o'},
                                            {"gain", required_argument, NULL, 'g'},
                                            {"paint", no_argument, NULL, PAINT},
                                            {"steps", required_argument, NULL, 's'},
                                            {"gaussians-only", no_argument, NULL, GAUSSIANS_ONLY},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    for (int option; (option = ffp_cli_next(argc, argv, ":c:v:t:o:g:s:h", options)) != -1;) {
        const int status = take(option, argv[0], arguments, views, targets);
        if (status >= 0) return status;
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one FILE.ply");
    arguments->gaussians = argv[optind];
    arguments->how.views = views->values, arguments->how.n_views = views->count;
    arguments->how.targets = targets->values, arguments->how.n_targets = targets->count;
    return check(arguments, argv[0]);
}

int ffp_cli_compensate(int argc, char **argv) {
    Arguments arguments = {.how = {.gain = 1, .steps = STEPS}};
    FfpList views = {0}, targets = {0};
    int status = parse(argc, argv, &arguments, &views, &targets);
    if (status < 0) status = run(&arguments);
    ffp_cli_list_free(&views);
    ffp_cli_list_free(&targets);
    return status;
}
