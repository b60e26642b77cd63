#include "core/base/arena.h"
#include "engine/refine/refine.h"
#include "lab/train/train.h"

bool ffp_scene_polish(FfpGaussians *gaussians, const FfpTrainConfig *config, const FfpRenderSettings *render,
                      const FfpScene *scene, uint64_t seed, FfpError *err) {
    const int patterns[] = {scene->inputs.black, scene->inputs.white, scene->active};
    FfpRefineSettings settings = ffp_polish_defaults(config->polish_steps);
    settings.render = *render;
    settings.seed = seed;
    settings.quiet = true;
    FfpRefineResult result;
    return ffp_refine(gaussians, &scene->inputs, patterns, 3, &settings, &result, err);
}
