// A neural field through the public header: fitted, saved, read, drawn by an evaluation, cancelled, refused.
// Labels: slow
#include <math.h>
#include <string.h>
#include "core/base/file.h"
#include "ffprocams/lab.h"
#include "lab/baselines/field.h"
#include "small.h"

enum { STEPS = 60 };

static FfpCapture *capture;

static int setup(void **state) {
    FfpError err = {0};
    if (small_setup(state) != 0) return -1;
    capture = ffp_capture_open(NULL, in_scratch("capture"), NULL, &err);
    return capture ? 0 : -1;
}

static int teardown(void **state) {
    ffp_capture_close(capture);
    return scratch_teardown(state);
}

static FfpNeuralField *fit(FfpContext *context, int64_t steps, FfpRefinementStats *stats) {
    FfpError err = {0};
    const FfpRefinement how = {.size = sizeof how, .steps = steps, .seed = 1};
    FfpNeuralField *field = ffp_fit_neural_field(context, capture, &how, NULL, stats, &err);
    if (!field) fail_msg("%s", err.text);
    return field;
}

static FfpContext *context_of(int threads) {
    FfpContextSettings settings = ffp_context_defaults();
    FfpError err = {0};
    settings.threads = threads;
    FfpContext *context = ffp_context_new(&settings, &err);
    if (!context) fail_msg("%s", err.text);
    return context;
}

// Wants no more when it has been asked some times.
static bool stop_later(void *user, const FfpProgress *progress) {
    static int asked = 0;
    (void)user;
    if (progress->stage && strcmp(progress->stage, "fitting a field") == 0) {
        asked++;
        assert_int_equal(progress->total, 24); // its steps, where nothing else ends it
    }
    return asked < 10;
}

// The same seed, one thread and two: the same numbers to the bit; more steps, better pictures.
static void threads_do_not_matter_and_steps_do(void **state) {
    (void)state;
    FfpContext *one = context_of(1), *two = context_of(2);
    FfpRefinementStats few = {0}, more = {0};
    FfpNeuralField *a = fit(one, 8, &few), *b = fit(two, 8, NULL), *c = fit(two, STEPS, &more);
    assert_memory_equal(a->parameters, b->parameters, (size_t)a->layout.count * sizeof(real));
    assert_int_equal(few.steps, 8);
    assert_int_equal(more.steps, STEPS);
    assert_true(more.psnr_after > few.psnr_after + 3);
    assert_true(more.psnr_after > 13);
    ffp_neural_field_close(a), ffp_neural_field_close(b), ffp_neural_field_close(c);
    ffp_context_free(one), ffp_context_free(two);
}

// Stopped on the way, it goes on to the bits of a fit that was never stopped; another fit does not.
static void it_goes_on_from_a_checkpoint(void **state) {
    (void)state;
    FfpError err = {0};
    FfpContextSettings settings = ffp_context_defaults();
    char path[128];
    snprintf(path, sizeof path, "%s", in_scratch("checkpoint"));
    FfpRefinement how = {.size = sizeof how, .steps = 24, .seed = 1};
    FfpRefinementStats stats = {0};
    settings.progress = stop_later, settings.interval_s = 1e-6; // asked at every step
    FfpContext *context = ffp_context_new(&settings, &err);
    FfpNeuralField *whole = fit(NULL, 24, NULL);
    FfpNeuralField *part = ffp_fit_neural_field(context, capture, &how, path, &stats, &err);
    if (!part) fail_msg("%s", err.text);
    assert_true(stats.stopped && stats.steps > 0 && stats.steps < 24);
    FfpNeuralField *rest = ffp_fit_neural_field(NULL, capture, &how, path, &stats, &err);
    if (!rest) fail_msg("%s", err.text);
    assert_int_equal(stats.steps, 24);
    assert_memory_equal(whole->parameters, rest->parameters, (size_t)whole->layout.count * sizeof(real));
    how.seed = 2;
    assert_null(ffp_fit_neural_field(NULL, capture, &how, path, &stats, &err));
    assert_non_null(strstr(err.text, "another fit"));
    ffp_neural_field_close(whole), ffp_neural_field_close(part), ffp_neural_field_close(rest);
    ffp_context_free(context);
}

static int left; // steps until it is enough

static bool stop_after(void *user, const FfpProgress *progress) {
    (void)user;
    if (progress->stage && strcmp(progress->stage, "fitting a field") == 0) left--;
    return left > 0;
}

static double told_loss(const char *path) {
    FfpError err = {0};
    char *text;
    size_t size;
    if (!ffp_read_text(path, 1 << 16, &text, &size, &err)) fail_msg("%s", err.text);
    const char *loss = strstr(text, "\"step\": 100,");
    assert_non_null(loss);
    const double value = strtod(strstr(loss, "\"loss\": ") + strlen("\"loss\": "), NULL);
    ffp_free(text);
    return value;
}

