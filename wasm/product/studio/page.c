// The studio in a page (view/studio_page.js): its folder is /studio of the worker's files, which
// view/engine_worker.js keeps in the browser's storage; commands run inside the worker, one after the other,
// after the request that began them.
#include <emscripten.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "product/studio/studio.h"

#define FOLDER "/studio"
#define SLOWER 3.6 // than the program on one thread (docs/design/portability.md)

int command_line(int argc, char **argv); // src/product/cli/main.c
const char *studio_open(int run);
const char *studio_state(void);
const char *studio_post(const char *path, const char *set, const char *number, const char *watch,
                        const char *body, size_t size);
int studio_work(int events);
void studio_hear(int is_event, const char *line);

static FfpStudio *studio;
static FfpStudioJob *working; // whose command runs
static char *answer;

// studio_work comes to it. A page has no simulator: what its rig was not photographed with cannot be.
static bool run(FfpStudio *s, FfpStudioJob *job) {
    return job != &s->camera;
}

static void stop(FfpStudio *s, FfpStudioJob *job) {
    (void)s, (void)job; // it has not begun; the page ends the worker of one that has
}

static bool watch(FfpStudio *s, const char *folder, char said[FFP_STUDIO_SAID]) {
    (void)s, (void)folder;
    return ffp_studio_say(said, "a page cannot watch a folder");
}

static const char *told(json_t *state) {
    free(answer);
    answer = json_dumps(state, JSON_COMPACT);
    json_decref(state);
    return answer ? answer : "{\"error\": \"no memory\"}";
}

// Opens the studio of the folder. `run`: another number each time. Returns "", or what is wrong.
EMSCRIPTEN_KEEPALIVE const char *studio_open(int number) {
    static const FfpStudioPlatform platform = {run, stop, watch};
    static char said[FFP_STUDIO_SAID];
    if (studio) return "";
    FfpStudio *s = calloc(1, sizeof *s);
    if (!s) return "no memory";
    s->platform = &platform;
    s->run = number;
    s->speed = 1 / SLOWER;
    s->shown = -1;
    s->root = open(FOLDER, O_RDONLY | O_DIRECTORY);
    if (s->root < 0 || !ffp_studio_load(s, false, said)) {
        if (!said[0]) ffp_studio_say(said, "there is no room for its files");
        if (s->root >= 0) close(s->root);
        ffp_studio_close(s);
        free(s);
        return said;
    }
    studio = s;
    return "";
}

EMSCRIPTEN_KEEPALIVE const char *studio_state(void) {
    return told(ffp_studio_state(studio));
}

// As FfpStudioRequest; "": the address has none. Returns the state as JSON, with "error" where it was
// refused.
EMSCRIPTEN_KEEPALIVE const char *studio_post(const char *path, const char *set, const char *number,
                                             const char *watched, const char *body, size_t size) {
    bool ok;
    const FfpStudioRequest request = {.path = path,
                                      .set = *set ? set : NULL,
                                      .number = *number ? number : NULL,
                                      .watch = *watched ? watched : NULL,
                                      .body = body,
                                      .size = size};
    return told(ffp_studio_answer(studio, &request, &ok));
}

// The next command of a job, or its end.
static void run_command(FfpStudioJob *job, const char *descriptor) {
    char *words[FFP_STUDIO_WORDS + 3], how[64];
    working = job;
    if (ffp_studio_begin_command(studio, job, descriptor, words)) {
        int argc = 0;
        while (words[argc]) argc++;
        const int status = command_line(argc, words);
        fflush(NULL);
        snprintf(how, sizeof how, "exit status %d", status);
        ffp_studio_end_command(job, status == 0 ? NULL : how);
        ffp_studio_changed(studio);
    } else {
        ffp_studio_end_job(studio, job);
    }
    working = NULL;
}

// Runs a command of each job that was begun, with its --events to a descriptor. Returns how many jobs there
// were.
EMSCRIPTEN_KEEPALIVE int studio_work(int events) {
    FfpStudioJob *const jobs[] = {&studio->job, &studio->camera, &studio->eye};
    char descriptor[16];
    int count = 0;
    snprintf(descriptor, sizeof descriptor, "%d", events);
    if (chdir(FOLDER) != 0) return 0;
    for (int i = 0; i < 3; i++) {
        if (jobs[i]->end != FFP_JOB_RUNNING) continue;
        run_command(jobs[i], descriptor);
        count++;
    }
    return chdir("/") == 0 ? count : 0;
}

// A line of the command that runs: of its events or of its text.
EMSCRIPTEN_KEEPALIVE void studio_hear(int is_event, const char *line) {
    if (!working) return;
    if (is_event)
        ffp_studio_hear_event(working, line);
    else
        ffp_studio_hear_text(working, line);
    studio->version++;
}
