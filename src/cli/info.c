#include <stdio.h>
#include <stdlib.h>
#include "cli.h"

typedef struct Arguments {
    const char *file;
} Arguments;

static int run(void *data) {
    const Arguments *arguments = data;
    FfpError err = {0};
    char *text = ffp_info(ffp_cli_context(), arguments->file, &err);
    if (!text) return ffp_cli_fail(&err);
    fputs(text, stdout);
    ffp_free(text);
    return FFP_EXIT_OK;
}

static const FfpOption options[] = {{0}};

const FfpCommand ffp_cli_info = {
    .name = "info",
    .group = FFP_CLI_CAPTURE,
    .purpose = "tells what a capture, a model, a PLY or a field holds, and checks it",
    .prose =
        "Of a capture: views, patterns, sizes, bounds, intensity and whether it was known, and what to do "
        "about each doubt. Of a model: configuration, parameters, how it was trained. Of Gaussians: count, "
        "bounds, how opaque they are. Of a neural field: numbers, place, how much it fills. The file is "
        "checked as every other command checks it.",
    .positional = {.name = "FILE",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, file),
                   .help =
                       "a capture's folder or JSON file, a safetensors model, a PLY, or a field of `refine`"},
    .options = options,
    .examples = (const FfpExample[]){{.command = "ffprocams info data/sample"}, {0}},
    .size = sizeof(Arguments),
    .run = run,
};
