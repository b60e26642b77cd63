#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *capture, *output;
    FfpAligning options;
} Arguments;

static void tell(const char *output, const FfpAlignStats *stats) {
    if (stats->turntable)
        printf("turntable   devices turned by %.3f degrees to what all views have in common\n",
               stats->evened);
    else
        printf("turntable   no: each view has its own pose\n");
    if (stats->own)
        printf(
            "each view   devices turned by %.3f degrees; camera rays pass what they show of the pattern by "
            "%.3f\n"
            "            pixels of the projector, before %.3f; views' surfaces lie apart by %.3f pixels, "
            "before "
            "%.3f\n",
            stats->turned, stats->off[1], stats->off[0], stats->apart[1], stats->apart[0]);
    if (stats->focal[0] != 1 || stats->focal[1] != 1)
        printf("focal       lengths of the camera times %.4f, of the projector times %.4f\n", stats->focal[0],
               stats->focal[1]);
    printf("all views   camera turned by %+.3f degrees to the projector and %+.3f across, the projector as "
           "much\n"
           "            against it; both by %+.3f sideways\n"
           "pictures    pattern values differ by %.4f, before by %.4f\n"
           "%s: aligned in %.1f s\n",
           stats->depth, stats->across, stats->side, stats->after, stats->before, output, stats->seconds);
}

static int run(void *data) {
    const Arguments *arguments = data;
    FfpError err = {0};
    FfpAlignStats stats;
    FfpCapture *capture = ffp_can_save_capture(arguments->output, &err)
                              ? ffp_capture_open(ffp_cli_context(), arguments->capture, &err)
                              : NULL;
    const bool ok = capture &&
                    ffp_align_poses(ffp_cli_context(), capture, &arguments->options, &stats, &err) &&
                    ffp_capture_save(ffp_cli_context(), capture, arguments->output, &err);
    if (ok) tell(arguments->output, &stats);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static const FfpOption options[] = {
    {.name = "output",
     .letter = 'o',
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .required = true,
     .offset = offsetof(Arguments, output),
     .help = "a capture like it with the better poses; it must be new or empty"},
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, options.pattern),
     .help = "the structured-light pattern to look at. Default: as `reconstruct`"},
    {.name = "focal",
     .letter = 'f',
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, options.focal_lengths),
     .help = "correct the focal lengths of camera and projector too, the same in all views. Needs views that "
             "see the object from more than one side"},
    {0},
};

const FfpCommand ffp_cli_align = {
    .name = "align",
    .group = FFP_CLI_CAPTURE,
    .purpose = "corrects where a capture's cameras and projectors look, from the photographs themselves",
    .prose =
        "A direction that is wrong by a fifth of a degree, or a principal point by half a pixel, costs more "
        "than anything else: run this after `import` when `info` doubts the calibration, or when predictions "
        "look doubled.\n"
        "- Views of one rig that stood still while the object turned get what is common to all their poses, "
        "if the pictures agree no worse so. Poses that were calibrated one by one gain most from that.\n"
        "- Views that are not a turntable's get poses of their own: those under which camera rays meet what "
        "they show of the pattern, and the surfaces of different views each other.\n"
        "- One turn of the camera and one of the projector, the same in all views, are searched for: those "
        "under which the surfaces that the pattern shows in one view are those that the others show.\n"
        "What no picture can tell stays as it was: where the object lies along the turntable's axis.",
    .positional = {.name = "CAPTURE",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, capture),
                   .help = "as for `reconstruct`"},
    .options = options,
    .examples = (const FfpExample[]){{.command = "ffprocams align vase -o vase-aligned\n"
                                                 "ffprocams reconstruct vase-aligned -o vase.ply"},
                                     {0}},
    .size = sizeof(Arguments),
    .run = run,
};
