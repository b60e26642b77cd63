// The two predictors of the quality table on captures that another renderer made: they find every error of
// convention, since each picture is predicted from nothing but depth, poses and patterns.
#include <math.h>
#include "core/base/alloc.h"
#include "engine/loss/metrics.h"
#include "engine/match/match.h"
#include "support.h"

typedef enum Depth { TRUE_DEPTH, MATCHED_DEPTH } Depth;

// Mean PSNR, dB, over the input poses and the lollipops that were not given; full frame.
static double predictor_psnr(FfpCapture *capture, Depth kind) {
    FfpError err = {0};
    const int active = ffp_capture_active_pattern(capture, "lollipop_0", &err);
    if (active < 0) fail_msg("%s", err.text);
    ffp_capture_normalise(capture, capture->centre, capture->radius);
    const FfpMatchSettings settings = ffp_match_defaults();
    double sum = 0;
    int pictures = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real *depth = ffp_alloc((size_t)view->camera.width * view->camera.height, sizeof *depth);
        assert_non_null(depth);
        if (kind == MATCHED_DEPTH) ffp_match_depth(capture, v, &active, 1, &settings, depth);
        for (int p = 0; p < capture->n_patterns; p++) {
            const bool lollipop = strncmp(capture->patterns[p].name, "lollipop", 8) == 0;
            if (!lollipop || p == active || !view->images[p].data) continue;
            FfpImage truth = ffp_image_copy(&view->images[p]);
            ffp_image_to_srgb(&truth);
            FfpImage predicted =
                ffp_predict_by_lookup(capture, v, p, kind == TRUE_DEPTH ? view->depth.data : depth);
            sum += ffp_psnr(&predicted, &truth), pictures++;
            ffp_image_free(&predicted);
            ffp_image_free(&truth);
        }
        ffp_free(depth);
    }
    assert_true(pictures > 0);
    return sum / pictures;
}

static double psnr_of_file(const char *path, Depth kind) {
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, path, &err)) fail_msg("%s", err.text);
    const double psnr = predictor_psnr(&capture, kind);
    print_message("%s, %s depth: %.2f dB\n", capture.name, kind == TRUE_DEPTH ? "true" : "matched", psnr);
    ffp_capture_free(&capture);
    return psnr;
}

static double mean_of_the_four(Depth kind) {
    static const char *const names[4] = {"spot", "teapot", "suzanne", "cow"};
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        char name[64], path[1024];
        snprintf(name, sizeof name, "captures/%s/render_poses.json", names[i]);
        if (!shared_path(path, name)) skip();
        sum += psnr_of_file(path, kind);
    }
    return sum / 4;
}

static void true_depth_predicts_other_renderers_pictures(void **state) {
    (void)state;
    SAME_WAY_AGAIN(); // both_predict_the_samples_pictures
    assert_true(mean_of_the_four(TRUE_DEPTH) >= 45);
}

static void matched_depth_predicts_other_renderers_pictures(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    assert_true(mean_of_the_four(MATCHED_DEPTH) >= 42);
}

// The captures of the repository, likewise.
static void both_predict_the_samples_pictures(void **state) {
    (void)state;
    assert_true(psnr_of_file(FFP_SOURCE_DIR "/data/sample", TRUE_DEPTH) >= 45);
    assert_true(psnr_of_file(FFP_SOURCE_DIR "/data/sample", MATCHED_DEPTH) >= 42);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(true_depth_predicts_other_renderers_pictures),
        cmocka_unit_test(matched_depth_predicts_other_renderers_pictures),
        cmocka_unit_test(both_predict_the_samples_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
