#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"

enum { FRAMES_MAX = 9999, SIDE_MAX = 16384 };

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpList views, patterns;
    FfpPictures pictures;
    int up;
} Arguments;

static int check(const Arguments *arguments) {
    const FfpPictures *pictures = &arguments->pictures;
    if (pictures->orbit != FFP_ORBIT_NONE && pictures->n_views > 1)
        return ffp_cli_usage("render", "--orbit takes at most one --view");
    if (!arguments->capture && !pictures->poses)
        return ffp_cli_usage("render", "--capture CAPTURE or --poses FILE is missing");
    if (pictures->maps && (pictures->orbit != FFP_ORBIT_NONE || pictures->video))
        return ffp_cli_usage("render", "--maps cannot be combined with --orbit or --video");
    return -1;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpPictures *pictures = &arguments->pictures;
    FfpError err = {0};
    int written = -1;
    pictures->views = arguments->views.values;
    pictures->n_views = arguments->views.count;
    pictures->patterns = arguments->patterns.values;
    pictures->n_patterns = arguments->patterns.count;
    if (check(arguments) >= 0) return FFP_EXIT_USAGE;
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err);
    const bool with = arguments->capture != NULL;
    const bool sphere = pictures->orbit != FFP_ORBIT_NONE; // that the orbit leads around
    FfpCapture *capture = gaussians && with ? ffp_cli_open_devices(arguments->capture, sphere, &err) : NULL;
    const bool turned =
        capture && ffp_cli_turn(gaussians, arguments->gaussians, capture, arguments->up, &err);
    if (gaussians && (turned || !with))
        written = ffp_render_pictures(ffp_cli_context(), gaussians, capture, pictures, &err);
    if (written >= 0) printf("%s: %d picture%s\n", pictures->folder, written, FFP_CLI_S(written));
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return written >= 0 ? FFP_EXIT_OK : ffp_cli_fail_patterns(&err, &arguments->patterns);
}

// "camera,90"
static bool read_orbit(const char *text, void *destination) {
    static const char *const names[] = {
        [FFP_ORBIT_CAMERA] = "camera,", [FFP_ORBIT_PROJECTOR] = "projector,", [FFP_ORBIT_OBJECT] = "object,"};
    FfpPictures *pictures = destination;
    for (int orbit = FFP_ORBIT_CAMERA; orbit <= FFP_ORBIT_OBJECT; orbit++) {
        const size_t length = strlen(names[orbit]);
        int64_t frames;
        if (strncmp(text, names[orbit], length) != 0 ||
            !ffp_cli_number(text + length, 1, FRAMES_MAX, &frames))
            continue;
        pictures->orbit = (FfpOrbit)orbit;
        pictures->frames = (int)frames;
        return true;
    }
    return false;
}

// "640" or "640x480"
static bool read_size(const char *text, void *destination) {
    FfpPictures *pictures = destination;
    char first[16] = "";
    const size_t length = strcspn(text, "x");
    int64_t width, height = 0;
    if (length >= sizeof first) return false;
    memcpy(first, text, length);
    if (!ffp_cli_number(first, 1, SIDE_MAX, &width)) return false;
    if (text[length] && !ffp_cli_number(text + length + 1, 1, SIDE_MAX, &height)) return false;
    pictures->width = (int)width;
    pictures->height = (int)height;
    return true;
}

// "7.96" or "7,8,9"
static bool read_intensity(const char *text, void *destination) {
    FfpPictures *pictures = destination;
    double *rgb = pictures->intensity;
    int n = 0;
    const char *end = NULL;
    for (const char *at = text; n < 3; at = end + 1) {
        rgb[n] = ffp_cli_decimal(at, &end);
        if (!(rgb[n++] > 0) || (*end && *end != ',')) return false;
        if (!*end) break;
    }
    if (*end || n == 2) return false;
    if (n == 1) rgb[1] = rgb[2] = rgb[0];
    return true;
}

static void set_defaults(void *data) {
    ((Arguments *)data)->pictures = ffp_pictures_defaults();
}

