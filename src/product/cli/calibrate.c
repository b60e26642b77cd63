#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"
#include "scan_names.h"

#define DOUBTFUL 1.0 // pixels of root mean square

typedef struct Arguments {
    FfpList attitudes, calibrations;
    FfpAngles angles;
    FfpRigCalibration rig;
    bool json, without_board, camera_per_folder;
    double focal_35mm, length;
} Arguments;

static void set_defaults(void *data) {
    FfpRigCalibration *rig = &((Arguments *)data)->rig;
    *rig = ffp_rig_calibration_defaults();
    rig->width = rig->height = 0; // not given
}

static bool read_board(const char *text, void *destination) {
    FfpRigCalibration *rig = destination;
    return ffp_cli_pair(text, 'x', 1, &rig->columns, &rig->rows);
}

static bool read_size(const char *text, void *destination) {
    FfpRigCalibration *rig = destination;
    return ffp_cli_pair(text, 'x', 1, &rig->width, &rig->height);
}

static const FfpWord terms[] = {{"k1", FFP_FIX_K1},
                                {"k2", FFP_FIX_K2},
                                {"k3", FFP_FIX_K3},
                                {"p", FFP_FIX_TANGENTIAL},
                                {"centre", FFP_FIX_CENTRE},
                                {"aspect", FFP_FIX_ASPECT},
                                {0}};

// [camera.|projector.]TERM
static bool read_fix(const char *text, void *destination) {
    FfpRigCalibration *rig = destination;
    const bool camera = strncmp(text, "camera.", 7) == 0, projector = strncmp(text, "projector.", 10) == 0;
    const char *term = text + (camera ? 7 : projector ? 10 : 0);
    for (const FfpWord *word = terms; word->name; word++) {
        if (strcmp(word->name, term) != 0) continue;
        if (!projector) rig->fix_camera |= (unsigned)word->value;
        if (!camera) rig->fix_projector |= (unsigned)word->value;
        return true;
    }
    return false;
}

static bool read_angles(const char *text, void *destination) {
    const char *where;
    return !ffp_cli_angles(text, destination, &where);
}

static void print_rig(const FfpRigCalibration *rig, const FfpRigCalibrationStats *s) {
    printf("%s: %d of %d attitudes, rms %.3f pixels (camera alone %.3f, projector alone %.3f), %d of %d "
           "corners left "
           "out\n",
           rig->file, s->used, s->attitudes, s->both, s->camera, s->projector, s->left_out, s->corners);
    if (rig->report) printf("%s: check this report before you go on\n", rig->report);
}

static void print_axis(const FfpRigCalibration *rig, const FfpRigCalibrationStats *s) {
    printf("turntable: %d of %d photographs, rms %.3f pixels; axis uncertainty %.3f degrees and %.3g units, "
           "the camera's included\n",
           s->stops_used, s->stops, s->stops_rms, s->tilt, s->shift);
    printf("the axis points along %.6f,%.6f,%.6f through %.6g,%.6g,%.6g; the table turned %sclockwise as "
           "seen from "
           "above\n",
           s->axis[0], s->axis[1], s->axis[2], s->point[0], s->point[1], s->point[2],
           s->reversed ? "" : "anti");
    if (rig->turntable_file)
        printf("%s: import with -t %s --angles ANGLES (those of the object's stops: 8x45)\n",
               rig->turntable_file, rig->turntable_file);
}

