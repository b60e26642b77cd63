// From photographs to a page: the other commands one after the other, as anybody would type them.
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli.h"
#include "product/studio/typed.h"
#include "scan_names.h"

enum { NO_STEP = -1 };

typedef struct Arguments {
    FfpList photographs, calibrations;
    const char *folder, *projector, *shown, *angles, *lens, *attitudes, *board, *square, *turntable,
        *graycode, *width, *camera_size, *camera_fit, *mask;
    bool scene, dry;
    int from, to;
} Arguments;

// Results, in FOLDER; the first three are folders that their steps do not fill twice.
enum { PATTERNS, CALIBRATION, CAPTURE, CALIBRATION_FILE, AXIS, OBJECT, PAGE, REPORT, RESULTS };
static const char *const results[RESULTS] = {"patterns",  "calibration", "capture",     "calibration.xml",
                                             "axis.json", "object.ply",  "object.html", "report.html"};

typedef struct Scan {
    const Arguments *given;
    char paths[RESULTS][FFP_CLI_PATH], images[FFP_CLI_PATH + 32], codes[FFP_CLI_PATH + FFP_CLI_NAME + 32];
    const char *graycode; // as given, or `codes`, of folders of their own; NULL: among the images
    FfpList words;        // of the command at hand
} Scan;

static void word(Scan *s, const char *text) {
    s->words.values[s->words.count++] = text;
}

static void option(Scan *s, const char *name, const char *value) {
    if (value) word(s, name), word(s, value);
}

static const char *shown(const Scan *s) {
    return s->given->shown ? s->given->shown : s->paths[PATTERNS];
}

// Where projector and camera are is found by calibrate, from the photographs of the object.
static bool is_found(const Arguments *a) {
    return a->calibrations.count == 0 && !a->attitudes;
}

// --- The steps: each adds its words; false: there is no need of it. ---

static bool patterns(Scan *s) {
    option(s, "-o", s->paths[PATTERNS]);
    option(s, "--projector", s->given->projector);
    for (int i = 0; i < s->given->calibrations.count && !s->given->projector; i++)
        option(s, "-c", s->given->calibrations.values[i]);
    return !s->given->shown && !s->graycode;
}

static bool calibrate(Scan *s) {
    const Arguments *a = s->given;
    const bool walk = !a->attitudes && !a->angles;
    for (int i = 0; i < a->photographs.count && !a->attitudes; i++) word(s, a->photographs.values[i]);
    if (a->attitudes) {
        word(s, a->attitudes);
    } else {
        word(s, "--without-board");
        option(s, "--angles", a->angles);
        option(s, "--turntable-output", walk ? NULL : s->paths[AXIS]);
    }
    option(s, "--board", a->board);
    option(s, "--square", a->square);
    option(s, "--lens", a->lens);
    if (s->graycode)
        option(s, "--projector", a->projector);
    else
        option(s, "--shown", shown(s));
    option(s, "-o", s->paths[walk ? CALIBRATION : CALIBRATION_FILE]);
    return a->calibrations.count == 0;
}

static void add_turntable(Scan *s) {
    const Arguments *a = s->given;
    const char *axis = is_found(a) ? s->paths[AXIS] : a->turntable;
    option(s, "-t", axis ? axis : a->angles);
    if (!axis) word(s, "--fit-axis");
    if (axis && !is_found(a)) option(s, "--angles", a->angles);
}

static bool import(Scan *s) {
    const Arguments *a = s->given;
    const bool known = a->calibrations.count > 0, turns = a->angles || a->turntable;
    for (int i = 0; i < a->calibrations.count; i++) option(s, "-c", a->calibrations.values[i]);
    if (!known) option(s, "-c", s->paths[turns || a->attitudes ? CALIBRATION_FILE : CALIBRATION]);
    if (known) option(s, "--projector-size", a->projector);
    option(s, "--camera-size", a->camera_size);
    option(s, "--camera-fit", a->camera_fit);
    if (turns) add_turntable(s);
    if (a->scene || (is_found(a) && !turns)) word(s, "--scene");
    option(s, "--shown", s->graycode ? NULL : shown(s));
    option(s, "-i", s->images);
    option(s, "-g", s->graycode);
    option(s, "-m", a->mask);
    option(s, "-w", a->width);
    option(s, "-o", s->paths[CAPTURE]);
    return true;
}

