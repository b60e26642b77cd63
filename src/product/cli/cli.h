// The command line: main.c selects a command; each has a file with its table and the function it runs.
#ifndef FFP_CLI_CLI_H
#define FFP_CLI_CLI_H

#include "ffprocams.h"
#include "options.h"

enum { FFP_CLI_PATH = 4096, FFP_CLI_NAME = 256 }; // of a path that a command makes, and of a name in it

#define FFP_CLI_S(count) ((count) == 1 ? "" : "s") // "1 picture", "2 pictures"

enum { FFP_EXIT_OK = 0, FFP_EXIT_FAILURE = 1, FFP_EXIT_USAGE = 2 };

extern const FfpCommand ffp_cli_import, ffp_cli_align, ffp_cli_info, ffp_cli_reconstruct, ffp_cli_refine,
    ffp_cli_render, ffp_cli_compensate, ffp_cli_map, ffp_cli_export, ffp_cli_evaluate, ffp_cli_bench,
    ffp_cli_generate, ffp_cli_train, ffp_cli_view, ffp_cli_patterns, ffp_cli_calibrate, ffp_cli_studio,
    ffp_cli_scan;

enum { FFP_CLI_COMMANDS_MAX = 32 };
extern const FfpCommand *const ffp_cli_commands[FFP_CLI_COMMANDS_MAX]; // in the order of the help; then NULL
const FfpCommand *ffp_cli_command(const char *name);                   // NULL: none is called so

int ffp_cli_fail(const FfpError *err); // "ffprocams: error: WHAT (WHERE)"; returns FFP_EXIT_FAILURE
// The same, and a hint where one of the --pattern values looks like several: "-p a,b".
int ffp_cli_fail_patterns(const FfpError *err, const FfpList *patterns);
// "ffprocams: error: WHAT" and where to read more; returns FFP_EXIT_USAGE
int ffp_cli_usage(const char *command, const char *what_format, ...) __attribute__((format(printf, 2, 3)));

// If other programs also use the processors, restarts this one with threads that sleep while they wait
// (OMP_WAIT_POLICY=passive), unless the user has set that variable or nothing would be gained. Otherwise
// returns.
void ffp_cli_wait_passively(char **argv);

// Calls the function on a stack of 8 MB, and gives later threads as much, if the user's limit (ulimit -s) is
// lower; otherwise it just calls it. Returns what it returns.
int ffp_cli_on_large_stack(int (*function)(void *argument), void *argument);

// The program's one context, which writes to stderr and is cancelled by SIGINT and SIGTERM: they end a call
// as soon as it can end cleanly; a second one ends the program at once. open: again, with another device.
bool ffp_cli_open_context(FfpDeviceKind device, FfpError *err);
FfpContext *ffp_cli_context(void);
// Continues after a call that was ended by a signal.
void ffp_cli_clear_interrupt(void);
void ffp_cli_clear_progress(void); // takes the line of progress off the terminal
// The command prints what its calls find itself, on stdout.
void ffp_cli_findings_are_printed(void);
// Releases it. If a signal has ended a call, the program ends by that signal, as its parent expects.
void ffp_cli_close_context(void);
// The value of --device: everything from here on runs there. NULL: no change.
bool ffp_cli_use_device(const char *name, FfpError *err);

// --events: what happens, as lines of JSON to the file descriptor of this number. open: false, it is none.
bool ffp_cli_open_events(const char *descriptor);
int ffp_cli_events(void); // the descriptor; -1: nobody listens
void ffp_cli_event_progress(const FfpProgress *progress);
void ffp_cli_event_finding(const FfpFinding *finding);
// Those of all calls from now on, and so far: an array of JSON.
struct json_t *ffp_cli_keep_findings(void);
void ffp_cli_event_log(FfpLogLevel level, const char *text);
void ffp_cli_event_error(const FfpError *err);

