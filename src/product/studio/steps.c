// The steps as commands, which the page shows and the shell understands: they run in the studio's folder.
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "rules.h"

static void words(FfpStudioCommand *c, const char *const list[]) {
    for (int i = 0; list[i]; i++) ffp_studio_word(c, "%s", list[i]);
}

static void option(FfpStudioCommand *c, const char *name, const char *value) {
    ffp_studio_word(c, "%s", name);
    ffp_studio_word(c, "%s", value);
}

// The chessboard that is used.
static void add_board(const FfpStudio *studio, FfpStudioCommand *c) {
    ffp_studio_word(c, "--board");
    ffp_studio_word(c, "%lldx%lld", ffp_studio_number(studio, "board", 0, 9),
                    ffp_studio_number(studio, "board", 1, 6));
    ffp_studio_word(c, "--square");
    ffp_studio_word(c, "%.9g", json_number_value(json_object_get(studio->settings, "square")));
}

// --- Patterns. ---

static bool patterns(FfpStudio *studio, FfpStudioJob *job, char *said) {
    if (ffp_studio_photographed(studio))
        return ffp_studio_say(
            said, "there are photographs of the patterns as they are; begin a new folder for others");
    if (!ffp_studio_set_aside(studio, "patterns") || !ffp_studio_set_aside(studio, "virtual"))
        return ffp_studio_say(said, "the patterns cannot be moved to discarded/");
    FfpStudioCommand *c = ffp_studio_command(job, "patterns");
    words(c, (const char *const[]){"-o", "patterns", "--projector", NULL});
    ffp_studio_word(c, "%lldx%lld", ffp_studio_number(studio, "projector", 0, 0),
                    ffp_studio_number(studio, "projector", 1, 0));
    add_board(studio, c);
    ffp_studio_word(c, "--lollipops");
    ffp_studio_word(c, "%lld", ffp_studio_number(studio, "lollipops", -1, 1));
    return true;
}

// --- The calibration. ---

static int add_attitudes(const FfpStudio *studio, FfpStudioCommand *c) {
    char names[64][FFP_STUDIO_NAME];
    FfpStudioSet set;
    int complete = 0;
    const int count = ffp_studio_set_names(studio, NULL, names, 64);
    for (int i = 0; i < count; i++) {
        if (!ffp_studio_set(studio, names[i], &set) || set.kind != FFP_SET_ATTITUDE ||
            !ffp_studio_complete(&set))
            continue;
        ffp_studio_word(c, "%s", names[i]);
        complete++;
    }
    return complete;
}

static void add_table(const FfpStudio *studio, FfpStudioCommand *c) {
    FfpStudioSet set;
    char list[2048] = "";
    size_t length = 0;
    if (!ffp_studio_set(studio, "calibration/turntable", &set) || set.count < 3 || !ffp_studio_complete(&set))
        return;
    for (int i = 0; i < set.count && length < sizeof list; i++)
        length += (size_t)snprintf(list + length, sizeof list - length, "%s%.9g", i > 0 ? "," : "",
                                   set.shots[i].angle);
    option(c, "--turntable-board", set.name);
    ffp_studio_word(c, "--angles=%s", list); // the first may be negative
    option(c, "--turntable-output", "calibration/axis.json");
}

// The calibration from the codes on an object, at those of its stops that are complete; how many.
static int add_stops(const FfpStudio *studio, FfpStudioCommand *c, const char *object, const char *folder) {
    char names[FFP_STUDIO_SETS][FFP_STUDIO_NAME], angles[2048] = "";
    FfpStudioSet set;
    size_t length = 0;
    int complete = 0;
    const int count = ffp_studio_set_names(studio, object, names, FFP_STUDIO_SETS);
    for (int i = 0; i < count; i++) {
        if (!ffp_studio_set(studio, names[i], &set) || set.kind != FFP_SET_STOP || !ffp_studio_complete(&set))
            continue;
        ffp_studio_word(c, "%s", names[i]);
        length += (size_t)snprintf(angles + length, sizeof angles - length, "%s%.9g",
                                   complete++ > 0 ? "," : "", set.shots[0].angle);
    }
    words(c, (const char *const[]){"--without-board", "--angles", angles, "--shown", "patterns", "-o", NULL});
    ffp_studio_word(c, "%s/calibration.xml", folder);
    ffp_studio_word(c, "--turntable-output");
    ffp_studio_word(c, "%s/axis.json", folder);
    return complete;
}

// How well the stops so far determine the rig.
static bool look_at_stops(FfpStudio *studio, char *said) {
    const char *object = ffp_studio_setting(studio, "object", "");
    char folder[FFP_STUDIO_NAME];
    snprintf(folder, sizeof folder, "objects/%.60s/known", object);
    if (add_stops(studio, ffp_studio_command(&studio->eye, "calibrate"), object, folder) < 3) {
        ffp_studio_clear(&studio->eye);
        return ffp_studio_say(said, "three stops are the least that tell anything");
    }
    return (ffp_studio_make(studio, folder) && ffp_studio_start(studio, &studio->eye, "known")) ||
           ffp_studio_say(said, "the stops cannot be looked at");
}

