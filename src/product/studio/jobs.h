// Jobs: the program's other commands, one after the other. The rules choose them; a platform runs them.
#ifndef FFP_STUDIO_JOBS_H
#define FFP_STUDIO_JOBS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

enum {
    FFP_STUDIO_WORDS = 128,   // of a command
    FFP_STUDIO_LINES = 7,     // commands of a job
    FFP_STUDIO_LOG = 1 << 15, // what a job wrote last
    FFP_STUDIO_FINDINGS = 500 // of a job
};

typedef struct FfpStudioCommand {
    char *words[FFP_STUDIO_WORDS + 1]; // owned; NULL ends them. The first is "ffprocams"
    int count;
    bool failed; // no room
} FfpStudioCommand;

typedef enum FfpJobEnd {
    FFP_JOB_NONE,
    FFP_JOB_RUNNING,
    FFP_JOB_DONE,
    FFP_JOB_FAILED,
    FFP_JOB_STOPPED
} FfpJobEnd;

typedef struct FfpStudioJob {
    char name[32]; // "calibrate"; its log is logs/NAME.txt
    FfpStudioCommand commands[FFP_STUDIO_LINES];
    int n_commands, current;
    FfpJobEnd end;
    bool stop, failed; // asked for; a command has failed
    char stage[80];    // of the progress; "" without any
    long long done, total;
    char error[1024]; // why it failed; ""
    json_t *findings; // what its commands found, as ffp_finding_json; they end in logs/NAME.json
    char log[FFP_STUDIO_LOG];
    size_t logged;
    double began, seconds;
} FfpStudioJob;

struct FfpStudio;

// --- For the rules; all with the platform's lock. ---

// A new command of a job, which has its name already; its words follow.
FfpStudioCommand *ffp_studio_command(FfpStudioJob *job, const char *name);
void ffp_studio_word(FfpStudioCommand *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
// Begins a job of the commands that it holds already; false if one runs.
bool ffp_studio_start(struct FfpStudio *studio, FfpStudioJob *job, const char *name);
void ffp_studio_stop(struct FfpStudio *studio, FfpStudioJob *job); // it ends as soon as it can
void ffp_studio_clear(FfpStudioJob *job);                          // its commands; not while it runs
// As one would type it in the folder; to be freed.
char *ffp_studio_typed(const FfpStudioCommand *command);

// --- For a platform, which runs them; all with its lock. ---

// The next command begins. Its words, with --events DESCRIPTOR among them, in `words`; false: none is left.
bool ffp_studio_begin_command(struct FfpStudio *studio, FfpStudioJob *job, const char *descriptor,
                              char *words[FFP_STUDIO_WORDS + 3]);
void ffp_studio_hear_text(FfpStudioJob *job, const char *line);  // that it wrote
void ffp_studio_hear_event(FfpStudioJob *job, const char *line); // of its --events
// It has ended: well, or as `how` says; NULL: well.
void ffp_studio_end_command(FfpStudioJob *job, const char *how);
// There is no further one, or one has failed: writes log and findings.
void ffp_studio_end_job(struct FfpStudio *studio, FfpStudioJob *job);

#endif
