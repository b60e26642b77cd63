// studio.json, and what the page is told.
#define _GNU_SOURCE
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "rules.h"

bool ffp_studio_say(char said[FFP_STUDIO_SAID], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(said, FFP_STUDIO_SAID, format, arguments);
    va_end(arguments);
    return false;
}

// --- studio.json. ---

// The virtual rig's board, angles and panel are the simulator's; with a real one they are only a beginning.
static json_t *new_settings(bool virtual_rig) {
    if (virtual_rig)
        return json_pack(
            "{s:i, s:b, s:b, s:s, s:[ii], s:i, s:[ii], s:i, s:[iiiii], s:i, s:i, s:[], s:{}, s:[ssssssssss]}",
            "version", 1, "virtual", 1, "without_board", 1, "camera", "virtual", "projector", 320, 200,
            "lollipops", 2, "board", 9, 6, "square", 16, "board_angles", -40, -20, 0, 20, 40, "attitudes", 8,
            "width", 128, "fix", "objects", "simulator", "--split", "test", "--first", "15", "--resolution",
            "360", "--sensor", "read=0.003", "--sensor", "shot=0.0003");
    return json_pack("{s:i, s:b, s:b, s:s, s:[ii], s:i, s:[ii], s:i, s:[iiiii], s:i, s:i, s:[], s:{}}",
                     "version", 1, "virtual", 0, "without_board", 1, "camera", "browser", "projector", 1920,
                     1080, "lollipops", 2, "board", 9, 6, "square", 25, "board_angles", 0, 15, 30, 45, 60,
                     "attitudes", 8, "width", 128, "fix", "objects");
}

bool ffp_studio_save(FfpStudio *studio, char said[FFP_STUDIO_SAID]) {
    char *text = json_dumps(studio->settings, JSON_INDENT(1) | JSON_REAL_PRECISION(12));
    const bool ok = text && ffp_studio_write(studio, "studio.json", text, strlen(text));
    ffp_studio_changed(studio);
    free(text);
    return ok ||
           ffp_studio_say(said, "studio.json cannot be written: %s", text ? strerror(errno) : "no memory");
}

// Faults that another program, or an unlucky hand, left in the file end the start, not the session.
static const char *wrong_field(const json_t *s) {
    static const struct {
        const char *name;
        json_type type;
        size_t count; // of an array's whole numbers; 0: any
    } fields[] = {
        {"camera", JSON_STRING, 0},  {"projector", JSON_ARRAY, 2},    {"lollipops", JSON_INTEGER, 0},
        {"board", JSON_ARRAY, 2},    {"board_angles", JSON_ARRAY, 0}, {"attitudes", JSON_INTEGER, 0},
        {"objects", JSON_OBJECT, 0}, {"fix", JSON_ARRAY, 0},          {"width", JSON_INTEGER, 0}};
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        const json_t *value = json_object_get(s, fields[i].name);
        if (!value || json_typeof(value) != fields[i].type) return fields[i].name;
        if (fields[i].count > 0 && json_array_size(value) != fields[i].count) return fields[i].name;
        for (size_t k = 0; k < fields[i].count; k++)
            if (!json_is_integer(json_array_get(value, k))) return fields[i].name;
    }
    return json_is_number(json_object_get(s, "square")) ? NULL : "square";
}

bool ffp_studio_load(FfpStudio *studio, bool virtual_rig, char said[FFP_STUDIO_SAID]) {
    studio->version = 1;
    if (!ffp_studio_exists(studio, "studio.json")) {
        studio->settings = new_settings(virtual_rig);
        return studio->settings ? ffp_studio_save(studio, said) : ffp_studio_say(said, "no memory");
    }
    studio->settings = ffp_studio_read_json(studio, "studio.json");
    if (!json_is_object(studio->settings)) return ffp_studio_say(said, "studio.json cannot be read");
    const char *wrong = wrong_field(studio->settings);
    if (wrong) return ffp_studio_say(said, "studio.json: %s is missing or of another kind", wrong);
    if (virtual_rig && !json_is_true(json_object_get(studio->settings, "virtual")))
        return ffp_studio_say(said, "this folder is a real rig's: name another for --virtual");
    return true;
}

