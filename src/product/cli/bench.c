#include <stdio.h>
#include <stdlib.h>
#include "cli.h"

typedef struct Arguments {
    const char *json;
} Arguments;

static int run(void *data) {
    const Arguments *arguments = data;
    FfpError err = {0};
    char *text = ffp_benchmark(ffp_cli_context(), arguments->json, &err);
    if (!text) return ffp_cli_fail(&err);
    fputs(text, stdout);
    ffp_free(text);
    return FFP_EXIT_OK;
}

static const FfpOption options[] = {
    {.name = "json",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .writes = true,
     .offset = offsetof(Arguments, json),
     .help = "write peaks, kernels and steps as JSON too"},
    {0},
};

const FfpCommand ffp_cli_bench = {
    .name = "bench",
    .group = FFP_CLI_EVALUATE,
    .purpose = "measures this machine's limits and how close the program comes to them",
    .prose =
        "First measures the peaks: products and multiply-adds from registers, and copying. Then times the "
        "network's kernels, the rasteriser, the parts of a training step, and a reconstruction with one "
        "relit view, each as a share of the peak that bounds it. Takes about a minute, during which the "
        "machine should be otherwise idle. FFPROCAMS_CPU and OMP_NUM_THREADS select kernels and threads.",
    .options = options,
    .examples = (const FfpExample[]){{.command = "ffprocams bench --json here.json"}, {0}},
    .size = sizeof(Arguments),
    .run = run,
};
