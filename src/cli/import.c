#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams import --calibration FILE.. [--turntable T] --images NAMES=FILES..\n"
    "                        --pattern NAME=FILE.. -o DIR [OPTIONS]\n"
    "\n"
    "Makes a capture of photographs and of the calibration that you have: poses in the object's frame,\n"
    "lens distortion removed, the background masked. DIR is written whole or not at all; then\n"
    "`ffprocams info DIR` checks it.\n"
    "\n"
    "  -c, --calibration FILE   again where the calibration is in several files. Read are OpenCV "
    "FileStorage\n"
    "                           (YAML, XML, JSON) of procam-calibration, single-shot-pro-cam-calib,\n"
    "                           Moreno-Taubin, Calibrator and OpenCV's samples; params.yml of DeProCams;\n"
    "                           COLMAP's text model (its folder); transforms.json of nepmap; cameras.json\n"
    "                           and projector.json of GS-ProCams\n"
    "      --projector-image N  COLMAP: the image that is the projector. Default: calib\n"
    "  -t, --turntable T        AX,AY,AZ,PX,PY,PZ,ANGLES: the object turned before a fixed camera and\n"
    "                           projector. Direction of the axis and a point of it in camera coordinates\n"
    "                           (x right, y down, z forward, the calibration's unit); degrees by which the\n"
    "                           object had turned, with commas between, or 8x45 for eight steps of 45;\n"
    "                           right-handed about the axis: with the axis up (0,-1,0), anticlockwise as\n"
    "                           seen from above. Or a JSON file {\"axis\": [..], \"point\": [..], "
    "\"angles\":\n"
    "                           [..]} or with \"count\" and \"step\". Without it a fixed rig has one view\n"
    "      --fit-axis[=GUESS]   find the axis from the pictures; --turntable then has the angles alone "
    "(8x45).\n"
    "                           GUESS: AX,AY,AZ,PX,PY,PZ. Reports how certain it is, and refuses what it\n"
    "                           cannot tell: fewer than three angles, an object that is round about many\n"
    "                           axes, silhouettes or patterns that no axis explains. Then fit it on another\n"
    "                           object, or measure it (calibrate a chessboard on the table at several\n"
    "                           angles: its poses turn about the axis), and give it in --turntable\n"
    "  -i, --images NAMES=FILES the photographs under a pattern (black, white, and what you call yours).\n"
    "                           FILES has {view}, {index} (from 0), {number} (from 1), {number:3} (with\n"
    "                           zeros); or *, whose files are taken in order, img_9 before img_10. Several\n"
    "                           names: FILES has {pattern}, or * runs through all names of the first view,\n"
    "                           then of the second. Views of a turntable are called by angle: 000, 045\n"
    "  -p, --pattern NAME=FILE  what the projector showed, as it was sent to it. Black and white need none\n"
    "      --held-out NAME=FILE likewise, but never to be reconstructed from: a test picture\n"
    "  -m, --mask FILES|otsu    the object's silhouettes (white on black), FILES as above; otsu: made from\n"
    "                           white minus black. Default: alpha channels where there are, else otsu\n"
    "      --fit-response       find the projector's gamma, black level and intensity from the pictures, "
    "where\n"
    "                           it does not answer to values as sRGB has it, and turn the patterns into the\n"
    "                           light that was made of them. The pattern needs middling values in all\n"
    "                           channels; where it has none, or depth cannot be matched, that is an error\n"
    "  -v, --view ID            only this view, again for more\n"
    "      --camera-size WxH    pixels at which the camera was calibrated, where its file does not say\n"
    "      --projector-size WxH likewise for the projector\n"
    "      --camera-fit F       photographs are of another size than calibrated: scaled, or crop=X,Y (cut "
    "out,\n"
    "                           their first pixel being X,Y of the calibrated picture)\n"
    "      --projector-fit F    likewise for the patterns\n"
    "  -w, --width W            make the pictures W pixels wide (the shipped model was trained at 128)\n"
    "      --linear WHAT        images, or patterns, again for both: their PNG and JPEG hold linear\n"
    "                           light (raw converters, nepmap), not sRGB\n"
    "      --exposure STOPS     brighten the pictures (linear light): EXR files may leave the range 0 to 1,\n"
    "                           which the capture's 8-bit pictures do not. Default: 0\n"
    "      --object X,Y,Z,R     a sphere around the object, in its frame. Default: from poses and masks\n"
    "      --name NAME          of the capture. Default: that of DIR\n"
    "  -o, --output DIR         the capture's folder; it must be new or empty\n"
    "\n"
    "Projector distortion is removed from the patterns as the camera's is from the photographs: what\n"
    "the capture calls a pattern is what an ideal projector would have shown.\n"
    "\n"
    "procam-calibration (kamino410), eight stops, photographs IMG_0001 to IMG_0024 in the order black,\n"
    "white, lollipop at each stop; the file does not hold the projector's size:\n"
    "  ffprocams import -c calibration_result.xml --projector-size 1024x768 \\\n"
    "      -t 0,-1,0,0,40,600,8x45 -i 'black,white,lollipop=shots/IMG_*.JPG' \\\n"
    "      -p lollipop=lollipop.png -w 160 -o vase\n"
    "single-shot-pro-cam-calib (calib-info.yml beside calibration.yml holds the sizes):\n"
    "  ffprocams import -c calibration.yml -t table.json -i 'black={view}/black.png' \\\n"
    "      -i 'white={view}/white.png' -i 'dots={view}/dots.png' -p dots=dots.png -o vase\n"
    "DeProCams: one view, no turntable; the sizes are not in params.yml:\n"
    "  ffprocams import -c params/params.yml --camera-size 640x480 --projector-size 800x600 \\\n"
    "      -i black=ref/img_0001.png -i white=ref/img_0002.png -i p=train/img_0001.png \\\n"
    "      -p p=patterns/img_0001.png -o flat\n"
    "GS-ProCams, poses from COLMAP, or what it exported (again -c):\n"
    "  ffprocams import -c colmap/sparse/0 -i 'black=views/{view}/cam/raw/ref/img_0001.png' \\\n"
    "      -i 'white=views/{view}/cam/raw/ref/img_0002.png' -i 'p=views/{view}/cam/raw/test/img_0001.png' "
    "\\\n"
    "      -m 'views/{view}/cam/raw/mask/mask.png' -p p=patterns/test/img_0001.png -o bottles\n"
    "nepmap, whose file names pictures and patterns itself, makes the shortest\n"
    "example: ffprocams import -c bunny/transforms.json -o rabbit\n";

