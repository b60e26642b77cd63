// Prediction against reality: the object as it stands now, under one pattern on the real projector, beside
// what its Gaussians predict; and where the devices are if something was moved since.
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "rules.h"

// A numbered file of patterns/ beside black and white.
static bool is_pattern(const FfpStudio *studio, const char *name) {
    char path[FFP_STUDIO_NAME];
    if (!name || ffp_studio_pattern_number(name) == 0) return false;
    const FfpShotRole role = ffp_studio_pattern_role(name);
    if (role == FFP_SHOT_BLACK || role == FFP_SHOT_WHITE) return false;
    snprintf(path, sizeof path, "patterns/%s", name);
    return ffp_studio_exists(studio, path);
}

// Out of the way: what watching photographed of the object is deleted, the rest kept. NULL: the simulated
// rig's, which is of the last trial whatever its object.
static bool put_away(const FfpStudio *studio, const char *object, const char *path) {
    const json_t *trial = json_object_get(studio->settings, "trial");
    const char *of = json_string_value(json_object_get(trial, "object"));
    const bool watched =
        json_is_true(json_object_get(trial, "watch")) && (!object || (of && strcmp(of, object) == 0));
    return watched ? ffp_studio_remove(studio, path) : ffp_studio_set_aside(studio, path);
}

bool ffp_studio_try(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]) {
    const char *object = ffp_studio_setting(studio, "object", ""),
               *view = json_string_value(json_object_get(request, "view")),
               *pattern = json_string_value(json_object_get(request, "pattern"));
    const json_t *about = ffp_studio_object(studio, object), *turned = json_object_get(request, "turned");
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/object.ply", object);
    if (!about || !ffp_studio_exists(studio, path))
        return ffp_studio_say(said, "the object is not reconstructed yet");
    if (!view || ffp_studio_stop_angle(about, view) < 0)
        return ffp_studio_say(said, "view: takes a stop of the object");
    const bool watch = json_is_true(json_object_get(request, "watch"));
    snprintf(path, sizeof path, watch ? FFP_STUDIO_WATCHED : FFP_STUDIO_OWNED, object);
    const bool own = pattern && strcmp(pattern, "own") == 0;
    if (watch && !own) return ffp_studio_say(said, "watch: takes the pattern own, the show's picture");
    if (own ? !ffp_studio_exists(studio, path) : !is_pattern(studio, pattern))
        return ffp_studio_say(
            said, "pattern: takes one of patterns/ beside black and white, or a picture of your own");
    if (turned && (!json_is_integer(turned) || llabs(json_integer_value(turned)) > 180))
        return ffp_studio_say(said, "turned: takes -180 to 180 whole degrees");
    snprintf(path, sizeof path, "objects/%.60s/now", object);
    if (!put_away(studio, object, path) || !put_away(studio, NULL, "virtual/now") ||
        !put_away(studio, NULL, "virtual/shown"))
        return ffp_studio_say(said, "%s cannot be put away", path);
    json_object_set_new(studio->settings, "trial",
                        json_pack("{s:s, s:s, s:s, s:I, s:b}", "object", object, "view", view, "pattern",
                                  pattern, "turned", json_integer_value(turned), "watch", watch));
    return ffp_studio_save(studio, said);
}

bool ffp_studio_store_own(FfpStudio *studio, bool watch, const void *bytes, size_t size,
                          char said[FFP_STUDIO_SAID]) {
    char path[FFP_STUDIO_NAME];
    int width, height;
    const char *ending, *object = ffp_studio_setting(studio, "object", "");
    if (!ffp_studio_object(studio, object)) return ffp_studio_say(said, "no object is chosen");
    if (!ffp_studio_picture(bytes, size, &width, &height, &ending) || strcmp(ending, "png") != 0)
        return ffp_studio_say(said, "this is not a whole PNG picture");
    if (width != ffp_studio_number(studio, "projector", 0, 0) ||
        height != ffp_studio_number(studio, "projector", 1, 0))
        return ffp_studio_say(said, "the picture has %d x %d pixels, the projector others", width, height);
    snprintf(path, sizeof path, watch ? FFP_STUDIO_WATCHED : FFP_STUDIO_OWNED, object);
    if (!ffp_studio_write(studio, path, bytes, size))
        return ffp_studio_say(said, "%s cannot be written: %s", path, strerror(errno));
    ffp_studio_changed(studio);
    return true;
}

