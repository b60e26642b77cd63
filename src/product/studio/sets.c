// Which photographs are to be taken, and which there are: a set is a folder, a shot a file in it. The folder
// is all there is to know of a set, so that whatever happens, the next shot is the first that is missing.
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "rules.h"

static const char *const endings[] = {"png", "jpg"};
const char *const ffp_set_kinds[] = {"attitude", "table", "empty", "stop", "second", "trial"};

const char *ffp_studio_setting(const FfpStudio *studio, const char *name, const char *otherwise) {
    const char *text = json_string_value(json_object_get(studio->settings, name));
    return text ? text : otherwise;
}

long long ffp_studio_number(const FfpStudio *studio, const char *name, int index, long long otherwise) {
    const json_t *value = json_object_get(studio->settings, name);
    if (index >= 0) value = json_array_get(value, (size_t)index);
    return json_is_integer(value) ? json_integer_value(value) : otherwise;
}

json_t *ffp_studio_object(const FfpStudio *studio, const char *name) {
    return json_object_get(json_object_get(studio->settings, "objects"), name);
}

bool ffp_studio_without_board(const FfpStudio *studio) {
    return json_is_true(json_object_get(studio->settings, "without_board"));
}

// --- What a set consists of. ---

typedef enum Wanted { WANTED_CAPTURE, WANTED_CODES, WANTED_ALL } Wanted;

int ffp_studio_pattern_number(const char *file) {
    char *end;
    const long number = strtol(file, &end, 10);
    const size_t length = strlen(file);
    return end == file + 3 && *end == '_' && number > 0 && ffp_studio_path(file) && length > 8 &&
                   length <= 46 && strcmp(file + length - 4, ".png") == 0
               ? (int)number
               : 0;
}

void ffp_studio_pattern_name(const char *file, char *name, size_t size) {
    const char *slash = strrchr(file, '/'), *last = slash ? slash + 1 : file, *number = strchr(last, '_'),
               *begins = number ? number + 1 : last, *dot = strrchr(begins, '.');
    snprintf(name, size, "%.*s", (int)(dot ? dot - begins : (ptrdiff_t)strlen(begins)), begins);
}

FfpShotRole ffp_studio_pattern_role(const char *file) {
    static const struct {
        const char *begins;
        FfpShotRole role;
    } roles[] = {{"black.", FFP_SHOT_BLACK},
                 {"white.", FFP_SHOT_WHITE},
                 {"lollipop_", FFP_SHOT_LOLLIPOP},
                 {"gray_", FFP_SHOT_CODE}};
    const char *name = strchr(file, '_') + 1;
    for (size_t i = 0; i < sizeof roles / sizeof *roles; i++)
        if (strncmp(name, roles[i].begins, strlen(roles[i].begins)) == 0) return roles[i].role;
    return FFP_SHOT_OTHER;
}

static bool is_wanted(FfpShotRole role, Wanted wanted) {
    return wanted == WANTED_ALL || role != (wanted == WANTED_CODES ? FFP_SHOT_LOLLIPOP : FFP_SHOT_CODE);
}

static void add_patterns_of(const FfpStudio *studio, const char *folder, FfpStudioSet *set, Wanted wanted) {
    char *names[FFP_STUDIO_SHOTS];
    const int count = ffp_studio_list(studio, folder, names, FFP_STUDIO_SHOTS);
    for (int i = 0; i < count; i++) {
        const int number = ffp_studio_pattern_number(names[i]);
        if (number == 0 || !is_wanted(ffp_studio_pattern_role(names[i]), wanted)) continue;
        FfpStudioShot *shot = &set->shots[set->count++];
        *shot = (FfpStudioShot){.number = number, .role = ffp_studio_pattern_role(names[i])};
        snprintf(shot->pattern, sizeof shot->pattern, "%.80s/%.46s", folder, names[i]);
    }
    ffp_studio_free_names(names, count);
}

static void add_patterns(const FfpStudio *studio, FfpStudioSet *set, Wanted wanted) {
    add_patterns_of(studio, "patterns", set, wanted);
}

