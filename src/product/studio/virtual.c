// The simulated rig's camera: what the simulator photographs of what is due.
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "rules.h"

// A part of what the simulated rig photographs, as `generate --photographs` makes it.
typedef struct Stage {
    const char *folder, *patterns, *only;
    int stops;
    bool other_projector;
} Stage;

// The simulator photographs a stage under all patterns at once: its rays are the same for all of them.
static void simulate(const FfpStudio *studio, const Stage *stage, FfpStudioCommand *c) {
    ffp_studio_word(c, "ffprocams");
    ffp_studio_word(c, "generate");
    ffp_studio_word(c, "%s", stage->folder);
    ffp_studio_word(c, "--photographs");
    ffp_studio_word(c, "%s", stage->patterns);
    ffp_studio_word(c, "--only");
    ffp_studio_word(c, "%s", stage->only);
    ffp_studio_word(c, "--attitudes");
    ffp_studio_word(c, "%lld", ffp_studio_number(studio, "attitudes", -1, 8));
    ffp_studio_word(c, "--views");
    ffp_studio_word(c, "%d", stage->stops);
    if (stage->other_projector) ffp_studio_word(c, "--other-projector");
    const json_t *options = json_object_get(studio->settings, "simulator");
    for (size_t i = 0; i < json_array_size(options); i++)
        ffp_studio_word(c, "%s", json_string_value(json_array_get(options, i)));
}

// --- The object as it stands now. ---

// The patterns of the set alone, and where the table stands.
static bool copy_pattern(FfpStudio *studio, const FfpStudioShot *shot) {
    char to[FFP_STUDIO_NAME];
    size_t size;
    const char *name = strrchr(shot->pattern, '/') + 1;
    const int file = ffp_studio_open(studio, shot->pattern);
    char *bytes = file >= 0 ? ffp_studio_read_whole(file, &size) : NULL;
    if (file >= 0) close(file);
    if (shot->role == FFP_SHOT_OWN)
        snprintf(to, sizeof to, "virtual/shown/%d_own.png", FFP_STUDIO_OWN);
    else
        snprintf(to, sizeof to, "virtual/shown/%s", name);
    const bool ok = bytes && ffp_studio_write(studio, to, bytes, size);
    free(bytes);
    return ok;
}

// "view-047", as `generate --only` calls it, of so many stops.
static void place_of(const FfpStudio *studio, const FfpStudioTrial *t, char place[32], int *stops) {
    const json_t *about = ffp_studio_object(studio, t->object);
    *stops = (int)json_integer_value(json_object_get(about, "stops"));
    snprintf(place, 32, "%.31s", t->view);
    if (t->turned == 0) return;
    *stops = 360; // whole degrees
    const long angle = lround(ffp_studio_stop_angle(about, t->view)) + t->turned;
    snprintf(place, 32, "view-%03ld", (angle + 720) % 360);
}

static void trial_path(const FfpStudio *studio, const FfpStudioShot *shot, char path[2 * FFP_STUDIO_NAME]) {
    FfpStudioTrial t;
    char place[32] = "";
    int stops;
    if (ffp_studio_read_trial(studio, ffp_studio_setting(studio, "object", ""), &t))
        place_of(studio, &t, place, &stops);
    snprintf(path, 2 * FFP_STUDIO_NAME, "virtual/now/%s/%03d.png", place, shot->number);
}

static bool simulate_trial(FfpStudio *studio, const FfpStudioSet *set, FfpStudioCommand *c) {
    FfpStudioTrial t;
    char place[32];
    int stops;
    if (!ffp_studio_read_trial(studio, ffp_studio_setting(studio, "object", ""), &t)) return false;
    for (int i = 0; i < set->count; i++)
        if (!copy_pattern(studio, &set->shots[i])) return false;
    place_of(studio, &t, place, &stops);
    simulate(studio,
             &(Stage){.folder = "virtual/now", .patterns = "virtual/shown", .only = place, .stops = stops},
             c);
    return true;
}

// --- A second projector. ---

static const char *stop_of(const FfpStudioSet *set) {
    return strrchr(set->name, '/') + 1;
}

