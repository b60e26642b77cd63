// Takes the photographs: patterns sent out, subjects simulated under them, pictures written.
#include "world/synth/photographing.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/log.h"
#include "world/shapes/noise.h"
#include "world/synth/natural.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate.h"

// Patterns at a time: eight, or as many as ROOM holds of their and the pictures' pixels, four bytes for every
// colour.
enum { BATCH_LEAST = 8, BATCH_MOST = 64, NAME = 96 };
#define ROOM 128e6 // bytes

// --- Patterns. ---

static const int held_out_kinds[] = {2, 4}; // of natural.h

static bool is_held_out(const FfpPhotographing *job, int pattern) {
    return pattern >= job->shown.n;
}

static const char *held_out_name(const FfpPhotographing *job, int pattern) {
    return ffp_natural_name(held_out_kinds[pattern - job->shown.n]);
}

static bool pattern_path(const FfpPhotographing *job, int pattern, char path[FFP_PATH_MAX], FfpError *err) {
    char name[NAME];
    if (!is_held_out(job, pattern)) {
        snprintf(path, FFP_PATH_MAX, "%s", job->shown.patterns[pattern].file);
        return true;
    }
    snprintf(name, sizeof name, "held-out/%s.png", held_out_name(job, pattern));
    return ffp_photographing_path(job, name, path, err);
}

static bool draw_held_out(const FfpPhotographing *job, int pattern, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!pattern_path(job, pattern, path, err)) return false;
    FfpImage image = ffp_natural_pattern(job->shown.width, job->shown.height,
                                         held_out_kinds[pattern - job->shown.n], job->options->seed);
    ffp_image_to_srgb(&image);
    const bool ok = ffp_image_write_png(&image, path, err);
    ffp_image_free(&image);
    return ok;
}

// The projector's light for a pattern, linear; a new image.
static bool emit(const FfpPhotographing *job, int pattern, FfpImage *emitted, FfpError *err) {
    char path[FFP_PATH_MAX];
    return pattern_path(job, pattern, path, err) && ffp_sensor_emit_file(emitted, path, &job->sensor, err);
}

// --- Which pictures, and what they are called. ---

static bool is_code(const FfpPhotographing *job, int pattern) {
    return !is_held_out(job, pattern) && ffp_shown_is_code(&job->shown, pattern);
}

static bool is_called(const FfpPhotographing *job, int pattern, const char *name) {
    return !is_held_out(job, pattern) && strcmp(job->shown.patterns[pattern].name, name) == 0;
}

static bool is_wanted(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern) {
    switch (subject->kind) {
    case FFP_SUBJECT_STOP:
        return true;
    case FFP_SUBJECT_BETWEEN:
        return !is_code(job, pattern);
    case FFP_SUBJECT_EMPTY:
        return !is_code(job, pattern) && !is_held_out(job, pattern);
    case FFP_SUBJECT_ATTITUDE:
        return is_code(job, pattern) || is_called(job, pattern, "black") || is_called(job, pattern, "white");
    default:
        return is_called(job, pattern, "white");
    }
}

static bool has_truth(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern) {
    return job->options->room && subject->kind <= FFP_SUBJECT_BETWEEN && !is_code(job, pattern);
}

// "view-045/002.JPG", "held-out/view-045/map.JPG" or "turntable/03.JPG", below `top`.
static bool picture_path(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern,
                         const char *top, const char *ending, char path[FFP_PATH_MAX], FfpError *err) {
    char name[NAME];
    const bool board = subject->kind == FFP_SUBJECT_TURNTABLE;
    if (is_held_out(job, pattern))
        snprintf(name, sizeof name, "%sheld-out/%s/%s.%s", top, subject->name, held_out_name(job, pattern),
                 ending);
    else
        snprintf(name, sizeof name, "%s%s/%0*d.%s", top, subject->name, board ? 2 : 3,
                 board ? subject->stop : job->shown.patterns[pattern].number, ending);
    return ffp_photographing_path(job, name, path, err);
}

static bool make_folder(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern,
                        const char *top, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!picture_path(job, subject, pattern, top, "", path, err)) return false;
    *strrchr(path, '/') = 0;
    return ffp_make_folders(path, err);
}

static bool make_folders(const FfpPhotographing *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    bool ok = ffp_photographing_path(job, "masks", path, err) && ffp_make_folders(path, err);
    for (int s = 0; s < job->n_subjects; s++)
        for (int p = 0; ok && p < job->n_patterns; p++) {
            const FfpPhotographed *subject = &job->subjects[s];
            if (!is_wanted(job, subject, p)) continue;
            ok = make_folder(job, subject, p, "", err) &&
                 (!has_truth(job, subject, p) || make_folder(job, subject, p, "truth/", err));
        }
    return ok;
}

// --- Pictures. ---

