#include <limits.h>
#include <stdio.h>
#include <string.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include "cli.h"

// Beside --help, which everything has.
static const FfpOption options[] = {
    {.name = "version", .help = "the version"},
    {.name = "pages",
     .argument = "DIR",
     .type = FFP_OPTION_FOLDER,
     .help = "write the manual pages of all commands, ffprocams-completion.bash, for completion in bash, and "
             "ffprocams-options.md, the reference of all options, to this folder"},
    {.name = "events",
     .argument = "FD COMMAND...",
     .type = FFP_OPTION_TEXT,
     .help =
         "run a command and write what happens to this file descriptor, a line of JSON each: progress with "
         "its stage, findings, notes, warnings and errors; progress is then not shown otherwise"},
    {0},
};

static const FfpProgram program = {
    .name = "ffprocams",
    .purpose = "turns photographs of an object under projected patterns into relightable 3D Gaussians",
    .prose = "From eight photographed projector-camera views of an object to relightable 3D Gaussians, and "
             "pictures of the object under any pattern, camera pose and projector pose.",
    .commands = ffp_cli_commands,
    .options = options,
    .environment = "The environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16, amx; on "
                   "ARM portable, neon, neonbf16) selects kernels other than the best that the processor "
                   "supports. OMP_NUM_THREADS sets the number of threads and OMP_WAIT_POLICY (active, "
                   "passive) how they wait for each other; by "
                   "default that depends on how busy the machine is. FFPROCAMS_MODELS and FFPROCAMS_MODULES "
                   "name the folders of the shipped weights and of the modules (Embree, Assimp, OpenCV, "
                   "libtiff, Little CMS, Zstandard, libwebp), if they lie elsewhere than where they were "
                   "built or installed.",
    .exit_status = "Exit status: 0 on success, 1 on an error (reported on stderr; no output is left "
                   "half-written), 2 for incorrect usage.",
    .examples = (const FfpExample[]){{.command = "ffprocams reconstruct data/sample -o spot.ply"},
                                     {.command = "ffprocams render spot.ply --capture data/sample --pattern "
                                                 "lollipop_3 -o relit"},
                                     {0}},
};

// Output that was lost on the way (a full disk behind a pipe) is an error too.
static int finish(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    fprintf(stderr, "ffprocams: error: cannot write (standard output)\n");
    return FFP_EXIT_FAILURE;
}

static int unknown_command(const char *word) {
    const char *names[FFP_CLI_COMMANDS_MAX + sizeof options / sizeof *options] = {"help"};
    const bool dashes = strncmp(word, "--", 2) == 0;
    int n = 1;
    for (const FfpOption *option = options; option->name; option++) names[n++] = option->name;
    const int first_command = n;
    for (int i = 0; ffp_cli_commands[i]; i++) names[n++] = ffp_cli_commands[i]->name;
    const char *nearest = ffp_cli_nearest(dashes ? word + 2 : word, names);
    const char *what = dashes ? "unknown option" : "unknown command";
    if (!nearest) return ffp_cli_usage(NULL, "%s %s", what, word);
    bool option = false;
    for (int i = 0; i < first_command; i++) option |= names[i] == nearest;
    return ffp_cli_usage(NULL, "%s %s: did you mean %s%s?", what, word, option ? "--" : "", nearest);
}

const FfpCommand *ffp_cli_command(const char *name) {
    for (int i = 0; ffp_cli_commands[i]; i++)
        if (strcmp(ffp_cli_commands[i]->name, name) == 0) return ffp_cli_commands[i];
    return NULL;
}

typedef struct Given {
    const FfpCommand *command;
    int argc;
    char **argv;
} Given;

static int run(void *argument) {
    const Given *given = argument;
    FfpError err;
    if (!ffp_cpu_check(&err) || !ffp_cli_open_context(FFP_DEVICE_CPU, &err)) return ffp_cli_fail(&err);
    const int status = ffp_cli_leave_ranks(finish(ffp_cli_run(given->command, given->argc, given->argv)));
    ffp_cli_close_context();
    return status;
}

// Arrays of a reconstruction of 1024 x 1024, and large photographs, have tens of megabytes and come and go:
// by default each goes back to the system and is faulted in again, page by page (docs/design/performance.md).
// One arena, because a thread's own has heaps of 64 MB, which go back when they are empty.
static void keep_large_blocks(void) {
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, INT_MAX);
    mallopt(M_ARENA_MAX, 1);
#endif
}

int main(int argc, char **argv) {
    static char help[] = "--help";
    FfpProgram here = program;
    here.version = ffp_version();
    if (argc == 3 && strcmp(argv[1], "help") == 0) argv[1] = argv[2], argv[2] = help; // help COMMAND
    if (argc < 2) {
        ffp_cli_program_help(&here, stderr);
        return FFP_EXIT_USAGE;
    }
    if (strcmp(argv[1], help) == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], help + 2) == 0) {
        ffp_cli_program_help(&here, stdout);
        return finish(FFP_EXIT_OK);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("ffprocams %s\n", here.version);
        return finish(FFP_EXIT_OK);
    }
    if (strcmp(argv[1], "--pages") == 0)
        return argc == 3 ? ffp_cli_pages(&here, argv[2])
                         : ffp_cli_usage(NULL, "--pages takes exactly one value: DIR");
    char **const whole = argv;
    const char *events = strcmp(argv[1], "--events") == 0 ? argv[2] : NULL;
    if (whole[1] && strcmp(whole[1], "--events") == 0) {
        if (argc < 4)
            return ffp_cli_usage(NULL, "--events takes the number of a file descriptor, and a command");
        argc -= 2, argv += 2;
    }
    const FfpCommand *command = ffp_cli_command(argv[1]);
    if (!command) return unknown_command(argv[1]);
    ffp_cli_wait_passively(whole);
    if (events && !ffp_cli_open_events(events))
        return ffp_cli_usage(NULL, "--events: %s is not an open file descriptor", events);
    if (command == &ffp_cli_reconstruct || command == &ffp_cli_import) keep_large_blocks();
    return ffp_cli_on_large_stack(run, &(Given){command, argc - 1, argv + 1});
}
