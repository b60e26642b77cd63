#include <stdio.h>
#include <stdlib.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams info FILE\n"
    "\n"
    "Tells what a file holds: a capture (views, patterns, sizes, bounds, intensity and whether it was\n"
    "known), a model (configuration, parameters, how it was trained), or Gaussians (count, bounds, how\n"
    "opaque they are). The file is checked as every other command checks it.\n"
    "\n"
    "  FILE  a capture's folder or JSON file, a safetensors model, or a PLY\n"
    "\n"
    "example: ffprocams info data/sample\n";

int ffp_cli_info(int argc, char **argv) {
    static const struct option options[] = {{"help", no_argument, NULL, 'h'}, {0}};
    for (int option; (option = ffp_cli_next(argc, argv, ":h", options)) != -1;) {
        if (option == 'h') fputs(help, stdout);
        return option == 'h' ? FFP_EXIT_OK : FFP_EXIT_USAGE;
    }
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one FILE");
    FfpError err = {0};
    char *text = ffp_info(argv[optind], &err);
    if (!text) return ffp_cli_fail(&err);
    fputs(text, stdout);
    free(text);
    return FFP_EXIT_OK;
}
