#include <stdio.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams render FILE.ply --capture CAPTURE [--poses FILE] [--view ID]..\n"
    "                        [--pattern NAME|FILE].. -o DIR [--maps]\n"
    "\n"
    "Draws Gaussians as the camera would see them under projected patterns:\n"
    "DIR/<view>_<pattern>.png, 8-bit sRGB over black. One rasterisation a view serves all patterns.\n"
    "\n"
    "  FILE.ply               Gaussians that `ffprocams reconstruct` wrote\n"
    "  -c, --capture CAPTURE  the capture they come from: poses, patterns, the projector's intensity\n"
    "      --poses FILE       other poses of camera and projector (targets.json or scene.json)\n"
    "  -v, --view ID          a view to draw, again for more. Default: every view of the poses\n"
    "  -p, --pattern P        a pattern of the capture by name, or an image file; again for more.\n"
    "                         Default: white\n"
    "  -o, --output DIR       folder for the pictures\n"
    "      --maps             also the G-buffers: <view>_depth.exr (camera z) and viewable PNGs of\n"
    "                         opacity, depth, normal, albedo, roughness and ambient\n"
    "      --drawing D        ours (default), or paper for Gaussians of a model in the paper's form\n"
    "\n"
    "example: ffprocams render spot.ply --capture data/sample --pattern sun.png -o relit\n"
    "         ffprocams render spot.ply --capture data/sample --poses data/sample/targets.json -o new\n";

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpPictures pictures;
} Arguments;

static int run(const Arguments *arguments) {
    FfpError err = {0};
    int written = -1;
    FfpGaussians *gaussians = ffp_gaussians_open(arguments->gaussians, &err);
    FfpCapture *capture = gaussians ? ffp_capture_open(arguments->capture, &err) : NULL;
    if (capture) written = ffp_render_pictures(gaussians, capture, &arguments->pictures, &err);
    if (written >= 0) printf("%s: %d pictures\n", arguments->pictures.folder, written);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return written >= 0 ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

// Fills everything but the lists; -1 to go on, else the exit code.
static int parse(int argc, char **argv, Arguments *arguments, FfpList *views, FfpList *patterns) {
    enum { POSES = 256, MAPS, DRAWING };
    static const struct option options[] = {{"capture", required_argument, NULL, 'c'},
                                            {"poses", required_argument, NULL, POSES},
                                            {"view", required_argument, NULL, 'v'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"output", required_argument, NULL, 'o'},
                                            {"maps", no_argument, NULL, MAPS},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    for (int option; (option = ffp_cli_next(argc, argv, ":c:v:p:o:h", options)) != -1;) {
        switch (option) {
        case 'c':
            arguments->capture = optarg;
            break;
        case POSES:
            arguments->pictures.poses = optarg;
            break;
        case 'v':
            ffp_cli_append(views, optarg);
            break;
        case 'p':
            ffp_cli_append(patterns, optarg);
            break;
        case 'o':
            arguments->pictures.folder = optarg;
            break;
        case MAPS:
            arguments->pictures.maps = true;
            break;
        case DRAWING:
            if (ffp_cli_drawing(optarg, &arguments->pictures.drawing)) break;
            return ffp_cli_usage(argv[0], "--drawing is ours or paper, not %s", optarg);
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one FILE.ply");
    if (!arguments->capture) return ffp_cli_usage(argv[0], "--capture CAPTURE is missing");
    if (!arguments->pictures.folder) return ffp_cli_usage(argv[0], "-o DIR is missing");
    arguments->gaussians = argv[optind];
    return -1;
}

int ffp_cli_render(int argc, char **argv) {
    Arguments arguments = {0};
    FfpList views = {0}, patterns = {0};
    int status = parse(argc, argv, &arguments, &views, &patterns);
    if (status < 0) {
        arguments.pictures.views = views.values, arguments.pictures.n_views = views.count;
        arguments.pictures.patterns = patterns.values, arguments.pictures.n_patterns = patterns.count;
        status = run(&arguments);
    }
    ffp_cli_list_free(&views);
    ffp_cli_list_free(&patterns);
    return status;
}
