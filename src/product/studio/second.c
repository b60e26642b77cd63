// A second projector: its patterns, and the commands that find it by the object that is known.
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "rules.h"

enum { SIDE_LEAST = 64, SIDE_MOST = 8192 };

static bool is_side(const json_t *side) {
    return json_is_integer(side) && json_integer_value(side) >= SIDE_LEAST &&
           json_integer_value(side) <= SIDE_MOST;
}

static bool draw_patterns(FfpStudio *studio, const FfpStudioSecond *s, char *said) {
    ffp_studio_clear(&studio->job);
    FfpStudioCommand *c = ffp_studio_command(&studio->job, "patterns");
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/patterns", s->folder);
    ffp_studio_word(c, "--projector");
    ffp_studio_word(c, "%dx%d", s->width, s->height);
    return (ffp_studio_make(studio, s->folder) && ffp_studio_start(studio, &studio->job, "draw")) ||
           ffp_studio_say(said, "%s cannot be begun", s->folder);
}

static bool set_before_aside(const FfpStudio *studio, const char *object, char *said) {
    char path[FFP_STUDIO_NAME], *names[FFP_STUDIO_SETS];
    snprintf(path, sizeof path, "objects/%.60s/" FFP_STUDIO_SECOND, object);
    bool ok = ffp_studio_set_aside(studio, path);
    const int count = ffp_studio_list(studio, "virtual", names, FFP_STUDIO_SETS);
    for (int i = 0; i < count; i++) {
        snprintf(path, sizeof path, "virtual/%.100s", names[i]);
        if (strncmp(names[i], FFP_STUDIO_SECOND, sizeof FFP_STUDIO_SECOND - 1) == 0)
            ok = ffp_studio_set_aside(studio, path) && ok;
    }
    ffp_studio_free_names(names, count);
    return ok || ffp_studio_say(said, "what was photographed before cannot be moved to discarded/");
}

bool ffp_studio_begin_second(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]) {
    const char *object = ffp_studio_setting(studio, "object", ""),
               *view = json_string_value(json_object_get(request, "view"));
    const json_t *size = json_object_get(request, "size");
    json_t *about = ffp_studio_object(studio, object);
    const bool every = view && strcmp(view, FFP_STUDIO_EVERY) == 0;
    char path[FFP_STUDIO_NAME];
    FfpStudioSecond s;
    snprintf(path, sizeof path, "objects/%.60s/object.ply", object);
    if (!about || (!every && !ffp_studio_exists(studio, path)))
        return ffp_studio_say(said, "the object is not reconstructed yet");
    if (!view || (!every && ffp_studio_stop_angle(about, view) < 0))
        return ffp_studio_say(said, "view: takes a stop of the object, or every");
    if (json_array_size(size) != 2 || !is_side(json_array_get(size, 0)) || !is_side(json_array_get(size, 1)))
        return ffp_studio_say(said, "size: takes two sides of %d to %d pixels", SIDE_LEAST, SIDE_MOST);
    if (studio->job.end == FFP_JOB_RUNNING)
        return ffp_studio_say(said, "%s is still running", studio->job.name);
    if (!set_before_aside(studio, object, said)) return false;
    json_object_set_new(about, "second",
                        json_pack("{s:s, s:[II]}", "view", view, "size",
                                  json_integer_value(json_array_get(size, 0)),
                                  json_integer_value(json_array_get(size, 1))));
    return ffp_studio_read_second(studio, object, &s) && ffp_studio_save(studio, said) &&
           draw_patterns(studio, &s, said);
}

// --- The commands. ---

static bool set_made_aside(const FfpStudio *studio, const FfpStudioSecond *s, const char *what, char *said) {
    char path[FFP_STUDIO_NAME + 16];
    snprintf(path, sizeof path, "%s/%s", s->folder, what);
    return ffp_studio_set_aside(studio, path) ||
           ffp_studio_say(said, "%.120s cannot be moved to discarded/", path);
}

static void add_import(const FfpStudio *studio, FfpStudioJob *job, const char *object,
                       const FfpStudioSecond *s) {
    const size_t before = ffp_studio_without_board(studio) ? 0 : sizeof FFP_STUDIO_VIEW - 1;
    FfpStudioCommand *c = ffp_studio_import(studio, job, object);
    ffp_studio_word(c, "--other-projector");
    ffp_studio_word(c, "--projector-size");
    ffp_studio_word(c, "%dx%d", s->width, s->height);
    if (!s->every) {
        ffp_studio_word(c, "-v");
        ffp_studio_word(c, "%s", s->view + before);
    }
    ffp_studio_word(c, "--shown");
    ffp_studio_word(c, "%s/patterns", s->folder);
    ffp_studio_word(c, "-i");
    ffp_studio_word(c, "%s/%s{view}/*.*", s->folder, before > 0 ? FFP_STUDIO_VIEW : "");
    ffp_studio_add_sphere(studio, object, c);
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/capture", s->folder);
}

bool ffp_studio_find_second(FfpStudio *studio, FfpStudioJob *job, char said[FFP_STUDIO_SAID]) {
    const char *object = ffp_studio_setting(studio, "object", "");
    FfpStudioSecond s;
    json_t *state = ffp_studio_second_state(studio, object);
    const json_int_t count = json_integer_value(json_object_get(state, "count"));
    const bool all = count > 0 && json_integer_value(json_object_get(state, "done")) == count;
    json_decref(state);
    if (!all || !ffp_studio_read_second(studio, object, &s))
        return ffp_studio_say(said, "the second projector is not photographed yet");
    if (!set_made_aside(studio, &s, "capture", said) || !set_made_aside(studio, &s, "found", said))
        return false;
    add_import(studio, job, object, &s);
    FfpStudioCommand *c = ffp_studio_command(job, "align");
    ffp_studio_word(c, "%s/capture", s.folder);
    ffp_studio_word(c, "--gaussians");
    ffp_studio_word(c, "objects/%.60s/object.ply", object);
    ffp_studio_word(c, "--second-projector");
    ffp_studio_word(c, "--json");
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/found", s.folder);
    return true;
}
