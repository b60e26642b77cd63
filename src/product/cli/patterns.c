#include <stdio.h>
#include <string.h>
#include "cli.h"

enum { FOCUS = 1, CAPTURE = 2, GRAY_CODES = 4 };

typedef struct Arguments {
    FfpPatterns patterns;
    FfpList calibrations;
    int parts; // those wanted; 0: all
} Arguments;

static bool read_size(const char *text, void *destination) {
    FfpPatterns *patterns = destination;
    return ffp_cli_pair(text, 'x', 1, &patterns->width, &patterns->height);
}

static bool read_board(const char *text, void *destination) {
    FfpPatterns *patterns = destination;
    return ffp_cli_pair(text, 'x', 1, &patterns->columns, &patterns->rows);
}

static const FfpWord parts[] = {{"focus", FOCUS}, {"capture", CAPTURE}, {"graycode", GRAY_CODES}, {0}};

static bool read_part(const char *text, void *destination) {
    for (const FfpWord *part = parts; part->name; part++) {
        if (strcmp(part->name, text) != 0) continue;
        *(int *)destination |= (int)part->value;
        return true;
    }
    return false;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpPatterns *patterns = &arguments->patterns;
    FfpError err = {0};
    const int wanted = arguments->parts ? arguments->parts : FOCUS | CAPTURE | GRAY_CODES;
    patterns->focus = wanted & FOCUS;
    patterns->capture = wanted & CAPTURE;
    patterns->gray_codes = wanted & GRAY_CODES;
    patterns->calibrations = arguments->calibrations.values;
    patterns->n_calibrations = arguments->calibrations.count;
    const int count = ffp_write_patterns(ffp_cli_context(), patterns, &err);
    if (count < 0) return ffp_cli_fail(&err);
    char size[32] = "";
    if (patterns->n_calibrations == 0)
        snprintf(size, sizeof size, " of %d x %d", patterns->width, patterns->height);
    printf("%s: %d pattern%s%s; open show.html on the projector (README.txt explains how)\n",
           patterns->folder, count, FFP_CLI_S(count), size);
    return FFP_EXIT_OK;
}

static void set_defaults(void *data) {
    ((Arguments *)data)->patterns = ffp_patterns_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_FOLDER(offsetof(Arguments, patterns.folder),
                   "folder for the pictures, README.txt and show.html; it must be new or empty"),
    {.name = "projector",
     .argument = "WxH",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, patterns),
     .parse = read_size,
     .takes = "width x height in pixels (1920x1080)",
     .help = "native resolution of the projector's panel. Default: 1920x1080"},
    {.name = "calibration",
     .letter = 'c',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .repeated = true,
     .excludes = "projector",
     .offset = offsetof(Arguments, calibrations),
     .help = "a calibration that `import` reads: the panel is of the size that it gives the projector"},
    {.name = "lollipops",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, patterns.lollipops),
     .high = 100,
     .help = "number of lollipop patterns. Default: 1; two or three give a more exact surface"},
    {.name = "greys",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, patterns.greys),
     .high = 64,
     .help = "number of even greys between black and white, by whose photographs `import --shown` finds how "
             "much light the projector makes of a value; 4 to 8 are enough. Default: 0"},
    {.name = "board",
     .argument = "CxR",
     .type = FFP_OPTION_PARSED,
     .offset = offsetof(Arguments, patterns),
     .parse = read_board,
     .takes = "columns x rows of corners (9x6)",
     .help = "inner corners of the chessboard that is written for printing, 3 to 64 each way. Default: 9x6"},
    {.name = "square",
     .argument = "MM",
     .type = FFP_OPTION_REAL,
     .offset = offsetof(Arguments, patterns.square),
     .least = 1,
     .most = 500,
     .help = "side of its squares, mm. Default: 25"},
    {.name = "only",
     .argument = "PART",
     .type = FFP_OPTION_PARSED,
     .repeated = true,
     .offset = offsetof(Arguments, parts),
     .words = parts,
     .parse = read_part,
     .takes = "focus, capture or graycode",
     .help = "write only this part; may be repeated: focus (a chart), capture (black, white, lollipops), "
             "graycode. Default: all parts"},
    {0},
};

const FfpCommand ffp_cli_patterns = {
    .name = "patterns",
    .group = FFP_CLI_CAPTURE,
    .purpose = "draws the patterns for the projector to show",
    .prose =
        "Writes the pictures that a projector shows while a rig is photographed, numbered as their "
        "photographs are: a chart for focusing (000, not photographed); black, white and lollipops for a "
        "reconstruction; and Gray codes, each with its inverse, for a calibration. `calibrate` and "
        "`import` take the photographs in this order (--shown DIR). Lollipops are round and as high as "
        "the panel. README.txt, written beside them, lists the photographs to take. show.html shows them "
        "full screen in any browser, advancing with the space bar, and warns "
        "if its window does not have the panel's size. With the Gray codes comes the chessboard, "
        "chessboard.pdf "
        "and chessboard.svg, to be printed at 100 %.",
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams patterns -o patterns --projector 1280x800"},
                             {.about = "For a capture alone:",
                              .command = "ffprocams patterns -o patterns --only focus --only capture"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
