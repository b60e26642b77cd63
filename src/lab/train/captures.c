#include "lab/train/captures.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/integer.h"
#include "core/base/listing.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/base/rng.h"
#include "core/capture/pad.h"
#include "core/capture/reduce.h"
#include "engine/denoise/denoise.h"
#include "lab/train/prepare.h"

enum { CAPTURES_MAX = 4096, EVERY = 4, STREAM = 77 };

typedef struct Member {
    char name[256];
    bool held_out;
    int inputs;         // views that are photographs; a room's other views are its clean pictures
    FfpCapture capture; // all views, made smaller; normalised
    FfpCapture clean;   // the photographs without noise: views and lists are its own
    FfpCapture padded;  // of whole patches, for matching and the network; borrows from `clean`
    FfpImage *lists;    // of the noise filter
    int photographs[FFP_PHOTOGRAPHS];
} Member;

struct FfpCaptureSet {
    const char *folder; // while it is read
    bool rooms;
    int count, learnt; // members, and those that are not held out
    Member *members;
};

// --- Which there are. ---

static bool is_capture(const char *folder, const char *name) {
    char path[FFP_PATH_MAX], json[FFP_PATH_MAX];
    if (name[0] == '.' || !ffp_join_path(path, folder, name)) return false;
    return (ffp_join_path(json, path, "scene.json") && ffp_is_file(json)) ||
           (ffp_join_path(json, path, "render_poses.json") && ffp_is_file(json));
}

static int by_name(const void *a, const void *b) {
    return strcmp(((const Member *)a)->name, ((const Member *)b)->name);
}

static bool list_captures(FfpCaptureSet *set, FfpError *err) {
    const char *folder = set->folder;
    char json[FFP_PATH_MAX];
    set->members = ffp_alloc(CAPTURES_MAX, sizeof *set->members);
    FfpListing listing;
    if (!ffp_list_folder(&listing, folder))
        return ffp_fail(err, FFP_ERROR_IO, folder, "cannot read the folder of %s: %s",
                        set->rooms ? "rooms" : "captures", strerror(errno));
    for (int i = 0; i < listing.count; i++) {
        const char *name = listing.names[i];
        if (set->count < CAPTURES_MAX && strlen(name) < sizeof set->members->name && is_capture(folder, name))
            memcpy(set->members[set->count++].name, name, strlen(name) + 1);
    }
    ffp_free(listing.names);
    const int least = set->rooms ? 1 : 2;
    if ((set->rooms || set->count < least) && ffp_join_path(json, folder, "scene.json") && ffp_is_file(json))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder,
                        set->rooms ? "is a room: name the folder that holds it"
                                   : "is a capture: name the folder that holds it and at least another one");
    if (set->count < least)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder,
                        set->rooms
                            ? "holds no rooms (folders with a scene.json and targets/scene.json)"
                            : "holds %d captures (folders with a scene.json): at least two are needed, "
                              "one to learn from and one to hold out",
                        set->count);
    qsort(set->members, (size_t)set->count, sizeof *set->members, by_name);
    return true;
}

static void hold_out(FfpCaptureSet *set) {
    for (int i = 0; i < set->count; i++) {
        set->members[i].held_out = set->rooms           ? false
                                   : set->count < EVERY ? i == set->count - 1
                                                        : i % EVERY == EVERY - 1;
        set->learnt += !set->members[i].held_out;
    }
}

// --- Reading one. ---

static bool seen_by_all(const FfpCapture *capture, int pattern) {
    for (int v = 0; v < capture->n_views; v++)
        if (!capture->views[v].images[pattern].data) return false;
    return true;
}

// Black, white, the pattern to reconstruct from, and others that every view has.
static bool keep_useful_patterns(FfpCapture *capture, int others, FfpError *err) {
    int chosen[FFP_PATTERNS_MAX], count = 3;
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    if (active < 0) return false;
    chosen[0] = capture->black;
    chosen[1] = capture->white;
    chosen[2] = active;
    for (int p = 0; p < ffp_patterns_shown(capture) && count < 2 + others; p++)
        if (p != active && p != capture->black && p != capture->white && seen_by_all(capture, p))
            chosen[count++] = p;
    ffp_scene_keep_patterns(capture, chosen, count);
    return true;
}

