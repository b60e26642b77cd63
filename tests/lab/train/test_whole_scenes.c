// Matching of whole scenes against the truth of generated ones: what no projector reaches has depth, too.
// Labels: slow
#include <math.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "engine/match/match.h"
#include "support.h"
#include "world/synth/synth.h"

typedef struct Errors { // medians of |depth - truth| / truth, and shares of pixels off by more than a tenth
    double lit, unlit, lit_off, unlit_off;
} Errors;

static FfpCapture make_scene(uint64_t seed, FfpSceneRig rig) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 17, spec.material = 5, spec.seed = seed;
    spec.rig = rig, spec.resolution = 72, spec.targets = 0;
    spec.lollipops = 1, spec.pattern_side = 400;
    spec.views = rig == FFP_SCENE_WALK_TWO ? 16 : 8;
    FfpCapture capture;
    FfpError err;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    const real centre[3] = {capture.centre[0], capture.centre[1], capture.centre[2]};
    ffp_capture_normalise(&capture, centre, capture.radius);
    return capture;
}

static void summarise(real *errors, size_t count, double *median, double *off) {
    size_t far = 0;
    for (size_t i = 0; i < count; i++) far += errors[i] > 0.1F;
    *median = (double)ffp_median(errors, count);
    *off = (double)far / (double)count;
}

static Errors errors_of(const FfpCapture *capture) {
    const int active = 2;
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpInitialisation start;
    FfpError err;
    if (!ffp_initialisation_new(&start, capture, &active, 1, &settings, &err)) fail_msg("%s", err.text);
    const size_t area = (size_t)start.width * (size_t)start.height, count = area * (size_t)start.views;
    real *lit = ffp_alloc(count, sizeof *lit), *unlit = ffp_alloc(count, sizeof *unlit);
    size_t n_lit = 0, n_unlit = 0;
    for (size_t i = 0; i < count; i++) {
        const FfpView *view = &capture->views[i / area];
        const real truth = view->depth.data[i % area];
        const real error = fabsf(start.footprint[i] * view->camera.fx - truth) / truth;
        if (view->direct_white.data[3 * (i % area)] > 0.02F)
            lit[n_lit++] = error;
        else
            unlit[n_unlit++] = error;
    }
    assert_true(n_lit > count / 8 && n_unlit > count / 8);
    Errors out;
    summarise(lit, n_lit, &out.lit, &out.lit_off);
    summarise(unlit, n_unlit, &out.unlit, &out.unlit_off);
    ffp_free(lit);
    ffp_free(unlit);
    ffp_initialisation_free(&start);
    return out;
}

// The same pictures as a scene and as an object in a sphere.
static void unlit_parts_of_a_scene_have_depth(void **state) {
    (void)state;
    Errors scene = {0}, object = {0};
    enum { SCENES = 2 };
    for (uint64_t seed = 0; seed < SCENES; seed++) {
        FfpCapture capture = make_scene(seed, FFP_SCENE_WALK);
        const Errors one = errors_of(&capture);
        capture.scene = false;
        const Errors other = errors_of(&capture);
        scene.lit += one.lit / SCENES, scene.unlit += one.unlit / SCENES;
        scene.lit_off += one.lit_off / SCENES, scene.unlit_off += one.unlit_off / SCENES;
        object.unlit += other.unlit / SCENES, object.unlit_off += other.unlit_off / SCENES;
        ffp_capture_free(&capture);
    }
    print_message("scene: lit %.4f, %.3f off; unlit %.4f, %.3f off; as an object: unlit %.4f, %.3f off\n",
                  scene.lit, scene.lit_off, scene.unlit, scene.unlit_off, object.unlit, object.unlit_off);
    assert_true(scene.lit < 0.01 && scene.lit_off < 0.08);
    assert_true(scene.unlit < 0.03 && scene.unlit_off < 0.35);
    assert_true(scene.unlit < object.unlit / 2 && scene.unlit_off < object.unlit_off);
}

// Views of one place and two projectors tell each other nothing about depth, and must not count as
// neighbours.
static void two_projectors_light_one_scene(void **state) {
    (void)state;
    FfpCapture capture = make_scene(1, FFP_SCENE_WALK_TWO);
    const Errors errors = errors_of(&capture);
    print_message("two projectors: lit %.4f, %.3f off; unlit %.4f, %.3f off\n", errors.lit, errors.lit_off,
                  errors.unlit, errors.unlit_off);
    assert_true(errors.lit < 0.01 && errors.unlit < 0.03 && errors.unlit_off < 0.35);
    ffp_capture_free(&capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unlit_parts_of_a_scene_have_depth),
        cmocka_unit_test(two_projectors_light_one_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
