// The page's requests. Everything is checked before anything changes, and on disk before it is answered.
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "rules.h"

enum { SIDE_LEAST = 64, SIDE_MOST = 16384 };

static bool say(char *said, const char *field, const char *takes) {
    return ffp_studio_say(said, "%s: %s", field, takes);
}

static bool is_pair(const json_t *value, json_int_t least, json_int_t most) {
    if (!json_is_array(value) || json_array_size(value) != 2) return false;
    for (size_t i = 0; i < 2; i++) {
        const json_t *number = json_array_get(value, i);
        if (!json_is_integer(number) || json_integer_value(number) < least ||
            json_integer_value(number) > most)
            return false;
    }
    return true;
}

static bool is_count(const json_t *value, json_int_t least, json_int_t most) {
    return json_is_integer(value) && json_integer_value(value) >= least && json_integer_value(value) <= most;
}

static bool is_angles(const json_t *value) {
    const size_t count = json_array_size(value);
    if (count < 3 || count > 64) return false;
    for (size_t i = 0; i < count; i++) {
        const json_t *angle = json_array_get(value, i);
        if (!json_is_number(angle) || fabs(json_number_value(angle)) > 3600) return false;
    }
    return true;
}

static bool is_fix(const json_t *value) {
    static const char *const terms[] = {"k1", "k2", "k3", "p", "centre", "aspect"};
    if (!json_is_array(value) || json_array_size(value) > 16) return false;
    for (size_t i = 0; i < json_array_size(value); i++) {
        const char *term = json_string_value(json_array_get(value, i));
        bool known = false;
        if (!term) return false;
        if (strncmp(term, "camera.", 7) == 0)
            term += 7;
        else if (strncmp(term, "projector.", 10) == 0)
            term += 10;
        for (size_t k = 0; k < sizeof terms / sizeof *terms; k++) known |= strcmp(term, terms[k]) == 0;
        if (!known) return false;
    }
    return true;
}

static bool is_camera(const FfpStudio *studio, const json_t *value) {
    const char *name = json_string_value(value);
    if (!name) return false;
    if (json_is_true(json_object_get(studio->settings, "virtual")))
        return strcmp(name, "virtual") == 0 || strcmp(name, "browser") == 0 || strcmp(name, "folder") == 0;
    return strcmp(name, "browser") == 0 || strcmp(name, "folder") == 0;
}

static bool check_setting(FfpStudio *studio, const char *name, const json_t *value, char *said) {
    if (strcmp(name, "projector") == 0)
        return is_pair(value, SIDE_LEAST, SIDE_MOST) ||
               say(said, name, "takes two sides of 64 to 16384 pixels");
    if (strcmp(name, "board") == 0)
        return is_pair(value, 3, 64) || say(said, name, "takes two numbers of corners, 3 to 64");
    if (strcmp(name, "square") == 0)
        return (json_is_number(value) && json_number_value(value) > 0 && json_number_value(value) < 1e6) ||
               say(said, name, "takes a length above 0");
    if (strcmp(name, "board_angles") == 0)
        return is_angles(value) || say(said, name, "takes 3 to 64 angles in degrees");
    if (strcmp(name, "attitudes") == 0)
        return is_count(value, 3, 40) || say(said, name, "takes a number from 3 to 40");
    if (strcmp(name, "lollipops") == 0)
        return is_count(value, 1, 8) || say(said, name, "takes a number from 1 to 8");
    if (strcmp(name, "width") == 0)
        return is_count(value, 64, 1024) || say(said, name, "takes a width of 64 to 1024 pixels");
    if (strcmp(name, "fix") == 0) return is_fix(value) || say(said, name, "takes terms of `calibrate --fix`");
    if (strcmp(name, "without_board") == 0 || strcmp(name, "draft") == 0)
        return json_is_boolean(value) || say(said, name, "takes true or false");
    if (strcmp(name, "camera") == 0)
        return is_camera(studio, value) || say(said, name, "there is no such camera");
    if (strcmp(name, "watched") == 0) {
        const char *folder = json_string_value(value);
        if (!folder || folder[0] != '/' || strlen(folder) > 3000)
            return say(said, name, "takes a folder's whole path, from /");
        return true;
    }
    return say(said, name, "there is no such setting");
}

// True for a new value of a setting that patterns and photographs on disk depend on.
static bool is_held(const FfpStudio *studio, const char *name, const json_t *value) {
    const bool holds = strcmp(name, "projector") == 0 || strcmp(name, "lollipops") == 0 ||
                       strcmp(name, "without_board") == 0;
    return holds && !json_equal(value, json_object_get(studio->settings, name)) &&
           ffp_studio_photographed(studio);
}

static bool set_up(FfpStudio *studio, const json_t *request, char *said) {
    const json_t *values = json_object_get(request, "settings");
    const char *name;
    json_t *value;
    if (!json_is_object(values)) return say(said, "settings", "are missing");
    json_object_foreach((json_t *)values, name, value) {
        if (!check_setting(studio, name, value, said)) return false;
        if (is_held(studio, name, value))
            return ffp_studio_say(
                said, "%s: there are photographs of the patterns as they are; begin a new folder", name);
    }
    const char *watched = json_string_value(json_object_get(values, "watched"));
    if (watched && !studio->platform->watch(studio, watched, said)) return false;
    json_object_update(studio->settings, (json_t *)values);
    return ffp_studio_save(studio, said);
}