static const FfpOption options[] = {
    {.name = "capture",
     .letter = 'c',
     .argument = "CAPTURE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, capture),
     .help =
         "the capture that the Gaussians come from: poses, patterns, the projector's intensity. May be "
         "omitted if --poses is given: the projector's size and intensity and named patterns then come from "
         "that file (or from the first --pattern FILE, and --intensity); photographs are not needed"},
    FFP_CLI_FOLDER(offsetof(Arguments, pictures.folder), "folder for the pictures"),
    FFP_CLI_POSES(offsetof(Arguments, pictures.poses)),
    FFP_CLI_VIEWS(offsetof(Arguments, views),
                  "view to draw; may be repeated. Default: all views of the poses"),
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME|FILE|FOLDER|FILM",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, patterns),
     .help =
         "a pattern of the capture (by name), an image file, a folder of images, taken in the order "
         "of their names, or a film (FILM@FROM-TO: that part, in seconds), of which --rate frames a second "
         "are taken, by ffmpeg; may be repeated. Default: white"},
    FFP_CLI_FRAMING(offsetof(Arguments, pictures.framing), "image files"),
    {.name = "maps",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, pictures.maps),
     .help = "also write the G-buffers: <view>_depth.exr (camera z) and viewable PNGs of opacity, depth, "
             "normal, albedo, roughness and ambient"},
    {.name = "size",
     .argument = "W[xH]",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, pictures),
     .parse = read_size,
     .takes = "W or WxH pixels, 1 to 16384 each",
     .help = "size of the pictures. W alone scales them; an aspect ratio other than the camera's shows more "
             "or less above and below. Default: the camera's size"},
    {.name = "intensity",
     .argument = "I|R,G,B",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, pictures),
     .parse = read_intensity,
     .takes = "one number, or three separated by commas",
     .help = "the projector's radiant intensity at pattern value 1, as printed by `ffprocams info CAPTURE`. "
             "Default: that of the capture or of --poses"},
    FFP_CLI_UP(offsetof(Arguments, up)),
    FFP_CLI_DRAWING(offsetof(Arguments, pictures.drawing.form), FFP_CLI_FORM_HELP),
    FFP_CLI_SAMPLES(offsetof(Arguments, pictures.drawing.samples), FFP_CLI_SAMPLES_HELP),
    {.name = "orbit",
     .argument = "WHAT,N",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, pictures),
     .parse = read_orbit,
     .takes = "camera, projector or object and 1 to 9999 frames (object,90)",
     .words = (const FfpWord[]){{"camera,", 0}, {"projector,", 0}, {"object,", 0}, {0}},
     .group = "films",
     .help = "N frames, DIR/frame_0000.png and so on, of one full turn of camera, projector or object, "
             "starting from the given view (or the first); several patterns divide the turn evenly"},
    {.name = "video",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, pictures.video),
     .group = "films",
     .help = "also write all pictures, in order, as one video. The extension selects its format: .png or "
             ".apng, an animated PNG; .gif, .mp4, .webm or .mkv, encoded by ffmpeg, which must be installed. "
             "Without --orbit: every view under every pattern"},
    {.name = "rate",
     .needs = "video",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, pictures.rate),
     .low = 1,
     .high = 1000,
     .group = "films",
     .help = "frames per second of the video. Default: 15"},
    {0},
};

const FfpCommand ffp_cli_render = {
    .name = "render",
    .group = FFP_CLI_LOOK,
    .purpose = "renders Gaussians as a camera sees them under projected patterns",
    .prose = "Writes DIR/<view>_<pattern>.png, 8-bit sRGB over black. Each view is rasterised once for all "
             "patterns.",
    .positional = FFP_CLI_GAUSSIANS(offsetof(Arguments, gaussians)),
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams render spot.ply --capture data/sample --pattern data/sun.png -o relit\n"
                        "ffprocams render spot.ply --capture data/sample --poses "
                        "data/sample/targets.json -o new\n"
                        "ffprocams render spot.ply --capture data/sample --pattern data/sun.png \\\n"
                        "    --orbit object,90 -o frames --video turn.png"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