// Replaces the views by those with pictures of at most `longest` pixels a side, and no truth.
static void reduce_views(FfpCapture *capture, int longest) {
    int all[FFP_PATTERNS_MAX];
    for (int p = 0; p < capture->n_patterns; p++) all[p] = p;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        const int side = camera->width > camera->height ? camera->width : camera->height;
        const double by = side > longest ? (double)longest / side : 1;
        const int width = (int)(camera->width * by + 0.5), height = (int)(camera->height * by + 0.5);
        FfpView small = ffp_view_reduced(&capture->views[v], capture->n_patterns, all, capture->n_patterns,
                                         width > 0 ? width : 1, height > 0 ? height : 1);
        ffp_view_free(&capture->views[v], capture->n_patterns);
        capture->views[v] = small;
    }
}

// Appends the clean pictures of a room.
static bool read_targets(FfpCapture *capture, const char *path, FfpError *err) {
    char json[FFP_PATH_MAX];
    if (!ffp_join_path(json, path, "targets/scene.json"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "the path is too long");
    if (!ffp_is_file(json))
        return ffp_fail(err, FFP_ERROR_FILE, json, "the room has no clean pictures to learn from");
    FfpCapture targets;
    if (!ffp_capture_read_targets(&targets, json, capture, err)) return false;
    const char *why = targets.n_views > FFP_TRAIN_VIEWS_MAX    ? "holds too many views"
                      : !seen_by_all(&targets, capture->black) ? "a view has no picture under black"
                      : !seen_by_all(&targets, capture->white) ? "a view has no picture under white"
                                                               : NULL;
    if (!why) ffp_scene_append_views(capture, &targets);
    ffp_capture_free(&targets);
    return !why || ffp_fail(err, FFP_ERROR_FILE, ffp_place(json, "views").text, "%s", why);
}

static bool read_photographs(Member *member, const FfpTrainConfig *config, const char *path, bool room,
                             FfpError *err) {
    FfpCapture *capture = &member->capture;
    if (!ffp_capture_read(capture, path, err)) return false;
    member->inputs = capture->n_views;
    if (room && !read_targets(capture, path, err)) return false;
    if (!keep_useful_patterns(capture, config->lollipops, err)) return false;
    if (capture->n_views == 1 && capture->n_patterns == 3)
        return ffp_fail(err, FFP_ERROR_FILE, path, "one view under one pattern leaves nothing to predict");
    reduce_views(capture, config->resolution);
    const real centre[3] = {capture->centre[0], capture->centre[1], capture->centre[2]};
    ffp_capture_normalise(capture, centre, capture->radius);
    return true;
}

static void clean_photographs(Member *member, int patch) {
    const FfpCapture *capture = &member->capture;
    for (int i = 0; i < FFP_PHOTOGRAPHS; i++) member->photographs[i] = i;
    member->clean = *capture;
    member->clean.views = ffp_alloc((size_t)member->inputs, sizeof *member->clean.views);
    member->clean.n_views = member->inputs;
    memcpy(member->clean.views, capture->views, (size_t)member->inputs * sizeof *capture->views);
    const double noise = ffp_noise_estimate(&member->clean, member->photographs);
    if (noise > 0) member->lists = ffp_denoise(&member->clean, member->photographs, FFP_PHOTOGRAPHS, noise);
    member->padded = ffp_padded_capture(&member->clean, member->photographs, FFP_PHOTOGRAPHS, patch);
}

static void close_member(Member *member) {
    if (member->padded.views) ffp_padded_capture_free(&member->padded, &member->clean);
    if (member->lists) ffp_denoise_free(member->lists, &member->clean, member->photographs, FFP_PHOTOGRAPHS);
    ffp_free(member->clean.views);
    ffp_capture_free(&member->capture);
}

static bool open_member(const FfpCaptureSet *set, Member *member, const FfpTrainConfig *config,
                        FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_join_path(path, set->folder, member->name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, set->folder, "the path is too long");
    if (!read_photographs(member, config, path, set->rooms, err)) return false;
    clean_photographs(member, config->model.patch);
    return true;
}

// Bytes that a member keeps: photographs, coverage, what the noise filter and the padding made of them,
// patterns.
static double bytes_of(const Member *member) {
    const FfpCapture *capture = &member->capture;
    double values = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        values += (double)camera->width * camera->height * (3 * (capture->n_patterns + FFP_PHOTOGRAPHS) + 1);
    }
    for (int v = 0; v < member->inputs; v++) {
        const FfpCamera *padded = &member->padded.views[v].camera;
        values += (double)padded->width * padded->height * (3 * FFP_PHOTOGRAPHS + 1);
    }
    for (int p = 0; p < capture->n_patterns; p++)
        values += 3.0 * capture->patterns[p].image.width * capture->patterns[p].image.height;
    return values * sizeof(real);
}

