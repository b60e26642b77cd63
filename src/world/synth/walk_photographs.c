#include "world/synth/walk_photographs.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/rigid.h"
#include "core/patterns/shown.h"
#include "rig/optics/colmap_write.h"
#include "world/synth/photographs.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate.h"
#include "world/synth/walk.h"

enum { NAME = 32, BATCH = 16 };

static const double camera_lens[5] = {-0.08, 0.02, 0, 0, 0}, projector_lens[5] = {-0.03, 0, 0, 0, 0};
#define CAMERA_X 0.006 // principal points beside the middle, of the width
#define CAMERA_Y (-0.004)
#define PROJECTOR_X 0.008
#define PROJECTOR_Y 0.05

typedef struct Job {
    const FfpSceneSpec *spec;
    FfpWalk walk;
    FfpSurroundings around;
    FfpMaterial material;
    FfpTracer *tracer;
    FfpShown shown;
    const char *folder; // being written
    int done;
    FfpTask task;
} Job;

static void set_projector(Job *job) {
    FfpCamera *p = &job->walk.projector[0];
    const int width = job->shown.width, height = job->shown.height;
    p->fx = p->fy = p->fy * (real)height / (real)p->height; // the field stays
    p->width = width, p->height = height;
    p->cx = (real)((0.5 + PROJECTOR_X) * width), p->cy = (real)(0.5 * height + PROJECTOR_Y * width);
}

static void place(const Job *job, int index, FfpView *view) {
    ffp_walk_input(&job->walk, job->spec, index, view);
    view->camera.cx += (real)(CAMERA_X * view->camera.width);
    view->camera.cy += (real)(CAMERA_Y * view->camera.width);
}

// --- Pictures. ---

static void name_place(int index, char name[NAME]) {
    snprintf(name, NAME, "place-%02d", index);
}

static bool path_in(const Job *job, const char *name, char path[FFP_PATH_MAX], FfpError *err) {
    return ffp_join_path(path, job->folder, name) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, job->folder, "the path is too long");
}

static bool write_photograph(const Job *job, int index, int pattern, FfpImage *image, FfpError *err) {
    char name[NAME], file[NAME + 16], path[FFP_PATH_MAX];
    name_place(index, name);
    snprintf(file, sizeof file, "%s/%03d.png", name, job->shown.patterns[pattern].number);
    if (!path_in(job, file, path, err)) return false;
    ffp_image_to_srgb(image);
    return ffp_image_write_png(image, path, err);
}

// One place under a batch of patterns.
static bool photograph(const Job *job, int index, const FfpLight *light, int first, FfpError *err) {
    const FfpSceneSpec *spec = job->spec;
    const float intensity = job->walk.intensity;
    const FfpSimulation simulation = {.tracer = job->tracer,
                                      .mesh = &job->around.mesh,
                                      .material = &job->material,
                                      .light = light,
                                      .intensity = {intensity, intensity, intensity},
                                      .ambient = job->walk.ambient,
                                      .samples = spec->samples,
                                      .ambient_rays = spec->ambient_rays,
                                      .shot = spec->sensor.shot,
                                      .read = spec->sensor.read,
                                      .sensor = &spec->sensor,
                                      .camera_lens = camera_lens,
                                      .projector_lens = projector_lens,
                                      .photograph = true,
                                      .first_pattern = first,
                                      .seed = spec->seed,
                                      .around = &job->around,
                                      .whole = true};
    FfpView view = {0};
    bool ok = true;
    place(job, index, &view);
    ffp_simulate_view(&simulation, &view, (uint32_t)index, NULL);
    for (int i = 0; ok && i < light->n_patterns; i++)
        ok = write_photograph(job, index, first + i, &view.images[i], err);
    ffp_view_free(&view, light->n_patterns);
    return ok;
}

static bool photograph_batch(Job *job, int first, int count, FfpError *err) {
    FfpImage emitted[BATCH] = {0};
    const FfpImage *images[BATCH];
    bool ok = true;
    for (int i = 0; ok && i < count; i++) {
        ok = ffp_sensor_emit_file(&emitted[i], job->shown.patterns[first + i].file, &job->spec->sensor, err);
        images[i] = &emitted[i];
    }
    if (ok) {
        FfpLight light = ffp_light_new(images, count);
        if (job->spec->sensor.focus_blur > 0) ffp_light_soften(&light);
        for (int p = 0; ok && p < job->spec->views; p++) {
            ok = photograph(job, p, &light, first, err);
            ffp_task_step(&job->task, job->done += count, NULL);
        }
        ffp_light_free(&light);
    }
    for (int i = 0; i < count; i++) ffp_image_free(&emitted[i]);
    return ok;
}

