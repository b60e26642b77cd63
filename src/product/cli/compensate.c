#include <float.h>
#include <math.h>
#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpList views, targets;
    int transparent;
    FfpCompensation how;
    int up;
} Arguments;

static void tell(const FfpCompensation *how, const FfpCompensationStats *stats) {
    printf("patterns       %d\n", stats->patterns);
    if (!how->paint) printf("gain           %.3f\n", stats->gain);
    printf("unlit          %.1f %% of the object's pixels\n", 100 * stats->unlit);
    printf("out of gamut   %.1f %% too dark, %.1f %% too bright\n", 100 * stats->too_dark,
           100 * stats->too_bright);
    if (!how->paint && stats->too_dark + stats->too_bright > 0.5)
        printf("               most of this target is out of reach: try --paint%s\n",
               how->gain == 0 ? "" : ", or --gain auto");
    printf("PSNR           %.2f dB dark, %.2f dB in closed form, %.2f dB after %d steps (predicted, lit "
           "pixels)\n",
           stats->psnr_dark, stats->psnr_closed, stats->psnr, how->steps);
    printf("time           %.1f s\n", stats->elapsed_s);
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpCompensation *how = &arguments->how;
    FfpError err = {0};
    FfpCompensationStats stats;
    bool ok = false;
    how->views = arguments->views.values;
    how->n_views = arguments->views.count;
    how->targets = arguments->targets.values;
    how->n_targets = arguments->targets.count;
    how->transparent_free = arguments->transparent == 1;
    if (how->n_targets > 1 && how->n_targets != how->n_views)
        return ffp_cli_usage("compensate", "%d targets for %d views: give one for all views, or one for each",
                             how->n_targets, how->n_views);
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err);
    FfpCapture *capture = gaussians ? ffp_cli_open_devices(arguments->capture, true, &err) : NULL;
    if (capture && ffp_cli_turn(gaussians, arguments->gaussians, capture, arguments->up, &err))
        ok = ffp_compensate(ffp_cli_context(), gaussians, capture, how, &stats, &err);
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
                           "the capture that the Gaussians come from: poses, patterns, photographs"),
    {.name = "view",
     .letter = 'v',
     .argument = "ID",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .required = true,
     .offset = offsetof(Arguments, views),
     .help = "the view whose camera sees the target; may be repeated: all their projectors shine at once and "
             "share the light where they overlap, each fading out towards the edge of the area it lights"},
    {.name = "target",
     .letter = 't',
     .argument = "IMAGE|FILM",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .required = true,
     .offset = offsetof(Arguments, targets),
     .help = "sRGB image that the camera should see. Give one for all views, or one for each; or a film, "
             "with --video"},
    FFP_CLI_FRAMING(offsetof(Arguments, how.framing), "targets"),
    {.name = "transparent",
     .argument = "black|free",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, transparent),
     .words = (const FfpWord[]){{"black", 0}, {"free", 1}, {0}},
     .help =
         "transparent parts of a target: black (default), as around text and logos, or free: anything may "
         "be seen there"},
    {.name = "video",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, how.video),
     .group = "films",
     .help =
         "with a film as target (FILM@FROM-TO: that part, in seconds): the corrected film, with its sound; "
         "its extension selects the format as in render. --output then shows the first frame"},
    {.name = "rate",
     .needs = "video",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, how.rate),
     .low = 1,
     .high = 1000,
     .group = "films",
     .help = "frames per second of the video. Default: the film's own"},
    FFP_CLI_FILE(
        offsetof(Arguments, how.pattern), "FILE.png",
        "the pattern to project; with several projectors FILE_<view>.png. Written beside it: "
        "FILE_seen_<view>.png, what the camera will see, and FILE_target_<view>.png, what it should see"),
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
     .help = "factor on the target's linear light (default 1); auto: the gain that brings the target closest "
             "to what projected light can reach, and the brightest of several equally good ones"},
    {.name = "paint",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.paint),
     .help =
         "treat the target as light on the object: black means each pixel's appearance with the projector "
         "dark, white its appearance under full light, shared where projectors overlap. Always reachable; "
         "the object keeps its own colours"},
    {.name = "black-level",
     .argument = "SHARE",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, how.black_level),
     .most = 0.1,
     .help = "share of its white that a dark projector still gives (0.001 for a contrast of 1000 to 1; "
             "default 0): where "
             "several overlap it adds up, and the dark beside is lifted until it is as bright"},
    {.name = "sharpen",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.sharpen),
     .help =
         "sharpen the pattern for the projector's blur, as found by import. Helps a projector that is out of "
         "focus, the more with --steps 100; edges may ring"},
    {.name = "steps",
     .letter = 's',
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, how.steps),
     .high = 100000,
     .help = "steps of gradient descent (default 30); 0: the closed form only. More steps fit the Gaussians "
             "better, but not the real object where the Gaussians are wrong"},
    {.name = "gaussians-only",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.gaussians_only),
     .help =
         "ignore the view's photographs under black and white, which otherwise give the range of each pixel"},
    {.name = "for-device",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.for_device),
     .help = "write the pattern ready for the real projector: at its panel's size, with lens distortion "
             "reapplied and gamma undone, as recorded by import in scene.json (projector.device)"},
    FFP_CLI_UP(offsetof(Arguments, up)),
    FFP_CLI_DRAWING(offsetof(Arguments, how.drawing.form), FFP_CLI_FORM_HELP),
    FFP_CLI_SAMPLES(offsetof(Arguments, how.drawing.samples), FFP_CLI_SAMPLES_HELP),
    {0},
};

const FfpCommand ffp_cli_compensate = {
    .name = "compensate",
    .group = FFP_CLI_PROJECT,
    .purpose = "computes the pattern that makes a camera see a target picture on the object",
    .prose = "Compensates, as far as projected light allows, for the object's shape and colours, the angle "
             "and distance of the light, and the ambient light: first in closed form, then by gradient "
             "descent through the renderer.\n"
             "A projector can only add light. A target that is darker than the black picture or brighter "
             "than the white one cannot be reached; the command reports the percentage of such pixels. On a "
             "dark or coloured object in a bright room that may be most of them; then use --paint.",
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
