#include "product/export/light.h"
#include <string.h>
#include "core/base/file.h"
#include "engine/apply/choose.h"
#include "engine/pipeline/relight.h"
#include "engine/render/bake.h"

bool ffp_export_lights(const FfpExport *options) {
    return options->light && strcmp(options->light, "ambient") != 0;
}

static bool choose_pattern(FfpPattern *pattern, const FfpCapture *capture, const FfpCamera *projector,
                           const FfpExport *options, FfpError *err) {
    const char *name = options->light;
    const bool white = strcmp(name, "white") == 0;
    const int known = white ? capture->white : ffp_capture_find_pattern(capture, name);
    *pattern = (FfpPattern){0};
    if (known >= 0) {
        pattern->image = ffp_image_copy(&capture->patterns[known].image);
        return true;
    }
    if (!ffp_is_file(name))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, capture->folder,
            "%.256s is not ambient, white, an image file or a pattern of the capture; its patterns are %s",
            name, ffp_list_patterns(capture).text);
    return ffp_pattern_read(pattern, name, projector, options->framing, err);
}

static bool bake_views(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                       const FfpView *light_view, const FfpView *camera_view, real *colour, FfpError *err) {
    FfpPattern pattern;
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){.form = options->form}, NULL);
    if (!choose_pattern(&pattern, capture, &light_view->projector, options, err)) return false;
    FfpSummed summed = ffp_summed_new(&pattern.image);
    const real *pose = camera_view ? camera_view->camera.pose : NULL;
    const real eye[3] = {pose ? pose[3] : 0, pose ? pose[7] : 0, pose ? pose[11] : 0};
    const FfpBakeLight light = {&light_view->projector, capture->intensity, &summed, pose ? eye : NULL};
    ffp_bake(gaussians, &light, &settings, colour);
    ffp_summed_free(&summed);
    ffp_image_free(&pattern.image);
    return true;
}

bool ffp_export_bake(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                     real *colour, FfpError *err) {
    if (!ffp_export_lights(options)) {
        memcpy(colour, gaussians->ambient, 3 * (size_t)gaussians->count * sizeof *colour);
        return true;
    }
    FfpChosen light, camera = {0};
    bool ok = ffp_choose_views(&light, capture, options->poses, &options->projector_view,
                               options->projector_view ? 1 : 0, err) &&
              (!options->camera_view ||
               ffp_choose_views(&camera, capture, options->poses, &options->camera_view, 1, err));
    ok = ok && bake_views(gaussians, capture, options, light.views[0], camera.views ? camera.views[0] : NULL,
                          colour, err);
    ffp_chosen_free(&light);
    ffp_chosen_free(&camera);
    return ok;
}