typedef struct Lists {
    FfpList calibrations, images, patterns, held_out, views;
} Lists;

static void free_lists(Lists *lists) {
    ffp_cli_list_free(&lists->calibrations);
    ffp_cli_list_free(&lists->images);
    ffp_cli_list_free(&lists->patterns);
    ffp_cli_list_free(&lists->held_out);
    ffp_cli_list_free(&lists->views);
}

// Two whole numbers with `between` between them.
static bool read_pair(const char *text, char between, int64_t low, int *a, int *b) {
    char first[16];
    const char *place = strchr(text, between);
    int64_t x = 0, y = 0;
    if (!place || (size_t)(place - text) >= sizeof first) return false;
    memcpy(first, text, (size_t)(place - text));
    first[place - text] = 0;
    if (!ffp_cli_number(first, low, 1000000, &x) || !ffp_cli_number(place + 1, low, 1000000, &y))
        return false;
    *a = (int)x, *b = (int)y;
    return true;
}

static bool read_fit(const char *text, FfpCalibratedAt *at) {
    at->fit = strcmp(text, "scaled") == 0 ? FFP_FIT_SCALED : FFP_FIT_CROPPED;
    if (at->fit == FFP_FIT_SCALED) return true;
    return strncmp(text, "crop=", 5) == 0 && read_pair(text + 5, ',', 0, &at->left, &at->top);
}

static bool read_linear(const char *text, FfpImport *import) {
    const bool images = strcmp(text, "images") == 0, patterns = strcmp(text, "patterns") == 0;
    import->linear_images |= images, import->linear_patterns |= patterns;
    return images || patterns;
}

// X,Y,Z,R
static bool read_sphere(const char *text, double sphere[4]) {
    const char *at = text;
    for (int i = 0; i < 4; i++) {
        char *end;
        sphere[i] = strtod(at, &end);
        if (end == at || !isfinite(sphere[i]) || *end != (i < 3 ? ',' : 0)) return false;
        at = end + 1;
    }
    return sphere[3] > 0;
}

enum {
    PROJECTOR_IMAGE = 256,
    FIT_AXIS,
    FIT_RESPONSE,
    HELD_OUT,
    CAMERA_SIZE,
    PROJECTOR_SIZE,
    CAMERA_FIT,
    PROJECTOR_FIT,
    LINEAR,
    EXPOSURE,
    OBJECT,
    NAME
};

