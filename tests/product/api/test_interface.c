// Programs that were compiled with other headers than the library.
#include <stdio.h>
#include <string.h>
#include "initialised.h"

static void versions_agree(void **state) {
    (void)state;
    char text[64];
    snprintf(text, sizeof text, "%d.%d.%d", FFPROCAMS_VERSION_MAJOR, FFPROCAMS_VERSION_MINOR,
             FFPROCAMS_VERSION_PATCH);
    assert_string_equal(ffp_version(), text);
    int major, minor, patch;
    assert_int_equal(sscanf(ffp_version(), "%d.%d.%d", &major, &minor, &patch), 3);
    assert_int_equal(FFPROCAMS_VERSION, FFPROCAMS_VERSION_NUMBER(major, minor, patch));
    assert_true(FFPROCAMS_VERSION_NUMBER(0, 4, 0) > FFPROCAMS_VERSION_NUMBER(0, 3, 12));
    assert_true(FFPROCAMS_VERSION_NUMBER(1, 0, 0) > FFPROCAMS_VERSION_NUMBER(0, 40, 40));
}

// --- Structs of options: every function that takes one. ---

static FfpContext *cancelled; // its calls end where their work begins
static FfpError err;

static bool cancel(void *user, const FfpProgress *progress) {
    (void)user, (void)progress;
    return false;
}

static bool new_context(const FfpContextSettings *settings) {
    FfpContext *context = ffp_context_new(settings, &err);
    ffp_context_free(context);
    return context != NULL;
}

static bool evaluate(const FfpEvaluation *options) {
    int n;
    FfpScore *scores = ffp_evaluate(cancelled, options, &n, &err);
    ffp_free(scores);
    return scores != NULL;
}

static bool closed(FfpGaussians *made) {
    ffp_gaussians_close(made);
    return made != NULL;
}

static bool fit_field(const FfpRefinement *options) {
    FfpNeuralField *field = ffp_fit_neural_field(cancelled, capture, options, NULL, NULL, &err);
    ffp_neural_field_close(field); // as far as it came
    return field != NULL;
}

static bool prepare(const FfpReconstruction *options) {
    FfpPrepared *prepared = ffp_prepare(cancelled, capture, options, &err);
    ffp_prepared_close(prepared);
    return prepared != NULL;
}

static bool compensate(const FfpCompensation *options) {
    FfpImages *images = ffp_compensate_images(cancelled, gaussians, capture, options, NULL, &err);
    ffp_images_close(images);
    return images != NULL;
}

#define TAKES(function, type, defaults, call)                                                                \
    static bool call_##function(const void *given) {                                                         \
        const type *options = given;                                                                         \
        return call;                                                                                         \
    }                                                                                                        \
    static void give_##function(void *options, size_t size) {                                                \
        defaults##_into(options, size);                                                                      \
    }
TAKES(context, FfpContextSettings, ffp_context_defaults, new_context(options))
TAKES(reconstruct, FfpReconstruction, ffp_reconstruction_defaults,
      closed(ffp_reconstruct(cancelled, capture, options, NULL, &err)))
TAKES(prepare, FfpReconstruction, ffp_reconstruction_defaults, prepare(options))
TAKES(refine, FfpRefinement, ffp_refinement_defaults,
      ffp_refine_gaussians(cancelled, gaussians, capture, options, NULL, &err))
TAKES(scratch, FfpRefinement, ffp_refinement_defaults,
      closed(ffp_fit_from_scratch(cancelled, capture, NULL, options, NULL, &err)))
TAKES(field, FfpRefinement, ffp_refinement_defaults, fit_field(options))
TAKES(render, FfpPictures, ffp_pictures_defaults,
      ffp_render_pictures(cancelled, gaussians, capture, options, &err) >= 0)
TAKES(page, FfpPage, ffp_page_defaults, ffp_write_page(cancelled, gaussians, capture, options, NULL, &err))
TAKES(images, FfpCompensation, ffp_compensation_defaults, compensate(options))
TAKES(compensate, FfpCompensation, ffp_compensation_defaults,
      ffp_compensate(cancelled, gaussians, capture, options, NULL, &err))
TAKES(maps, FfpWarps, ffp_warps_defaults,
      ffp_write_warps(cancelled, gaussians, capture, options, NULL, 0, &err) >= 0)
TAKES(splats, FfpExport, ffp_export_defaults, ffp_export(cancelled, gaussians, capture, options, NULL, &err))
TAKES(evaluate, FfpEvaluation, ffp_evaluation_defaults, evaluate(options))
TAKES(train, FfpTraining, ffp_training_defaults, ffp_train_model(cancelled, options, &err))
TAKES(generate, FfpGeneration, ffp_generation_defaults, ffp_generate(cancelled, options, &err))
TAKES(patterns, FfpPatterns, ffp_patterns_defaults, ffp_write_patterns(cancelled, options, &err) >= 0)
TAKES(calibrate, FfpRigCalibration, ffp_rig_calibration_defaults,
      ffp_calibrate_rig(cancelled, options, NULL, &err))
