#include <stdio.h>
#include <string.h>
#include "cli/cli.h"

#define FRAMES_MAX 9999

static const char help[] =
    "usage: ffprocams render FILE.ply --capture CAPTURE [--poses FILE] [--view ID]..\n"
    "                        [--pattern NAME|FILE|FOLDER].. -o DIR [--maps]\n"
    "                        [--orbit camera|projector|object,FRAMES] [--video FILE.png] [--rate N]\n"
    "\n"
    "Draws Gaussians as the camera would see them under projected patterns:\n"
    "DIR/<view>_<pattern>.png, 8-bit sRGB over black. One rasterisation a view serves all patterns.\n"
    "\n"
    "  FILE.ply               Gaussians that `ffprocams reconstruct` wrote\n"
    "  -c, --capture CAPTURE  the capture they come from: poses, patterns, the projector's intensity\n"
    "      --poses FILE       other poses of camera and projector (targets.json or scene.json)\n"
    "  -v, --view ID          a view to draw, again for more. Default: every view of the poses\n"
    "  -p, --pattern P        a pattern of the capture by name, an image file, or a folder of these in\n"
    "                         the order of their names; again for more. Default: white\n"
    "  -o, --output DIR       folder for the pictures\n"
    "      --maps             also the G-buffers: <view>_depth.exr (camera z) and viewable PNGs of\n"
    "                         opacity, depth, normal, albedo, roughness and ambient\n"
    "      --orbit WHAT,N     N frames, DIR/frame_0000.png and so on, of one turn of camera, projector\n"
    "                         or object from the view given (or the first); several patterns follow\n"
    "                         each other evenly through it\n"
    "      --video FILE.png   all pictures in order as an animated PNG; they are numbered too. Without\n"
    "                         --orbit: every view under every pattern\n"
    "      --rate N           frames a second of the video. Default: 15\n"
    "      --drawing D        ours (default), or paper for Gaussians of a model in the paper's "
    "form\n" FFP_CLI_SAMPLES_HELP "\n"
    "example: ffprocams render spot.ply --capture data/sample --pattern sun.png -o relit\n"
    "         ffprocams render spot.ply --capture data/sample --poses data/sample/targets.json -o new\n"
    "         ffprocams render spot.ply --capture data/sample --pattern sun.png --orbit object,90 \\\n"
    "             -o frames --video turn.png\n";

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

// "camera,90"
static bool set_orbit(FfpPictures *pictures, const char *text) {
    static const char *const names[] = {
        [FFP_ORBIT_CAMERA] = "camera,", [FFP_ORBIT_PROJECTOR] = "projector,", [FFP_ORBIT_OBJECT] = "object,"};
    for (int orbit = FFP_ORBIT_CAMERA; orbit <= FFP_ORBIT_OBJECT; orbit++) {
        const size_t length = strlen(names[orbit]);
        int64_t frames;
        if (strncmp(text, names[orbit], length) != 0 ||
            !ffp_cli_number(text + length, 1, FRAMES_MAX, &frames))
            continue;
        pictures->orbit = (FfpOrbit)orbit, pictures->frames = (int)frames;
        return true;
    }
    return false;
}

static int check(int argc, char **argv, Arguments *arguments, const FfpList *views) {
    const FfpPictures *pictures = &arguments->pictures;
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one FILE.ply");
    if (!arguments->capture) return ffp_cli_usage(argv[0], "--capture CAPTURE is missing");
    if (!pictures->folder) return ffp_cli_usage(argv[0], "-o DIR is missing");
    if (pictures->orbit != FFP_ORBIT_NONE && views->count > 1)
        return ffp_cli_usage(argv[0], "--orbit starts from one --view");
    if (pictures->maps && (pictures->orbit != FFP_ORBIT_NONE || pictures->video))
        return ffp_cli_usage(argv[0], "--maps goes neither with --orbit nor with --video");
    arguments->gaussians = argv[optind];
    return -1;
}

// Fills everything but the lists; -1 to go on, else the exit code.
static int parse(int argc, char **argv, Arguments *arguments, FfpList *views, FfpList *patterns) {
    enum { POSES = 256, MAPS, DRAWING, SAMPLES, ORBIT, VIDEO, RATE };
    int64_t number;
    static const struct option options[] = {{"capture", required_argument, NULL, 'c'},
                                            {"poses", required_argument, NULL, POSES},
                                            {"view", required_argument, NULL, 'v'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"output", required_argument, NULL, 'o'},
                                            {"maps", no_argument, NULL, MAPS},
                                            {"drawing", required_argument, NULL, DRAWING},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"orbit", required_argument, NULL, ORBIT},
                                            {"video", required_argument, NULL, VIDEO},
                                            {"rate", required_argument, NULL, RATE},
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
            if (!ffp_cli_drawing(argv[0], optarg, &arguments->pictures.drawing)) return FFP_EXIT_USAGE;
            break;
        case SAMPLES:
            if (!ffp_cli_samples(argv[0], optarg, &arguments->pictures.drawing)) return FFP_EXIT_USAGE;
            break;
        case ORBIT:
            if (set_orbit(&arguments->pictures, optarg)) break;
            return ffp_cli_usage(
                argv[0], "--orbit is camera, projector or object and 1 to %d frames (object,90), not %s",
                FRAMES_MAX, optarg);
        case VIDEO:
            arguments->pictures.video = optarg;
            break;
        case RATE:
            if (!ffp_cli_number(optarg, 1, 1000, &number))
                return ffp_cli_usage(argv[0], "--rate is a number from 1 to 1000, not %s", optarg);
            arguments->pictures.rate = (int)number;
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    return check(argc, argv, arguments, views);
}

int ffp_cli_render(int argc, char **argv) {
    Arguments arguments = {.pictures.rate = 15};
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
