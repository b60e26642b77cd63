#include <stdio.h>
#include <stdlib.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams map FILE.ply --capture CAPTURE [--poses FILE] [--view ID].. -o DIR\n"
    "\n"
    "Says where the projector's light goes: which projector pixel lights which camera pixel, and how much\n"
    "light, how dense and at what angle, falls on the object. For each view, in DIR:\n"
    "\n"
    "  <view>_camera_to_projector.exr  for a camera pixel: x, y in the projector (R, G, pixels, centres at\n"
    "                                  + 0.5) and the share of the light that is not shadowed (B);\n"
    "                                  -1 -1 0 where there is nothing\n"
    "  <view>_projector_to_camera.exr  for a projector pixel: x, y in the camera (R, G), 1 (B); -1 -1 0 "
    "where\n"
    "                                  the camera sees nothing that the pixel lights\n"
    "  both also as 16-bit PNG: x / width, y / height; alpha 0 where there is nothing\n"
    "  <view>_projector_sees.png       the object from the projector's place, in its white light\n"
    "  <view>_lit.png                  projector pixels that fall on the object\n"
    "  <view>_density.exr              camera pixels per projector pixel\n"
    "  <view>_resolution.exr           projector pixels per unit of length on the surface\n"
    "  <view>_incidence.exr            angle of incidence in degrees, -1 where there is nothing\n"
    "  <view>_illuminance.exr, .png    light that arrives on the surface, 1 at its greatest in the view\n"
    "\n"
    "  FILE.ply               Gaussians that `ffprocams reconstruct` wrote\n"
    "  -c, --capture CAPTURE  the capture they come from\n"
    "      --poses FILE       other poses of camera and projector (targets.json or scene.json)\n"
    "  -v, --view ID          a view to map, again for more. Default: every view of the poses\n"
    "  -o, --output DIR       folder for the files\n"
    "      --drawing D        ours (default), or paper for Gaussians of a model in the paper's "
    "form\n" FFP_CLI_SAMPLES_HELP "\n"
    "It prints, for each view, how far camera pixels end from where they began on the way to the projector\n"
    "and back: a check of the two correspondence maps against each other.\n"
    "\n"
    "example: ffprocams map spot.ply --capture data/sample --view 000 -o maps\n";

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpMaps maps;
} Arguments;

static void tell(const Arguments *arguments, const FfpMapStory *stories, int written) {
    for (int v = 0; v < FFP_MAP_STORIES && stories[v].view[0]; v++) {
        const FfpMapStory *story = &stories[v];
        printf("%s: %.1f %% of the projector's pixels fall on the object; there and back: %d camera pixels, "
               "%.2f %% within half a pixel, median %.3f, most %.3f; %d more find no way back\n",
               story->view, 100 * story->lit_share, story->lit_pixels, 100 * story->within_half,
               story->median, story->most, story->lost_pixels);
    }
    printf("%s: %d files\n", arguments->maps.folder, written);
}

static int run(const Arguments *arguments) {
    static FfpMapStory stories[FFP_MAP_STORIES];
    FfpError err = {0};
    int written = -1;
    FfpGaussians *gaussians = ffp_gaussians_open(arguments->gaussians, &err);
    FfpCapture *capture = gaussians ? ffp_capture_open(arguments->capture, &err) : NULL;
    if (capture) written = ffp_write_maps(gaussians, capture, &arguments->maps, stories, &err);
    if (written >= 0) tell(arguments, stories, written);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return written >= 0 ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

// Fills everything but the list; -1 to go on, else the exit code.
static int parse(int argc, char **argv, Arguments *arguments, FfpList *views) {
    enum { POSES = 256, DRAWING, SAMPLES };
    static const struct option options[] = {{"capture", required_argument, NULL, 'c'},
                                            {"poses", required_argument, NULL, POSES},
                                            {"view", required_argument, NULL, 'v'},
                                            {"output", required_argument, NULL, 'o'},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    for (int option; (option = ffp_cli_next(argc, argv, ":c:v:o:h", options)) != -1;) {
        switch (option) {
        case 'c':
            arguments->capture = optarg;
            break;
        case POSES:
            arguments->maps.poses = optarg;
            break;
        case 'v':
            ffp_cli_append(views, optarg);
            break;
        case 'o':
            arguments->maps.folder = optarg;
            break;
        case DRAWING:
            if (!ffp_cli_drawing(argv[0], optarg, &arguments->maps.drawing)) return FFP_EXIT_USAGE;
            break;
        case SAMPLES:
            if (!ffp_cli_samples(argv[0], optarg, &arguments->maps.drawing)) return FFP_EXIT_USAGE;
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one FILE.ply");
    if (!arguments->capture) return ffp_cli_usage(argv[0], "--capture CAPTURE is missing");
    if (!arguments->maps.folder) return ffp_cli_usage(argv[0], "-o DIR is missing");
    arguments->gaussians = argv[optind];
    return -1;
}

int ffp_cli_map(int argc, char **argv) {
    Arguments arguments = {0};
    FfpList views = {0};
    int status = parse(argc, argv, &arguments, &views);
    if (status < 0) {
        arguments.maps.views = views.values, arguments.maps.n_views = views.count;
        status = run(&arguments);
    }
    ffp_cli_list_free(&views);
    return status;
}
