#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"
#include "import_text.h"

typedef struct Arguments {
    FfpList calibrations, images, empty, patterns, held_out, views;
    FfpAngles angles;
    const char *turntable, *fit_axis, *mask; // NULL: not given
    FfpImport import;
} Arguments;

static void set_defaults(void *data) {
    ((Arguments *)data)->import = ffp_import_defaults();
}

static void set_masks(FfpImport *import, const char *text) {
    const bool files = strcmp(text, "otsu") != 0;
    import->masks = files ? FFP_MASKS_FROM_FILES : FFP_MASKS_FROM_LIGHT;
    import->mask_files = files ? text : NULL;
}

// The texts of all options as what the library takes.
static bool read_texts(Arguments *arguments, FfpImportLists *read, FfpError *err) {
    FfpImport *import = &arguments->import;
    for (int i = 0; i < arguments->images.count; i++)
        if (!ffp_cli_add_images(read, arguments->images.values[i], import->shown != NULL, err)) return false;
    for (int i = 0; i < arguments->empty.count; i++)
        if (!ffp_cli_add_empty(read, arguments->empty.values[i], err)) return false;
    for (int i = 0; i < arguments->patterns.count; i++)
        if (!ffp_cli_add_pattern(read, arguments->patterns.values[i], false, err)) return false;
    for (int i = 0; i < arguments->held_out.count; i++)
        if (!ffp_cli_add_pattern(read, arguments->held_out.values[i], true, err)) return false;
    if (arguments->fit_axis && !ffp_cli_fit_axis(arguments->fit_axis, &import->turntable, err)) return false;
    import->turntable.angles = arguments->angles.degrees;
    import->turntable.n_angles = arguments->angles.count;
    if (arguments->turntable && !ffp_cli_turntable(read, arguments->turntable, &import->turntable, err))
        return false;
    if (arguments->mask) set_masks(import, arguments->mask);
    import->calibrations = arguments->calibrations.values;
    import->n_calibrations = arguments->calibrations.count;
    import->images = read->images;
    import->n_images = read->n_images;
    import->empty = read->empty;
    import->n_empty = read->n_empty;
    import->patterns = read->patterns;
    import->n_patterns = read->n_patterns;
    import->held_out = read->held_out;
    import->n_held_out = read->n_held_out;
    import->views = arguments->views.values;
    import->n_views = arguments->views.count;
    return true;
}

static int run(void *data) {
    Arguments *arguments = data;
    const FfpImport *import = &arguments->import;
    FfpImportLists read = {0};
    FfpError err = {0};
    const bool ok = read_texts(arguments, &read, &err) && ffp_import_capture(ffp_cli_context(), import, &err);
    ffp_cli_import_lists_free(&read);
    if (ok) {
        printf("%s: now run ffprocams info %s\n", import->folder, import->folder);
        return FFP_EXIT_OK;
    }
    const int status = ffp_cli_fail_patterns(&err, &arguments->patterns);
    const char *option = err.finding ? NULL : ffp_cli_import_option(&err); // a finding says what to do
    if (option) fprintf(stderr, "ffprocams: for %s see: ffprocams import --help\n", option);
    return status;
}

static bool read_size(const char *text, void *destination) {
    FfpCalibratedAt *at = destination;
    return ffp_cli_pair(text, 'x', 1, &at->width, &at->height);
}

static bool read_angles(const char *text, void *destination) {
    const char *where;
    return !ffp_cli_angles(text, destination, &where);
}

static bool read_fit(const char *text, void *destination) {
    FfpCalibratedAt *at = destination;
    at->fit = strcmp(text, "scaled") == 0 ? FFP_FIT_SCALED : FFP_FIT_CROPPED;
    if (at->fit == FFP_FIT_SCALED) return true;
    return strncmp(text, "crop=", 5) == 0 && ffp_cli_pair(text + 5, ',', 0, &at->left, &at->top);
}

static bool read_linear(const char *text, void *destination) {
    FfpImport *import = destination;
    const bool images = strcmp(text, "images") == 0, patterns = strcmp(text, "patterns") == 0;
    import->linear_images |= images;
    import->linear_patterns |= patterns;
    return images || patterns;
}

// X,Y,Z,R
static bool read_sphere(const char *text, void *destination) {
    double *sphere = destination;
    const char *at = text;
    for (int i = 0; i < 4; i++) {
        const char *end;
        sphere[i] = ffp_cli_decimal(at, &end);
        if (isnan(sphere[i]) || *end != (i < 3 ? ',' : 0)) return false;
        at = end + 1;
    }
    return sphere[3] > 0;
}