static bool reconstruct(Scan *s) {
    word(s, s->paths[CAPTURE]);
    option(s, "-o", s->paths[OBJECT]);
    return true;
}

static bool view(Scan *s) {
    word(s, s->paths[OBJECT]);
    option(s, "--capture", s->paths[CAPTURE]);
    option(s, "-o", s->paths[PAGE]);
    return true;
}

static bool info(Scan *s) {
    word(s, s->paths[CAPTURE]);
    option(s, "--report", s->paths[REPORT]);
    return true;
}

enum { STEPS = 6 };
static const FfpWord steps[] = {
    {"patterns", 0}, {"calibrate", 1}, {"import", 2}, {"reconstruct", 3}, {"view", 4}, {"info", 5}, {0}};
static bool (*const add_words[STEPS])(Scan *) = {patterns, calibrate, import, reconstruct, view, info};

// --- Before the first step. ---

static int check_results(const Scan *s) {
    FfpError err = {.code = FFP_ERROR_FILE};
    const int from = s->given->from;
    const char *filled =
        from == NO_STEP && ffp_cli_count_entries(s->given->folder, false) > 0 ? s->given->folder : NULL;
    for (int i = from; i >= 0 && i <= CAPTURE && i <= s->given->to && !filled; i++)
        if (ffp_cli_count_entries(s->paths[i], false) > 0) filled = s->paths[i];
    if (!filled) return FFP_EXIT_OK;
    snprintf(err.text, sizeof err.text,
             "already exists and is not empty: remove it, or go on %s --from STEP (%.500s)",
             from == NO_STEP ? "with" : "with another", filled);
    return ffp_cli_fail(&err);
}

static int prepare(Scan *s) {
    const Arguments *a = s->given;
    const size_t most = 64 + (size_t)a->photographs.count + 2 * (size_t)a->calibrations.count;
    for (int i = 0; i < RESULTS; i++) snprintf(s->paths[i], FFP_CLI_PATH, "%s/%s", a->folder, results[i]);
    s->words.values = calloc(most, sizeof *s->words.values);
    if (!s->words.values) return ffp_cli_fail(&(FfpError){.text = "out of memory"});
    char views[FFP_CLI_PATH], inner[FFP_CLI_NAME];
    const bool found = !a->graycode && ffp_cli_find_codes(a->photographs.values, a->photographs.count, inner);
    if (found && a->shown)
        return ffp_cli_usage("scan", "%s has codes in '%s', beside black and white: --projector, not --shown",
                             a->photographs.values[0], inner);
    const int status = ffp_cli_name_views(&a->photographs, a->angles && !is_found(a), a->graycode || found,
                                          views, sizeof views);
    if (status != FFP_EXIT_OK) return status;
    s->graycode = found ? s->codes : a->graycode;
    snprintf(s->images, sizeof s->images, "%s%s/*.*", s->graycode ? "black,white=" : "", views);
    if (found) snprintf(s->codes, sizeof s->codes, "%s/%s/*.*", views, inner);
    return a->dry ? FFP_EXIT_OK : check_results(s);
}

#define CALIBRATE "calibration"