// --- The commands. ---

bool ffp_studio_add_sphere(const FfpStudio *studio, const char *object, FfpStudioCommand *c) {
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/capture/scene.json", object);
    json_t *scene = ffp_studio_read_json(studio, path);
    const json_t *sphere = json_object_get(scene, "object"), *centre = json_object_get(sphere, "centre");
    const bool ok = json_array_size(centre) == 3 && json_is_number(json_object_get(sphere, "radius"));
    if (ok)
        ffp_studio_word(c, "--object=%.9g,%.9g,%.9g,%.9g", json_number_value(json_array_get(centre, 0)),
                        json_number_value(json_array_get(centre, 1)),
                        json_number_value(json_array_get(centre, 2)),
                        json_number_value(json_object_get(sphere, "radius")));
    json_decref(scene);
    return ok;
}

// The photographs under black and white that were taken of the stop.
static void add_plain(const FfpStudio *studio, const FfpStudioTrial *t, FfpStudioCommand *c) {
    FfpStudioSet stop;
    char path[FFP_STUDIO_NAME], name[80];
    snprintf(path, sizeof path, "objects/%.60s/%.60s", t->object, t->view);
    if (!ffp_studio_set(studio, path, &stop)) return;
    for (int i = 0; i < stop.count; i++) {
        if (stop.shots[i].role != FFP_SHOT_BLACK && stop.shots[i].role != FFP_SHOT_WHITE) continue;
        ffp_studio_pattern_name(stop.shots[i].pattern, name, sizeof name);
        ffp_studio_word(c, "-i");
        ffp_studio_word(c, "%s=%s/%03d.%s", name, path, stop.shots[i].number, stop.ending);
    }
}

static void add_shots(const FfpStudio *studio, const FfpStudioTrial *t, const FfpStudioSet *now,
                      FfpStudioCommand *c) {
    FfpStudioSet empty;
    char path[FFP_STUDIO_NAME], name[80];
    snprintf(path, sizeof path, "objects/%.60s/empty", t->object);
    const bool has_empty = !t->watch && ffp_studio_set(studio, path, &empty);
    if (t->watch) add_plain(studio, t, c);
    for (int i = 0; i < now->count; i++) {
        ffp_studio_pattern_name(now->shots[i].pattern, name, sizeof name);
        if (now->shots[i].role == FFP_SHOT_OWN) snprintf(name, sizeof name, "%s", t->name);
        ffp_studio_word(c, "-i");
        ffp_studio_word(c, "%s=%s/%03d.%s", name, now->name, now->shots[i].number, now->ending);
        for (int k = 0; has_empty && k < empty.count; k++) {
            if (empty.shots[k].number != now->shots[i].number) continue;
            ffp_studio_word(c, "--empty");
            ffp_studio_word(c, "%s=%s/%03d.%s", name, path, empty.shots[k].number, empty.ending);
        }
    }
    ffp_studio_word(c, "-p");
    ffp_studio_word(c, "%s=%s", t->name, t->file);
}

// `evaluate` of objects/NAME/now/WHAT, with the predicted pictures beside it.
static void add_comparison(FfpStudioJob *job, const char *object, const char *what) {
    FfpStudioCommand *c = ffp_studio_command(job, "evaluate");
    const char *const options[][2] = {{"--save", "predicted"}, {"--json", "scores"}, {"--report", "report"}};
    const char *const endings[] = {"", ".json", ".html"};
    ffp_studio_word(c, "objects/%.60s/now/%s", object, what);
    ffp_studio_word(c, "--gaussians");
    ffp_studio_word(c, "objects/%.60s/object.ply", object);
    for (int i = 0; i < 3; i++) {
        ffp_studio_word(c, "%s", options[i][0]);
        ffp_studio_word(c, "objects/%.60s/now/%s/%s%s", object, what, options[i][1], endings[i]);
    }
}

