// The command line: main.c picks a subcommand, each of which has a file with its help and its arguments.
#ifndef FFP_CLI_CLI_H
#define FFP_CLI_CLI_H

#include <getopt.h>
#include <stdbool.h>
#include <stdint.h>
#include "ffprocams.h"

enum { FFP_EXIT_OK = 0, FFP_EXIT_FAILURE = 1, FFP_EXIT_USAGE = 2 };

// argv[0] is the subcommand's name; all return one of the exit codes above.
int ffp_cli_import(int argc, char **argv);
int ffp_cli_align(int argc, char **argv);
int ffp_cli_reconstruct(int argc, char **argv);
int ffp_cli_refine(int argc, char **argv);
int ffp_cli_render(int argc, char **argv);
int ffp_cli_compensate(int argc, char **argv);
int ffp_cli_map(int argc, char **argv);
int ffp_cli_evaluate(int argc, char **argv);
int ffp_cli_generate(int argc, char **argv);
int ffp_cli_train(int argc, char **argv);
int ffp_cli_bench(int argc, char **argv);
int ffp_cli_info(int argc, char **argv);

// The next option: its value (the struct option's `val`, always positive), -1 at the end, or 0 when it was
// wrong (said already, with a pointer to --help).
int ffp_cli_next(int argc, char **argv, const char *short_options, const struct option *options);

int ffp_cli_fail(const FfpError *err); // "ffprocams: error: WHAT (WHERE)"; returns FFP_EXIT_FAILURE
// "ffprocams: error: WHAT" and where to read more; returns FFP_EXIT_USAGE
int ffp_cli_usage(const char *command, const char *what_format, ...) __attribute__((format(printf, 2, 3)));

// A whole decimal number in [low, high] out of an option's value; false otherwise.
bool ffp_cli_number(const char *text, int64_t low, int64_t high, int64_t *out);
bool ffp_cli_real(const char *text, double low, double high, double *out); // any finite number in between
// Values of --polish, a number of steps, --noise, `auto` or a deviation, and --layers, `auto`, `all` or a
// number; false with the usage told.
bool ffp_cli_polish(const char *command, const char *text, int64_t *out);
bool ffp_cli_noise(const char *command, const char *text, double *out);
bool ffp_cli_layers(const char *command, const char *text, double *out);

// Values of an option that may be given again and again. There cannot be more than arguments.
typedef struct FfpList {
    const char **values; // owned; the strings are argv's
    int count;
} FfpList;
void ffp_cli_append(FfpList *list, const char *value);
void ffp_cli_list_free(FfpList *list);

// Values of --drawing, a form's name, and --samples, a number; false with the usage told.
bool ffp_cli_drawing(const char *command, const char *text, FfpDrawing *drawing);
bool ffp_cli_samples(const char *command, const char *text, FfpDrawing *drawing);
// Value of --device: opens it for all that follows; else the exit code, with usage or error told.
int ffp_cli_device(const char *command, const char *name);
// Lines of help on --samples, for all commands that draw.
#define FFP_CLI_SAMPLES_HELP                                                                                 \
    "      --samples N        draw with N x N samples a pixel, 1 to 4. More are smoother and slower.\n"      \
    "                         Default: as the model has it, else 2 (1 in the paper's form)\n"

#endif
