#include "synth/dataset.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "base/log.h"
#include "synth/natural.h"
#include "ffprocams.h"

enum { MESHES_MAX = 1024 };

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

static bool preset_spec(const FfpGeneration *options, FfpSceneSpec *spec, FfpError *err) {
    const char *preset = options->preset ? options->preset : "paper";
    *spec = ffp_scene_defaults();
    if (!strcmp(preset, "paper")) {
        spec->lollipops = 6, spec->targets = 6;
        spec->samples = 64, spec->ambient_rays = 2;
    } else if (!strcmp(preset, "smoke")) {
        spec->lollipops = 2, spec->targets = 2;
        spec->resolution = 64, spec->pattern_side = 400;
    } else {
        return ffp_fail(err, "--preset", "'%s' is not paper or smoke", preset);
    }
    if (options->split && !strcmp(options->split, "test")) spec->naturals = FFP_NATURAL_KINDS;
    if (options->resolution > 0) spec->resolution = options->resolution;
    return true;
}

// The views from `first` on as a capture of their own, to be written; memory stays with the whole.
static bool write_part(const FfpCapture *whole, int first, int count, const char *folder, FfpError *err) {
    FfpCapture part = *whole;
    part.views = whole->views + first;
    part.n_views = count;
    return ffp_make_folders(folder, err) && ffp_capture_write(&part, folder, err);
}

static bool is_complete(const char *folder, const char *targets, bool with_targets) {
    char scene[FFP_PATH_MAX], poses[FFP_PATH_MAX];
    if (!ffp_join_path(scene, folder, "scene.json") || !ffp_join_path(poses, targets, "scene.json"))
        return false;
    return ffp_is_file(scene) && (!with_targets || ffp_is_file(poses));
}

// Targets first: the input views' scene.json is the last file, so that a scene which has it is whole.
static bool generate_scene(const FfpSceneSpec *spec, const char *folder, bool *made, FfpError *err) {
    char targets[FFP_PATH_MAX];
    if (!ffp_join_path(targets, folder, "targets")) return ffp_fail(err, folder, "the path is too long");
    *made = !is_complete(folder, targets, spec->targets > 0);
    if (!*made) return true;
    FfpCapture capture;
    if (!ffp_scene_make(&capture, spec, err)) return false;
    const bool ok = (spec->targets == 0 || write_part(&capture, spec->views, spec->targets, targets, err)) &&
                    write_part(&capture, 0, spec->views, folder, err);
    ffp_capture_free(&capture);
    return ok;
}

bool ffp_generate(const FfpGeneration *options, FfpError *err) {
    FfpSceneSpec spec;
    if (!options->folder) return ffp_fail(err, NULL, "no folder to write to is given");
    if (!preset_spec(options, &spec, err)) return false;
    const int64_t size = ffp_dataset_size(options->split);
    if (size == 0) return ffp_fail(err, "--split", "'%s' is not train, validation or test", options->split);
    if (options->first < 0 || options->first >= size)
        return ffp_fail(err, "--first", "scene %lld is not in 0..%lld", (long long)options->first,
                        (long long)size - 1);
    const int64_t left = size - options->first, count = options->count < 0 ? left : options->count;
    if (count < 1 || count > left)
        return ffp_fail(err, "--count", "%lld scenes from %lld on are not in 1..%lld", (long long)count,
                        (long long)options->first, (long long)left);
    if (!ffp_make_folders(options->folder, err)) return false;
    FfpProgress progress = ffp_progress("generating", count);
    int64_t kept = 0;
    for (int64_t i = 0; i < count; i++) {
        char name[FFP_NAME_MAX], folder[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%s_%05lld", options->split ? options->split : "all",
                 (long long)options->first + (long long)i);
        if (!ffp_join_path(folder, options->folder, name))
            return ffp_fail(err, options->folder, "the path is too long");
        ffp_dataset_scene(options->split, options->first + i, options->seed, &spec);
        bool made = false;
        if (!generate_scene(&spec, folder, &made, err)) return false;
        kept += !made;
        ffp_progress_step(&progress, i + 1, name);
    }
    ffp_progress_end(&progress);
    if (kept > 0) ffp_note("%lld scenes were there already and were kept", (long long)kept);
    return true;
}
