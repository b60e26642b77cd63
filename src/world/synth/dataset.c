// Scenes on disk. A scene is written under a hidden name and renamed when it is whole, so that a folder with
// a scene's own name is always complete, whatever happened to the process that made it.
#include "world/synth/dataset.h"
#include <errno.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/node.h"
#include "world/shapes/mesh.h"
#include "world/synth/natural.h"
#include "world/synth/photographs.h"
#include "world/synth/picture_folder.h"
#include "world/synth/sensor.h"
#include "world/synth/texture.h"
#include "world/synth/trace.h"
#include "world/synth/walk_photographs.h"

enum { MESHES_MAX = 1024, VIEWS_MAX = 360 };
static const int64_t ASSET_SCENES = 100000; // of one mesh: names stay five digits

// One call of ffp_dataset_write, shared by its workers.
typedef struct Job {
    const FfpDatasetSettings *options;
    FfpSceneSpec spec; // what all scenes have in common
    FfpMesh mesh;      // the user's, where one is given
    FfpTextures *textures;
    FfpStock stock;
    char asset[FFP_NAME_MAX]; // the user's mesh's name; empty: none
    int rank, ranks;          // this rank makes every `ranks`-th scene, from its own number on
    int64_t done, kept;
    bool failed;
    FfpTask progress;
    FfpError *err; // of the first scene that failed
} Job;

static int meshes_of(const char *split, int meshes[MESHES_MAX]) {
    if (split) return ffp_split_meshes(split, meshes, MESHES_MAX);
    const int count = ffp_mesh_count();
    for (int i = 0; i < count && i < MESHES_MAX; i++) meshes[i] = i;
    return count;
}

int64_t ffp_dataset_size(const char *split) {
    int meshes[MESHES_MAX];
    return (int64_t)meshes_of(split, meshes) * ffp_material_count();
}

void ffp_dataset_scene(const char *split, int64_t index, uint64_t seed, FfpSceneSpec *spec) {
    int meshes[MESHES_MAX];
    const int64_t count = meshes_of(split, meshes), slot = index % count;
    spec->mesh = meshes[slot];
    spec->material = (int)((index / count + 7 * slot) % ffp_material_count());
    // the seed belongs to the pair, so that a scene is the same whichever split names it
    spec->seed = seed * 0x9e3779b97f4a7c15ULL + (uint64_t)spec->mesh * 1000U + (uint64_t)spec->material;
}

// Scene `number` of a user's mesh: the materials in turn (none of which shows where the user gives one too).
static void asset_scene(int64_t number, uint64_t seed, FfpSceneSpec *spec) {
    spec->material = (int)(number % ffp_material_count());
    spec->seed = seed * 0x9e3779b97f4a7c15ULL + (uint64_t)number;
}

static bool rig_spec(const FfpDatasetSettings *options, FfpSceneSpec *spec, FfpError *err) {
    spec->rig = options->rig;
    if (options->views < 0 || options->views > VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "%d is not in 1..%d", options->views, VIEWS_MAX);
    if (options->views > 0) spec->views = options->views;
    return true;
}

static bool preset_spec(const FfpDatasetSettings *options, FfpSceneSpec *spec, FfpError *err) {
    *spec = ffp_scene_defaults();
    switch (options->preset) {
    case FFP_DATASET_PAPER:
        spec->lollipops = 6, spec->targets = 6;
        spec->samples = 16, spec->ambient_rays = 4;
        break;
    case FFP_DATASET_SMOKE:
        spec->lollipops = 2, spec->targets = 2;
        spec->resolution = 64, spec->pattern_side = 400;
        break;
    case FFP_DATASET_TRAINING:
        spec->jitter = true; // and the rest as it is
        break;
    }
    if (options->split && !strcmp(options->split, "test")) spec->naturals = FFP_NATURAL_KINDS;
    if (options->resolution > 0) spec->resolution = options->resolution;
    if (!rig_spec(options, spec, err)) return false;
    spec->sensor = options->sensor;
    return ffp_sensor_check(&spec->sensor, err);
}

