// Whole scenes: what no pattern reaches lies on walls and floors that are known elsewhere.
#include "engine/match/match.h"
#include "support.h"
#include "world/synth/scene.h"

static FfpCapture walk(uint64_t seed) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 17, spec.material = 5, spec.seed = seed;
    spec.rig = FFP_SCENE_WALK, spec.resolution = 64;
    spec.lollipops = 1, spec.pattern_side = 200;
    FfpCapture capture;
    FfpError err;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    return capture;
}

// Share of a view's unlit pixels whose splat is in front of the truth by more than a tenth. There it hides
// the wall from other places.
static double share_in_front(const FfpCapture *capture, const FfpInitialisation *start, int v) {
    const FfpView *view = &capture->views[v];
    const int area = start->width * start->height;
    int unlit = 0, in_front = 0;
    for (int i = 0; i < area; i++) {
        if (view->direct_white.data[3 * i] > 0) continue;
        const double z = (double)start->footprint[v * area + i] * (double)view->camera.fx;
        unlit++;
        in_front += z < 0.9 * (double)view->depth.data[i];
    }
    return (double)in_front / unlit;
}

// The first and the last view show most of what is in no other picture.
static void nothing_hangs_before_the_walls(void **state) {
    (void)state;
    double share = 0;
    for (uint64_t seed = 3; seed < 5; seed++) {
        FfpCapture capture = walk(seed);
        FfpInitialisation start;
        FfpError err;
        const int pattern = 2, last = capture.n_views - 1;
        const FfpMatchSettings settings = ffp_match_defaults();
        if (!ffp_initialisation_new(&start, &capture, &pattern, 1, &settings, &err)) fail_msg("%s", err.text);
        share += (share_in_front(&capture, &start, 0) + share_in_front(&capture, &start, last)) / 4;
        ffp_initialisation_free(&start);
        ffp_capture_free(&capture);
    }
    if (share >= 0.04) fail_msg("%.1f %% hang in front", 100 * share);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_hangs_before_the_walls)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