// --- What the page is told. ---

// Names of files are bytes; what is no UTF-8 is shown with question marks.
static json_t *text(const char *bytes, size_t length) {
    json_t *value = json_stringn(bytes, length);
    char *copy = value ? NULL : malloc(length + 1);
    if (!copy) return value ? value : json_string("");
    for (size_t i = 0; i < length; i++) copy[i] = (unsigned char)bytes[i] < 0x80 ? bytes[i] : '?';
    value = json_stringn(copy, length);
    free(copy);
    return value;
}

static json_t *job_state(const FfpStudioJob *job) {
    static const char *const ends[] = {"none", "running", "done", "failed", "stopped"};
    json_t *lines = json_array();
    for (int i = 0; i < job->n_commands; i++) {
        char *typed = ffp_studio_typed(&job->commands[i]);
        json_array_append_new(lines, text(typed ? typed : "", typed ? strlen(typed) : 0));
        free(typed);
    }
    return json_pack("{s:s, s:s, s:o, s:i, s:s, s:I, s:I, s:o, s:o, s:f}", "name", job->name, "end",
                     ends[job->end], "commands", lines, "current", job->current, "stage", job->stage, "done",
                     (json_int_t)job->done, "total", (json_int_t)job->total, "log",
                     text(job->log, job->logged), "error", text(job->error, strlen(job->error)), "seconds",
                     job->seconds);
}

static json_t *set_state(const FfpStudio *studio, const FfpStudioSet *set) {
    char board[FFP_STUDIO_NAME + 16];
    const int next = ffp_studio_next(set);
    snprintf(board, sizeof board, "%s/board.json", set->name);
    json_t *state =
        json_pack("{s:s, s:s, s:i, s:i, s:s, s:b, s:b}", "name", set->name, "kind", ffp_set_kinds[set->kind],
                  "count", set->count, "done", set->done, "ending", set->ending, "simulated",
                  set->stage[0] != 0, "looked", ffp_studio_exists(studio, board));
    if (set->count > 0 && set->shots[0].has_angle)
        json_object_set_new(state, "angle", json_real(set->shots[next >= 0 ? next : 0].angle));
    if (set->panel[0] > 0)
        json_object_set_new(state, "panel", json_pack("[ii]", set->panel[0], set->panel[1]));
    if (next >= 0 && set->count > 0)
        json_object_set_new(
            state, "next",
            json_pack("{s:i, s:s}", "number", set->shots[next].number, "pattern", set->shots[next].pattern));
    return state;
}

static json_t *shots_state(const FfpStudioSet *set) {
    json_t *shots = json_array();
    for (int i = 0; i < set->count; i++)
        json_array_append_new(shots, json_pack("{s:i, s:s, s:b, s:b}", "number", set->shots[i].number,
                                               "pattern", set->shots[i].pattern, "white",
                                               set->shots[i].role == FFP_SHOT_WHITE, "there", set->there[i]));
    return shots;
}

static json_t *sets_state(const FfpStudio *studio, const char *object) {
    char(*names)[FFP_STUDIO_NAME] = calloc(FFP_STUDIO_SETS, sizeof *names);
    FfpStudioSet set;
    json_t *sets = json_array();
    const int count = names ? ffp_studio_set_names(studio, object, names, FFP_STUDIO_SETS) : 0;
    for (int i = 0; i < count; i++)
        if (ffp_studio_set(studio, names[i], &set)) json_array_append_new(sets, set_state(studio, &set));
    free(names);
    return sets;
}

static bool in_object(const FfpStudio *studio, const char *object, const char *file) {
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/%s", object, file);
    return ffp_studio_exists(studio, path);
}