// The loss told is the mean of the steps that it is of, and not of a hundred where a fit that went on had
// done some.
static void the_loss_is_of_steps_done(void **state) {
    (void)state;
    FfpError err = {0};
    FfpContextSettings settings = ffp_context_defaults();
    char checkpoint[128], whole[128], rest[128];
    snprintf(checkpoint, sizeof checkpoint, "%s", in_scratch("nearly"));
    snprintf(whole, sizeof whole, "%s", in_scratch("whole.jsonl"));
    snprintf(rest, sizeof rest, "%s", in_scratch("rest.jsonl"));
    FfpRefinement how = {.size = sizeof how, .steps = 100, .seed = 1, .metrics = whole};
    FfpRefinementStats stats = {0};
    ffp_neural_field_close(ffp_fit_neural_field(NULL, capture, &how, NULL, &stats, &err));
    settings.progress = stop_after, settings.interval_s = 1e-6, left = 90;
    FfpContext *context = ffp_context_new(&settings, &err);
    how.metrics = NULL;
    ffp_neural_field_close(ffp_fit_neural_field(context, capture, &how, checkpoint, &stats, &err));
    assert_true(stats.stopped && stats.steps > 70 && stats.steps < 100);
    how.metrics = rest;
    ffp_neural_field_close(ffp_fit_neural_field(NULL, capture, &how, checkpoint, &stats, &err));
    printf("loss of 100 steps %g, of the last %g\n", told_loss(whole), told_loss(rest));
    assert_true(stats.steps == 100 && told_loss(rest) > 0.4 * told_loss(whole));
    ffp_context_free(context);
}

// An evaluation of the file agrees with the fit's report on its pictures.
static void a_saved_field_is_evaluated(void **state) {
    (void)state;
    FfpError err = {0};
    FfpRefinementStats stats = {0};
    FfpNeuralField *field = fit(NULL, STEPS, &stats);
    char path[128];
    snprintf(path, sizeof path, "%s", in_scratch("a.field"));
    if (!ffp_neural_field_save(NULL, field, path, &err)) fail_msg("%s", err.text);
    ffp_neural_field_close(field);
    const char *const captures[] = {in_scratch("capture")};
    FfpEvaluation options = ffp_evaluation_defaults();
    options.captures = captures, options.n_captures = 1, options.field = path;
    int count = 0;
    FfpScore *scores = ffp_evaluate(NULL, &options, &count, &err);
    if (!scores) fail_msg("%s", err.text);
    assert_int_equal(count, 2);
    assert_string_equal(scores[0].protocol, "rendering");
    assert_string_equal(scores[1].protocol, "given");
    assert_true(scores[0].psnr == scores[1].psnr);
    assert_true(fabs(scores[0].psnr - stats.psnr_after) < 0.3); // rounded to 8 bits, densities to bf16
    assert_true(isfinite(scores[0].depth_lit_median) && isfinite(scores[0].albedo_mse));
    ffp_free(scores);
}

static bool stop(void *user, const FfpProgress *progress) {
    (void)user;
    return !progress->stage || strcmp(progress->stage, "fitting a field") != 0;
}

static void cancelled_it_keeps_what_it_has(void **state) {
    (void)state;
    FfpContextSettings settings = ffp_context_defaults();
    FfpError err = {0};
    FfpRefinementStats stats = {0};
    settings.progress = stop;
    FfpContext *context = ffp_context_new(&settings, &err);
    FfpNeuralField *field = fit(context, 1000000, &stats);
    assert_true(stats.stopped && stats.steps < 1000000);
    ffp_neural_field_close(field);
    ffp_context_free(context);
}

static void refuse(const char *path, const char *what) {
    FfpError err = {0};
    assert_null(ffp_neural_field_open(NULL, path, &err));
    if (!strstr(err.text, what) || !strstr(err.text, path)) fail_msg("%s", err.text);
}

static void other_files_are_refused(void **state) {
    (void)state;
    FfpError err = {0};
    char *data;
    size_t size;
    char path[128];
    refuse(in_scratch("absent.field"), "absent");
    snprintf(path, sizeof path, "%s", in_scratch("weights"));
    refuse(path, "not a neural field");
    FfpNeuralField field = ffp_neural_field_new(1);
    snprintf(path, sizeof path, "%s", in_scratch("odd.field"));
    field.parameters[7] = NAN;
    assert_true(ffp_neural_field_write(&field, path, &err));
    refuse(path, "parameters");
    field.parameters[7] = 0, field.radius = -1;
    assert_true(ffp_neural_field_write(&field, path, &err));
    refuse(path, "place");
    field.radius = 1, field.density[3] = -1;
    assert_true(ffp_neural_field_write(&field, path, &err));
    refuse(path, "density");
    ffp_neural_field_free(&field);
    assert_true(ffp_read_file(path, (size_t)1 << 28, &data, &size, &err));
    assert_true(ffp_write_file(path, data, size / 2, &err));
    refuse(path, "");
    ffp_free(data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter_and_steps_do), cmocka_unit_test(it_goes_on_from_a_checkpoint),
        cmocka_unit_test(the_loss_is_of_steps_done),          cmocka_unit_test(a_saved_field_is_evaluated),
        cmocka_unit_test(cancelled_it_keeps_what_it_has),     cmocka_unit_test(other_files_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
