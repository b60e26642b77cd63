#include <stdio.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams bench [--json FILE]\n"
    "\n"
    "Measures what this machine can do (products and multiply-adds from registers, copying), then the\n"
    "network's kernels, the rasteriser, a training step by part and a reconstruction with one relit\n"
    "view, each as a share of the peak that bounds it. Takes about a minute; leave the machine alone\n"
    "meanwhile. FFPROCAMS_CPU and OMP_NUM_THREADS choose kernels and threads.\n"
    "\n"
    "  --json FILE  the same as JSON: peaks, kernels, steps\n"
    "\n"
    "example: ffprocams bench --json here.json\n";

int ffp_cli_bench(int argc, char **argv) {
    static const struct option options[] = {
        {"help", no_argument, NULL, 'h'}, {"json", required_argument, NULL, 'j'}, {0}};
    const char *json = NULL;
    for (int option; (option = ffp_cli_next(argc, argv, ":h", options)) != -1;) {
        if (option == 'h') fputs(help, stdout);
        if (option != 'j') return option == 'h' ? FFP_EXIT_OK : FFP_EXIT_USAGE;
        json = optarg;
    }
    if (optind != argc) return ffp_cli_usage(argv[0], "it takes no %s", argv[optind]);
    FfpError err = {0};
    return ffp_benchmark(json, &err) ? FFP_EXIT_OK : ffp_cli_fail(&err);
}
