// Scenes for training: made by the generator or read from a folder, normalised as a user's capture would be,
// matched once.
#include <stdio.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/rng.h"
#include "lab/train/prepare.h"
#include "world/shapes/mesh.h"
#include "world/synth/picture_folder.h"

// The devices of a careful rig that is not ideal: each strength anywhere up to the given.
#define NOISE_MAX 0.015F // deviation at a value of 1, and of reading
#define DEFOCUS_MAX 1.0F // projector pixels
#define TURN_MAX 0.0035F // radians: 0.2 degrees
#define SHIFT_MAX 0.004F // world units, of a distance of 3 to 4

static FfpSensor random_sensor(FfpRng *rng) {
    const float shot = ffp_rng_range(rng, 0, NOISE_MAX);
    return (FfpSensor){.shot = shot * shot,
                       .read = ffp_rng_range(rng, 0, NOISE_MAX),
                       .defocus = ffp_rng_range(rng, 0, DEFOCUS_MAX),
                       .turn_error = ffp_rng_range(rng, 0, TURN_MAX),
                       .shift_error = ffp_rng_range(rng, 0, SHIFT_MAX)};
}

// Draws the kinds of training scenes from a random stream of their own, so that the scenes are the same
// otherwise.
static void mix(FfpSceneSpec *spec, const FfpTrainConfig *config, int64_t number) {
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + 2, (uint64_t)number);
    if (ffp_rng_uniform(&rng) < config->free_share) spec->rig = FFP_SCENE_FREE;
    if (ffp_rng_uniform(&rng) < config->large_share) spec->resolution = config->large_resolution;
    if (config->views_least > 0)
        spec->views = config->views_least +
                      (int)ffp_rng_below(&rng, (uint32_t)(config->views - config->views_least + 1));
}

// The part of the stock that scene `number` is made with: a material, patterns, both or nothing.
static FfpStock pick_stock(const FfpStock *stock, const FfpTrainConfig *config, const char *split,
                           int64_t number) {
    FfpStock picked = {0};
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + 2, (uint64_t)number ^ (1ULL << 62));
    if (!stock || split[0] != 't') return picked;
    if (ffp_rng_uniform(&rng) < config->material_share) picked.materials = stock->materials;
    if (ffp_rng_uniform(&rng) < config->pattern_share) picked.patterns = stock->patterns;
    return picked;
}

static bool make_scene(FfpCapture *capture, FfpSceneSpec *spec, const FfpStock *stock, FfpError *err) {
    const bool ok = ffp_stock_dress(stock, spec, err) && ffp_scene_make(capture, spec, err);
    ffp_stock_undress(stock, spec);
    return ok;
}

// Mesh, material and jitter of scene `number` of a split: independent draws from its own random stream.
static bool scene_spec(FfpSceneSpec *spec, const FfpTrainConfig *config, const char *split, int64_t number,
                       FfpError *err) {
    const int capacity = ffp_mesh_count();
    int *meshes = ffp_alloc((size_t)capacity, sizeof *meshes);
    const int count = ffp_split_meshes(split, meshes, capacity);
    if (count < 1) {
        ffp_free(meshes);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, split, "no meshes in this split");
    }
    FfpRng rng = ffp_rng((uint64_t)config->seed * 3 + (split[0] == 'v' ? 1 : 0), (uint64_t)number);
    *spec = ffp_scene_defaults();
    spec->mesh = meshes[ffp_rng_below(&rng, (uint32_t)count)];
    spec->material = (int)ffp_rng_below(&rng, (uint32_t)ffp_material_count());
    spec->seed = ((uint64_t)ffp_rng_u32(&rng) << 32) | ffp_rng_u32(&rng);
    spec->resolution = config->resolution;
    spec->views = config->views;
    spec->targets = config->targets;
    spec->lollipops = config->lollipops;
    spec->pattern_side = config->pattern_side;
    spec->samples = config->samples;
    spec->ambient_rays = config->ambient_rays;
    spec->jitter = true;
    const bool training = split[0] == 't';
    if (training && ffp_rng_uniform(&rng) < config->sensor_share) spec->sensor = random_sensor(&rng);
    if (training) mix(spec, config, number);
    ffp_free(meshes);
    return true;
}

// Prepares the network's inputs from a scene: the work of whoever makes it, not of who waits for the device.
static bool prepare_numbers(FfpScene *scene, const FfpTrainConfig *config, FfpError *err) {
    scene->prepared =
        ffp_prepared_new(&config->model, &scene->inputs, &scene->start, &scene->context, scene->active, err);
    if (!scene->prepared) return false;
    const int64_t count = ffp_prepared_count(scene->prepared);
    scene->true_t = ffp_alloc((size_t)count + 1, sizeof *scene->true_t);
    ffp_scene_distances(scene->true_t, scene, ffp_prepared_pixels(scene->prepared), count);
    return true;
}