static bool is_name(const char *name) {
    const size_t length = name ? strlen(name) : 0;
    if (length == 0 || length > 40 || !isalnum((unsigned char)name[0])) return false;
    return strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") == length;
}

// A new object, or one to go on with.
static bool choose_object(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "name"));
    const json_t *stops = json_object_get(request, "stops"),
                 *objects = json_object_get(studio->settings, "objects");
    if (!is_name(name)) return say(said, "name", "takes up to 40 letters, digits, - and _");
    if (!ffp_studio_object(studio, name)) {
        if (!is_count(stops, 3, 72)) return say(said, "stops", "takes a number from 3 to 72");
        if (json_object_size(objects) >= 100) return say(said, "objects", "100 are enough for a folder");
        json_object_set_new(
            (json_t *)objects, name,
            json_pack("{s:I, s:b, s:b}", "stops", json_integer_value(stops), "coded",
                      ffp_studio_without_board(studio) || json_is_true(json_object_get(request, "coded")),
                      "empty", json_is_true(json_object_get(request, "empty"))));
    }
    json_object_set_new(studio->settings, "object", json_string(name));
    return ffp_studio_save(studio, said);
}

// Begins to photograph a set, or goes on with it; null: nothing any more.
static bool shoot(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "set"));
    FfpStudioSet set;
    if (!name) {
        json_object_del(studio->settings, "active");
        return ffp_studio_save(studio, said);
    }
    if (!ffp_studio_set(studio, name, &set)) return say(said, "set", "there is no such set of photographs");
    if (set.count == 0) return ffp_studio_say(said, "the patterns are not drawn yet");
    if (ffp_studio_next(&set) < 0) return ffp_studio_say(said, "%s is complete", name);
    const char *watched = ffp_studio_setting(studio, "watched", NULL);
    if (strcmp(ffp_studio_setting(studio, "camera", ""), "folder") == 0 && !studio->watching &&
        !(watched ? studio->platform->watch(studio, watched, said)
                  : ffp_studio_say(said, "name the folder that the camera fills (step 1)")))
        return false;
    json_object_set_new(studio->settings, "active", json_string(name));
    studio->notice[0] = 0;
    studio->shown = -1;
    return ffp_studio_save(studio, said);
}

static bool show(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "set"));
    const json_t *number = json_object_get(request, "number");
    if (!name || !json_is_integer(number)) return say(said, "show", "takes a set and a number");
    return ffp_studio_show(studio, name, (int)json_integer_value(number), said);
}

static bool take(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "set"));
    const json_t *number = json_object_get(request, "number");
    if (!name || !json_is_integer(number)) return say(said, "take", "takes a set and a number");
    return ffp_studio_take(studio, name, (int)json_integer_value(number), said);
}

static bool look(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "set"));
    return name ? ffp_studio_look(studio, name, said) : say(said, "set", "is missing");
}

static bool discard(FfpStudio *studio, const json_t *request, char *said) {
    const char *name = json_string_value(json_object_get(request, "set"));
    FfpStudioSet set;
    if (!name || !ffp_studio_set(studio, name, &set))
        return say(said, "set", "there is no such set of photographs");
    if (!ffp_studio_set_aside(studio, name))
        return ffp_studio_say(said, "%s cannot be moved to discarded/", name);
    if (strcmp(ffp_studio_setting(studio, "active", ""), name) == 0)
        json_object_del(studio->settings, "active");
    return ffp_studio_save(studio, said);
}

static bool run(FfpStudio *studio, const json_t *request, char *said) {
    const char *step = json_string_value(json_object_get(request, "step"));
    if (!step) return say(said, "step", "is missing");
    if (studio->job.end == FFP_JOB_RUNNING)
        return ffp_studio_say(said, "%s is still running", studio->job.name);
    ffp_studio_clear(&studio->job);
    const bool ready = strcmp(step, "second") == 0 ? ffp_studio_find_second(studio, &studio->job, said)
                       : ffp_studio_is_trial_step(step)
                           ? ffp_studio_trial_step(studio, step, &studio->job, said)
                           : ffp_studio_step(studio, step, &studio->job, said);
    if (ready && ffp_studio_start(studio, &studio->job, step)) return true;
    ffp_studio_clear(&studio->job);
    return said[0] ? false : ffp_studio_say(said, "%s cannot be started", step);
}

static bool cancel(FfpStudio *studio, const json_t *request, char *said) {
    (void)request, (void)said;
    ffp_studio_stop(studio, &studio->job);
    ffp_studio_changed(studio);
    return true;
}

bool ffp_studio_do(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]) {
    static const struct {
        const char *name;
        bool (*act)(FfpStudio *, const json_t *, char *);
    } verbs[] = {{"set", set_up},
                 {"object", choose_object},
                 {"shoot", shoot},
                 {"show", show},
                 {"take", take},
                 {"look", look},
                 {"discard", discard},
                 {"run", run},
                 {"cancel", cancel},
                 {"try", ffp_studio_try},
                 {"second", ffp_studio_begin_second}};
    const char *verb = json_string_value(json_object_get(request, "verb"));
    said[0] = 0;
    for (size_t i = 0; verb && i < sizeof verbs / sizeof *verbs; i++)
        if (strcmp(verbs[i].name, verb) == 0) return verbs[i].act(studio, request, said);
    return ffp_studio_say(said, "there is no such request");
}
