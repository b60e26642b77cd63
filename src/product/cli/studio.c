#include <stdio.h>
#include "cli.h"
#include "product/server/server.h"

static int run(void *data) {
#ifdef FFP_WITH_STUDIO
    char error[512];
    if (ffp_server_main(data, error, sizeof error)) return FFP_EXIT_OK;
    fprintf(stderr, "ffprocams: error: %s\n", error);
#else
    (void)data;
    fprintf(stderr,
            "ffprocams: error: this program was built without the studio: install libmicrohttpd-dev and "
            "build it again\n");
#endif
    return FFP_EXIT_FAILURE;
}

static void set_defaults(void *data) {
    *(FfpStudioOptions *)data = (FfpStudioOptions){.folder = "studio"};
}

static const FfpOption options[] = {
    {.name = "virtual",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(FfpStudioOptions, virtual_rig),
     .help = "a new folder's rig is a simulated one: camera, projector, chessboard, turntable and object. "
             "Nothing else is needed to try everything"},
    {.name = "no-browser",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(FfpStudioOptions, stays_closed),
     .help = "only print the page's address"},
    {.name = "port",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(FfpStudioOptions, port),
     .high = 65535,
     .help = "port on this machine's loopback address. Default: 0, that of last time or any that is free"},
    {.name = "osc",
     .argument = "[ADDRESS:]PORT",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(FfpStudioOptions, osc),
     .help =
         "also take OSC messages for the show over UDP (docs/guide/show.md): 9000 listens on this machine's "
         "loopback address, 192.168.1.5:9000 on the network, where no key is needed. Default: none"},
    {0},
};

const FfpCommand ffp_cli_studio = {
    .name = "studio",
    .group = FFP_CLI_CAPTURE,
    .purpose = "takes a projector and a camera to the relit object, on one page in the browser",
    .prose =
        "Serves a page to this machine's browser that draws the patterns, shows them on the projector, takes "
        "the photographs, calibrates, reconstructs and shows the object under light that you move. Each step "
        "runs one of the other commands, which the page shows. Everything is in the folder, written before "
        "the page says so: end the studio, or lose it, at any time, and start it again with the same folder. "
        "The page's address holds a key; only this machine, and only pages of the studio itself, can use it. "
        "docs/guide/studio.md shows how.",
    .positional = {.name = "FOLDER",
                   .least = 0,
                   .most = 1,
                   .offset = offsetof(FfpStudioOptions, folder),
                   .help = "studio.json, patterns, calibration and objects; made if it does not exist. "
                           "Default: studio"},
    .options = options,
    .examples = (const FfpExample[]){{.about = "Without projector and camera:",
                                      .command = "ffprocams studio --virtual"},
                                     {.about = "With your own:", .command = "ffprocams studio rig"},
                                     {0}},
    .size = sizeof(FfpStudioOptions),
    .set_defaults = set_defaults,
    .run = run,
};
