#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "cli.h"

static const FfpCommand *const commands[] = {
    &ffp_cli_patterns,
    &ffp_cli_calibrate,
    &ffp_cli_import,
    &ffp_cli_align,
    &ffp_cli_info,
    &ffp_cli_reconstruct,
    &ffp_cli_refine,
    &ffp_cli_render,
    &ffp_cli_view,
    &ffp_cli_export,
    &ffp_cli_compensate,
    &ffp_cli_map,
    &ffp_cli_evaluate,
    &ffp_cli_bench,
    &ffp_cli_generate,
    &ffp_cli_train,
    NULL,
};

// Beside --help, which everything has.
static const FfpOption options[] = {
    {.name = "version", .help = "the version"},
    {.name = "pages",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .help = "write the manual pages of all commands and ffprocams-completion.bash, for the completion of "
             "bash, into a folder"},
    {0},
};

static const FfpProgram program = {
    .name = "ffprocams",
    .purpose = "turns photographs of an object under projected patterns into relightable 3D Gaussians",
    .prose = "From eight photographed projector-camera views of an object to relightable 3D Gaussians, and "
             "pictures of the object under any pattern, camera pose and projector pose.",
    .commands = commands,
    .options = options,
    .environment = "The environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16, amx) chooses "
                   "the kernels in place of the best ones that the processor can run; OMP_NUM_THREADS is the "
                   "number of threads, OMP_WAIT_POLICY (active, passive) how they wait for each other, which "
                   "follows from how busy the machine is otherwise.",
    .exit_status = "Exit status: 0 when all went well, 1 on an error (told on stderr; no output is left "
                   "half-written), 2 for wrong usage.",
    .examples = (const FfpExample[]){{.command = "ffprocams reconstruct data/sample -o spot.ply"},
                                     {.command = "ffprocams render spot.ply --capture data/sample --pattern "
                                                 "lollipop_3 -o relit"},
                                     {0}},
};

const FfpWord ffp_cli_auto[] = {{"auto", -1}, {0}}; // FFP_POLISH_AUTO and FFP_NOISE_ESTIMATED
const FfpWord ffp_cli_layers[] = {{"auto", FFP_LAYERS_AUTO}, {"all", 0}, {0}};
const FfpWord ffp_cli_forms[] = {
    {"ours", FFP_FORM_OURS}, {"paper", FFP_FORM_PAPER}, {"gs-procams", FFP_FORM_GS_PROCAMS}, {0}};
const FfpWord ffp_cli_page_forms[] = {{"ours", FFP_FORM_OURS}, {"paper", FFP_FORM_PAPER}, {0}};
const FfpWord ffp_cli_devices[] = {{"cpu", 0}, {"cuda", 1}, {0}};
const FfpWord ffp_cli_none[] = {{"none", 0}, {0}};

int ffp_cli_fail(const FfpError *err) {
    ffp_cli_clear_progress();
    fprintf(stderr, "ffprocams: %serror: %s\n", ffp_cli_rank_name(), err->text);
    return FFP_EXIT_FAILURE;
}

// A comma may be part of a name, so it is no mistake by itself.
int ffp_cli_fail_patterns(const FfpError *err, const FfpList *patterns) {
    const int status = ffp_cli_fail(err);
    for (int i = 0; i < patterns->count; i++) {
        const char *name = patterns->values[i];
        const size_t length = strcspn(name, "=");
        if (memchr(name, ',', length) == NULL) continue;
        fprintf(stderr,
                "ffprocams: '%.*s' is taken as one pattern's name; repeat -p for several: -p A -p B\n",
                (int)length, name);
        break;
    }
    return status;
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

bool ffp_cli_use_device(const char *name, FfpError *err) {
    const FfpDeviceKind kind = name && strcmp(name, "cuda") == 0 ? FFP_DEVICE_CUDA : FFP_DEVICE_CPU;
    return !name || ffp_cli_open_context(kind, err);
}

// Output that was lost on the way (a full disk behind a pipe) is an error too.
static int finish(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    fprintf(stderr, "ffprocams: error: cannot write (standard output)\n");
    return FFP_EXIT_FAILURE;
}

static int unknown_command(const char *word) {
    enum { COUNT = sizeof commands / sizeof *commands + sizeof options / sizeof *options };
    const char *names[COUNT] = {"help"};
    const bool dashes = strncmp(word, "--", 2) == 0;
    int n = 1;
    for (const FfpOption *option = options; option->name; option++) names[n++] = option->name;
    const int first_command = n;
    for (int i = 0; commands[i]; i++) names[n++] = commands[i]->name;
    const char *nearest = ffp_cli_nearest(dashes ? word + 2 : word, names);
    const char *what = dashes ? "unknown option" : "there is no command";
    if (!nearest) return ffp_cli_usage(NULL, "%s %s", what, word);
    bool option = false;
    for (int i = 0; i < first_command; i++) option |= names[i] == nearest;
    return ffp_cli_usage(NULL, "%s %s: did you mean %s%s?", what, word, option ? "--" : "", nearest);
}

static int run(const FfpCommand *command, int argc, char **argv) {
    FfpError err;
    if (!ffp_cpu_check(&err) || !ffp_cli_open_context(FFP_DEVICE_CPU, &err)) return ffp_cli_fail(&err);
    const int status = ffp_cli_leave_ranks(finish(ffp_cli_run(command, argc, argv)));
    ffp_cli_close_context();
    return status;
}

int main(int argc, char **argv) {
    FfpProgram here = program;
    here.version = ffp_version();
    if (argc < 2) {
        ffp_cli_program_help(&here, stderr);
        return FFP_EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        ffp_cli_program_help(&here, stdout);
        return finish(FFP_EXIT_OK);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("ffprocams %s\n", here.version);
        return finish(FFP_EXIT_OK);
    }
    if (strcmp(argv[1], "--pages") == 0)
        return argc == 3 ? ffp_cli_pages(&here, argv[2])
                         : ffp_cli_usage(NULL, "--pages needs a value, and nothing more: DIR");
    for (int i = 0; commands[i]; i++)
        if (strcmp(argv[1], commands[i]->name) == 0) {
            ffp_cli_wait_kindly(argv);
            return run(commands[i], argc - 1, argv + 1);
        }
    return unknown_command(argv[1]);
}
