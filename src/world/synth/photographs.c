// Photographs of a rig: what stands before it, and the folder.
#include "world/synth/photographs.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "world/synth/photographing.h"
#include "world/synth/sensor.h"

enum { SIDE_MIN = 64, SIDE_MAX = 4096, ATTITUDES_MAX = 64, HELD_OUT = 2 };
static const int between[] = {22, 157}; // degrees
enum { BETWEEN = sizeof between / sizeof *between };

// --- Subjects. ---

// NULL: it is not to be photographed.
static FfpPhotographed *add_subject(FfpPhotographing *job, FfpPhotographedKind kind, int stream, double angle,
                                    const char *name) {
    const char *only = job->options->only;
    if (only && strcmp(only, name) != 0) return NULL;
    FfpPhotographed *s = &job->subjects[job->n_subjects++];
    *s = (FfpPhotographed){.kind = kind, .stream = (uint32_t)stream, .angle = angle};
    snprintf(s->name, sizeof s->name, "%s", name);
    return s;
}

static void add_object(FfpPhotographing *job, FfpPhotographedKind kind, int stream, double angle) {
    char name[32];
    snprintf(name, sizeof name, "view-%03d", (int)lround(angle)); // as `import` calls it
    add_subject(job, kind, stream, angle, name);
}

// In a room a board is held above the platter.
static FfpChessboard lifted(const FfpPhotographing *job, FfpChessboard board) {
    const float floor = ffp_room_floor(job->mesh);
    float lowest = floor;
    for (int corner = 0; corner < 4; corner++) {
        float point[3];
        ffp_chessboard_point(&board, corner % 2 ? (float)board.columns + 1 : -2,
                             corner / 2 ? (float)board.rows + 1 : -2, point);
        lowest = fminf(lowest, point[2] - 0.02F);
    }
    if (job->options->room) board.origin[2] += floor - lowest;
    return board;
}

static void add_boards(FfpPhotographing *job, int attitudes, int stops, int stream) {
    const uint64_t seed = job->options->room ? job->options->seed : job->spec->seed;
    const FfpBareRig *rig = &job->room.rig;
    for (int i = 0; i < attitudes; i++) {
        char name[32];
        snprintf(name, sizeof name, "attitude-%02d", i);
        FfpPhotographed *s = add_subject(job, FFP_SUBJECT_ATTITUDE, stream + i, 0, name);
        if (s) s->board = lifted(job, ffp_bare_rig_attitude(rig, i, seed));
    }
    for (int i = 0; i < stops; i++) {
        FfpPhotographed *s =
            add_subject(job, FFP_SUBJECT_TURNTABLE, stream + attitudes + i, ffp_board_angle(i), "turntable");
        if (s) s->stop = i, s->board = lifted(job, ffp_bare_rig_turntable_board(rig));
    }
}

static bool add_subjects(FfpPhotographing *job, FfpError *err) {
    const bool room = job->options->room;
    const int views = job->spec->views, attitudes = job->shown.n_codes > 0 ? job->options->attitudes : 0,
              stops = attitudes > 0 ? FFP_BOARD_STOPS : 0;
    const int boards = room ? views + BETWEEN + 1 : views; // the streams of a room are in another order
    job->subjects =
        ffp_alloc((size_t)views + BETWEEN + 1 + (size_t)attitudes + (size_t)stops, sizeof *job->subjects);
    for (int i = 0; i < views; i++) add_object(job, FFP_SUBJECT_STOP, i, 360.0 * i / views);
    for (int i = 0; i < BETWEEN && room; i++) add_object(job, FFP_SUBJECT_BETWEEN, views + i, between[i]);
    add_boards(job, attitudes, stops, boards);
    add_subject(job, FFP_SUBJECT_EMPTY, room ? views + BETWEEN : boards + attitudes + stops, 0, "empty");
    return job->n_subjects > 0 ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "only", "nothing is called \"%s\" among what is photographed",
                    job->options->only);
}

// --- All of it. ---