bool ffp_studio_look(FfpStudio *studio, const char *name, char said[FFP_STUDIO_SAID]) {
    FfpStudioSet set;
    int white = -1;
    if (studio->eye.end == FFP_JOB_RUNNING) return true; // asked again in a moment
    const bool known = ffp_studio_set(studio, name, &set);
    if (known && ffp_studio_without_board(studio) && set.object[0]) {
        ffp_studio_clear(&studio->eye);
        return look_at_stops(studio, said);
    }
    if (!known || set.kind != FFP_SET_ATTITUDE)
        return ffp_studio_say(said, "set: there is no such set of photographs of the board");
    for (int i = 0; i < set.count; i++)
        if (set.there[i] && set.shots[i].role == FFP_SHOT_WHITE) white = set.shots[i].number;
    if (white < 0) return ffp_studio_say(said, "%s has no photograph under white yet", name);
    ffp_studio_clear(&studio->eye);
    FfpStudioCommand *c = ffp_studio_command(&studio->eye, "calibrate");
    ffp_studio_word(c, "%s/%03d.%s", name, white, set.ending);
    add_board(studio, c);
    ffp_studio_word(c, "--seen");
    ffp_studio_word(c, "%s/board.json", name);
    return ffp_studio_start(studio, &studio->eye, "board") ||
           ffp_studio_say(said, "the board cannot be looked for");
}

static bool calibrate(FfpStudio *studio, FfpStudioJob *job, char *said) {
    FfpStudioCommand *c = ffp_studio_command(job, "calibrate");
    const int attitudes = add_attitudes(studio, c);
    if (attitudes < 3)
        return ffp_studio_say(said, "%d attitudes of the board are photographed; three are the least",
                              attitudes);
    words(c, (const char *const[]){"--shown", "patterns", "-o", "calibration/calibration.xml", "--report",
                                   "calibration/report.html", NULL});
    add_board(studio, c);
    const json_t *fix = json_object_get(studio->settings, "fix");
    for (size_t i = 0; i < json_array_size(fix); i++)
        option(c, "--fix", json_string_value(json_array_get(fix, i)));
    add_table(studio, c);
    return true;
}

// --- The object. ---

// The last of several lollipops, which is to be predicted; NULL: there is one only.
static const FfpStudioShot *held_out(const FfpStudioSet *set) {
    const FfpStudioShot *last = NULL;
    int count = 0;
    for (int i = 0; i < set->count; i++)
        if (set->shots[i].role == FFP_SHOT_LOLLIPOP) last = &set->shots[i], count++;
    return count > 1 ? last : NULL;
}

static void add_photographs(const FfpStudio *studio, FfpStudioCommand *c, const char *object,
                            const FfpStudioSet *stop) {
    FfpStudioSet empty;
    char path[FFP_STUDIO_NAME], name[80];
    const FfpStudioShot *kept = held_out(stop);
    ffp_studio_word(c, "-i");
    ffp_studio_word(c, "objects/%s/%s{view}/*.%s", object,
                    ffp_studio_without_board(studio) ? "" : FFP_STUDIO_VIEW, stop->ending);
    if (kept) {
        ffp_studio_pattern_name(kept->pattern, name, sizeof name);
        ffp_studio_word(c, "--held-out");
        ffp_studio_word(c, "%s=%s", name, kept->pattern);
    }
    snprintf(path, sizeof path, "objects/%.60s/empty", object);
    if (!ffp_studio_set(studio, path, &empty)) return;
    for (int i = 0; i < empty.count; i++) {
        if (kept && kept->number == empty.shots[i].number) continue;
        ffp_studio_pattern_name(empty.shots[i].pattern, name, sizeof name);
        ffp_studio_word(c, "--empty");
        ffp_studio_word(c, "%s=%s/%03d.%s", name, path, empty.shots[i].number, empty.ending);
    }
}

// All stops under the first projector, and the empty stage where one is wanted; `stop` is the last of them.
static bool all_there(const FfpStudio *studio, const char *object, FfpStudioSet *stop, char *said) {
    char names[FFP_STUDIO_SETS][FFP_STUDIO_NAME];
    FfpStudioSet set;
    const int count = ffp_studio_set_names(studio, object, names, FFP_STUDIO_SETS);
    memset(stop, 0, sizeof *stop);
    for (int i = 0; i < count; i++) {
        const bool known = ffp_studio_set(studio, names[i], &set);
        if (known && set.kind == FFP_SET_SECOND) continue; // that projector is found later
        if (!known || !ffp_studio_complete(&set))
            return ffp_studio_say(said, "%s has %d of %d photographs", names[i], set.done, set.count);
        *stop = set;
    }
    return count > 0;
}