static void add_board_stops(const FfpStudio *studio, FfpStudioSet *set) {
    FfpStudioSet all = {.count = 0};
    const FfpStudioShot *white = NULL;
    add_patterns(studio, &all, WANTED_CAPTURE);
    for (int i = 0; i < all.count; i++)
        if (all.shots[i].role == FFP_SHOT_WHITE) white = &all.shots[i];
    const json_t *angles = json_object_get(studio->settings, "board_angles");
    for (size_t i = 0; white && i < json_array_size(angles) && i < FFP_STUDIO_SHOTS; i++) {
        FfpStudioShot *shot = &set->shots[set->count++];
        *shot = *white;
        shot->number = (int)i, shot->has_angle = true;
        shot->angle = json_number_value(json_array_get(angles, i));
    }
}

double ffp_studio_stop_angle(const json_t *object, const char *folder) {
    const int stops = (int)json_integer_value(json_object_get(object, "stops"));
    for (int i = 0; i < stops; i++) {
        char name[32];
        snprintf(name, sizeof name, FFP_STUDIO_VIEW "%03d", (int)lround(360.0 * i / stops));
        if (strcmp(name, folder) == 0) return 360.0 * i / stops;
    }
    return -1;
}

// --- The object as it stands now: under black, white and one pattern. ---

bool ffp_studio_read_trial(const FfpStudio *studio, const char *object, FfpStudioTrial *t) {
    const json_t *trial = json_object_get(studio->settings, "trial");
    *t = (FfpStudioTrial){.object = json_string_value(json_object_get(trial, "object")),
                          .view = json_string_value(json_object_get(trial, "view")),
                          .pattern = json_string_value(json_object_get(trial, "pattern")),
                          .turned = (int)json_integer_value(json_object_get(trial, "turned")),
                          .watch = json_is_true(json_object_get(trial, "watch"))};
    if (!t->object || !t->view || !t->pattern || strcmp(t->object, object) != 0 ||
        ffp_studio_stop_angle(ffp_studio_object(studio, object), t->view) < 0)
        return false;
    t->is_own = strcmp(t->pattern, "own") == 0;
    if (t->is_own) {
        snprintf(t->name, sizeof t->name, "own");
        snprintf(t->file, sizeof t->file, t->watch ? FFP_STUDIO_WATCHED : FFP_STUDIO_OWNED, object);
    } else {
        if (ffp_studio_pattern_number(t->pattern) == 0) return false;
        ffp_studio_pattern_name(t->pattern, t->name, sizeof t->name);
        snprintf(t->file, sizeof t->file, "patterns/%s", t->pattern);
    }
    return true;
}

static bool is_of(const FfpStudioShot *shot, const FfpStudioTrial *t) {
    return shot->role == FFP_SHOT_BLACK || shot->role == FFP_SHOT_WHITE ||
           strcmp(shot->pattern, t->file) == 0;
}

// Of a set that has every pattern, the photographs of the trial remain; false: there is none of the object.
static bool trial_set(const FfpStudio *studio, const char *object, FfpStudioSet *set) {
    FfpStudioTrial t;
    if (!ffp_studio_read_trial(studio, object, &t)) return false;
    const int all = set->count; // every pattern: those that are not of it go
    set->count = 0;
    for (int i = 0; i < all; i++)
        if (!t.watch && is_of(&set->shots[i], &t)) set->shots[set->count++] = set->shots[i];
    if (t.is_own && set->count < FFP_STUDIO_SHOTS) {
        set->shots[set->count] = (FfpStudioShot){.number = FFP_STUDIO_OWN, .role = FFP_SHOT_OWN};
        snprintf(set->shots[set->count++].pattern, sizeof set->shots->pattern, "%.127s", t.file);
    }
    const double angle = ffp_studio_stop_angle(ffp_studio_object(studio, object), t.view);
    for (int i = 0; i < set->count; i++) set->shots[i].angle = angle, set->shots[i].has_angle = true;
    snprintf(set->stage, sizeof set->stage, "now");
    return true;
}

// --- A second projector, at one stop or all. ---

bool ffp_studio_read_second(const FfpStudio *studio, const char *object, FfpStudioSecond *s) {
    const json_t *about = ffp_studio_object(studio, object), *second = json_object_get(about, "second"),
                 *size = json_object_get(second, "size");
    *s = (FfpStudioSecond){.view = json_string_value(json_object_get(second, "view")),
                           .width = (int)json_integer_value(json_array_get(size, 0)),
                           .height = (int)json_integer_value(json_array_get(size, 1))};
    s->every = s->view && strcmp(s->view, FFP_STUDIO_EVERY) == 0;
    snprintf(s->folder, sizeof s->folder, "objects/%.60s/" FFP_STUDIO_SECOND, object);
    return (s->every || (s->view && ffp_studio_stop_angle(about, s->view) >= 0)) && s->width > 0 &&
           s->height > 0;
}