#define CALIBRATION "calibration"
#define TURNTABLE "turntable"
#define PHOTOGRAPHS "photographs and patterns"
#define RESULT "the capture"

static const FfpOption options[] = {
    {.name = "calibration",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .required = true,
     .offset = offsetof(Arguments, calibrations),
     .group = CALIBRATION,
     .help = "the calibration; may be repeated if it is in several files. Supported: OpenCV FileStorage "
             "(YAML, XML, JSON) from `ffprocams calibrate`, procam-calibration, single-shot-pro-cam-calib, "
             "Moreno-Taubin, Calibrator, SLStudio, ROS, Kalibr and OpenCV's samples; params.yml of "
             "DeProCams; COLMAP's text model "
             "(its folder); transforms.json of nepmap; cameras.json and projector.json of GS-ProCams"},
    {.name = "projector-image",
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, import.projector_image),
     .group = CALIBRATION,
     .help = "COLMAP: the image that is the projector. Default: calib"},
    {.name = "camera-size",
     .argument = "WxH",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, import.camera),
     .parse = read_size,
     .takes = "width x height in pixels (1024x768)",
     .group = CALIBRATION,
     .help = "image size at which the camera was calibrated, if its file does not say"},
    {.name = "projector-size",
     .argument = "WxH",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, import.projector),
     .parse = read_size,
     .takes = "width x height in pixels (1024x768)",
     .group = CALIBRATION,
     .help = "likewise for the projector"},
    {.name = "other-projector",
     .type = FFP_OPTION_FLAG,
     .needs = "projector-size",
     .offset = offsetof(Arguments, import.other_projector),
     .group = CALIBRATION,
     .help =
         "the photographs show the light of another projector than the calibration's, of "
         "--projector-size: `align --second-projector` then finds its place and lens from its Gray codes"},
    {.name = "camera-fit",
     .argument = "FIT",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, import.camera),
     .parse = read_fit,
     .takes = "scaled or crop=X,Y",
     .words = (const FfpWord[]){{"scaled", 0}, {"crop=", 0}, {0}},
     .group = CALIBRATION,
     .help = "how photographs of a different size relate to the calibrated picture: scaled, or crop=X,Y (cut "
             "out, where their first pixel is X,Y of the calibrated picture)"},
    {.name = "projector-fit",
     .argument = "FIT",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, import.projector),
     .parse = read_fit,
     .takes = "scaled or crop=X,Y",
     .words = (const FfpWord[]){{"scaled", 0}, {"crop=", 0}, {0}},
     .group = CALIBRATION,
     .help = "likewise for the patterns"},
    {.name = "turntable",
     .letter = 't',
     .argument = "T",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, turntable),
     .group = TURNTABLE,
     .help =
         "AX,AY,AZ,PX,PY,PZ,ANGLES: the object turned in front of a fixed camera and projector. "
         "Direction of the axis and a point on it in camera coordinates (x right, y down, z forward, the "
         "calibration's unit); rotation angles of the object in degrees, separated by commas, or 8x45 "
         "for eight steps of 45; right-handed about the axis: with the axis up (0,-1,0), anticlockwise "
         "as seen from above. Or a JSON file {\"axis\": [..], \"point\": [..], \"angles\": [..]}, or "
         "with \"count\" and \"step\" instead of angles, or that of `ffprocams calibrate`: of a board, with "
         "--angles; without a board it has angles and views. Without -t a fixed rig has one view"},
    {.name = "angles",
     .argument = "ANGLES",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, angles),
     .parse = read_angles,
     .takes = "up to 512 angles in degrees, separated by commas, or 8x45 for eight steps of 45",
     .group = TURNTABLE,
     .help =
         "angles of the turntable at the object's stops, in degrees: 0,45,90 or 8x45; they replace those of "
         "--turntable's file. After `ffprocams calibrate` they count as its angles did, clockwise or not"},
    {.name = "fit-axis",
     .argument = "GUESS",
     .type = FFP_OPTION_TEXT,
     .optional_value = true,
     .offset = offsetof(Arguments, fit_axis),
     .group = TURNTABLE,
     .help =
         "find the axis from the pictures; --turntable then gives only the angles (8x45). GUESS: "
         "AX,AY,AZ,PX,PY,PZ. Reports the uncertainty, and fails where the axis cannot be determined: with "
         "fewer than three angles, an object that is symmetric about many axes, or silhouettes or patterns "
         "that no axis explains. In that case fit it on another object, or measure it (`ffprocams calibrate "
         "--turntable-board`: a chessboard on the table at several angles), and pass it in --turntable"},
    {.name = "shown",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, import.shown),
     .group = PHOTOGRAPHS,
     .help = "folder of `ffprocams patterns`: --images FILES, without names, are then the photographs of its "
             "patterns in their order, with the Gray codes or without, and --pattern is not needed. Other "
             "usual orders of codes are found from the pictures; black and white may be missing, and are "
             "then made from the codes"},
    {.name = "images",
     .letter = 'i',
     .argument = "[NAMES=]FILES",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, images),
     .group = PHOTOGRAPHS,
     .help = "the photographs under a pattern (black, white, and your own names). FILES contains {view}, "
             "{index} (from 0, among all views, selected or not), {number} (from 1), {number:3} "
             "(zero-padded) and, for several names, {pattern}; or *, or both. * matches the remaining files "
             "in order, img_9 before img_10: all patterns of the first view, then those of the second. Views "
             "of a turntable are named by angle: 000, 045. Raw photographs are developed (by dcraw_emu). A "
             "video stands for the mean of its frames, VIDEO@3-4.5 for those between two times in seconds, "
             "VIDEO@3 for a single frame (by ffmpeg); name videos with {number} or the like, not with *"},
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME=FILE",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, patterns),
     .group = PHOTOGRAPHS,
     .help = "the image sent to the projector for this pattern. Not needed for black and white"},
    {.name = "held-out",
     .argument = "NAME=FILE",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, held_out),
     .group = PHOTOGRAPHS,
     .help = "likewise, but for testing only, never reconstructed from"},
    {.name = "graycode",
     .letter = 'g',
     .argument = "FILES",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, import.gray_codes),
     .group = PHOTOGRAPHS,
     .help = "photographs of the Gray codes of `ffprocams patterns`, in the order shown: columns before "
             "rows, coarsest first, each followed by its inverse, or in another usual order. FILES as above; "
             "{pattern} is gray_x_00, gray_x_00_inverse and so on. Where codes can be decoded, depth is "
             "exact and needs no matching. "
             "Without any other pattern, one of the codes becomes the capture's pattern"},
    {.name = "keep-codes",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, import.kept_codes),
     .low = 0,
     .high = 32,
     .group = PHOTOGRAPHS,
     .help = "of the photographs of Gray codes, keep N of each view in the capture for fits: of codes whose "
             "stripes its pixels resolve, without those that are the same as another pattern or its inverse. "
             "If nothing is held out, two more codes are, by which reconstructions are judged. "
             "Default: 8; 0: none"},
    {.name = "empty",
     .argument = "NAMES=FILES",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, empty),
     .group = PHOTOGRAPHS,
     .help =
         "the stage without the object, under black, white and, better, every other pattern: a photograph "
         "each, which serves all stops of a turntable ({view} if the camera moves). What looks like it "
         "is background, and no masks are needed in a lit room"},
    {.name = "mask",
     .letter = 'm',
     .argument = "FILES|otsu",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, mask),
     .words = (const FfpWord[]){{"otsu", 0}, {0}},
     .group = PHOTOGRAPHS,
     .help =
         "the object's silhouettes (white on black), FILES as above; otsu: made from the photographs: "
         "in the dark from all light, otherwise from white minus black (Otsu 1979) and, with four or more "
         "views, completed where the projector does not reach. Default: alpha channels if present, "
         "otherwise otsu"},
    {.name = "linear",
     .argument = "WHAT",
     .type = FFP_OPTION_PARSED,
     .repeated = true,
     .offset = offsetof(Arguments, import),
     .parse = read_linear,
     .takes = "images or patterns",
     .words = (const FfpWord[]){{"images", 0}, {"patterns", 0}, {0}},
     .group = PHOTOGRAPHS,
     .help = "images or patterns, repeat for both: their PNG and JPEG files hold linear light (raw "
             "converters, nepmap) rather than sRGB"},
    {.name = "exposure",
     .argument = "STOPS",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, import.exposure),
     .least = -32,
     .most = 32,
     .group = PHOTOGRAPHS,
     .help = "exposure adjustment of linear pictures, in stops: EXR values may exceed the range 0 to 1, the "
             "capture's 8-bit pictures cannot. Default: 0"},
    {.name = "scene",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, import.scene),
     .group = PHOTOGRAPHS,
     .help =
         "a whole scene, such as a stage, a room or a facade, before which the projector stands and the "
         "camera "
         "walks: everything in view belongs to it, lit or not. There are no masks and no turntable; depth "
         "is found from the pattern and, where no projector reaches, from the photographs of neighbouring "
         "views, so keep them within some 15 degrees of each other"},
    {.name = "fit-response",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, import.fit_response),
     .group = PHOTOGRAPHS,
     .help =
         "estimate the projector's gamma, black level and intensity from the pictures, for a projector "
         "that does not follow sRGB, and convert the patterns to the light that it actually emitted. "
         "Kept only if the pattern then explains every other view better, which has no part in the estimate. "
         "Fails if the pattern lacks mid-range values in some channel or if depth cannot be matched"},
    {.name = "output",
     .letter = 'o',
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .required = true,
     .offset = offsetof(Arguments, import.folder),
     .group = RESULT,
     .help = "folder for the capture; it must be new or empty"},
    {.name = "view",
     .letter = 'v',
     .argument = "ID",
     .type = FFP_OPTION_TEXT,
     .repeated = true,
     .offset = offsetof(Arguments, views),
     .group = RESULT,
     .help = "import only this view; may be repeated"},
    {.name = "width",
     .letter = 'w',
     .argument = "W",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, import.width),
     .low = 8,
     .high = 16384,
     .group = RESULT,
     .help =
         "make the pictures W pixels wide; 128 is the paper's protocol, at which the shipped model was "
         "trained. Default: as fine as the photographs show the object, as long as its longer side has at "
         "most 1024 pixels, all views show two million of its pixels, half of the free memory suffices and a "
         "reconstruction takes three minutes; "
         "and cut to the object if that halves them. Both sides are padded to multiples of 8 pixels"},
    {.name = "object",
     .argument = "X,Y,Z,R",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, import.object),
     .parse = read_sphere,
     .takes = "X,Y,Z,R with a radius above 0",
     .group = RESULT,
     .help = "sphere around the object, in the object's frame. Default: derived from poses and masks"},
    {.name = "name",
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, import.name),
     .group = RESULT,
     .help = "name of the capture. Default: that of DIR"},
    {0},
};