static const FfpOption options[] = {
    FFP_CLI_FOLDER(offsetof(Arguments, folder),
                   "folder for the results, new or empty, except with --from: capture, object.ply, "
                   "object.html (the page), report.html (the checks), and patterns, calibration or "
                   "calibration.xml and axis.json, unless these are given"),
    {.name = "projector",
     .argument = "WxH",
     .type = FFP_OPTION_TEXT,
     .excludes = "shown",
     .offset = offsetof(Arguments, projector),
     .help = "size of the projector's panel. Default: 1920x1080"},
    {.name = "shown",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .excludes = "graycode",
     .offset = offsetof(Arguments, shown),
     .help = "folder of `ffprocams patterns`, of what was shown. Default: drawn for --projector, with black, "
             "white, the Gray codes and one lollipop, whose photograph may be missing"},
    {.name = "graycode",
     .letter = 'g',
     .argument = "FILES",
     .type = FFP_OPTION_TEXT,
     .needs = "calibration",
     .offset = offsetof(Arguments, graycode),
     .help = "photographs of the Gray codes, as `import` takes them, where PHOTOGRAPHS hold black and white "
             "alone, in this order"},
    {.name = "angles",
     .argument = "ANGLES",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, angles),
     .help = "the object stands on a turntable, and these are its angles in degrees, 0,45,90 or 8x45, in the "
             "order of PHOTOGRAPHS. Default: the camera walks before a whole scene"},
    {.name = "mask",
     .letter = 'm',
     .argument = "FILES|otsu",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, mask),
     .help = "the object's silhouettes, as `import` takes them"},
    {.name = "width",
     .letter = 'w',
     .argument = "W",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, width),
     .help = "make the capture's pictures W pixels wide. Default: as `import` does"},
    {.name = "from",
     .argument = "STEP",
     .type = FFP_OPTION_CHOICE,
     .words = steps,
     .offset = offsetof(Arguments, from),
     .help = "begin with patterns, calibrate, import, reconstruct, view or info, using what DIR has from "
             "earlier steps. Files are replaced; delete folders (patterns, calibration, capture) that are to "
             "be made again"},
    {.name = "to",
     .argument = "STEP",
     .type = FFP_OPTION_CHOICE,
     .words = steps,
     .offset = offsetof(Arguments, to),
     .help = "end with this step (import: with the capture). Default: info"},
    {.name = "dry-run",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, dry),
     .help = "only print the commands"},
    {.name = "lens",
     .argument = "MM",
     .type = FFP_OPTION_TEXT,
     .excludes = "calibration",
     .offset = offsetof(Arguments, lens),
     .group = CALIBRATE,
     .help = "the camera's focal length as that of a 35 mm camera, if its files do not tell it (EXIF)"},
    {.name = "calibration",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .offset = offsetof(Arguments, calibrations),
     .group = CALIBRATE,
     .help = "a calibration that `import` reads; none is computed then"},
    {.name = "camera-size",
     .argument = "WxH",
     .type = FFP_OPTION_TEXT,
     .needs = "calibration",
     .offset = offsetof(Arguments, camera_size),
     .group = CALIBRATE,
     .help = "the size of its camera's pictures, if it does not say"},
    {.name = "camera-fit",
     .argument = "FIT",
     .type = FFP_OPTION_TEXT,
     .needs = "calibration",
     .offset = offsetof(Arguments, camera_fit),
     .group = CALIBRATE,
     .help = "scaled or crop=X,Y: what was done to the photographs since, as `import` takes it"},
    {.name = "turntable",
     .letter = 't',
     .argument = "T",
     .type = FFP_OPTION_FILE,
     .needs = "calibration",
     .offset = offsetof(Arguments, turntable),
     .group = CALIBRATE,
     .help = "its turntable's axis, as `import` takes it. Default, with --angles: the axis is found from the "
             "pictures"},
    {.name = "scene",
     .type = FFP_OPTION_FLAG,
     .needs = "calibration",
     .offset = offsetof(Arguments, scene),
     .group = CALIBRATE,
     .help = "everything in view belongs to the capture; the default for a walk without --calibration"},
    {.name = "attitudes",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .needs = "board",
     .excludes = "calibration",
     .offset = offsetof(Arguments, attitudes),
     .group = CALIBRATE,
     .help = "calibrate from photographs of a chessboard: a folder with a folder for each of its attitudes"},
    {.name = "board",
     .argument = "CxR",
     .type = FFP_OPTION_TEXT,
     .needs = "square",
     .offset = offsetof(Arguments, board),
     .group = CALIBRATE,
     .help = "its inner corners, columns x rows"},
    {.name = "square",
     .argument = "LENGTH",
     .type = FFP_OPTION_TEXT,
     .needs = "attitudes",
     .offset = offsetof(Arguments, square),
     .group = CALIBRATE,
     .help = "side of its squares"},
    {0},
};

// --- All of it. ---

static void type_option(const char *name, const char *value) {
    fprintf(stderr, " --%s ", name);
    ffp_studio_type(stderr, value);
}

