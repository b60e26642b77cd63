#include "world/synth/room_photographs.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "world/shapes/noise.h"
#include "world/synth/natural.h"
#include "world/synth/pattern_folder.h"
#include "world/synth/photographing.h"
#include "world/synth/room.h"
#include "world/synth/room_truth.h"
#include "world/synth/sensor.h"

enum { NAME = 256 };

typedef enum Kind { KIND_STOP, KIND_BETWEEN, KIND_EMPTY, KIND_ATTITUDE, KIND_TURNTABLE } Kind;

// What a picture before the camera is called, and what exists already.
typedef struct Subject {
    Kind kind;
    char name[32];
    double angle;        // by which the turntable has turned
    int stop;            // of the board on it
    FfpChessboard board; // of attitudes and turntable
} Subject;

typedef struct Sent {
    char name[NAME], file[NAME + 16]; // in patterns/
    int number;
    bool held_out;
} Sent;

typedef struct Job {
    const FfpRoomPhotographs *options;
    const FfpSceneSpec *spec;
    FfpSensor sensor;
    const FfpMesh *mesh;
    FfpMaterial material;
    FfpRoom room;
    FfpPatternFolder patterns;
    int n_sent, n_subjects;
    Sent *sent;
    Subject *subjects;
    const char *folder; // being written
    FfpPhotographing run;
} Job;

static bool path_in(const Job *job, const char *name, char path[FFP_PATH_MAX], FfpError *err) {
    return ffp_photographing_path(job->folder, name, path, err);
}

static bool make_folder(const Job *job, const char *name, FfpError *err) {
    char path[FFP_PATH_MAX];
    return path_in(job, name, path, err) && ffp_make_folders(path, err);
}

// --- Patterns. ---

static const int held_out_kinds[] = {2, 4}; // of natural.h
enum { HELD_OUT = sizeof held_out_kinds / sizeof *held_out_kinds };

// Where patterns of a series are kept apart, so that `*` names them all; "": among the others.
static const char *series_of(const char *name) {
    return strncmp(name, "gray_", 5) == 0 ? "graycode" : "";
}

static bool is_sent(const Job *job, const char *name) {
    for (int i = 0; i < job->n_sent; i++)
        if (strcmp(job->sent[i].name, name) == 0) return true;
    return false;
}

static Sent *add_sent(Job *job, const char *name, int number) {
    Sent *sent = &job->sent[job->n_sent++];
    const char *series = series_of(name);
    snprintf(sent->name, sizeof sent->name, "%s", name);
    snprintf(sent->file, sizeof sent->file, "%s%s%s.png", series, *series ? "/" : "", name);
    sent->number = number;
    return sent;
}

static bool list_sent(Job *job, FfpError *err) {
    const FfpPatternFolder *from = &job->patterns;
    job->sent = ffp_alloc((size_t)from->count + HELD_OUT, sizeof *job->sent);
    for (int i = 0; i < from->count; i++) {
        if (is_sent(job, from->list[i].name))
            return ffp_fail(err, FFP_ERROR_FILE, from->folder, "two patterns are called %s",
                            from->list[i].name);
        add_sent(job, from->list[i].name, from->list[i].number);
    }
    if (!is_sent(job, "black") || !is_sent(job, "white"))
        return ffp_fail(err, FFP_ERROR_FILE, from->folder,
                        "a room is photographed under black and white too: no %s",
                        is_sent(job, "black") ? "white" : "black");
    for (int i = 0; i < HELD_OUT; i++) {
        const char *name = ffp_natural_name(held_out_kinds[i]);
        if (is_sent(job, name))
            return ffp_fail(err, FFP_ERROR_FILE, from->folder,
                            "a pattern is called %s, as one of those that are held out", name);
        add_sent(job, name, 0)->held_out = true;
    }
    return true;
}

static bool copy_pattern(const Job *job, int index, const char *path, FfpError *err) {
    enum { LARGEST = 1 << 30 };
    char from[FFP_PATH_MAX], *data;
    size_t size;
    if (!ffp_pattern_folder_path(&job->patterns, index, from, err) ||
        !ffp_read_file(from, LARGEST, &data, &size, err))
        return false;
    const bool ok = ffp_write_file(path, data, size, err);
    ffp_free(data);
    return ok;
}

static bool draw_held_out(const Job *job, int index, const char *path, FfpError *err) {
    FfpImage image = ffp_natural_pattern(job->patterns.width, job->patterns.height, held_out_kinds[index],
                                         job->options->seed);
    ffp_image_to_srgb(&image);
    const bool ok = ffp_image_write_png(&image, path, err);
    ffp_image_free(&image);
    return ok;
}