bool ffp_photographs_check(const FfpSceneSpec *spec, FfpError *err) {
    if (spec->sensor.turn_error > 0 || spec->sensor.shift_error > 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "turn_error and shift_error are of written poses: photographs have none");
    return (spec->resolution >= SIDE_MIN && spec->resolution <= SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "resolution", "%d is not in %d..%d", spec->resolution, SIDE_MIN,
                    SIDE_MAX);
}

static bool check(const FfpPhotographs *options, const FfpSceneSpec *spec, FfpError *err) {
    if (!ffp_photographs_check(spec, err)) return false;
    if (options->attitudes < 0 || options->attitudes > ATTITUDES_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "attitudes", "%d are not in 0..%d", options->attitudes,
                        ATTITUDES_MAX);
    return !options->room || (options->quality >= 1 && options->quality <= 100) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "quality", "%d is not in 1..100", options->quality);
}

static bool read_patterns(FfpPhotographing *job, FfpError *err) {
    const FfpShown *shown = &job->shown;
    if (!ffp_shown_list(&job->shown, job->options->patterns, err)) return false;
    job->n_patterns = shown->n + (job->options->room ? HELD_OUT : 0);
    return (shown->width >= SIDE_MIN && shown->height >= SIDE_MIN) ||
           ffp_fail(err, FFP_ERROR_FILE, shown->folder, "%d x %d pixels: a panel has at least %d a side",
                    shown->width, shown->height, SIDE_MIN);
}

// The room's faults, with those that were asked for in their place.
static FfpSensor sensor_of(const FfpRoom *room, const FfpSensor *asked) {
    FfpSensor sensor = *asked;
    if (sensor.shot == 0) sensor.shot = room->sensor.shot;
    if (sensor.read == 0) sensor.read = room->sensor.read;
    if (sensor.defocus == 0) sensor.defocus = room->sensor.defocus;
    if (sensor.gamma == 0 && sensor.power == 0) sensor.gamma = room->sensor.gamma;
    if (sensor.black_level == 0) sensor.black_level = room->sensor.black_level;
    return sensor;
}

static void draw_rig(FfpPhotographing *job) {
    const FfpShown *shown = &job->shown;
    const int height = job->spec->resolution;
    job->sensor = job->spec->sensor;
    ffp_sensor_settle(&job->sensor, job->options->room ? job->options->seed : job->spec->seed);
    if (job->options->room) {
        job->room =
            ffp_room_draw(job->options->seed, ffp_room_floor(job->mesh), height, shown->width, shown->height);
        job->sensor = sensor_of(&job->room, &job->sensor);
    } else {
        job->room.rig = ffp_bare_rig(height, shown->width, shown->height);
        if (job->options->other_projector) ffp_bare_rig_exchange(&job->room.rig);
    }
}

static bool write_folder(FfpPhotographing *job, FfpError *err) {
    FfpOutput folder;
    if (!ffp_capture_probe(job->options->folder, err) ||
        !ffp_output_open_folder(&folder, job->options->folder, true, err))
        return false;
    job->folder = folder.temporary;
    const int64_t count = ffp_photographing_run(job, err);
    const bool ok = count >= 0 && ffp_photographing_truth(job, err) && ffp_output_commit(&folder, err);
    if (ok)
        ffp_note("%s: %lld photographs of %s", job->options->folder, (long long)count,
                 job->options->attitudes > 0 ? "the object and of the chessboard" : "the object");
    ffp_output_abort(&folder);
    job->folder = NULL;
    return ok;
}

bool ffp_photographs_write(const FfpPhotographs *options, const FfpSceneSpec *spec, FfpError *err) {
    FfpPhotographing job = {
        .options = options, .spec = spec, .material = ffp_material_make(spec->material, spec->seed)};
    FfpMesh made = {0};
    bool ok = check(options, spec, err) && read_patterns(&job, err);
    if (ok) {
        if (!spec->own_mesh) made = ffp_mesh_make(spec->mesh);
        job.mesh = spec->own_mesh ? spec->own_mesh : &made;
        draw_rig(&job);
        ok = add_subjects(&job, err) && write_folder(&job, err);
    }
    ffp_free(job.subjects);
    ffp_room_free(&job.room);
    ffp_mesh_free(&made);
    ffp_shown_free(&job.shown);
    return ok;
}