static bool photograph_all(Job *job, FfpError *err) {
    bool ok = true;
    for (int p = 0; ok && p < job->spec->views; p++) {
        char name[NAME], path[FFP_PATH_MAX];
        name_place(p, name);
        ok = path_in(job, name, path, err) && ffp_make_folders(path, err);
    }
    job->task = ffp_task("photographing", (int64_t)job->spec->views * job->shown.n);
    for (int first = 0; ok && first < job->shown.n; first += BATCH) {
        const int left = job->shown.n - first;
        ok = photograph_batch(job, first, left < BATCH ? left : BATCH, err);
    }
    ffp_task_end(&job->task);
    return ok;
}

// --- What is true. ---

static FfpOptics optics_of(const FfpCamera *device, const double lens[5]) {
    FfpOptics out = {device->width,
                     device->height,
                     (double)device->fx,
                     (double)device->fy,
                     (double)device->cx,
                     (double)device->cy,
                     {0}};
    memcpy(out.lens, lens, sizeof out.lens);
    return out;
}

static FfpRigid to_device(const FfpCamera *device) {
    const FfpRigid pose = ffp_rigid_from_pose(device->pose);
    FfpRigid out;
    ffp_rigid_inverse(&pose, &out);
    return out;
}

// truth.json, where there is real light.
static bool write_light(const Job *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    json_t *light = ffp_sensor_truth(&job->spec->sensor);
    if (!light) return true;
    json_t *root = json_pack("{s:o}", "light", light);
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    const bool ok = path_in(job, "truth.json", path, err) && ffp_write_file(path, text, strlen(text), err);
    free(text);
    json_decref(root);
    return ok;
}

static bool write_truth(const Job *job, FfpError *err) {
    const int views = job->spec->views;
    FfpColmapImage *images = ffp_alloc((size_t)views + 1, sizeof *images);
    char(*files)[NAME + 4] = ffp_alloc((size_t)views, sizeof *files), path[FFP_PATH_MAX], name[NAME];
    FfpView view = {0};
    for (int i = 0; i < views; i++) {
        place(job, i, &view);
        name_place(i, name);
        snprintf(files[i], sizeof files[i], "%s.jpg", name);
        images[i] = (FfpColmapImage){files[i], 0, to_device(&view.camera)};
    }
    images[views] = (FfpColmapImage){"calib.jpg", 1, to_device(&job->walk.projector[0])};
    const FfpOptics devices[2] = {optics_of(&view.camera, camera_lens),
                                  optics_of(&job->walk.projector[0], projector_lens)};
    const FfpColmapModel model = {
        .cameras = devices, .images = images, .n_cameras = 2, .n_images = views + 1};
    const bool ok = path_in(job, "colmap", path, err) && ffp_make_folders(path, err) &&
                    ffp_colmap_write(&model, path, err) && write_light(job, err);
    ffp_free(images), ffp_free(files);
    return ok;
}

// --- All of it. ---

static bool write_folder(Job *job, const char *folder, FfpError *err) {
    FfpOutput out;
    if (!ffp_capture_probe(folder, err) || !ffp_output_open_folder(&out, folder, true, err)) return false;
    job->folder = out.temporary;
    const bool ok = photograph_all(job, err) && write_truth(job, err) && ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    job->folder = NULL;
    return ok;
}

bool ffp_walk_photographs_write(const char *folder, const char *patterns, const FfpSceneSpec *spec,
                                FfpError *err) {
    FfpSceneSpec settled = *spec;
    ffp_sensor_settle(&settled.sensor, spec->seed);
    Job job = {.spec = &settled, .material = ffp_material_make(spec->material, spec->seed)};
    if (!ffp_photographs_check(spec, err) || !ffp_shown_list(&job.shown, patterns, err)) return false;
    job.walk = ffp_walk_draw(spec);
    job.around = ffp_around_new(&job.walk.room, NULL, 0);
    set_projector(&job);
    job.tracer = ffp_tracer_new(&job.around.mesh, err);
    const bool ok = job.tracer && write_folder(&job, folder, err);
    ffp_tracer_free(job.tracer);
    ffp_around_free(&job.around);
    ffp_walk_free(&job.walk);
    ffp_shown_free(&job.shown);
    return ok;
}
