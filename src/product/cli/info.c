#include <stdio.h>
#include <stdlib.h>
#include "cli.h"

typedef struct Arguments {
    const char *file, *report;
    bool json;
} Arguments;

static int run(void *data) {
    const Arguments *arguments = data;
    FfpError err = {0};
    ffp_cli_findings_are_printed();
    char *text = arguments->json ? ffp_info_json(ffp_cli_context(), arguments->file, &err)
                                 : ffp_info(ffp_cli_context(), arguments->file, &err);
    if (!text) return ffp_cli_fail(&err);
    fputs(text, stdout);
    ffp_free(text);
    if (arguments->report && !ffp_info_report(ffp_cli_context(), arguments->file, arguments->report, &err))
        return ffp_cli_fail(&err);
    return FFP_EXIT_OK;
}

static const FfpOption options[] = {
    {.name = "report",
     .argument = "FILE.html",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, report),
     .help = "also write an HTML page of a capture: the checks, a contact sheet of the masks in which "
             "doubtful views are marked, and the views in colours that say which depths are guesses"},
    FFP_CLI_JSON(
        offsetof(Arguments, json),
        "print JSON instead: the text, and what was checked as findings, each with its code, severity, "
        "view, figure, limit and advice"),
    {0},
};

const FfpCommand ffp_cli_info = {
    .name = "info",
    .group = FFP_CLI_CAPTURE,
    .purpose = "describes and checks a capture, a model, Gaussians or a field",
    .prose = "For a capture: views, patterns, sizes, bounds, intensity and whether it was given or "
             "estimated, and advice on anything doubtful. For a model: configuration, parameters, training. "
             "For Gaussians: count, bounds, opacity. For a neural field: parameters, bounds, occupancy. The "
             "file is checked as by every other command.",
    .positional = {.name = "FILE",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, file),
                   .help = "a capture's folder or JSON file, a safetensors model, Gaussians (PLY, SPZ, glTF "
                           "or GLB), or a field "
                           "from `refine`"},
    .options = options,
    .examples = (const FfpExample[]){{.command = "ffprocams info data/sample --report sample.html"}, {0}},
    .size = sizeof(Arguments),
    .run = run,
};