FfpStudioCommand *ffp_studio_import(const FfpStudio *studio, FfpStudioJob *job, const char *object) {
    const int stops = (int)json_integer_value(json_object_get(ffp_studio_object(studio, object), "stops"));
    FfpStudioCommand *c = ffp_studio_command(job, "import");
    if (ffp_studio_without_board(studio)) {
        ffp_studio_word(c, "-c");
        ffp_studio_word(c, "objects/%.60s/calibration.xml", object);
        ffp_studio_word(c, "-t");
        ffp_studio_word(c, "objects/%.60s/axis.json", object);
    } else {
        words(c, (const char *const[]){"-c", "calibration/calibration.xml", "-t", "calibration/axis.json",
                                       "--angles", NULL});
        ffp_studio_word(c, "%dx%.9g", stops, 360.0 / stops);
    }
    option(c, "--name", object);
    return c;
}

void ffp_studio_add_width(const FfpStudio *studio, FfpStudioCommand *c) {
    ffp_studio_word(c, "-w");
    ffp_studio_word(c, "%lld", ffp_studio_number(studio, "width", -1, 128));
}

// Reconstructs the object and writes its page.
static void add_object(const FfpStudio *studio, FfpStudioJob *job, const char *folder, bool draft) {
    FfpStudioCommand *c = ffp_studio_command(job, "reconstruct");
    ffp_studio_word(c, "%s/capture", folder);
    if (draft) ffp_studio_add_width(studio, c);
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/object.ply", folder);
    c = ffp_studio_command(job, "view");
    ffp_studio_word(c, "%s/object.ply", folder);
    ffp_studio_word(c, "--capture");
    ffp_studio_word(c, "%s/capture", folder);
    ffp_studio_word(c, "-o");
    ffp_studio_word(c, "%s/view.html", folder);
}

static bool make(FfpStudio *studio, FfpStudioJob *job, char *said) {
    const char *object = ffp_studio_setting(studio, "object", "");
    FfpStudioSet stop;
    char folder[FFP_STUDIO_NAME], capture[FFP_STUDIO_NAME], found[FFP_STUDIO_NAME];
    if (!ffp_studio_object(studio, object)) return ffp_studio_say(said, "no object is chosen");
    const bool alone = ffp_studio_without_board(studio);
    if (!alone && !ffp_studio_exists(studio, "calibration/axis.json"))
        return ffp_studio_say(said, "the rig is not calibrated yet");
    if (!all_there(studio, object, &stop, said)) return false;
    snprintf(folder, sizeof folder, "objects/%.60s", object);
    snprintf(capture, sizeof capture, "objects/%.60s/capture", object);
    snprintf(found, sizeof found, "objects/%.60s/" FFP_STUDIO_SECOND "/found", object); // in another world
    if (!ffp_studio_set_aside(studio, capture))
        return ffp_studio_say(said, "%s cannot be moved to discarded/", capture);
    if (!ffp_studio_set_aside(studio, found))
        return ffp_studio_say(said, "%s cannot be moved to discarded/", found);
    if (alone) add_stops(studio, ffp_studio_command(job, "calibrate"), object, folder);
    FfpStudioCommand *c = ffp_studio_import(studio, job, object);
    ffp_studio_word(c, "--fit-response");
    option(c, "--shown", "patterns");
    add_photographs(studio, c, object, &stop);
    option(c, "-o", capture);
    ffp_studio_word(ffp_studio_command(job, "info"), "%s", capture);
    add_object(studio, job, folder, true);
    if (!json_is_true(json_object_get(studio->settings, "draft"))) add_object(studio, job, folder, false);
    return true;
}

static bool evaluate(FfpStudio *studio, FfpStudioJob *job, char *said) {
    const char *object = ffp_studio_setting(studio, "object", "");
    char folder[FFP_STUDIO_NAME], ply[FFP_STUDIO_NAME + 16];
    snprintf(folder, sizeof folder, "objects/%.60s", object);
    snprintf(ply, sizeof ply, "%s/object.ply", folder);
    if (!ffp_studio_exists(studio, ply)) return ffp_studio_say(said, "the object is not reconstructed yet");
    FfpStudioCommand *c = ffp_studio_command(job, "evaluate");
    ffp_studio_word(c, "%s/capture", folder);
    option(c, "--gaussians", ply); // those that the viewer shows
    ffp_studio_word(c, "--json");
    ffp_studio_word(c, "%s/scores.json", folder);
    ffp_studio_word(c, "--report");
    ffp_studio_word(c, "%s/report.html", folder);
    option(c, "--viewer", "view.html");
    return true;
}

bool ffp_studio_step(FfpStudio *studio, const char *step, FfpStudioJob *job, char said[FFP_STUDIO_SAID]) {
    static const struct {
        const char *name;
        bool (*make)(FfpStudio *, FfpStudioJob *, char *);
    } steps[] = {{"patterns", patterns}, {"calibrate", calibrate}, {"make", make}, {"evaluate", evaluate}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++)
        if (strcmp(steps[i].name, step) == 0) return steps[i].make(studio, job, said);
    return ffp_studio_say(said, "there is no step called %.40s", step);
}