// The description of a scene, for its file: the numbers that make it again, and what they stand for.
static json_t *describe(const Job *job, int64_t number, const FfpSceneSpec *spec) {
    const FfpDatasetSettings *options = job->options;
    const char *own = spec->own_material ? spec->own_material : options->material;
    const char *split = job->asset[0] ? NULL : options->split ? options->split : "all";
    char material[FFP_NAME_MAX];
    snprintf(material, sizeof material, "%s", ffp_material_name(spec->material));
    if (own) ffp_asset_name(own, material);
    FfpSensor sensor = spec->sensor;
    ffp_sensor_settle(&sensor, spec->seed);
    return json_pack("{s:s, s:s*, s:I, s:I, s:s, s:s, s:o*}", "version", FFP_VERSION, "split", split,
                     "number", (json_int_t)number, "seed", (json_int_t)options->seed, "mesh",
                     job->asset[0] ? job->asset : ffp_mesh_name(spec->mesh), "material", material, "light",
                     ffp_sensor_truth(&sensor));
}

// A scene in the making.
typedef struct Scene {
    const Job *job;
    int64_t number;
    FfpSceneSpec spec;
    FfpCapture capture; // input views, then new poses
} Scene;

// The views from `first` on as a capture of their own, to be written; memory stays with the whole.
static bool write_part(const Scene *scene, int first, int count, const char *folder, FfpError *err) {
    FfpCapture part = scene->capture;
    part.views += first;
    part.n_views = count;
    return ffp_make_folders(folder, err) && ffp_capture_write(&part, folder, err) &&
           ffp_scene_json_add(folder, NULL, "generator", describe(scene->job, scene->number, &scene->spec),
                              err);
}

static bool is_complete(const char *folder) {
    char scene[FFP_PATH_MAX], poses[FFP_PATH_MAX];
    if (!ffp_join_path(scene, folder, "scene.json") || !ffp_join_path(poses, folder, "targets/scene.json"))
        return false;
    return ffp_is_file(scene) && ffp_is_file(poses);
}

static void remove_part(void *folder) {
    ffp_remove_tree(folder);
    ffp_free(folder);
}