static bool second_of(const FfpStudio *studio, const FfpStudioSet *set, FfpStudioSecond *s) {
    return set->kind == FFP_SET_SECOND && ffp_studio_read_second(studio, set->object, s);
}

// --- The photograph that is due. ---

static int stops_of(const FfpStudio *studio, const FfpStudioSet *set) {
    if (!set->object[0]) return 1;
    return (int)json_integer_value(json_object_get(ffp_studio_object(studio, set->object), "stops"));
}

// Where the simulator writes the photograph of a shot.
static void path_of(const FfpStudio *studio, const FfpStudioSet *set, const FfpStudioShot *shot,
                    char path[2 * FFP_STUDIO_NAME]) {
    const bool table = set->kind == FFP_SET_TABLE;
    FfpStudioSecond s;
    if (set->kind == FFP_SET_TRIAL)
        trial_path(studio, shot, path);
    else if (second_of(studio, set, &s))
        snprintf(path, 2 * FFP_STUDIO_NAME, "virtual/%s/%s/%03d.png", set->stage, stop_of(set), shot->number);
    else
        snprintf(path, 2 * FFP_STUDIO_NAME, table ? "virtual/%s/%s/%02d.png" : "virtual/%s/%s/%03d.png",
                 set->stage, set->stage, shot->number);
}

// Begins to photograph a set.
static bool simulate_set(FfpStudio *studio, const FfpStudioSet *set, char *said) {
    FfpStudioCommand *c = &studio->camera.commands[0];
    char folder[2 * FFP_STUDIO_NAME], patterns[FFP_STUDIO_NAME + 16];
    FfpStudioSecond s;
    ffp_studio_clear(&studio->camera);
    snprintf(folder, sizeof folder, "virtual/%s", set->stage);
    Stage stage = {folder, "patterns", set->stage, stops_of(studio, set), false};
    studio->camera.n_commands = 1;
    if (set->kind == FFP_SET_TRIAL)
        return simulate_trial(studio, set, c) ||
               ffp_studio_say(said, "the patterns cannot be copied to virtual/shown");
    if (second_of(studio, set, &s)) {
        snprintf(patterns, sizeof patterns, "%s/patterns", s.folder);
        stage.patterns = patterns, stage.only = stop_of(set), stage.other_projector = true;
    }
    simulate(studio, &stage, c);
    return true;
}

bool ffp_studio_take(FfpStudio *studio, const char *name, int number, char said[FFP_STUDIO_SAID]) {
    FfpStudioSet set;
    char path[2 * FFP_STUDIO_NAME];
    const FfpStudioShot *shot = ffp_studio_due(studio, name, number, &set, said);
    if (!shot) return false;
    if (strcmp(ffp_studio_setting(studio, "camera", ""), "virtual") != 0 || !set.stage[0])
        return ffp_studio_say(said, "the virtual camera cannot photograph this");
    path_of(studio, &set, shot, path);
    int file = ffp_studio_open(studio, path);
    if (file < 0) { // a rig that was photographed before, for a page (wasm/rig)
        strcpy(strrchr(path, '.'), ".jpg");
        file = ffp_studio_open(studio, path);
    }
    if (file >= 0) {
        size_t size;
        char *bytes = ffp_studio_read_whole(file, &size);
        close(file);
        const bool ok = bytes ? ffp_studio_store(studio, name, number, bytes, size, said)
                              : ffp_studio_say(said, "%s cannot be read", path);
        free(bytes);
        return ok;
    }
    if (studio->camera.end == FFP_JOB_RUNNING) return true; // asked again in a moment
    if (studio->camera.end == FFP_JOB_FAILED && strcmp(studio->camera.name, "virtual") == 0) {
        studio->camera.end = FFP_JOB_NONE;
        return ffp_studio_say(said, "the virtual camera has failed; logs/virtual.txt says why");
    }
    if (!simulate_set(studio, &set, said)) return false;
    return ffp_studio_start(studio, &studio->camera, "virtual") ||
           ffp_studio_say(said, "the virtual camera cannot photograph this here");
}