static bool set_made_aside(const FfpStudio *studio, const char *object, const char *what, char *said) {
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/now/%s", object, what);
    return put_away(studio, object, path) || ffp_studio_say(said, "%s cannot be put away", path);
}

// Makes the capture of now.
static bool import_now(FfpStudio *studio, FfpStudioJob *job, bool watch, char *said) {
    const char *object = ffp_studio_setting(studio, "object", "");
    FfpStudioSet now;
    FfpStudioTrial t;
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/now", object);
    if (!ffp_studio_read_trial(studio, object, &t) || t.watch != watch ||
        !ffp_studio_set(studio, path, &now) || now.done < now.count)
        return ffp_studio_say(said, "it is not photographed as it is now");
    if (!set_made_aside(studio, object, "capture", said) || !set_made_aside(studio, object, "aligned", said))
        return false;
    FfpStudioCommand *c = ffp_studio_import(studio, job, object);
    if (watch)
        ffp_studio_add_width(studio, c);
    else
        ffp_studio_word(c, "--fit-response"); // one picture does not tell it
    ffp_studio_word(c, "-v");
    ffp_studio_word(c, "%s", t.view + (ffp_studio_without_board(studio) ? 0 : strlen(FFP_STUDIO_VIEW)));
    add_shots(studio, &t, &now, c);
    if (!ffp_studio_add_sphere(studio, object, c))
        return ffp_studio_say(said, "objects/%s/capture/scene.json has no object", object);
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/capture", path);
    return true;
}

static bool compare_now(FfpStudio *studio, FfpStudioJob *job, char *said) {
    if (!import_now(studio, job, false, said)) return false;
    add_comparison(job, ffp_studio_setting(studio, "object", ""), "capture");
    return true;
}

// `align` of objects/NAME/now/capture by the Gaussians.
static FfpStudioCommand *add_alignment(FfpStudioJob *job, const char *object) {
    FfpStudioCommand *c = ffp_studio_command(job, "align");
    ffp_studio_word(c, "objects/%.60s/now/capture", object);
    ffp_studio_word(c, "--gaussians");
    ffp_studio_word(c, "objects/%.60s/object.ply", object);
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "objects/%.60s/now/aligned", object);
    return c;
}

static bool watch_now(FfpStudio *studio, FfpStudioJob *job, char *said) {
    if (!import_now(studio, job, true, said)) return false;
    FfpStudioCommand *c = add_alignment(job, ffp_studio_setting(studio, "object", ""));
    ffp_studio_word(c, "-p");
    ffp_studio_word(c, "own");
    ffp_studio_word(c, "--json");
    return true;
}

static bool find_devices(FfpStudio *studio, FfpStudioJob *job, char *said) {
    const char *object = ffp_studio_setting(studio, "object", "");
    char path[FFP_STUDIO_NAME];
    snprintf(path, sizeof path, "objects/%.60s/now/capture/scene.json", object);
    if (!ffp_studio_exists(studio, path)) return ffp_studio_say(said, "it is not photographed as it is now");
    if (!set_made_aside(studio, object, "aligned", said)) return false;
    add_alignment(job, object);
    add_comparison(job, object, "aligned");
    return true;
}

bool ffp_studio_trial_step(FfpStudio *studio, const char *step, FfpStudioJob *job,
                           char said[FFP_STUDIO_SAID]) {
    if (strcmp(step, "watch") == 0) return watch_now(studio, job, said);
    return strcmp(step, "now") == 0 ? compare_now(studio, job, said) : find_devices(studio, job, said);
}

bool ffp_studio_is_trial_step(const char *step) {
    return strcmp(step, "now") == 0 || strcmp(step, "register") == 0 || strcmp(step, "watch") == 0;
}