static const FfpExample examples[] = {
    {"`calibrate` and the photographs that `patterns` lists, eight stops in shots/view-000 to view-315:",
     "ffprocams import -c calibration.xml -t axis.json --angles 8x45 --shown patterns \\\n"
     "    -i 'shots/view-{view}/*.JPG' -o vase"},
    {"procam-calibration (kamino410), eight stops, photographs IMG_0001 to IMG_0024 in the order black, "
     "white, lollipop at each stop; the file lacks the projector's size:",
     "ffprocams import -c calibration_result.xml --projector-size 1024x768 \\\n"
     "    -t 0,-1,0,0,40,600,8x45 -i 'black,white,lollipop=shots/IMG_*.JPG' \\\n"
     "    -p lollipop=lollipop.png -w 160 -o vase"},
    {"single-shot-pro-cam-calib (the sizes are in calib-info.yml beside calibration.yml):",
     "ffprocams import -c calibration.yml -t table.json -i 'black={view}/black.png' \\\n"
     "    -i 'white={view}/white.png' -i 'dots={view}/dots.png' -p dots=dots.png -o vase"},
    {"DeProCams: one view, no turntable; the sizes are not in params.yml:",
     "ffprocams import -c params/params.yml --camera-size 640x480 --projector-size 800x600 \\\n"
     "    -i black=ref/img_0001.png -i white=ref/img_0002.png -i p=train/img_0001.png \\\n"
     "    -p p=patterns/img_0001.png -o flat"},
    {"GS-ProCams, with poses from COLMAP (or from its own export, also with -c):",
     "ffprocams import -c colmap/sparse/0 -i 'black=views/{view}/cam/raw/ref/img_0001.png' \\\n"
     "    -i 'white=views/{view}/cam/raw/ref/img_0002.png' \\\n"
     "    -i 'p=views/{view}/cam/raw/test/img_0001.png' \\\n"
     "    -m 'views/{view}/cam/raw/mask/mask.png' -p p=patterns/test/img_0001.png -o bottles"},
    {"nepmap, whose file already names pictures and patterns:",
     "ffprocams import -c bunny/transforms.json -o rabbit"},
    {0},
};

const FfpCommand ffp_cli_import = {
    .name = "import",
    .group = FFP_CLI_CAPTURE,
    .purpose = "makes a capture from photographs and a calibration",
    .prose = "Transforms poses to the object's frame, removes lens distortion and masks the background. DIR "
             "is written completely or not at all; `ffprocams info DIR` then checks it.",
    .positional = {.excess = "--images NAMES=FILES?"},
    .options = options,
    .epilogue = "Lens distortion is removed from the patterns as it is from the photographs: the patterns of "
                "the capture are those that a distortion-free projector would have shown.",
    .examples = examples,
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