static bool write_scene(const Scene *scene, const char *part, const char *folder, FfpError *err) {
    const FfpSceneSpec *spec = &scene->spec;
    char targets[FFP_PATH_MAX];
    if (!ffp_join_path(targets, part, "targets"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
    ffp_remove_tree(part); // what a killed process left
    char *owned = ffp_copy_text(part);
    ffp_own(owned, remove_part);
    bool ok = write_part(scene, spec->views, spec->targets, targets, err) &&
              write_part(scene, 0, spec->views, part, err);
    if (ok && rename(part, folder) != 0) {
        const bool there = errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR;
        ok = there ? ffp_fail(err, FFP_ERROR_ARGUMENT, folder,
                              "already exists, but is not a complete scene: remove it")
                   : ffp_fail(err, FFP_ERROR_IO, folder, "cannot rename the finished scene: %s",
                              strerror(errno));
    }
    ffp_disown(owned);
    ffp_free(owned);
    if (!ok) ffp_remove_tree(part);
    return ok;
}

// The specification of scene `number`.
static FfpSceneSpec spec_of(const Job *job, int64_t number) {
    FfpSceneSpec spec = job->spec;
    if (job->asset[0])
        asset_scene(number, job->options->seed, &spec);
    else
        ffp_dataset_scene(job->options->split, number, job->options->seed, &spec);
    return spec;
}

static void scene_name(const Job *job, int64_t number, char name[FFP_NAME_MAX + 32]) {
    const char *kind = job->asset[0] ? job->asset : job->options->split ? job->options->split : "all";
    snprintf(name, FFP_NAME_MAX + 32, "%s_%05lld", kind, (long long)number);
}

// Scene `number` under `name` in the job's folder; *made tells whether it was not there yet.
static bool generate_scene(const Job *job, int64_t number, const char *name, bool *made, FfpError *err) {
    char folder[FFP_PATH_MAX], part[FFP_PATH_MAX], hidden[FFP_NAME_MAX + 64];
    snprintf(hidden, sizeof hidden, ".%s.part", name);
    if (!ffp_join_path(folder, job->options->folder, name) ||
        !ffp_join_path(part, job->options->folder, hidden))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, job->options->folder, "the path is too long");
    *made = !is_complete(folder);
    if (!*made) return true;
    Scene scene = {.job = job, .number = number, .spec = spec_of(job, number)};
    FfpSceneSpec *spec = &scene.spec;
    const bool made_it = ffp_stock_dress(&job->stock, spec, err) && ffp_scene_make(&scene.capture, spec, err);
    const bool ok = made_it && write_scene(&scene, part, folder, err);
    ffp_stock_undress(&job->stock, spec);
    if (made_it) ffp_capture_free(&scene.capture);
    return ok;
}

// One scene and the books. The books are short, so the workers take turns at them.
static void work_on(void *argument, int64_t index) {
    Job *job = argument;
    const int64_t number = job->options->first + job->rank + index * job->ranks;
    bool stop, made = false;
#pragma omp atomic read
    stop = job->failed;
    if (stop) return;
    char name[FFP_NAME_MAX + 32];
    scene_name(job, number, name);
    int64_t done = 0;
    FfpError error = {0};
    const bool ok = generate_scene(job, number, name, &made, &error);
#pragma omp critical(ffp_dataset_books)
    {
        if (!ok && !job->failed && job->err) *job->err = error;
        job->kept += ok && !made;
        done = job->done += ok;
    }
    if (ok) ffp_task_step(&job->progress, done, name);
    if (!ok) {
#pragma omp atomic write
        job->failed = true;
    }
}

// Reports the scenes that exist now.
static void tell(const Job *job, int64_t count) {
    const int64_t made = count - job->kept;
    char name[FFP_NAME_MAX + 32];
    scene_name(job, job->options->first + job->rank, name);
    if (made > 0)
        ffp_note("%s: %lld scene%s generated, the first is %s", job->options->folder, (long long)made,
                 made == 1 ? "" : "s", name);
    if (job->kept > 0)
        ffp_note("%lld scene%s already existed and %s kept", (long long)job->kept, job->kept == 1 ? "" : "s",
                 job->kept == 1 ? "was" : "were");
}

// Whole scenes in parallel, each on one thread: no part of a scene is left to one core alone. A worker more
// than cores fills the time in which a scene waits for the disk.
static bool generate_all(Job *job, int64_t total) {
    const FfpContext *context = ffp_call_context();
    const FfpRanks *ranks = context ? context->settings.ranks : NULL;
    job->rank = ranks ? ranks->rank : 0, job->ranks = ranks ? ranks->count : 1;
    const int64_t count = (total - job->rank + job->ranks - 1) / job->ranks;
    job->progress = ffp_task("generating", count);
    ffp_parallel_for(count, omp_get_max_threads() + 1, work_on, job);
    ffp_task_end(&job->progress);
    if (job->failed) return false;
    tell(job, count);
    return true;
}

// Checks the range of scenes asked for, and counts them.
static bool choose_scenes(const FfpDatasetSettings *options, int64_t *count, FfpError *err) {
    const int64_t size = options->mesh ? ASSET_SCENES : ffp_dataset_size(options->split);
    if (size == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "split", "'%s' is not train, validation or test",
                        options->split);
    if (options->first < 0 || options->first >= size)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "first", "scene %lld is not in 0..%lld",
                        (long long)options->first, (long long)size - 1);
    const int64_t left = size - options->first;
    *count = options->count >= 0 ? options->count : options->mesh ? 1 : left;
    if (*count < 1 || *count > left)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "%lld scenes starting at %lld are not in 1..%lld",
                        (long long)*count, (long long)options->first, (long long)left);
    return true;
}

static bool open_assets(Job *job, FfpError *err) {
    const FfpDatasetSettings *options = job->options;
    if (options->mesh) {
        if (!ffp_mesh_read(&job->mesh, options->mesh, err)) return false;
        ffp_asset_name(options->mesh, job->asset);
        job->spec.own_mesh = &job->mesh;
        job->spec.own_name = job->asset;
    }
    if (options->material && options->materials)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "materials", "`material` is given as well");
    if (!ffp_stock_open(&job->stock, options->materials, options->patterns, err)) return false;
    if (!options->material) return true;
    job->textures = ffp_textures_read(options->material, err);
    job->spec.own_textures = job->textures;
    return job->textures != NULL;
}