// Checks that the captures that are still to be read will find room, if they are as large as those before.
static bool check_room(const FfpCaptureSet *set, int read, FfpError *err) {
    double bytes = 0;
    for (int i = 0; i < read; i++) bytes += bytes_of(&set->members[i]);
    const double needed = bytes / read * (set->count - read), left = ffp_memory_available();
    return left < 0 || needed <= left ||
           ffp_fail(err, FFP_ERROR_MEMORY, set->folder,
                    "its %d captures take about %.1f GB: use fewer, or a smaller resolution", set->count,
                    (bytes + needed) / 1e9);
}

static FfpCaptureSet *open_set(const FfpTrainConfig *config, bool rooms, FfpError *err) {
    FfpCaptureSet *set = ffp_alloc(1, sizeof *set);
    *set = (FfpCaptureSet){.folder = rooms ? config->rooms : config->captures, .rooms = rooms};
    bool ok = list_captures(set, err);
    if (ok) hold_out(set);
    const FfpTask task = ffp_task(rooms ? "reading rooms" : "reading captures", ok ? set->count : 0);
    for (int i = 0; ok && i < set->count; i++) {
        ok = open_member(set, &set->members[i], config, err) && check_room(set, i + 1, err);
        ffp_task_step(&task, i + 1, set->members[i].name);
    }
    ffp_task_end(&task);
    if (ok) return set;
    ffp_captures_close(set);
    return NULL;
}

FfpCaptureSet *ffp_captures_open(const FfpTrainConfig *config, FfpError *err) {
    return open_set(config, false, err);
}

FfpCaptureSet *ffp_rooms_open(const FfpTrainConfig *config, FfpError *err) {
    return open_set(config, true, err);
}

void ffp_captures_close(FfpCaptureSet *set) {
    if (!set) return;
    for (int i = 0; i < set->count; i++) close_member(&set->members[i]);
    ffp_free(set->members);
    ffp_free(set);
}

int ffp_captures_count(const FfpCaptureSet *set, bool held_out) {
    return held_out ? set->count - set->learnt : set->learnt;
}

// --- Scenes. ---

// The `wanted`-th of those held out, or of the others.
static const Member *member_of(const FfpCaptureSet *set, bool held_out, int wanted) {
    int i = 0;
    for (; i < set->count; i++)
        if (set->members[i].held_out == held_out && wanted-- == 0) break;
    return &set->members[i];
}

static void shuffle(int *numbers, int count, FfpRng *rng) {
    for (int i = 0; i + 1 < count; i++) {
        const int k = i + (int)ffp_rng_below(rng, (uint32_t)(count - i)), swap = numbers[k];
        numbers[k] = numbers[i];
        numbers[i] = swap;
    }
}