// The random key of a picture's noise; no two pictures have the same.
static uint32_t key_of(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern) {
    const uint64_t seed = job->options->seed;
    if (!job->options->room)
        return (subject->stream * FFP_PATTERNS_MAX + (uint32_t)pattern) ^ (uint32_t)job->spec->seed;
    return ffp_hash32(
        (uint32_t)seed ^
        ffp_hash32((uint32_t)(seed >> 32) ^ ffp_hash32(subject->stream * 4096 + (uint32_t)pattern + 1)));
}

static bool write_truth(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern,
                        const FfpImage *light, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!picture_path(job, subject, pattern, "truth/", "png", path, err)) return false;
    FfpImage seen = ffp_image_copy(light);
    ffp_image_to_srgb(&seen);
    const bool ok = ffp_image_write_png(&seen, path, err);
    ffp_image_free(&seen);
    return ok;
}

// Of a room, the picture is light before the lens; otherwise it has its noise.
static bool write_picture(const FfpPhotographing *job, const FfpPhotographed *subject, int pattern,
                          FfpImage *picture, FfpError *err) {
    const bool room = job->options->room;
    char path[FFP_PATH_MAX];
    if (!picture_path(job, subject, pattern, "", room ? "JPG" : "png", path, err)) return false;
    if (room) {
        if (job->room.camera_defocus > 0) ffp_image_blur(picture, (real)job->room.camera_defocus);
        ffp_sensor_see(picture, &job->sensor, &job->room.rig.camera);
        if (has_truth(job, subject, pattern) && !write_truth(job, subject, pattern, picture, err))
            return false;
        ffp_sensor_expose(picture, &job->sensor, key_of(job, subject, pattern));
    }
    ffp_image_to_srgb(picture);
    return room ? ffp_image_write_jpeg(picture, job->options->quality, path, err)
                : ffp_image_write_png(picture, path, err);
}

typedef struct Writing {
    const FfpPhotographing *job;
    const FfpPhotographed *subject;
    int first;
    const FfpView *view;
    FfpError *errors; // of every picture
} Writing;

static void write_one(void *argument, int64_t index) {
    const Writing *w = argument;
    const int pattern = w->first + (int)index;
    if (is_wanted(w->job, w->subject, pattern))
        write_picture(w->job, w->subject, pattern, &w->view->images[index], &w->errors[index]);
}

// The wanted ones among the view's pictures, on all threads. Error: the first picture's that has one.
static bool write_pictures(const FfpPhotographing *job, const FfpPhotographed *subject, const FfpView *view,
                           int first, int count, FfpError *err) {
    FfpError *errors = ffp_alloc((size_t)count, sizeof *errors);
    int good = 0;
    ffp_parallel_for(count, 0, write_one, &(Writing){job, subject, first, view, errors});
    while (good < count && errors[good].code == FFP_OK) good++;
    if (good < count && err) *err = errors[good];
    ffp_free(errors);
    return good == count;
}

// The object's share of the pixels, as somebody who cuts it out by hand would have it.
static bool write_mask(const FfpPhotographing *job, const FfpPhotographed *subject, const FfpView *view,
                       FfpError *err) {
    char name[NAME], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "masks/%s.png", subject->name);
    return ffp_photographing_path(job, name, path, err) && ffp_image_write_png(&view->coverage, path, err);
}

// --- Subjects under patterns. ---

// How much light the camera takes: of a board in a room half as much, so that its paper is not clipped.
static float exposure_of(const FfpPhotographing *job, const FfpPhotographed *subject) {
    return exp2f(job->sensor.exposure) * (job->options->room && ffp_subject_is_board(subject) ? 0.5F : 1);
}

// `around`: NULL without a room.
static bool simulate(const FfpPhotographing *job, const FfpPhotographed *subject, const FfpMesh *mesh,
                     const FfpSurroundings *around, const FfpLight *light, int first, FfpView *view,
                     FfpError *err) {
    const FfpSceneSpec *spec = job->spec;
    const float gain = exposure_of(job, subject), intensity = gain * job->room.rig.intensity;
    FfpTracer *tracer = ffp_tracer_new(mesh, err);
    if (!tracer) return false;
    const FfpSimulation simulation = {.tracer = tracer,
                                      .mesh = mesh,
                                      .material = &job->material,
                                      .textures = spec->own_textures,
                                      .board = ffp_subject_is_board(subject) ? &subject->board : NULL,
                                      .around = around,
                                      .light = light,
                                      .intensity = {intensity, intensity, intensity},
                                      .ambient = around ? 0 : gain * job->room.rig.ambient,
                                      .samples = spec->samples,
                                      .ambient_rays = spec->ambient_rays,
                                      .shot = around ? 0 : job->sensor.shot,
                                      .read = around ? 0 : job->sensor.read,
                                      .sensor = &job->sensor,
                                      .camera_lens = job->room.rig.camera_lens,
                                      .projector_lens = job->room.rig.projector_lens,
                                      .photograph = true,
                                      .light_only = around != NULL,
                                      .first_pattern = first,
                                      .seed = around ? job->options->seed : spec->seed};
    ffp_simulate_view(&simulation, view, subject->stream, NULL);
    ffp_tracer_free(tracer);
    return true;
}