// Takes the object.
static void put_json(json_t *all) {
    json_object_set(all, "findings", ffp_cli_keep_findings());
    json_dumpf(all, stdout, JSON_INDENT(1) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(all);
}

// With --json the findings are there though nothing was made.
static int fail(bool json, const FfpError *err) {
    const int status = ffp_cli_fail(err);
    if (!json) return status;
    json_t *all = json_pack("{s:s}", "error", err->text);
    put_json(all ? all : json_object()); // a path that is no UTF-8
    return status;
}

// All that the other two print, and what was found.
static void print_json(const FfpRigCalibration *rig, const FfpRigCalibrationStats *s) {
    json_t *all = json_pack("{s:s?, s:i, s:i, s:f, s:f, s:f, s:i, s:i}", "file", rig->file, "attitudes",
                            s->attitudes, "used", s->used, "rms", s->both, "camera_rms", s->camera,
                            "projector_rms", s->projector, "corners", s->corners, "left_out", s->left_out);
    if (all && s->has_axis)
        json_object_set_new(all, "turntable",
                            json_pack("{s:[fff], s:[fff], s:b, s:i, s:i, s:f, s:f, s:f}", "axis", s->axis[0],
                                      s->axis[1], s->axis[2], "point", s->point[0], s->point[1], s->point[2],
                                      "clockwise", s->reversed, "stops", s->stops, "used", s->stops_used,
                                      "rms", s->stops_rms, "tilt", s->tilt, "shift", s->shift));
    put_json(all);
}

// A panel's size that nobody gave is the first thing to doubt where things do not fit.
static void tell_default(const FfpRigCalibration *rig) {
    fprintf(stderr, "ffprocams: no --projector given: assuming the default panel size, %d x %d\n", rig->width,
            rig->height);
}

// --- Without a board. ---

// The part of a path, the k-th from its end, by which places are told apart; its length, 0: there is none.
static int part_of(const char *path, int k, const char **part) {
    const char *end = path + strlen(path), *at = end;
    for (int i = 0; i <= k; i++) {
        end = at;
        while (end > path && end[-1] == '/') end--;
        at = end;
        while (at > path && at[-1] != '/') at--;
    }
    *part = at;
    return (int)(end - at);
}

// Template of the photographs, where the places' paths differ in one part alone; false: they do not.
static bool put_template(const FfpSelfCalibration *o, char text[FFP_CLI_PATH]) {
    const char *first = o->places[0], *part, *other;
    int length = (int)strlen(first);
    while (length > 1 && first[length - 1] == '/') length--;
    snprintf(text, FFP_CLI_PATH, "%.*s/{view}/*", length, first);
    for (int k = 0; k < 8 && o->n_places > 1; k++) {
        const int own = part_of(first, k, &part);
        bool alike = own > 0;
        for (int i = 1; alike && i < o->n_places; i++) {
            const int n = part_of(o->places[i], k, &other);
            alike = n > 0 && other - o->places[i] == part - first &&
                    strncmp(first, o->places[i], (size_t)(part - first)) == 0 &&
                    strcmp(part + own, other + n) == 0 && (n != own || strncmp(part, other, (size_t)n) != 0);
        }
        length = (int)strlen(part + own);
        while (length > 0 && part[own + length - 1] == '/') length--;
        snprintf(text, FFP_CLI_PATH, "%.*s{view}%.*s/*", (int)(part - first), first, length, part + own);
        if (alike) return true;
    }
    return o->n_places == 1;
}

// The commands that come next, as they are typed.
static void print_import(const FfpSelfCalibration *o) {
    char template[FFP_CLI_PATH], inner[FFP_CLI_NAME], panel[32], images[FFP_CLI_PATH + 32],
        codes[FFP_CLI_PATH + FFP_CLI_NAME + 32];
    const bool one = put_template(o, template), apart = ffp_cli_find_codes(o->places, o->n_places, inner);
    const char *files = one ? template : "{view}/*",
               *draw[] = {"ffprocams", "patterns", "-o", "patterns", "--projector", panel},
               *words[12] = {"ffprocams", "import", "-c", o->file ? o->file : o->folder};
    int n = 4;
    if (o->file)
        words[n++] = "-t", words[n++] = o->turntable_file;
    else
        words[n++] = "--scene";
    snprintf(images, sizeof images, "%s%s", apart ? "black,white=" : "", files);
    snprintf(codes, sizeof codes, "%.*s%s/*", (int)strlen(files) - 1, files, inner);
    words[n++] = apart ? "-g" : "--shown";
    words[n++] = apart ? codes : o->shown ? o->shown : "patterns";
    words[n++] = "-i", words[n++] = images;
    words[n++] = "-o", words[n++] = "capture";
    snprintf(panel, sizeof panel, "%dx%d", o->width, o->height);
    printf("now run%s\n", one ? "" : ", with the folders of photographs beside each other,");
    if (!o->shown && !apart) ffp_cli_type(stdout, &(FfpList){draw, 6});
    ffp_cli_type(stdout, &(FfpList){words, n});
}

static void print_places(const FfpSelfCalibration *o, const FfpSelfCalibrationStats *s) {
    printf("%s: %d of %d places, %d points, rms %.3f pixels; %.1f degrees between the outermost\n", o->folder,
           s->used, s->places, s->points, s->rms, s->parallax);
    printf("focal lengths: camera %.1f pixels (+- %.2f %%), projector %.1f (+- %.2f %%); places turned "
           "within %.3f "
           "degrees\n",
           s->camera_focal, 100 * s->camera_uncertain, s->projector_focal, 100 * s->projector_uncertain,
           s->turn_uncertain);
    print_import(o);
}

static void print_stops(const FfpSelfCalibration *o, const FfpSelfCalibrationStats *s) {
    printf("%s: %d of %d stops, %d points, rms %.3f pixels; turned to other stops they are off by %.3f\n",
           o->file, s->used, s->places, s->points, s->rms, s->surface);
    printf("focal lengths: camera %.1f pixels (+- %.2f %%), projector %.1f (+- %.2f %%)\n", s->camera_focal,
           100 * s->camera_uncertain, s->projector_focal, 100 * s->projector_uncertain);
    printf(
        "the axis points along %.6f,%.6f,%.6f through %.6g,%.6g,%.6g (+- %.2f degrees, %.2f %%); the table "
        "turned %sclockwise as seen from above, by angles up to %.2f degrees from those given\n",
        s->axis[0], s->axis[1], s->axis[2], s->point[0], s->point[1], s->point[2], s->tilt, 100 * s->shift,
        s->reversed ? "" : "anti", s->angle_off);
    print_import(o);
}

static void print_places_json(const FfpSelfCalibration *o, const FfpSelfCalibrationStats *s) {
    json_t *all = json_pack("{s:s, s:i, s:i, s:i, s:f, s:f, s:{s:f, s:f}, s:{s:f, s:f}, s:f}",
                            s->has_axis ? "file" : "folder", s->has_axis ? o->file : o->folder, "places",
                            s->places, "used", s->used, "points", s->points, "rms", s->rms, "parallax",
                            s->parallax, "camera", "focal", s->camera_focal, "uncertain", s->camera_uncertain,
                            "projector", "focal", s->projector_focal, "uncertain", s->projector_uncertain,
                            "turn_uncertain", s->turn_uncertain);
    if (all && s->has_axis)
        json_object_set_new(all, "turntable",
                            json_pack("{s:[fff], s:[fff], s:b, s:f, s:f, s:f, s:f}", "axis", s->axis[0],
                                      s->axis[1], s->axis[2], "point", s->point[0], s->point[1], s->point[2],
                                      "clockwise", s->reversed, "tilt", s->tilt, "shift", s->shift, "surface",
                                      s->surface, "angle_off", s->angle_off));
    put_json(all);
}

static int run_without_board(const Arguments *arguments) {
    const FfpRigCalibration *rig = &arguments->rig;
    FfpSelfCalibration o = ffp_self_calibration_defaults();
    FfpSelfCalibrationStats stats;
    FfpError err = {0};
    if (rig->width > 0) o.width = rig->width, o.height = rig->height;
    o.shown = rig->shown, o.linear = rig->linear;
    o.angles = arguments->angles.degrees, o.n_angles = arguments->angles.count;
    if (o.n_angles > 0)
        o.file = rig->file, o.turntable_file = rig->turntable_file;
    else
        o.folder = rig->file;
    o.camera_per_folder = arguments->camera_per_folder;
    o.focal_35mm = arguments->focal_35mm, o.length = arguments->length;
    o.places = arguments->attitudes.values, o.n_places = arguments->attitudes.count;
    if (rig->columns || rig->report || rig->seen || rig->turntable_board || rig->fix_camera ||
        rig->fix_projector)
        return ffp_cli_usage("calibrate", "--without-board takes none of the options of a board");
    if (o.n_angles > 0 && !(o.file && o.turntable_file))
        return ffp_cli_usage("calibrate", "the stops of a turntable give two files, --output and "
                                          "--turntable-output");
    if (arguments->json) ffp_cli_keep_findings();
    if (!ffp_self_calibrate(ffp_cli_context(), &o, &stats, &err)) return fail(arguments->json, &err);
    if (arguments->json)
        print_places_json(&o, &stats);
    else if (stats.has_axis)
        print_stops(&o, &stats);
    else
        print_places(&o, &stats);
    return FFP_EXIT_OK;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpRigCalibration *rig = &arguments->rig;
    if (arguments->without_board) return run_without_board(arguments);
    if (rig->columns == 0 || rig->square == 0)
        return ffp_cli_usage("calibrate", "--board and --square are required, or --without-board");
    if (!rig->turntable_board && (arguments->angles.count > 0 || rig->turntable_file))
        return ffp_cli_usage("calibrate", "%s requires --turntable-board, or --without-board",
                             rig->turntable_file ? "--turntable-output" : "--angles");
    const bool by_default = rig->width == 0 && !rig->shown && !rig->seen;
    if (by_default) {
        const FfpRigCalibration defaults = ffp_rig_calibration_defaults();
        rig->width = defaults.width;
        rig->height = defaults.height;
    }
    FfpRigCalibrationStats stats = {0};
    FfpError err = {0};
    if (arguments->json) ffp_cli_keep_findings();
    rig->attitudes = arguments->attitudes.values;
    rig->n_attitudes = arguments->attitudes.count;
    rig->calibrations = arguments->calibrations.values;
    rig->n_calibrations = arguments->calibrations.count;
    rig->angles = arguments->angles.degrees;
    rig->n_angles = arguments->angles.count;
    if (!ffp_calibrate_rig(ffp_cli_context(), rig, &stats, &err)) {
        const int status = fail(arguments->json, &err);
        if (by_default && err.code == FFP_ERROR_FILE && rig->n_attitudes > 0) tell_default(rig);
        return status;
    }
    if (arguments->json) {
        print_json(rig, &stats);
        return FFP_EXIT_OK;
    }
    if (rig->seen) printf("%s: where the board is\n", rig->seen);
    if (rig->file) print_rig(rig, &stats);
    if (by_default && rig->file && (stats.used < stats.attitudes || stats.both > DOUBTFUL)) tell_default(rig);
    if (stats.has_axis) print_axis(rig, &stats);
    return FFP_EXIT_OK;
}

#define RIG "camera and projector"
#define TURNTABLE "turntable"
#define WITHOUT "without a board: from the codes on anything"

static const FfpOption options[] = {
    FFP_CLI_JSON(
        offsetof(Arguments, json),
        "print the figures as JSON instead, with the findings: doubts with their codes, views and advice"),
    {.name = "board",
     .argument = "CxR",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, rig),
     .parse = read_board,
     .takes = "columns x rows of corners (9x6)",
     .help = "inner corners of the chessboard, where four squares meet: one fewer than squares each way"},
    {.name = "square",
     .argument = "LENGTH",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, rig.square),
     .least = 1e-9,
     .most = 1e9,
     .help = "side of a square, measured on the print; the calibration uses its unit"},
    {.name = "report",
     .argument = "FILE.html",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, rig.report),
     .help =
         "HTML page that shows the corners, their errors (enlarged), and how much of both images they cover"},
    {.name = "seen",
     .argument = "FILE.json",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .excludes = "output",
     .offset = offsetof(Arguments, rig.seen),
     .help = "calibrate nothing, but write where the board is in photographs, given instead of FOLDERs: "
             "whether it was found, its corners, its tilt and which way, and what is clipped. Tells in a "
             "second whether a board is worth its 40 photographs"},
    {.name = "projector",
     .argument = "WxH",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, rig),
     .parse = read_size,
     .takes = "width x height in pixels (1920x1080)",
     .group = RIG,
     .help = "size of the projector's panel, as for `ffprocams patterns`. Default: 1920x1080"},
    {.name = "shown",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .excludes = "projector",
     .offset = offsetof(Arguments, rig.shown),
     .group = RIG,
     .help =
         "folder of `ffprocams patterns`: the panel's size is that of its pictures, and a FOLDER may hold a "
         "photograph of each of them, lollipops too, in their order"},
    {.name = "linear",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, rig.linear),
     .group = RIG,
     .help =
         "the PNG and JPEG files hold linear light, as `import --linear images` has it (raw photographs and "
         "EXR always do)"},
    {.name = "output",
     .letter = 'o',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, rig.file),
     .group = RIG,
     .help = "the calibration, for `ffprocams import -c FILE`: OpenCV FileStorage, in YAML if the name ends "
             "in .yml or .yaml, otherwise in XML"},
    {.name = "fix",
     .argument = "TERM",
     .type = FFP_OPTION_PARSED,
     .repeated = true,
     .offset = offsetof(Arguments, rig),
     .words = terms,
     .parse = read_fix,
     .takes = "k1, k2, k3, p, centre or aspect, optionally prefixed with camera. or projector.",
     .group = RIG,
     .help = "hold this term fixed instead of fitting it; may be repeated. k1, k2, k3 and p (both tangential "
             "terms) become 0, centre is the middle of the picture, aspect makes pixels square. camera.k3 "
             "applies to the camera only"},
    {.name = "without-board",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, without_board),
     .group = WITHOUT,
     .help =
         "the FOLDERs are of places of a camera that walks, two or more, 10 to 20 degrees apart, before "
         "anything that is not flat: the scene itself. The projector stands still. --output is a new "
         "folder, COLMAP's text model, for `ffprocams import -c FOLDER --scene`. With --angles they are of "
         "a turntable's stops before a camera and a projector that stand still; --output and "
         "--turntable-output are files as those of a board"},
    {.name = "lens",
     .needs = "without-board",
     .argument = "MM",
     .type = FFP_OPTION_REAL,
     .least = 5,
     .most = 2000,
     .offset = offsetof(Arguments, focal_35mm),
     .group = WITHOUT,
     .help = "the camera's focal length as that of a 35 mm camera, if its files do not tell it (EXIF): "
             "photographs from few places say it less well"},
    {.name = "camera-per-folder",
     .needs = "without-board",
     .excludes = "angles",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, camera_per_folder),
     .group = WITHOUT,
     .help = "each FOLDER was photographed by another camera, or with another lens or zoom: each has a focal "
             "length, an axis and a distortion of its own. Photographs must tell more than of one camera, or "
             "their files or --lens the focal length"},
    {.name = "length",
     .needs = "without-board",
     .argument = "L",
     .type = FFP_OPTION_REAL,
     .least = 1e-9,
     .most = 1e9,
     .offset = offsetof(Arguments, length),
     .group = WITHOUT,
     .help = "distance between the first two places, or between the lenses of projector and camera before a "
             "turntable, which sets the unit of length. Default: 1"},
    {.name = "turntable-board",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, rig.turntable_board),
     .group = TURNTABLE,
     .help = "photographs of the board on the turntable, one for each angle of --angles, in order"},
    {.name = "angles",
     .argument = "ANGLES",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, angles),
     .parse = read_angles,
     .takes = "up to 512 angles in degrees, separated by commas, or 12x30 for twelve steps of 30",
     .group = TURNTABLE,
     .help =
         "angles of the table in these photographs, in degrees: 0,20,40 or 12x30. Without a board, of the "
         "FOLDERs in their order; they may be off by a few degrees, and are found"},
    {.name = "turntable-output",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, rig.turntable_file),
     .group = TURNTABLE,
     .help = "JSON file for the axis, for `ffprocams import -t FILE`: after a board with --angles ANGLES, "
             "those of "
             "the object's stops"},
    {.name = "calibration",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, calibrations),
     .group = TURNTABLE,
     .help = "an existing calibration of the camera, instead of FOLDERs"},
    {0},
};