TAKES(selfcal, FfpSelfCalibration, ffp_self_calibration_defaults,
      ffp_self_calibrate(cancelled, options, NULL, &err))
TAKES(import, FfpImport, ffp_import_defaults, ffp_import_capture(cancelled, options, &err))
TAKES(align, FfpAlignment, ffp_alignment_defaults, ffp_align_poses(cancelled, capture, options, NULL, &err))

#define ROW(function, type)                                                                                  \
    { "(" #type ")", sizeof(type), call_##function, give_##function }
static const struct {
    const char *place; // in an error
    size_t size;
    bool (*call)(const void *options);
    void (*give)(void *options, size_t size);
} takers[] = {
    ROW(context, FfpContextSettings),
    ROW(reconstruct, FfpReconstruction),
    ROW(prepare, FfpReconstruction),
    ROW(refine, FfpRefinement),
    ROW(scratch, FfpRefinement),
    ROW(field, FfpRefinement),
    ROW(render, FfpPictures),
    ROW(page, FfpPage),
    ROW(images, FfpCompensation),
    ROW(compensate, FfpCompensation),
    ROW(maps, FfpWarps),
    ROW(splats, FfpExport),
    ROW(evaluate, FfpEvaluation),
    ROW(train, FfpTraining),
    ROW(generate, FfpGeneration),
    ROW(patterns, FfpPatterns),
    ROW(calibrate, FfpRigCalibration),
    ROW(selfcal, FfpSelfCalibration),
    ROW(import, FfpImport),
    ROW(align, FfpAlignment),
};
enum { TAKERS = sizeof takers / sizeof *takers, ROOM = 1024, POISON = 0xa5 };
typedef union Options {
    size_t size;
    unsigned char bytes[ROOM];
} Options;

static void defaults_fit_the_program(void **state) {
    (void)state;
    for (int i = 0; i < TAKERS; i++) {
        Options now, earlier, later;
        const size_t size = takers[i].size;
        assert_true(size + 16 < ROOM);
        memset(&now, POISON, sizeof now), earlier = later = now;
        takers[i].give(&now, size), takers[i].give(&earlier, size - 8), takers[i].give(&later, size + 8);
        assert_true(now.size == size && earlier.size == size - 8 && later.size == size + 8);
        for (size_t k = sizeof(size_t); k < ROOM; k++) {
            assert_int_equal(now.bytes[k] == POISON, k >= size);
            assert_int_equal(earlier.bytes[k], k < size - 8 ? now.bytes[k] : POISON);
            assert_int_equal(later.bytes[k], k >= size && k < size + 8 ? 0 : now.bytes[k]);
        }
    }
}

static void options_of_no_or_a_later_size_are_refused(void **state) {
    (void)state;
    for (int i = 0; i < TAKERS; i++) {
        Options options;
        const size_t wrong[] = {0, sizeof(size_t) - 1, takers[i].size + 1, takers[i].size + 8, SIZE_MAX};
        for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
            err = (FfpError){0};
            takers[i].give(&options, takers[i].size);
            options.size = wrong[k];
            const bool done = takers[i].call(&options);
            if (done || err.code != FFP_ERROR_ARGUMENT || !strstr(err.text, takers[i].place))
                fail_msg("%d, %s of %zu bytes: %s", i, takers[i].place, wrong[k], err.text);
        }
    }
}

static void options_of_an_earlier_size_are_taken(void **state) {
    (void)state;
    for (int i = 0; i < TAKERS; i++) {
        Options options;
        err = (FfpError){0};
        memset(&options, POISON, sizeof options); // pointers into nowhere, if anything reads on
        options.size = sizeof(size_t);
        takers[i].call(&options);
        if (strstr(err.text, takers[i].place)) fail_msg("%d: %s", i, err.text);
    }
}

// A program that knows of no more than the panel's size.
static void options_that_it_does_not_know_have_their_defaults(void **state) {
    (void)state;
    int count[2];
    for (int k = 0; k < 2; k++) {
        FfpPatterns options = ffp_patterns_defaults();
        options.folder = in_scratch(k == 0 ? "now" : "earlier"), options.width = options.height = 64;
        if (k == 1) {
            options.size = offsetof(FfpPatterns, lollipops);
            options.lollipops = 7, options.gray_codes = false, options.focus = false;
        }
        count[k] = ffp_write_patterns(NULL, &options, &err);
        if (count[k] < 0) fail_msg("%s", err.text);
    }
    assert_true(count[0] > 10);
    assert_int_equal(count[1], count[0]);
}

static int begin(void **state) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.progress = cancel, settings.interval_s = 0;
    cancelled = ffp_context_new(&settings, NULL);
    return cancelled ? setup(state) : -1;
}

static int end(void **state) {
    ffp_context_free(cancelled);
    return teardown(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(versions_agree),
        cmocka_unit_test(defaults_fit_the_program),
        cmocka_unit_test(options_of_no_or_a_later_size_are_refused),
        cmocka_unit_test(options_of_an_earlier_size_are_taken),
        cmocka_unit_test(options_that_it_does_not_know_have_their_defaults),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
