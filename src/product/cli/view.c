#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpPage page;
    int up;
} Arguments;

static int run(void *data) {
    Arguments *arguments = data;
    FfpError err = {0};
    FfpPageStats stats;
    bool ok = false;
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err);
    FfpCapture *capture = gaussians ? ffp_cli_open_devices(arguments->capture, true, &err) : NULL;
    if (capture && ffp_cli_turn(gaussians, arguments->gaussians, capture, arguments->up, &err))
        ok = ffp_write_page(ffp_cli_context(), gaussians, capture, &arguments->page, &stats, &err);
    if (ok)
        printf("%s: %lld Gaussians, %d pattern%s, %d photograph%s, %.1f MB; open it in a browser\n",
               arguments->page.file, (long long)stats.gaussians, stats.patterns, FFP_CLI_S(stats.patterns),
               stats.photographs, FFP_CLI_S(stats.photographs), (double)stats.bytes * 1e-6);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->page = ffp_page_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_CAPTURE_OPTION(
        offsetof(Arguments, capture),
        "the capture that the Gaussians come from: poses, patterns, photographs, the projector's intensity"),
    FFP_CLI_FILE(offsetof(Arguments, page.file), "FILE.html", "the page"),
    FFP_CLI_UP(offsetof(Arguments, up)),
    {.name = "poses",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, page.poses),
     .help = "more camera and projector poses to jump to (targets.json or scene.json)"},
    {.name = "photographs",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, page.photographs),
     .high = 4096,
     .help = "longest side, in pixels, of the photographs included in the page for comparison with the "
             "prediction (default 512); 0: none"},
    {.name = "drawing",
     .argument = "D",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, page.drawing.form),
     .words = ffp_cli_page_forms,
     .help = "ours (default), or paper for Gaussians from a model in the paper's form"},
    FFP_CLI_SAMPLES(offsetof(Arguments, page.drawing.samples), FFP_CLI_SAMPLES_HELP),
    {0},
};

const FfpCommand ffp_cli_view = {
    .name = "view",
    .group = FFP_CLI_LOOK,
    .purpose = "makes an interactive page for moving camera and projector",
    .prose = "One self-contained HTML file that needs no network and no server and opens from disk in any "
             "browser with WebGL 2. Turn the object, move the projector, drop in a picture or a video, paint "
             "on the object, and send the compensated pattern to the real projector from a second window. "
             "The page holds up to 1 MB of patterns and 1.5 MB of photographs, of each view at least one.",
    .positional = FFP_CLI_GAUSSIANS(offsetof(Arguments, gaussians)),
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams view spot.ply --capture data/sample -o spot.html"}, {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