// Processes of an MPI job share the command's work: its calls then have their ranks, and only the first
// prints common messages. Does nothing in a process that was started alone.
bool ffp_cli_use_ranks(FfpError *err);
// For that and the end of the program. join: finds the job; leave: all of it ends unless status is
// FFP_EXIT_OK.
bool ffp_cli_join_ranks(FfpError *err);
const FfpRanks *ffp_cli_ranks(void); // NULL: alone
int ffp_cli_leave_ranks(int status);
const char *ffp_cli_rank_name(void); // "rank 3: "; "" alone

// Prints a command as it would be typed into a shell, and runs it as a process of its own that shares this
// one's output: of this program if its first word is "ffprocams". It hears of SIGINT, SIGTERM, SIGHUP,
// SIGQUIT and SIGTSTP, unless they are ignored. Returns its exit code.
void ffp_cli_type(FILE *out, const FfpList *words);
int ffp_cli_child(const FfpList *words);
void ffp_cli_end_as_child(void); // by the signal that ended one, or returns

// Headings of the commands in the program's help.
#define FFP_CLI_CAPTURE "make a capture"
#define FFP_CLI_RECONSTRUCT "reconstruct"
#define FFP_CLI_LOOK "look"
#define FFP_CLI_PROJECT "project"
#define FFP_CLI_EVALUATE "evaluate"
#define FFP_CLI_TRAIN "train"

// Options and arguments of several commands; `place` is the offset of their destination.
extern const FfpWord ffp_cli_framings[], ffp_cli_up[], ffp_cli_auto[], ffp_cli_layers[], ffp_cli_forms[],
    ffp_cli_page_forms[], ffp_cli_devices[], ffp_cli_none[];
#define FFP_CLI_GAUSSIANS(place)                                                                             \
    {                                                                                                        \
        .name = "FILE.ply", .least = 1, .most = 1, .offset = (place),                                        \
        .help = "Gaussians written by `ffprocams reconstruct`"                                               \
    }
#define FFP_CLI_CAPTURE_OPTION(place, text)                                                                  \
    {                                                                                                        \
        .name = "capture", .letter = 'c', .argument = "CAPTURE", .type = FFP_OPTION_FILE, .required = true,  \
        .offset = (place), .help = (text)                                                                    \
    }
#define FFP_CLI_FOLDER(place, text)                                                                          \
    {                                                                                                        \
        .name = "output", .letter = 'o', .argument = "DIR", .type = FFP_OPTION_FOLDER, .required = true,     \
        .offset = (place), .help = (text)                                                                    \
    }
#define FFP_CLI_FILE(place, file, text)                                                                      \
    {                                                                                                        \
        .name = "output", .letter = 'o', .argument = (file), .type = FFP_OPTION_FILE, .writes = true,        \
        .required = true, .offset = (place), .help = (text)                                                  \
    }
#define FFP_CLI_VIEWS(place, text)                                                                           \
    {                                                                                                        \
        .name = "view", .letter = 'v', .argument = "ID", .type = FFP_OPTION_TEXT, .repeated = true,          \
        .offset = (place), .help = (text)                                                                    \
    }
#define FFP_CLI_PATTERNS(place, text)                                                                        \
    {                                                                                                        \
        .name = "pattern", .letter = 'p', .argument = "NAME", .type = FFP_OPTION_TEXT, .repeated = true,     \
        .offset = (place), .help = (text)                                                                    \
    }
#define FFP_CLI_MODEL(place, text)                                                                           \
    {                                                                                                        \
        .name = "model", .letter = 'm', .argument = "FILE|none", .type = FFP_OPTION_FILE, .offset = (place), \
        .words = ffp_cli_none, .help = (text)                                                                \
    }
#define FFP_CLI_JSON(place, text)                                                                            \
    { .name = "json", .type = FFP_OPTION_FLAG, .offset = (place), .help = (text) }
#define FFP_CLI_POSES(place)                                                                                 \
    {                                                                                                        \
        .name = "poses", .argument = "FILE", .type = FFP_OPTION_FILE, .offset = (place),                     \
        .help = "other poses of camera and projector (targets.json or scene.json)"                           \
    }
