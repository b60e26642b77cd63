// A capture of three views of 16 x 16 pixels in a folder, and weights of the smallest network: for tests that
// do the same work again and again.
#ifndef FFP_TESTS_SMALL_H
#define FFP_TESTS_SMALL_H

#include "core/capture/capture.h"
#include "engine/network/network.h"
#include "ffprocams.h"
#include "scratch.h"
#include "world/synth/synth.h"

enum { SMALL_VIEWS = 3, SMALL_SIDE = 16, SMALL_PATTERN = 60 };

static inline int small_setup(void **state) {
    FfpError err = {0};
    FfpCapture capture;
    FfpModelConfig config;
    FfpSceneSpec spec = ffp_scene_defaults();
    if (scratch_setup(state) != 0) return -1;
    spec.mesh = 3, spec.material = 2;
    spec.resolution = SMALL_SIDE, spec.pattern_side = SMALL_PATTERN;
    spec.views = SMALL_VIEWS, spec.targets = 0, spec.lollipops = 1;
    spec.samples = 1, spec.ambient_rays = 1;
    bool ok = ffp_scene_make(&capture, &spec, &err);
    if (ok) {
        ok = ffp_capture_write(&capture, in_scratch("capture"), &err) && ffp_model_preset(&config, "tiny");
        ffp_capture_free(&capture);
    }
    FfpModel *model = ok ? ffp_model_new(&config, 1, &err) : NULL;
    ok = model && ffp_model_write(model, in_scratch("weights"), true, NULL, 0, &err);
    if (model) ffp_model_free(model);
    if (!ok) fprintf(stderr, "%s\n", err.text);
    return ok ? 0 : -1;
}

#endif
