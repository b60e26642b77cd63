#include <stdio.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams align CAPTURE -o DIR [--pattern NAME]\n"
    "\n"
    "Corrects where cameras and projectors look, from the photographs themselves. A direction that is\n"
    "wrong by a fifth of a degree, or a principal point by half a pixel, costs more than anything else:\n"
    "run this after `import` when `info` doubts the calibration, or when predictions look doubled.\n"
    "\n"
    "- Views of one rig that stood still while the object turned get what is common to all their poses,\n"
    "  if the pictures agree no worse so. Poses that were calibrated one by one gain most from that.\n"
    "- One turn of the camera and one of the projector, the same in all views, are searched for: those\n"
    "  under which the surfaces that the pattern shows in one view are those that the others show.\n"
    "\n"
    "What no picture can tell stays as it was: where the object lies along the turntable's axis. Focal\n"
    "lengths are not touched, and the devices' places only evened out. Errors that differ from view to\n"
    "view are only found on a turntable.\n"
    "\n"
    "  CAPTURE             as for `reconstruct`\n"
    "  -o, --output DIR    a capture like it with the better poses; it must be new or empty\n"
    "  -p, --pattern NAME  the structured-light pattern to look at. Default: as `reconstruct`\n"
    "\n"
    "example: ffprocams align vase -o vase-aligned\n"
    "         ffprocams reconstruct vase-aligned -o vase.ply\n";

static void tell(const char *output, const FfpAlignStory *story) {
    if (story->turntable)
        printf("turntable   devices turned by %.3f degrees to what all views have in common\n",
               story->evened);
    else
        printf("turntable   no: each view keeps its own pose\n");
    printf("all views   camera turned by %+.3f degrees to the projector and %+.3f across, the projector as "
           "much\n"
           "            against it; both by %+.3f sideways\n"
           "pictures    pattern values differ by %.4f, before by %.4f\n"
           "%s: aligned in %.1f s\n",
           story->depth, story->across, story->side, story->after, story->before, output, story->seconds);
}

static int run(const char *path, const char *pattern, const char *output) {
    FfpError err = {0};
    FfpAlignStory story;
    FfpCapture *capture = ffp_can_save_capture(output, &err) ? ffp_capture_open(path, &err) : NULL;
    const bool ok =
        capture && ffp_align_poses(capture, pattern, &story, &err) && ffp_capture_save(capture, output, &err);
    if (ok) tell(output, &story);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

int ffp_cli_align(int argc, char **argv) {
    static const struct option options[] = {{"output", required_argument, NULL, 'o'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    const char *output = NULL, *pattern = NULL;
    for (int option; (option = ffp_cli_next(argc, argv, ":o:p:h", options)) != -1;) {
        switch (option) {
        case 'o':
            output = optarg;
            break;
        case 'p':
            pattern = optarg;
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one CAPTURE");
    if (!output) return ffp_cli_usage(argv[0], "-o DIR is missing");
    return run(argv[optind], pattern, output);
}