// Options whose value is checked at once; false when it is wrong.
static bool take_checked(int option, const char *text, FfpImport *import) {
    int64_t width = 0;
    switch (option) {
    case CAMERA_SIZE:
        return read_pair(text, 'x', 1, &import->camera.width, &import->camera.height);
    case PROJECTOR_SIZE:
        return read_pair(text, 'x', 1, &import->projector.width, &import->projector.height);
    case CAMERA_FIT:
        return read_fit(text, &import->camera);
    case PROJECTOR_FIT:
        return read_fit(text, &import->projector);
    case LINEAR:
        return read_linear(text, import);
    case EXPOSURE:
        return ffp_cli_real(text, -32, 32, &import->exposure);
    case OBJECT:
        return read_sphere(text, import->object);
    default:
        if (!ffp_cli_number(text, 8, 16384, &width)) return false;
        import->width = (int)width;
        return true;
    }
}

// Options that are text; false when this is none of them.
static bool take_text(int option, const char *text, FfpImport *import, Lists *lists) {
    static const char letters[] = "cipv";
    FfpList *const several[] = {&lists->calibrations, &lists->images, &lists->patterns, &lists->views};
    const char *letter = option < 256 ? strchr(letters, option) : NULL;
    if (letter)
        ffp_cli_append(several[letter - letters], text);
    else if (option == HELD_OUT)
        ffp_cli_append(&lists->held_out, text);
    else if (option == PROJECTOR_IMAGE)
        import->projector_image = text;
    else if (option == 't')
        import->turntable = text;
    else if (option == FIT_AXIS)
        import->fit_axis = text != NULL ? text : "";
    else if (option == FIT_RESPONSE)
        import->fit_response = true;
    else if (option == 'm')
        import->mask = text;
    else if (option == NAME)
        import->name = text;
    else if (option == 'o')
        import->folder = text;
    else
        return false;
    return true;
}

// -1 to go on, else the exit code.
static int parse(int argc, char **argv, FfpImport *import, Lists *lists) {
    static const struct option options[] = {{"calibration", required_argument, NULL, 'c'},
                                            {"projector-image", required_argument, NULL, PROJECTOR_IMAGE},
                                            {"turntable", required_argument, NULL, 't'},
                                            {"fit-axis", optional_argument, NULL, FIT_AXIS},
                                            {"fit-response", no_argument, NULL, FIT_RESPONSE},
                                            {"images", required_argument, NULL, 'i'},
                                            {"pattern", required_argument, NULL, 'p'},
                                            {"held-out", required_argument, NULL, HELD_OUT},
                                            {"mask", required_argument, NULL, 'm'},
                                            {"view", required_argument, NULL, 'v'},
                                            {"camera-size", required_argument, NULL, CAMERA_SIZE},
                                            {"projector-size", required_argument, NULL, PROJECTOR_SIZE},
                                            {"camera-fit", required_argument, NULL, CAMERA_FIT},
                                            {"projector-fit", required_argument, NULL, PROJECTOR_FIT},
                                            {"width", required_argument, NULL, 'w'},
                                            {"linear", required_argument, NULL, LINEAR},
                                            {"exposure", required_argument, NULL, EXPOSURE},
                                            {"object", required_argument, NULL, OBJECT},
                                            {"name", required_argument, NULL, NAME},
                                            {"output", required_argument, NULL, 'o'},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    for (int option; (option = ffp_cli_next(argc, argv, ":c:t:i:p:m:v:w:o:h", options)) != -1;) {
        if (option == 0) return FFP_EXIT_USAGE;
        if (option == 'h') {
            fputs(help, stdout);
            return FFP_EXIT_OK;
        }
        if (!take_text(option, optarg, import, lists) && !take_checked(option, optarg, import))
            return ffp_cli_usage(argv[0], "%s is not what %s takes", optarg, argv[optind - 2]);
    }
    if (optind < argc) return ffp_cli_usage(argv[0], "%s is no option: --images NAMES=FILES?", argv[optind]);
    if (!lists->calibrations.count) return ffp_cli_usage(argv[0], "give --calibration FILE");
    if (!import->folder) return ffp_cli_usage(argv[0], "give -o DIR");
    return -1;
}

int ffp_cli_import(int argc, char **argv) {
    FfpImport import = {0};
    Lists lists = {0};
    int status = parse(argc, argv, &import, &lists);
    if (status < 0) {
        FfpError err = {0};
        import.calibrations = lists.calibrations.values, import.n_calibrations = lists.calibrations.count;
        import.images = lists.images.values, import.n_images = lists.images.count;
        import.patterns = lists.patterns.values, import.n_patterns = lists.patterns.count;
        import.held_out = lists.held_out.values, import.n_held_out = lists.held_out.count;
        import.views = lists.views.values, import.n_views = lists.views.count;
        const bool ok = ffp_import_capture(&import, &err);
        if (ok) printf("%s: now ffprocams info %s\n", import.folder, import.folder);
        status = ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
    }
    free_lists(&lists);
    return status;
}
