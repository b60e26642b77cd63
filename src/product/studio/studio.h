// The studio's rules, from a bare projector and a camera to the relit object: which photographs there are to
// be, which is due, what may be asked for and what a page is told. Whatever it makes is made by the program's
// other commands; its state is the files of one folder (docs/reference/formats/studio.md). A platform has the
// folder and runs the commands: a server with processes (product/server), or a browser's page
// (wasm/product/studio).
#ifndef FFP_STUDIO_STUDIO_H
#define FFP_STUDIO_STUDIO_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "jobs.h"

enum {
    FFP_STUDIO_NAME = 160,  // of a path inside the folder, with its 0
    FFP_STUDIO_SAID = 400,  // of a message
    FFP_STUDIO_SHOTS = 256, // of a set
    FFP_STUDIO_SETS = 256   // of an object or the calibration
};

typedef struct FfpStudio FfpStudio;

// All with the platform's lock.
typedef struct FfpStudioPlatform {
    // Runs the commands of a job that has begun (jobs.h), now or as soon as it can; false: it cannot.
    bool (*run)(FfpStudio *studio, FfpStudioJob *job);
    void (*stop)(FfpStudio *studio, FfpStudioJob *job); // at once, if the job was asked before (job->stop)
    // Watches a folder that a camera fills, in place of the one before, which stays if this one cannot be.
    bool (*watch)(FfpStudio *studio, const char *folder, char said[FFP_STUDIO_SAID]);
} FfpStudioPlatform;

struct FfpStudio {
    const FfpStudioPlatform *platform;
    char folder[4096];  // absolute
    int root;           // the open folder
    char program[4096]; // its path, for whoever has to start it again; "": there is none
    long run;           // another number each time that it is started
    double speed;       // of commands: processors that they have, each as fast as the program's
    bool watching;      // a folder that a camera fills
    bool closing;
    json_t *settings; // studio.json
    uint64_t version; // of what the page is told; grows with every change
    json_t *listed;   // the folder's sets and objects as they are told; NULL: to be looked up again
    char notice[FFP_STUDIO_SAID];
    int shown; // number of the shot whose pattern is on the projector, where a camera fills a folder; -1:
               // none
    FfpStudioJob job, camera, eye; // what the user began; the virtual camera; what looks for the board
};

// --- For a platform; all with its lock. ---

// studio.json of the open folder, which is written if there is none; false: what is wrong with it.
bool ffp_studio_load(FfpStudio *studio, bool virtual_rig, char said[FFP_STUDIO_SAID]);
bool ffp_studio_save(FfpStudio *studio, char said[FFP_STUDIO_SAID]);
void ffp_studio_close(FfpStudio *studio); // frees what it holds; no job runs any more
// Everything that a page shows.
json_t *ffp_studio_state(FfpStudio *studio);

// A request of a page: "do" with {"verb": ...}, "photograph" with a shot's picture, "own" with one of the
// user's.
typedef struct FfpStudioRequest {
    const char *path, *set, *number, *watch; // of the address; NULL: it has none
    const char *body;
    size_t size;
} FfpStudioRequest;
// The state after it, with "error" where `ok` is false: why it was refused.
json_t *ffp_studio_answer(FfpStudio *studio, const FfpStudioRequest *request, bool *ok);

// A file has come into the folder that a camera fills: the photograph of the pattern that is shown, or
// nothing.
void ffp_studio_arrived(FfpStudio *studio, const char *folder, const char *file);
// Something beside a job's progress has changed: the page is told, and what is in the folder is looked up
// again.
void ffp_studio_changed(FfpStudio *studio);
// The message; false, for `return`.
bool ffp_studio_say(char said[FFP_STUDIO_SAID], const char *format, ...)
    __attribute__((format(printf, 2, 3)));
const char *ffp_studio_setting(const FfpStudio *studio, const char *name, const char *otherwise);
long long ffp_studio_number(const FfpStudio *studio, const char *name, int index, long long otherwise);

#endif