#define FFP_CLI_POLISH(place, text)                                                                          \
    {                                                                                                        \
        .name = "polish", .argument = "STEPS", .type = FFP_OPTION_INT64, .offset = (place), .low = 0,        \
        .high = 1000000, .words = ffp_cli_auto, .takes = "auto or a number of steps from 0 to 1000000",      \
        .help = (text)                                                                                       \
    }
#define FFP_CLI_NOISE(place, text)                                                                           \
    {                                                                                                        \
        .name = "noise", .argument = "S", .type = FFP_OPTION_REAL, .offset = (place), .least = 0,            \
        .most = 0.2, .words = ffp_cli_auto, .help = (text)                                                   \
    }
#define FFP_CLI_LAYERS(place, text)                                                                          \
    {                                                                                                        \
        .name = "layers", .argument = "N", .type = FFP_OPTION_REAL, .offset = (place), .least = 0.5,         \
        .most = 100, .words = ffp_cli_layers, .help = (text)                                                 \
    }
#define FFP_CLI_DRAWING(place, text)                                                                         \
    {                                                                                                        \
        .name = "drawing", .argument = "D", .type = FFP_OPTION_CHOICE, .offset = (place),                    \
        .words = ffp_cli_forms, .help = (text)                                                               \
    }
#define FFP_CLI_FRAMING(place, text)                                                                         \
    {                                                                                                        \
        .name = "fit", .argument = "HOW", .type = FFP_OPTION_CHOICE, .offset = (place),                      \
        .words = ffp_cli_framings,                                                                           \
        .help = text " of another shape: cover (default) fills the frame and cuts off what is beyond it, "   \
                     "contain shows all of the picture with black beside it, stretch distorts it, pixel "    \
                     "shows it pixel for pixel"                                                              \
    }
// A capture whose photographs are left in their files; NULL: an error.
FfpCapture *ffp_cli_open_devices(const char *path, bool sphere, FfpError *err);
// By --up (int: 0, or 1 + FfpUp), or otherwise as the capture shows; see ffp_gaussians_turn.
bool ffp_cli_turn(FfpGaussians *gaussians, const char *path, const FfpCapture *capture, int up,
                  FfpError *err);
#define FFP_CLI_UP(place)                                                                                    \
    {                                                                                                        \
        .name = "up", .argument = "AXIS", .type = FFP_OPTION_CHOICE, .offset = (place), .words = ffp_cli_up, \
        .help = "of splats of another program, the direction that is up in their file: y (as export writes " \
                ".spz, .glb and .gltf), -y (.ply), or z for the capture's axes. Default: what fits the "     \
                "capture's silhouettes and colours, with a message"                                          \
    }
#define FFP_CLI_FORM_HELP                                                                                    \
    "ours (default), or paper for Gaussians from a model in the paper's form, or gs-procams for those "      \
    "fitted in it: the paper's form, in light without cosine and falloff"
#define FFP_CLI_SAMPLES(place, text)                                                                         \
    {                                                                                                        \
        .name = "samples", .argument = "N", .type = FFP_OPTION_INT, .offset = (place), .low = 1, .high = 4,  \
        .help = (text)                                                                                       \
    }
#define FFP_CLI_SAMPLES_HELP                                                                                 \
    "draw with N x N samples per pixel, 1 to 4. More are smoother and slower. Default: the model's "         \
    "setting, "                                                                                              \
    "otherwise 2 (1 in the paper's form)"
#define FFP_CLI_FORCE(place)                                                                                 \
    {                                                                                                        \
        .name = "force", .type = FFP_OPTION_FLAG, .offset = (place),                                         \
        .help = "continue although a view's photographs contradict the others or its devices (turned, "      \
                "mirrored, exchanged, black for white): otherwise that is an error, which names the view"    \
    }
#define FFP_CLI_DEVICE(place, text)                                                                          \
    {                                                                                                        \
        .name = "device", .argument = "cpu|cuda", .type = FFP_OPTION_NAME, .offset = (place),                \
        .words = ffp_cli_devices, .help = (text)                                                             \
    }

#endif