static bool write_patterns(const Job *job, FfpError *err) {
    if (!make_folder(job, "patterns/graycode", err)) return false;
    for (int i = 0; i < job->n_sent; i++) {
        char name[NAME + 32], path[FFP_PATH_MAX];
        snprintf(name, sizeof name, "patterns/%s", job->sent[i].file);
        const int own = i - job->patterns.count;
        if (!path_in(job, name, path, err) ||
            !(own < 0 ? copy_pattern(job, i, path, err) : draw_held_out(job, own, path, err)))
            return false;
    }
    return true;
}

// --- Subjects. ---

static bool is_board(const Subject *subject) {
    return subject->kind == KIND_ATTITUDE || subject->kind == KIND_TURNTABLE;
}

// Which patterns a subject is photographed under.
static bool suits(const Sent *sent, const Subject *subject) {
    const bool series = *series_of(sent->name), gray = strncmp(sent->name, "gray_", 5) == 0;
    switch (subject->kind) {
    case KIND_STOP:
        return true;
    case KIND_BETWEEN:
        return !series;
    case KIND_EMPTY:
        return !sent->held_out;
    case KIND_ATTITUDE:
        return gray || strcmp(sent->name, "black") == 0 || strcmp(sent->name, "white") == 0;
    default:
        return strcmp(sent->name, "white") == 0;
    }
}

static Subject *add_subject(Job *job, Kind kind, double angle) {
    Subject *s = &job->subjects[job->n_subjects++];
    s->kind = kind, s->angle = angle;
    return s;
}

// Raises a board so that it is held above the platter.
static void lift(FfpChessboard *board, float floor) {
    float lowest = floor;
    for (int corner = 0; corner < 4; corner++) {
        float point[3];
        ffp_chessboard_point(board, corner % 2 ? (float)board->columns + 1 : -2,
                             corner / 2 ? (float)board->rows + 1 : -2, point);
        lowest = fminf(lowest, point[2] - 0.02F);
    }
    board->origin[2] += floor - lowest;
}

static void add_boards(Job *job, float floor) {
    for (int i = 0; i < job->options->attitudes; i++) {
        Subject *s = add_subject(job, KIND_ATTITUDE, 0);
        snprintf(s->name, sizeof s->name, "attitude-%02d", i);
        s->board = ffp_bare_rig_attitude(&job->room.rig, i, job->options->seed);
        lift(&s->board, floor);
    }
    for (int i = 0; i < FFP_BOARD_STOPS && job->options->attitudes > 0; i++) {
        Subject *s = add_subject(job, KIND_TURNTABLE, ffp_board_angle(i));
        snprintf(s->name, sizeof s->name, "turntable");
        s->stop = i;
        s->board = ffp_bare_rig_turntable_board(&job->room.rig);
        lift(&s->board, floor);
    }
}

static void add_subjects(Job *job, float floor) {
    static const int between[] = {22, 157};
    const int views = job->spec->views;
    bool coded = false;
    for (int i = 0; i < job->n_sent; i++) coded |= strcmp(series_of(job->sent[i].name), "graycode") == 0;
    job->subjects = ffp_alloc((size_t)views + 3 + (size_t)job->options->attitudes + FFP_BOARD_STOPS,
                              sizeof *job->subjects);
    for (int i = 0; i < views; i++) {
        Subject *s = add_subject(job, KIND_STOP, 360.0 * i / views);
        snprintf(s->name, sizeof s->name, "%03d", (int)lround(s->angle));
    }
    for (int i = 0; i < 2; i++) {
        Subject *s = add_subject(job, KIND_BETWEEN, between[i]);
        snprintf(s->name, sizeof s->name, "new%d", between[i]);
    }
    snprintf(add_subject(job, KIND_EMPTY, 0)->name, sizeof job->subjects->name, "empty");
    if (coded) add_boards(job, floor);
}

// --- Pictures. ---

// The folder of a subject's photographs under a pattern, and the file's name without ending.
static void name_photograph(const Subject *subject, const Sent *sent, char folder[64], char name[NAME]) {
    const char *series = series_of(sent->name);
    snprintf(name, NAME, "%s", sent->name);
    if (subject->kind == KIND_EMPTY)
        snprintf(folder, 64, "empty");
    else if (is_board(subject))
        snprintf(folder, 64, "%s", subject->name);
    else
        snprintf(folder, 64, "%s/%s", *series ? series : "photographs", subject->name);
    if (subject->kind == KIND_ATTITUDE) snprintf(name, NAME, "%03d", sent->number);
    if (subject->kind == KIND_TURNTABLE) snprintf(name, NAME, "%02d", subject->stop);
}

