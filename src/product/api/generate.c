// Generated captures on disk: the public settings as the training world's.
#include "core/base/call.h"
#include "core/base/error.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "world/synth/dataset.h"

#define DEGREE 0.017453292519943295

void ffp_generation_defaults_into(FfpGeneration *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpGeneration){.count = -1, .attitudes = 8, .quality = 92},
                      sizeof(FfpGeneration));
}

static FfpSensor sensor_of(const FfpSensorFaults *faults, const FfpLightFaults *light) {
    const float spread = (float)light->spread;
    return (FfpSensor){.exposure = (float)faults->exposure,
                       .shot = (float)faults->shot,
                       .read = (float)faults->read,
                       .defocus = (float)faults->defocus,
                       .gamma = (float)faults->gamma,
                       .black_level = (float)faults->black_level,
                       .turn_error = (float)faults->turn_error * (float)DEGREE,
                       .shift_error = (float)faults->shift_error,
                       .real_light = (float)light->real_light,
                       .spread = {spread, spread, spread},
                       .spread_reach = (float)light->spread_reach,
                       .glare = (float)light->glare,
                       .glare_reach = (float)light->glare_reach,
                       .power = (float)light->power,
                       .vignetting = (float)light->vignetting,
                       .throw_fall = (float)light->throw_fall,
                       .focus_blur = (float)light->focus_blur,
                       .focus_at = (float)light->focus_at};
}

// Checks for values that a caller in C may pass though the type says otherwise.
static bool check_choices(const FfpGeneration *options, FfpError *err) {
    if (options->seed > INT64_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "seed", "is above %lld", (long long)INT64_MAX);
    return ffp_check_choice((int)options->split, FFP_SPLIT_TEST, "split", err) &&
           ffp_check_choice((int)options->preset, FFP_PRESET_TRAINING, "preset", err) &&
           ffp_check_choice((int)options->rig, FFP_RIG_WALK_TWO, "rig", err);
}

static bool generate(void *argument, FfpError *err) {
    const FfpGeneration *options = *(const FfpGeneration *const *)argument;
    static const char *const splits[] = {[FFP_SPLIT_ALL] = NULL,
                                         [FFP_SPLIT_TRAIN] = "train",
                                         [FFP_SPLIT_VALIDATION] = "validation",
                                         [FFP_SPLIT_TEST] = "test"};
    static const FfpDatasetPreset presets[] = {[FFP_PRESET_PAPER] = FFP_DATASET_PAPER,
                                               [FFP_PRESET_SMOKE] = FFP_DATASET_SMOKE,
                                               [FFP_PRESET_TRAINING] = FFP_DATASET_TRAINING};
    static const FfpSceneRig rigs[] = {[FFP_RIG_TURNTABLE] = FFP_SCENE_TURNTABLE,
                                       [FFP_RIG_FREE] = FFP_SCENE_FREE,
                                       [FFP_RIG_SPHERE] = FFP_SCENE_SPHERE,
                                       [FFP_RIG_WALK] = FFP_SCENE_WALK,
                                       [FFP_RIG_WALK_TWO] = FFP_SCENE_WALK_TWO};
    if (!check_choices(options, err)) return false;
    const FfpDatasetSettings settings = {.folder = options->folder,
                                         .split = splits[options->split],
                                         .preset = presets[options->preset],
                                         .first = options->first,
                                         .count = options->count,
                                         .resolution = options->resolution,
                                         .rig = rigs[options->rig],
                                         .views = options->views,
                                         .seed = options->seed,
                                         .mesh = options->mesh,
                                         .material = options->material,
                                         .materials = options->materials,
                                         .patterns = options->patterns,
                                         .photographs = options->photographs,
                                         .attitudes = options->attitudes,
                                         .only = options->only,
                                         .room = options->room,
                                         .quality = options->quality,
                                         .other_projector = options->other_projector,
                                         .sensor = sensor_of(&options->sensor, &options->light)};
    if (options->check) return ffp_dataset_check(&settings, err);
    return ffp_dataset_write(&settings, err);
}

bool ffp_generate(FfpContext *context, const FfpGeneration *options, FfpError *err) {
    FfpGeneration own = ffp_generation_defaults();
    if (!ffp_take_options(&own, options, "FfpGeneration", err) || !ffp_need(own.folder, "folder", err))
        return false;
    options = &own;
    return ffp_call_run(context, generate, &options, err);
}
