#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/cli.h"

#define POLISH_MAX 1000000 // steps
#define NOISE_MAX 0.2
#define LAYERS_MIN 0.5
#define LAYERS_MAX 100
#define SAMPLES_MAX 4 // a side

static const char help[] =
    "usage: ffprocams COMMAND [ARGUMENTS]\n"
    "\n"
    "From eight photographed projector-camera views of an object to relightable 3D Gaussians, and\n"
    "pictures of the object under any pattern, camera pose and projector pose.\n"
    "\n"
    "  import       photographs and a calibration file to a capture\n"
    "  align        a capture whose poses are corrected from its photographs\n"
    "  reconstruct  a capture to Gaussians (PLY), in one forward pass\n"
    "  refine       Gaussians fitted further to the photographs they come from\n"
    "  render       pictures of Gaussians under patterns, from chosen views\n"
    "  compensate   the pattern that makes a camera see a target picture on the object\n"
    "  map          which projector pixel lights what: correspondences, density, angles\n"
    "  evaluate     predictions against the photographs: tables, pictures, a report\n"
    "  generate     captures of made-up objects, traced with all their truth\n"
    "  train        weights from generated scenes\n"
    "  bench        what this machine can do, and how near the program comes to it\n"
    "  info         what a capture, a model or a PLY holds\n"
    "\n"
    "  --help       this text; ffprocams COMMAND --help for a command's own\n"
    "  --version    the version\n"
    "\n"
    "The environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16, amx) chooses the\n"
    "kernels in place of the best ones that the processor can run.\n"
    "\n"
    "Exit status: 0 when all went well, 1 on an error (told on stderr; no output is left\n"
    "half-written), 2 for wrong usage.\n"
    "\n"
    "example: ffprocams reconstruct data/sample -o spot.ply\n"
    "         ffprocams render spot.ply --capture data/sample --pattern lollipop_3 -o relit\n";

typedef struct Command {
    const char *name;
    int (*run)(int argc, char **argv);
} Command;

static const Command commands[] = {
    {"reconstruct", ffp_cli_reconstruct},
    {"refine", ffp_cli_refine},
    {"render", ffp_cli_render},
    {"compensate", ffp_cli_compensate},
    {"map", ffp_cli_map},
    {"evaluate", ffp_cli_evaluate},
    {"import", ffp_cli_import},
    {"align", ffp_cli_align},
    {"generate", ffp_cli_generate},
    {"train", ffp_cli_train},
    {"bench", ffp_cli_bench},
    {"info", ffp_cli_info},
};

int ffp_cli_fail(const FfpError *err) {
    fprintf(stderr, "ffprocams: error: %s\n", err->text);
    return FFP_EXIT_FAILURE;
}

int ffp_cli_usage(const char *command, const char *what_format, ...) {
    va_list arguments;
    fputs("ffprocams: error: ", stderr);
    va_start(arguments, what_format);
    vfprintf(stderr, what_format, arguments);
    va_end(arguments);
    fprintf(stderr, "\nffprocams: see: ffprocams %s%s--help\n", command ? command : "", command ? " " : "");
    return FFP_EXIT_USAGE;
}

int ffp_cli_next(int argc, char **argv, const char *short_options, const struct option *options) {
    opterr = 0; // the messages are ours
    const int option = getopt_long(argc, argv, short_options, options, NULL);
    if (option == ':') {
        ffp_cli_usage(argv[0], "%s needs a value", argv[optind - 1]);
        return 0;
    }
    if (option == '?') {
        ffp_cli_usage(argv[0], "unknown option %s", argv[optind - 1]);
        return 0;
    }
    return option;
}

bool ffp_cli_number(const char *text, int64_t low, int64_t high, int64_t *out) {
    char *end;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (errno || end == text || *end || value < low || value > high) return false;
    *out = value;
    return true;
}

bool ffp_cli_real(const char *text, double low, double high, double *out) {
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || !(value >= low && value <= high)) return false;
    *out = value;
    return true;
}

bool ffp_cli_polish(const char *command, const char *text, int64_t *out) {
    if (strcmp(text, "auto") == 0) {
        *out = FFP_POLISH_AUTO;
        return true;
    }
    if (ffp_cli_number(text, 0, POLISH_MAX, out)) return true;
    ffp_cli_usage(command, "--polish is auto or a number of steps from 0 to %d, not %s", POLISH_MAX, text);
    return false;
}

bool ffp_cli_noise(const char *command, const char *text, double *out) {
    if (strcmp(text, "auto") == 0) {
        *out = FFP_NOISE_ESTIMATED;
        return true;
    }
    if (ffp_cli_real(text, 0, NOISE_MAX, out)) return true;
    ffp_cli_usage(command, "--noise is auto or a number from 0 to %g, not %s", NOISE_MAX, text);
    return false;
}

bool ffp_cli_layers(const char *command, const char *text, double *out) {
    const bool automatic = strcmp(text, "auto") == 0;
    if (automatic || strcmp(text, "all") == 0) {
        *out = automatic ? FFP_LAYERS_AUTO : 0;
        return true;
    }
    if (ffp_cli_real(text, LAYERS_MIN, LAYERS_MAX, out)) return true;
    ffp_cli_usage(command, "--layers is auto, all or a number from %g to %d, not %s", LAYERS_MIN, LAYERS_MAX,
                  text);
    return false;
}

void ffp_cli_append(FfpList *list, const char *value) {
    const char **values = realloc(list->values, ((size_t)list->count + 1) * sizeof *values);
    if (!values) abort();
    list->values = values;
    list->values[list->count++] = value;
}

void ffp_cli_list_free(FfpList *list) {
    free(list->values);
    *list = (FfpList){0};
}

bool ffp_cli_drawing(const char *command, const char *text, FfpDrawing *drawing) {
    drawing->form = strcmp(text, "paper") == 0 ? FFP_FORM_PAPER : FFP_FORM_OURS;
    if (drawing->form == FFP_FORM_PAPER || strcmp(text, "ours") == 0) return true;
    ffp_cli_usage(command, "--drawing is ours or paper, not %s", text);
    return false;
}

bool ffp_cli_samples(const char *command, const char *text, FfpDrawing *drawing) {
    int64_t samples;
    if (!ffp_cli_number(text, 1, SAMPLES_MAX, &samples)) {
        ffp_cli_usage(command, "--samples is a number from 1 to %d, not %s", SAMPLES_MAX, text);
        return false;
    }
    drawing->samples = (int)samples;
    return true;
}

int ffp_cli_device(const char *command, const char *name) {
    FfpError err = {0};
    if (strcmp(name, "cpu") != 0 && strcmp(name, "cuda") != 0)
        return ffp_cli_usage(command, "--device is cpu or cuda, not %s", name);
    return ffp_device_open(name, &err) ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

// Output that was lost on the way (a full disk behind a pipe) is an error too.
static int finish(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    fprintf(stderr, "ffprocams: error: cannot write (standard output)\n");
    return FFP_EXIT_FAILURE;
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fputs(help, stderr);
        return FFP_EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        fputs(help, stdout);
        return finish(FFP_EXIT_OK);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("ffprocams %s\n", ffp_version());
        return finish(FFP_EXIT_OK);
    }
    FfpError err;
    if (!ffp_cpu_check(&err)) return ffp_cli_fail(&err);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (strcmp(argv[1], commands[i].name) == 0) return finish(commands[i].run(argc - 1, argv + 1));
    return ffp_cli_usage(NULL, "there is no command %s", argv[1]);
}