static bool photograph_dressed(const Job *job, const FfpSceneSpec *spec, FfpError *err) {
    const FfpDatasetSettings *options = job->options;
    if (spec->rig == FFP_SCENE_WALK && (options->room || options->only))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->room ? "room" : "only",
                        "is of an object's photographs: a walk is a whole scene, from all its places");
    if (spec->rig == FFP_SCENE_WALK)
        return ffp_walk_photographs_write(options->folder, options->photographs, spec, err);
    const FfpPhotographs photographs = {.folder = options->folder,
                                        .patterns = options->photographs,
                                        .attitudes = options->attitudes,
                                        .only = options->only,
                                        .room = options->room,
                                        .seed = options->seed,
                                        .quality = options->quality,
                                        .other_projector = options->other_projector};
    return ffp_photographs_write(&photographs, spec, err);
}

// The first scene's object, or the user's, before a bare rig or in a room; or a whole scene. Pictures are as
// high as asked for; 0: 480.
static bool photograph_object(const Job *job, FfpError *err) {
    const FfpDatasetSettings *options = job->options;
    FfpSceneSpec spec = job->spec;
    if (options->count > 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "photographs show one object, not %lld",
                        (long long)options->count);
    if (job->asset[0])
        asset_scene(options->first, options->seed, &spec);
    else
        ffp_dataset_scene(options->split, options->first, options->seed, &spec);
    spec.resolution = options->resolution > 0 ? options->resolution : 480;
    const bool ok = ffp_stock_dress(&job->stock, &spec, err) && photograph_dressed(job, &spec, err);
    ffp_stock_undress(&job->stock, &spec);
    return ok;
}

static bool generate_job(Job *job, int64_t count, FfpError *err) {
    if (job->options->photographs) return photograph_object(job, err);
    return ffp_make_folders(job->options->folder, err) && generate_all(job, count);
}

// Everything but the scenes themselves.
static bool open_job(Job *job, int64_t *count, FfpError *err) {
    if (!job->options->folder) return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "no output folder given");
    if (job->options->room && !job->options->photographs)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "room", "requires the patterns of `photographs`");
    if (job->options->other_projector && (!job->options->photographs || job->options->room))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "other_projector", "requires `photographs` without a room");
    if (job->options->only && !job->options->photographs)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "only", "requires `photographs`");
    if (job->options->patterns && job->options->photographs)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns", "photographs show those of `photographs`");
    return preset_spec(job->options, &job->spec, err) && choose_scenes(job->options, count, err) &&
           open_assets(job, err);
}

static void close_job(Job *job) {
    ffp_mesh_free(&job->mesh);
    ffp_textures_free(job->textures);
    ffp_stock_close(&job->stock);
}

bool ffp_dataset_write(const FfpDatasetSettings *options, FfpError *err) {
    Job job = {.options = options, .err = err};
    int64_t count = 0;
    const bool ok =
        ffp_tracer_available(err) && open_job(&job, &count, err) && generate_job(&job, count, err);
    close_job(&job);
    return ok;
}

// The names of the first few that are missing, into text; returns how many there are.
static int64_t list_missing(const Job *job, int64_t count, char *text, size_t size) {
    enum { NAMED = 6 };
    int64_t missing = 0;
    size_t length = 0;
    for (int64_t number = job->options->first; number < job->options->first + count; number++) {
        char name[FFP_NAME_MAX + 32], folder[FFP_PATH_MAX];
        scene_name(job, number, name);
        ffp_cancel_point();
        if (ffp_join_path(folder, job->options->folder, name) && is_complete(folder)) continue;
        if (missing++ < NAMED && length < size)
            length += (size_t)snprintf(text + length, size - length, "%s%.64s", length ? ", " : "", name);
    }
    if (missing > NAMED && length < size) snprintf(text + length, size - length, " and so on");
    return missing;
}

bool ffp_dataset_check(const FfpDatasetSettings *options, FfpError *err) {
    Job job = {.options = options};
    char names[480] = "";
    int64_t count = 0, missing = 0;
    const bool ok = open_job(&job, &count, err);
    if (ok) missing = list_missing(&job, count, names, sizeof names);
    close_job(&job);
    if (!ok) return false;
    if (missing > 0)
        return ffp_fail(err, FFP_ERROR_FILE, options->folder, "%lld of %lld scenes are missing: %s",
                        (long long)missing, (long long)count, names);
    ffp_note("all %lld scenes exist", (long long)count);
    return true;
}