bool ffp_scene_match(FfpScene *scene, const FfpTrainConfig *config, FfpError *err) {
    const FfpMatchSettings settings = ffp_match_defaults();
    scene->active = ffp_capture_active_pattern(&scene->inputs, NULL, err);
    if (scene->active < 0 ||
        !ffp_initialisation_new(&scene->start, &scene->inputs, &scene->active, 1, &settings, err) ||
        !ffp_pixel_context_new(&scene->context, &config->model, &scene->inputs, &scene->start, &scene->active,
                               1, err)) {
        ffp_scene_close(scene);
        return false;
    }
    if (ffp_device_offered() && !prepare_numbers(scene, config, err)) {
        ffp_scene_close(scene);
        return false;
    }
    const int n_patterns = scene->capture.n_patterns;
    scene->patterns = ffp_alloc((size_t)n_patterns, sizeof *scene->patterns);
    for (int i = 0; i < n_patterns; i++)
        scene->patterns[i] = ffp_summed_new(&scene->capture.patterns[i].image);
    return true;
}

// Completes a scene whose capture exists: normalised by its input views, the first `views`, and matched.
// Takes the capture away on failure.
static bool prepare(FfpScene *scene, const FfpTrainConfig *config, int views, FfpError *err) {
    FfpCapture *capture = &scene->capture;
    scene->inputs = *capture;
    scene->inputs.n_views = views;
    ffp_capture_estimate_bounds(&scene->inputs);
    const real centre[3] = {scene->inputs.centre[0], scene->inputs.centre[1], scene->inputs.centre[2]};
    ffp_capture_normalise(capture, centre, scene->inputs.radius);
    scene->inputs = *capture;
    scene->inputs.n_views = views;
    return ffp_scene_match(scene, config, err);
}

static bool open_rig(FfpScene *scene, const FfpTrainConfig *config, const FfpStock *stock, const char *split,
                     int64_t number, bool free_rig, FfpError *err) {
    FfpSceneSpec spec = {0};
    FfpError why = {0};
    *scene = (FfpScene){0};
    const bool ok = scene_spec(&spec, config, split, number, &why);
    if (ok && free_rig) spec.rig = FFP_SCENE_FREE;
    const FfpStock picked = pick_stock(stock, config, split, number);
    if (ok && make_scene(&scene->capture, &spec, &picked, &why) && prepare(scene, config, spec.views, &why))
        return true;
    char where[64];
    snprintf(where, sizeof where, "scene %lld of the %.16s split", (long long)number, split);
    return ffp_fail(err, why.code, where, "%s", why.text);
}

bool ffp_scene_open(FfpScene *scene, const FfpTrainConfig *config, const FfpStock *stock, const char *split,
                    int64_t number, FfpError *err) {
    return open_rig(scene, config, stock, split, number, false, err);
}

bool ffp_scene_open_free(FfpScene *scene, const FfpTrainConfig *config, int64_t number, FfpError *err) {
    return open_rig(scene, config, NULL, "validation", number, true, err);
}

bool ffp_scene_read(FfpScene *scene, const FfpTrainConfig *config, const FfpSceneFolder *folder,
                    int64_t number, FfpError *err) {
    *scene = (FfpScene){0};
    const char *name = ffp_scene_folder_name(folder, config->seed, number);
    return ffp_scene_folder_read(&scene->capture, folder, name, config, err) &&
           prepare(scene, config, config->views, err);
}

void ffp_scene_close(FfpScene *scene) {
    for (int i = 0; scene->patterns && i < scene->capture.n_patterns; i++)
        ffp_summed_free(&scene->patterns[i]);
    ffp_free(scene->patterns);
    ffp_free(scene->true_t);
    ffp_prepared_free(scene->prepared);
    ffp_pixel_context_free(&scene->context);
    ffp_initialisation_free(&scene->start);
    if (scene->borrowed) {
        ffp_free(scene->inputs.views);
        ffp_free(scene->capture.views);
    } else {
        ffp_capture_free(&scene->capture);
    }
    *scene = (FfpScene){0};
}

real ffp_true_t(const FfpView *view, int pixel) {
    if (!view->depth.data || view->depth.data[pixel] <= 0) return 0;
    const int x = pixel % view->depth.width, y = pixel / view->depth.width;
    real direction[3];
    return view->depth.data[pixel] / ffp_pixel_ray(&view->camera, (real)x + 0.5F, (real)y + 0.5F, direction);
}

void ffp_scene_distances(real *out, const FfpScene *scene, const int64_t *pixel, int64_t count) {
    const FfpView *views = scene->inputs.views;
    const int64_t area = (int64_t)views[0].camera.width * views[0].camera.height;
    for (int64_t i = 0; i < count; i++) out[i] = ffp_true_t(&views[pixel[i] / area], (int)(pixel[i] % area));
}