static bool second_set(const FfpStudio *studio, const char *object, const char *view, FfpStudioSet *set) {
    FfpStudioSecond s;
    char folder[FFP_STUDIO_NAME + 16];
    const double angle = ffp_studio_stop_angle(ffp_studio_object(studio, object), view);
    if (angle < 0 || !ffp_studio_read_second(studio, object, &s) || !(s.every || strcmp(view, s.view) == 0))
        return false;
    snprintf(folder, sizeof folder, "%s/patterns", s.folder);
    add_patterns_of(studio, folder, set, WANTED_ALL);
    for (int i = 0; i < set->count; i++) set->shots[i].angle = angle, set->shots[i].has_angle = true;
    set->panel[0] = s.width, set->panel[1] = s.height;
    snprintf(set->stage, sizeof set->stage, FFP_STUDIO_SECOND "-%.16s", view);
    return true;
}

static bool object_set(const FfpStudio *studio, const char *rest, FfpStudioSet *set) {
    char name[FFP_STUDIO_NAME];
    const char *slash = strchr(rest, '/');
    if (!slash) return false;
    snprintf(name, sizeof name, "%.*s", (int)(slash - rest), rest);
    const json_t *object = ffp_studio_object(studio, name);
    if (!object) return false;
    snprintf(set->object, sizeof set->object, "%s", name);
    const bool coded = json_is_true(json_object_get(object, "coded"));
    if (strcmp(slash + 1, "empty") == 0) {
        if (!json_is_true(json_object_get(object, "empty"))) return false;
        set->kind = FFP_SET_EMPTY;
        add_patterns(studio, set, WANTED_CAPTURE);
        snprintf(set->stage, sizeof set->stage, "empty");
        return true;
    }
    if (strcmp(slash + 1, "now") == 0) {
        set->kind = FFP_SET_TRIAL;
        add_patterns(studio, set, WANTED_ALL);
        return trial_set(studio, name, set);
    }
    if (strncmp(slash + 1, FFP_STUDIO_SECOND "/", sizeof FFP_STUDIO_SECOND) == 0) {
        set->kind = FFP_SET_SECOND;
        return second_set(studio, name, slash + 1 + sizeof FFP_STUDIO_SECOND, set);
    }
    const double angle = ffp_studio_stop_angle(object, slash + 1);
    if (angle < 0) return false;
    set->kind = FFP_SET_STOP;
    add_patterns(studio, set, coded ? WANTED_ALL : WANTED_CAPTURE);
    for (int i = 0; i < set->count; i++) set->shots[i].angle = angle, set->shots[i].has_angle = true;
    snprintf(set->stage, sizeof set->stage, "%.31s", slash + 1);
    return true;
}

static void see_what_is_there(const FfpStudio *studio, FfpStudioSet *set) {
    char *names[2 * FFP_STUDIO_SHOTS];
    const int count = ffp_studio_list(studio, set->name, names, 2 * FFP_STUDIO_SHOTS);
    for (int n = 0; n < count; n++) {
        char *end;
        const long number = strtol(names[n], &end, 10);
        if (end != names[n] + 3 || *end != '.') continue;
        for (size_t e = 0; e < sizeof endings / sizeof *endings; e++) {
            if (strcmp(end + 1, endings[e]) != 0) continue;
            for (int i = 0; i < set->count; i++)
                if (set->shots[i].number == number && !set->there[i]) {
                    set->there[i] = true, set->done++;
                    snprintf(set->ending, sizeof set->ending, "%s", endings[e]);
                }
        }
    }
    ffp_studio_free_names(names, count);
}