// A scene of the views in order: `inputs` of them as the network sees them, and all as they were
// photographed.
static bool make_scene(FfpScene *scene, const FfpTrainConfig *config, const Member *member, const int *views,
                       int inputs, int count, FfpError *err) {
    *scene = (FfpScene){.capture = member->capture, .inputs = member->padded, .borrowed = true};
    scene->capture.n_views = count;
    scene->inputs.n_views = inputs;
    scene->capture.views = ffp_alloc((size_t)count, sizeof *scene->capture.views);
    scene->inputs.views = ffp_alloc((size_t)inputs, sizeof *scene->inputs.views);
    for (int i = 0; i < count; i++) scene->capture.views[i] = member->capture.views[views[i]];
    for (int i = 0; i < inputs; i++) scene->inputs.views[i] = member->padded.views[views[i]];
    FfpError why = {0};
    return ffp_scene_match(scene, config, &why) || ffp_fail(err, why.code, member->name, "%s", why.text);
}

// The member whose turn it is: all in turn, in an order of the seed.
static const Member *member_in_turn(const FfpCaptureSet *set, uint64_t seed, uint64_t stream,
                                    int64_t number) {
    int order[CAPTURES_MAX];
    FfpRng rng = ffp_rng(seed, stream + (uint64_t)(number / set->learnt));
    for (int i = 0; i < set->learnt; i++) order[i] = i;
    shuffle(order, set->learnt, &rng);
    return member_of(set, false, order[number % set->learnt]);
}

// How many of so many views are to be predicted.
static int left_out(int views) {
    return views < 2 ? 0 : views < EVERY ? 1 : views / EVERY;
}

bool ffp_captures_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set,
                        int64_t number, FfpError *err) {
    int views[FFP_VIEWS_MAX];
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + 2, (uint64_t)number);
    const Member *member = member_in_turn(set, (uint64_t)config->seed, STREAM, number);
    const int n = member->capture.n_views;
    for (int v = 0; v < n; v++) views[v] = v;
    shuffle(views, n, &rng);
    const int targets = ffp_rng_below(&rng, EVERY) == 0 ? 0 : ffp_smaller(left_out(n), config->targets);
    const int inputs = ffp_smaller(n - targets, config->views);
    return make_scene(scene, config, member, views, inputs, inputs + targets, err);
}

bool ffp_captures_held_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set,
                             int index, FfpError *err) {
    int views[FFP_VIEWS_MAX], inputs = 0, targets = 0;
    const Member *member = member_of(set, true, index);
    const int n = member->capture.n_views, out = left_out(n), step = out > 0 ? n / out : n + 1;
    for (int v = 0; v < n; v++)
        if (v % step != step - 1 && inputs < config->views) views[inputs++] = v;
    for (int v = step - 1; v < n && targets < config->targets; v += step) views[inputs + targets++] = v;
    return make_scene(scene, config, member, views, inputs, inputs + targets, err);
}

// --- Rooms. ---

bool ffp_is_room(const FfpTrainConfig *config, int64_t number) {
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + 2, (uint64_t)number ^ (1ULL << 61));
    return ffp_rng_uniform(&rng) < config->room_share;
}

bool ffp_rooms_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set, int64_t number,
                     FfpError *err) {
    int views[FFP_VIEWS_MAX + FFP_TRAIN_VIEWS_MAX] = {0};
    const Member *member = member_in_turn(set, (uint64_t)config->seed, 1ULL << 40, number);
    const int n = member->inputs, targets = member->capture.n_views - n,
              inputs = ffp_smaller(n, config->views);
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + 2, (uint64_t)number);
    for (int v = 0; v < n; v++) views[v] = v;
    if (n > inputs) shuffle(views, n, &rng);
    for (int v = 0; v < targets; v++) views[inputs + v] = n + v;
    if (!make_scene(scene, config, member, views, inputs, inputs + targets, err)) return false;
    scene->targets_only = true;
    return true;
}