const FfpCommand ffp_cli_calibrate = {
    .name = "calibrate",
    .group = FFP_CLI_CAPTURE,
    .purpose = "calibrates a camera and a projector, from photographs of a chessboard or of anything",
    .prose =
        "Put a flat printed chessboard in front of the rig in five to fifteen attitudes, tilted by 20 to 40 "
        "degrees, each "
        "time in a different direction. In each, photograph the patterns of `ffprocams patterns --only "
        "capture "
        "--lollipops 0 "
        "--only graycode`, in order, and put the pictures in a folder of their own. The corners are found in "
        "the camera's "
        "pictures and "
        "carried to the projector's panel by homographies of the codes around each (Moreno and Taubin "
        "2012); then "
        "both devices are fitted, with lens distortion, and the motion between them. Corners and "
        "attitudes that "
        "do not fit are left out, and listed. docs/guide/own-rig.md shows how.\n"
        "With --turntable-board, a chessboard that lies or stands on the turntable gives its axis.\n"
        "With --without-board nothing is printed, glued or measured: the codes on the scene itself say where "
        "projector and camera are, as long as the camera stands at two places or more, or the object at "
        "three stops of a turntable.",
    .positional = {.name = "FOLDER",
                   .least = 0,
                   .most = INT_MAX,
                   .offset = offsetof(Arguments, attitudes),
                   .help = "photographs of one attitude, ordered by the numbers in their names: the "
                           "projector black and white, first or last, and the Gray codes of columns and rows "
                           "with their inverses. Other usual orders are found from the pictures. Or a folder "
                           "of such folders"},
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams calibrate shots -o calibration.xml --board 9x6 --square 25 "
                        "\\\n    --projector 1280x800 "
                        "--report calibration.html"},
            {.about = "Then the axis of the turntable. The file holds the angles of these "
                      "photographs; if the object was photographed at others, give the six "
                      "numbers printed to import, -t AX,AY,AZ,PX,PY,PZ,8x45:",
             .command = "ffprocams calibrate -c calibration.xml --board 9x6 --square 25 "
                        "\\\n    --turntable-board table "
                        "--angles 12x30 --turntable-output axis.json"},
            {.about = "Without a board, from the photographs of a scene at three places of the camera:",
             .command = "ffprocams calibrate places/1 places/2 places/3 --without-board "
                        "\\\n    --shown patterns -o calibration"},
            {.about = "From photographs of any object at eight stops of a turntable:",
             .command = "ffprocams calibrate view-* --without-board --angles 8x45 --shown patterns "
                        "\\\n    -o calibration.xml --turntable-output axis.json"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
