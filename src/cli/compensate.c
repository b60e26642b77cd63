#include <float.h>
#include <math.h>
#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpList views, targets;
    FfpCompensation how;
} Arguments;

static void tell(const FfpCompensation *how, const FfpCompensationStats *stats) {
    printf("patterns       %d\n", stats->patterns);
    if (!how->paint) printf("gain           %.3f\n", stats->gain);
    printf("not lit        %.1f %% of the object's pixels\n", 100 * stats->unlit);
    printf("out of gamut   %.1f %% too dark to reach, %.1f %% too bright\n", 100 * stats->too_dark,
           100 * stats->too_bright);
    printf("PSNR           %.2f dB dark, %.2f dB in closed form, %.2f dB after %d steps (predicted, lit "
           "pixels)\n",
           stats->psnr_dark, stats->psnr_closed, stats->psnr, how->steps);
    printf("time           %.1f s\n", stats->seconds);
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpCompensation *how = &arguments->how;
    FfpError err = {0};
    FfpCompensationStats stats;
    bool ok = false;
    how->views = arguments->views.values, how->n_views = arguments->views.count;
    how->targets = arguments->targets.values, how->n_targets = arguments->targets.count;
    if (how->n_targets > 1 && how->n_targets != how->n_views)
        return ffp_cli_usage("compensate", "%d targets for %d views: give one for all, or one for each",
                             how->n_targets, how->n_views);
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, &err);
    FfpCapture *capture = gaussians ? ffp_capture_open(ffp_cli_context(), arguments->capture, &err) : NULL;
    if (capture) ok = ffp_compensate(ffp_cli_context(), gaussians, capture, how, &stats, &err);
    if (ok) tell(how, &stats);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->how = ffp_compensation_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_CAPTURE_OPTION(offsetof(Arguments, capture),
                           "the capture they come from: poses, patterns, photographs"),
    {.name = "view",
     .letter = 'v',
     .argument = "ID",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .required = true,
     .offset = offsetof(Arguments, views),
     .help = "the view whose camera is to see the target; again for more: all their projectors shine at "
             "once, and where they overlap they share the work, each fading out towards the edge of what it "
             "lights"},
    {.name = "target",
     .letter = 't',
     .argument = "IMAGE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .required = true,
     .offset = offsetof(Arguments, targets),
     .help = "what the camera is to see: an image of the shape of the camera's frame, sRGB. Where it is "
             "transparent anything will do. Again: one for each view"},
    {.name = "output",
     .letter = 'o',
     .argument = "FILE.png",
     .type = FFP_OPTION_FILE,
     .required = true,
     .offset = offsetof(Arguments, how.pattern),
     .help =
         "the pattern to project. Of several projectors: FILE_<view>.png. Beside it FILE_seen_<view>.png, "
         "what the camera will see, and FILE_target_<view>.png, what it was to see"},
    FFP_CLI_POSES(offsetof(Arguments, how.poses)),
    {.name = "gain",
     .excludes = "paint",
     .letter = 'g',
     .argument = "G|auto",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, how.gain),
     .least = DBL_MIN,
     .most = INFINITY,
     .words = (const FfpWord[]){{"auto", 0}, {0}},
     .takes = "auto or a number above 0",
     .help = "multiplies the target's linear light (default 1); auto: the brightest of the gains that bring "
             "the target nearest to what light allows"},
    {.name = "paint",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.paint),
     .help = "the target is light on the object instead: black stands for the look of each pixel under a "
             "dark projector, white for that under full light. Always within reach; the object's own colours "
             "stay"},
    {.name = "steps",
     .letter = 's',
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, how.steps),
     .high = 100000,
     .help = "steps of gradient descent (default 30); 0: the closed form alone. More of them fit the "
             "Gaussians better, and where these err the object no more"},
    {.name = "gaussians-only",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.gaussians_only),
     .help = "do not use the view's photographs under black and white, which otherwise say how bright each "
             "pixel gets"},
    {.name = "for-device",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.for_device),
     .help = "write the pattern as the real projector is to be sent it: of its panel's size, with its lens's "
             "distortion put in again and its gamma undone, as import has kept them in scene.json "
             "(projector.device)"},
    FFP_CLI_DRAWING(offsetof(Arguments, how.drawing.form), FFP_CLI_FORM_HELP),
    FFP_CLI_SAMPLES(offsetof(Arguments, how.drawing.samples), FFP_CLI_SAMPLES_HELP),
    {0},
};

const FfpCommand ffp_cli_compensate = {
    .name = "compensate",
    .group = FFP_CLI_PROJECT,
    .purpose = "finds the pattern that makes a camera see a target picture on the object",
    .prose =
        "As nearly as light allows, it undoes the object's shape, its colours, the angles and distances of "
        "the light, and the ambient light: first in closed form, then by gradient descent through the "
        "renderer.\n"
        "A projector can only add light. What the target wants darker than the object is in the black "
        "picture, or brighter than in the white one, cannot be had: the command says how many per cent of "
        "the pixels that is. On a dark or coloured object in a bright room that may be most of them; then "
        "use --paint.",
    .positional = FFP_CLI_GAUSSIANS(offsetof(Arguments, gaussians)),
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams compensate spot.ply -c data/sample -v path_0_theta000 -t picture.png \\\n"
                        "    --paint -o pattern.png\n"
                        "ffprocams compensate spot.ply -c data/sample -v path_0_theta000 "
                        "-v path_0_theta090 \\\n"
                        "    -t grey.png -g auto -o both.png"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