// The command line with another --from.
static void tell_step(const Arguments *a, const char *step) {
    fputs("ffprocams: go on with: ffprocams scan", stderr);
    for (int i = 0; i < a->photographs.count; i++) {
        fputc(' ', stderr);
        ffp_studio_type(stderr, a->photographs.values[i]);
    }
    for (const FfpOption *o = options; o->name; o++) {
        const void *place = (const char *)a + o->offset;
        const FfpList *list = place;
        const char *const *text = place;
        if (o->type == FFP_OPTION_FLAG && *(const bool *)place) fprintf(stderr, " --%s", o->name);
        for (int i = 0; o->repeated && i < list->count; i++) type_option(o->name, list->values[i]);
        if (!o->repeated && o->argument && o->type != FFP_OPTION_CHOICE && *text) type_option(o->name, *text);
    }
    if (a->to < STEPS - 1) fprintf(stderr, " --to %s", steps[a->to].name);
    fprintf(stderr, " --from %s\n", step);
}

static int run_words(const Scan *s) {
    ffp_cli_type(stdout, &s->words);
    return s->given->dry ? FFP_EXIT_OK : ffp_cli_child(&s->words);
}

static int run_steps(Scan *s) {
    int status = FFP_EXIT_OK;
    if (s->given->from == NO_STEP) {
        word(s, "mkdir"), word(s, "-p"), word(s, s->given->folder);
        status = run_words(s);
    }
    for (int i = s->given->from == NO_STEP ? 0 : s->given->from; i <= s->given->to && status == FFP_EXIT_OK;
         i++) {
        s->words.count = 0;
        word(s, "ffprocams"), word(s, steps[i].name);
        if (!add_words[i](s)) continue;
        status = run_words(s);
        if (status != FFP_EXIT_OK) tell_step(s->given, steps[i].name);
    }
    return status;
}

static int run(void *data) {
    const Arguments *a = data;
    if (a->from > a->to)
        return ffp_cli_usage("scan", "--to %s comes before --from %s", steps[a->to].name,
                             steps[a->from].name);
    Scan *s = calloc(1, sizeof *s);
    if (!s) return ffp_cli_fail(&(FfpError){.text = "out of memory"});
    s->given = a;
    int status = prepare(s);
    if (status == FFP_EXIT_OK) status = run_steps(s);
    free(s->words.values);
    free(s);
    ffp_cli_end_as_child();
    return status;
}

static void set_defaults(void *data) {
    Arguments *a = data;
    a->from = NO_STEP, a->to = STEPS - 1;
}

const FfpCommand ffp_cli_scan = {
    .name = "scan",
    .group = FFP_CLI_CAPTURE,
    .purpose = "takes photographs under Gray codes to the relit object's page, in one line",
    .prose =
        "Runs `patterns`, `calibrate`, `import`, `reconstruct`, `view` and `info`, those that are needed, "
        "and prints each command as it can be pasted into a shell: copy one to run it with other options. It "
        "stops at the first that fails, with that command's message and exit code, and prints how to go on. "
        "Each place or stop is photographed under black, white and the Gray codes of `ffprocams patterns`, "
        "in their order, without anything moving, into a folder of its own. Without a board or a "
        "calibration, the codes on the object say where projector and camera are.",
    .positional = {.name = "PHOTOGRAPHS",
                   .least = 1,
                   .most = INT_MAX,
                   .offset = offsetof(Arguments, photographs),
                   .help = "folders, one for each place of the camera or stop of the turntable, or one of "
                           "the same name in each of these (shots/*/gray); or one folder of such folders. "
                           "The codes may be in a folder beside black and white. "
                           "With --calibration they are named after its views, or "
                           "come in natural order with --angles; one folder is of a rig that stands still"},
    .options = options,
    .examples =
        (const FfpExample[]){
            {.about = "A camera that walks round, before a projector that stands still:",
             .command = "ffprocams scan places/* --projector 1280x800 -o stage"},
            {.about = "An object at eight stops of a turntable, photographed under all that `patterns` drew:",
             .command = "ffprocams scan shots/view-* --angles 8x45 --shown patterns -o vase"},
            {.about = "The same before a calibrated rig:",
             .command = "ffprocams scan shots/view-* --angles 8x45 --shown patterns -c calibration.xml -t "
                        "axis.json \\\n    -o vase"},
            {.about = "The photographs of the codes by their files' names, black and white in shots/0 and "
                      "shots/1:",
             .command = "ffprocams scan shots/* -c colmap --scene -g 'shots/{view}/gray/*.jpg' -o stage"},
            {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