static bool has_truth(const Subject *subject, const Sent *sent) {
    return (subject->kind == KIND_STOP || subject->kind == KIND_BETWEEN) && !*series_of(sent->name);
}

// What the light of a picture makes of its noise; no two pictures of a room have the same.
static uint32_t key_of(uint64_t seed, int subject, int pattern) {
    return ffp_hash32((uint32_t)seed ^ ffp_hash32((uint32_t)(seed >> 32) ^
                                                  ffp_hash32((uint32_t)(subject * 4096 + pattern + 1))));
}

static bool write_truth(const Job *job, const Subject *subject, const Sent *sent, const FfpImage *light,
                        FfpError *err) {
    char name[NAME + 64], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "truth/%s/%s.png", subject->name, sent->name);
    if (!path_in(job, name, path, err)) return false;
    FfpImage seen = ffp_image_copy(light);
    ffp_image_to_srgb(&seen);
    const bool ok = ffp_image_write_png(&seen, path, err);
    ffp_image_free(&seen);
    return ok;
}

static bool write_photograph(const void *argument, int index, int pattern, FfpImage *light, FfpError *err) {
    const Job *job = argument;
    const Subject *subject = &job->subjects[index];
    const Sent *sent = &job->sent[pattern];
    char folder[64], name[NAME], file[NAME + 80], path[FFP_PATH_MAX];
    name_photograph(subject, sent, folder, name);
    snprintf(file, sizeof file, "%s/%s.JPG", folder, name);
    if (!path_in(job, file, path, err)) return false;
    if (job->room.camera_defocus > 0) ffp_image_blur(light, (real)job->room.camera_defocus);
    if (has_truth(subject, sent) && !write_truth(job, subject, sent, light, err)) return false;
    ffp_sensor_expose(light, &job->sensor, key_of(job->options->seed, index, pattern));
    ffp_image_to_srgb(light);
    return ffp_image_write_jpeg(light, job->options->quality, path, err);
}

static bool write_mask(const Job *job, const Subject *subject, const FfpView *view, FfpError *err) {
    char name[64], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "masks/%s.png", subject->name);
    return path_in(job, name, path, err) && ffp_image_write_png(&view->coverage, path, err);
}

// How much light the camera takes: of a board half as much, so that its paper is not clipped.
static float exposure_of(const Job *job, const Subject *subject) {
    return exp2f(job->sensor.exposure) * (is_board(subject) ? 0.5F : 1);
}

static FfpSimulation simulation_of(const Job *job, const Subject *subject, const FfpSurroundings *around,
                                   const FfpLight *light) {
    const float intensity = exposure_of(job, subject) * job->room.rig.intensity;
    return (FfpSimulation){.mesh = &around->mesh,
                           .material = &job->material,
                           .textures = job->spec->own_textures,
                           .board = is_board(subject) ? &subject->board : NULL,
                           .around = around,
                           .light = light,
                           .intensity = {intensity, intensity, intensity},
                           .samples = job->spec->samples,
                           .ambient_rays = job->spec->ambient_rays,
                           .camera_lens = job->room.rig.camera_lens,
                           .projector_lens = job->room.rig.projector_lens,
                           .photograph = true,
                           .light_only = true,
                           .seed = job->options->seed};
}

// The subject under the patterns of a batch.
static bool photograph(void *argument, int index, const FfpLight *light, int first, FfpError *err) {
    const Job *job = argument;
    const Subject *subject = &job->subjects[index];
    FfpMesh board = {0};
    if (is_board(subject)) board = ffp_chessboard_mesh(&subject->board);
    const FfpMesh *object = is_board(subject) ? &board : subject->kind == KIND_EMPTY ? NULL : job->mesh;
    FfpSurroundings around = ffp_around_new(&job->room, object, subject->angle);
    around.lamp.radiance *= exposure_of(job, subject);
    FfpSimulation simulation = simulation_of(job, subject, &around, light);
    FfpTracer *tracer = ffp_tracer_new(&around.mesh, err);
    simulation.tracer = tracer;
    bool ok = tracer != NULL;
    if (ok) {
        FfpView view = {0};
        ffp_bare_rig_devices(&job->room.rig, subject->angle, &view.camera, &view.projector);
        ffp_simulate_view(&simulation, &view, (uint32_t)index, NULL);
        ok = ffp_photographing_develop(&job->run, index, &view, first, light->n_patterns, err) &&
             (first > 0 || subject->kind > KIND_BETWEEN || write_mask(job, subject, &view, err));
        ffp_view_free(&view, light->n_patterns);
    }
    ffp_tracer_free(tracer);
    ffp_around_free(&around);
    ffp_mesh_free(&board);
    return ok;
}