bool ffp_studio_set(const FfpStudio *studio, const char *name, FfpStudioSet *set) {
    static const char attitude[] = "calibration/attitude-";
    const size_t before = sizeof attitude - 1;
    memset(set, 0, sizeof *set);
    if (!ffp_studio_path(name)) return false;
    snprintf(set->name, sizeof set->name, "%s", name);
    if (strncmp(name, attitude, before) == 0 && strlen(name) == before + 2 &&
        strspn(name + before, "0123456789") == 2) {
        set->kind = FFP_SET_ATTITUDE;
        add_patterns(studio, set, WANTED_CODES);
        snprintf(set->stage, sizeof set->stage, "attitude-%s", name + before);
    } else if (strcmp(name, "calibration/turntable") == 0) {
        set->kind = FFP_SET_TABLE;
        add_board_stops(studio, set);
        snprintf(set->stage, sizeof set->stage, "turntable");
    } else if (strncmp(name, "objects/", 8) != 0 || !object_set(studio, name + 8, set)) {
        return false;
    }
    see_what_is_there(studio, set);
    return true;
}

json_t *ffp_studio_second_state(const FfpStudio *studio, const char *object) {
    FfpStudioSecond s;
    FfpStudioSet set;
    char path[2 * FFP_STUDIO_NAME];
    int count = 0, done = 0;
    const json_t *about = ffp_studio_object(studio, object);
    const int stops = (int)json_integer_value(json_object_get(about, "stops"));
    if (!ffp_studio_read_second(studio, object, &s)) return json_null();
    for (int i = 0; i < stops; i++) {
        snprintf(path, sizeof path, "%s/" FFP_STUDIO_VIEW "%03d", s.folder, (int)lround(360.0 * i / stops));
        if (ffp_studio_set(studio, path, &set)) count += set.count, done += set.done;
    }
    snprintf(path, sizeof path, "%s/found/scene.json", s.folder);
    return json_pack("{s:s, s:[ii], s:i, s:i, s:b}", "view", s.view, "size", s.width, s.height, "count",
                     count, "done", done, "found", ffp_studio_exists(studio, path));
}

int ffp_studio_set_names(const FfpStudio *studio, const char *object, char names[][FFP_STUDIO_NAME],
                         int most) {
    const json_t *about = object ? ffp_studio_object(studio, object) : NULL;
    FfpStudioSecond s;
    int count = 0;
    if (!object) {
        const int attitudes = (int)ffp_studio_number(studio, "attitudes", -1, 8);
        for (int i = 0; i < attitudes && count < most; i++)
            snprintf(names[count++], FFP_STUDIO_NAME, "calibration/attitude-%02d", i);
        if (count < most) snprintf(names[count++], FFP_STUDIO_NAME, "calibration/turntable");
        return count;
    }
    if (json_is_true(json_object_get(about, "empty")) && count < most)
        snprintf(names[count++], FFP_STUDIO_NAME, "objects/%.60s/empty", object);
    const int stops = (int)json_integer_value(json_object_get(about, "stops"));
    const bool second = ffp_studio_read_second(studio, object, &s) && s.every;
    for (int i = 0; i < stops && count + 2 <= most; i++) {
        const int angle = (int)lround(360.0 * i / stops);
        snprintf(names[count++], FFP_STUDIO_NAME, "objects/%.60s/" FFP_STUDIO_VIEW "%03d", object, angle);
        if (second)
            snprintf(names[count++], FFP_STUDIO_NAME, "%.80s/" FFP_STUDIO_VIEW "%03d", s.folder, angle);
    }
    return count;
}

int ffp_studio_next(const FfpStudioSet *set) {
    for (int i = 0; i < set->count; i++)
        if (!set->there[i]) return i;
    return -1;
}

bool ffp_studio_complete(const FfpStudioSet *set) {
    return set->count > 0 && set->done == set->count;
}

static bool any_of(const FfpStudio *studio, const char *object) {
    char(*names)[FFP_STUDIO_NAME] = calloc(FFP_STUDIO_SETS, sizeof *names);
    FfpStudioSet set;
    bool any = false;
    const int count = names ? ffp_studio_set_names(studio, object, names, FFP_STUDIO_SETS) : 0;
    for (int i = 0; i < count && !any; i++) any = ffp_studio_set(studio, names[i], &set) && set.done > 0;
    free(names);
    return any;
}

bool ffp_studio_photographed(const FfpStudio *studio) {
    const char *name;
    json_t *object;
    if (any_of(studio, NULL)) return true;
    json_object_foreach(json_object_get(studio->settings, "objects"), name, object) {
        if (any_of(studio, name)) return true;
    }
    return false;
}