// Of the object's longer side, in the capture and in the photographs; null: it is of an older version, or
// none.
static json_t *pixels_of(const FfpStudio *studio, const char *object) {
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/capture/scene.json", object);
    json_t *scene = ffp_studio_read_json(studio, path),
           *pixels = json_object_get(json_object_get(scene, "object"), "pixels");
    pixels = pixels ? json_incref(pixels) : json_null();
    json_decref(scene);
    return pixels;
}

static json_t *objects_state(const FfpStudio *studio) {
    json_t *objects = json_array(), *about;
    const char *name;
    json_object_foreach(json_object_get(studio->settings, "objects"), name, about) {
        json_array_append_new(
            objects, json_pack("{s:s, s:O, s:o, s:o, s:o, s:b, s:b, s:b, s:b, s:b, s:b, s:o}", "name", name,
                               "about", about, "sets", sets_state(studio, name), "pixels",
                               pixels_of(studio, name), "expected", ffp_studio_expected(studio, name),
                               "capture", in_object(studio, name, "capture/scene.json"), "view",
                               in_object(studio, name, "view.html"), "known",
                               in_object(studio, name, "known/axis.json"), "scores",
                               in_object(studio, name, "scores.json"), "now",
                               in_object(studio, name, "now/capture/scores.json"), "aligned",
                               in_object(studio, name, "now/aligned/scores.json"), "second",
                               ffp_studio_second_state(studio, name)));
    }
    return objects;
}

static json_t *patterns_state(const FfpStudio *studio) {
    char *names[FFP_STUDIO_SHOTS];
    json_t *patterns = json_array();
    const int count = ffp_studio_list(studio, "patterns", names, FFP_STUDIO_SHOTS);
    for (int i = 0; i < count; i++)
        if (strlen(names[i]) > 8 && strcmp(names[i] + strlen(names[i]) - 4, ".png") == 0)
            json_array_append_new(patterns, json_string(names[i]));
    ffp_studio_free_names(names, count);
    return patterns;
}

// The part of the state that takes long to look up if there are many objects.
static json_t *listed_state(const FfpStudio *studio) {
    return json_pack("{s:o, s:o, s:o, s:b, s:b, s:b}", "patterns", patterns_state(studio), "sets",
                     sets_state(studio, NULL), "objects", objects_state(studio), "calibrated",
                     ffp_studio_exists(studio, "calibration/calibration.xml"), "axis",
                     ffp_studio_exists(studio, "calibration/axis.json"), "photographed",
                     ffp_studio_photographed(studio));
}

json_t *ffp_studio_state(FfpStudio *studio) {
    FfpStudioSet set;
    json_t *settings = json_deep_copy(studio->settings), *active = json_null();
    const char *name = ffp_studio_setting(studio, "active", NULL);
    // a set that is complete: the studio was ended between its last photograph and this note of it
    if (name && ffp_studio_set(studio, name, &set) && ffp_studio_next(&set) >= 0) {
        active = set_state(studio, &set);
        json_object_set_new(active, "shots", shots_state(&set));
        json_object_set_new(active, "shown", json_boolean(studio->shown >= 0));
    }
    json_object_del(settings, "simulator");
    if (!studio->listed) studio->listed = listed_state(studio);
    json_t *state = json_pack(
        "{s:I, s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "run", (json_int_t)studio->run, "version",
        (json_int_t)studio->version, "program", text(studio->program, strlen(studio->program)), "folder",
        text(studio->folder, strlen(studio->folder)), "settings", settings, "active", active, "job",
        job_state(&studio->job), "camera", job_state(&studio->camera), "eye", job_state(&studio->eye),
        "notice", text(studio->notice, strlen(studio->notice)));
    json_t *listed = json_deep_copy(studio->listed);
    json_object_update(state, listed);
    json_decref(listed);
    return state;
}

void ffp_studio_close(FfpStudio *studio) {
    FfpStudioJob *const jobs[] = {&studio->job, &studio->camera, &studio->eye};
    for (int i = 0; i < 3; i++) {
        json_decref(jobs[i]->findings);
        ffp_studio_clear(jobs[i]);
    }
    json_decref(studio->settings), json_decref(studio->listed);
}