// Nothing stands before the rig, and nothing is around it: the dark, and the camera's noise.
static void see_nothing(const FfpPhotographing *job, const FfpPhotographed *subject, int first, int count,
                        FfpView *view) {
    view->images = ffp_alloc((size_t)count, sizeof *view->images);
    for (int i = 0; i < count; i++) {
        view->images[i] = ffp_image_new(view->camera.width, view->camera.height, 3);
        ffp_sensor_expose(&view->images[i], &job->sensor, key_of(job, subject, first + i));
    }
}

// The subject under the patterns of a batch.
static bool photograph(const FfpPhotographing *job, const FfpPhotographed *subject, const FfpLight *light,
                       int first, FfpError *err) {
    const int count = light->n_patterns;
    const bool room = job->options->room, of_object = subject->kind <= FFP_SUBJECT_BETWEEN;
    FfpMesh board = {0};
    FfpSurroundings around = {0};
    FfpView view = {0};
    bool ok = true;
    if (ffp_subject_is_board(subject)) board = ffp_chessboard_mesh(&subject->board);
    const FfpMesh *mesh = of_object ? job->mesh : ffp_subject_is_board(subject) ? &board : NULL;
    ffp_bare_rig_devices(&job->room.rig, subject->angle, &view.camera, &view.projector);
    if (room) {
        around = ffp_around_new(&job->room, mesh, subject->angle);
        around.lamp.radiance *= exposure_of(job, subject);
        mesh = &around.mesh;
    }
    if (mesh)
        ok = simulate(job, subject, mesh, room ? &around : NULL, light, first, &view, err);
    else
        see_nothing(job, subject, first, count, &view);
    ok = ok && write_pictures(job, subject, &view, first, count, err) &&
         (first > 0 || !of_object || write_mask(job, subject, &view, err));
    if (view.images) ffp_view_free(&view, count);
    if (room) ffp_around_free(&around);
    ffp_mesh_free(&board);
    return ok;
}

// --- All of them. ---

static int batch_of(const FfpBareRig *rig) {
    const FfpCamera *devices[2] = {&rig->camera, &rig->projector};
    double bytes = 0;
    for (int k = 0; k < 2; k++) bytes += 12.0 * devices[k]->width * devices[k]->height;
    return (int)fmax(BATCH_LEAST, fmin(BATCH_MOST, ROOM / bytes));
}

static int count_wanted(const FfpPhotographing *job, int subject, int first, int count) {
    int wanted = 0;
    for (int p = first; p < first + count; p++) wanted += is_wanted(job, &job->subjects[subject], p);
    return wanted;
}

typedef struct Progress {
    FfpTask task;
    int64_t done;
} Progress;

static bool photograph_batch(const FfpPhotographing *job, Progress *progress, int first, int count,
                             FfpError *err) {
    FfpImage emitted[BATCH_MOST] = {0};
    const FfpImage *images[BATCH_MOST];
    bool ok = true;
    for (int i = 0; ok && i < count; i++) {
        ok = emit(job, first + i, &emitted[i], err);
        images[i] = &emitted[i];
    }
    if (ok) {
        FfpLight light = ffp_light_new(images, count);
        if (job->sensor.focus_blur > 0) ffp_light_soften(&light);
        for (int s = 0; ok && s < job->n_subjects; s++) {
            const int wanted = count_wanted(job, s, first, count);
            if (wanted == 0) continue;
            ok = photograph(job, &job->subjects[s], &light, first, err);
            progress->done += wanted;
            ffp_task_step(&progress->task, progress->done, job->subjects[s].name);
        }
        ffp_light_free(&light);
    }
    for (int i = 0; i < count; i++) ffp_image_free(&emitted[i]);
    return ok;
}

static bool draw_all_held_out(const FfpPhotographing *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    bool ok = job->n_patterns == job->shown.n ||
              (ffp_photographing_path(job, "held-out", path, err) && ffp_make_folders(path, err));
    for (int p = job->shown.n; ok && p < job->n_patterns; p++) ok = draw_held_out(job, p, err);
    return ok;
}

int64_t ffp_photographing_run(const FfpPhotographing *job, FfpError *err) {
    const int batch = batch_of(&job->room.rig);
    int64_t all = 0;
    for (int s = 0; s < job->n_subjects; s++) all += count_wanted(job, s, 0, job->n_patterns);
    bool ok = draw_all_held_out(job, err) && make_folders(job, err);
    Progress progress = {.task = ffp_task("photographing", all)};
    for (int first = 0; ok && first < job->n_patterns; first += batch) {
        const int left = job->n_patterns - first;
        ok = photograph_batch(job, &progress, first, left < batch ? left : batch, err);
    }
    ffp_task_end(&progress.task);
    return ok ? all : -1;
}