static const char *name_of(const void *argument, int subject) {
    const Job *job = argument;
    return job->subjects[subject].name;
}

static bool is_wanted(const void *argument, int subject, int pattern) {
    const Job *job = argument;
    return suits(&job->sent[pattern], &job->subjects[subject]);
}

static bool emit(const void *argument, int index, FfpImage *emitted, FfpError *err) {
    const Job *job = argument;
    char name[NAME + 32], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "patterns/%s", job->sent[index].file);
    return path_in(job, name, path, err) && ffp_pattern_emit(path, &job->sensor, emitted, err);
}

// The folders of all pictures.
static bool make_folders(const Job *job, FfpError *err) {
    if (!make_folder(job, "masks", err)) return false;
    for (int s = 0; s < job->n_subjects; s++)
        for (int p = 0; p < job->n_sent; p++) {
            const Subject *subject = &job->subjects[s];
            char folder[64], name[NAME], truth[64];
            if (!suits(&job->sent[p], subject)) continue;
            name_photograph(subject, &job->sent[p], folder, name);
            snprintf(truth, sizeof truth, "truth/%s", subject->name);
            if (!make_folder(job, folder, err) ||
                (has_truth(subject, &job->sent[p]) && !make_folder(job, truth, err)))
                return false;
        }
    return true;
}

static bool photograph_all(Job *job, FfpError *err) {
    job->run = (FfpPhotographing){job,       &job->room.rig, job->n_sent, job->n_subjects, name_of,
                                  is_wanted, emit,           photograph,  write_photograph};
    const int64_t count = make_folders(job, err) ? ffp_photographing_run(&job->run, err) : -1;
    if (count >= 0)
        ffp_note("%s: %lld photographs of %s", job->options->folder, (long long)count,
                 job->options->attitudes > 0 ? "the object and of the chessboard" : "the object");
    return count >= 0;
}

// --- All of it. ---

static bool check(const FfpRoomPhotographs *options, const FfpSceneSpec *spec, FfpError *err) {
    return ffp_photographing_check(spec, options->attitudes, err) &&
           ((options->quality >= 1 && options->quality <= 100) ||
            ffp_fail(err, FFP_ERROR_ARGUMENT, "quality", "%d is not in 1..100", options->quality));
}

// The room's faults, with those that were asked for in their place.
static FfpSensor sensor_of(const FfpRoom *room, const FfpSensor *asked) {
    FfpSensor sensor = room->sensor;
    sensor.exposure = asked->exposure;
    if (asked->shot != 0) sensor.shot = asked->shot;
    if (asked->read != 0) sensor.read = asked->read;
    if (asked->defocus != 0) sensor.defocus = asked->defocus;
    if (asked->gamma != 0) sensor.gamma = asked->gamma;
    if (asked->black_level != 0) sensor.black_level = asked->black_level;
    return sensor;
}

static bool write_folder(Job *job, FfpError *err) {
    FfpOutput folder;
    if (!ffp_capture_probe(job->options->folder, err) ||
        !ffp_output_open_folder(&folder, job->options->folder, true, err))
        return false;
    job->folder = folder.temporary;
    const bool ok = write_patterns(job, err) && photograph_all(job, err) &&
                    ffp_room_truth_write(&job->room.rig, job->spec->views, job->folder, err) &&
                    ffp_output_commit(&folder, err);
    ffp_output_abort(&folder);
    job->folder = NULL;
    return ok;
}

static bool write_room(Job *job, FfpError *err) {
    FfpMesh made = {0};
    if (!job->spec->own_mesh) made = ffp_mesh_make(job->spec->mesh);
    job->mesh = job->spec->own_mesh ? job->spec->own_mesh : &made;
    const float floor = ffp_room_floor(job->mesh);
    job->room = ffp_room_draw(job->options->seed, floor, job->spec->resolution, job->patterns.width,
                              job->patterns.height);
    job->sensor = sensor_of(&job->room, &job->spec->sensor);
    add_subjects(job, floor);
    const bool ok = write_folder(job, err);
    ffp_room_free(&job->room);
    ffp_mesh_free(&made);
    return ok;
}

bool ffp_room_photographs_write(const FfpRoomPhotographs *options, const FfpSceneSpec *spec, FfpError *err) {
    Job job = {.options = options, .spec = spec, .material = ffp_material_make(spec->material, spec->seed)};
    if (!check(options, spec, err) || !ffp_pattern_folder_open(&job.patterns, options->patterns, err))
        return false;
    const bool ok = list_sent(&job, err) && write_room(&job, err);
    ffp_free(job.subjects);
    ffp_free(job.sent);
    ffp_pattern_folder_close(&job.patterns);
    return ok;
}
