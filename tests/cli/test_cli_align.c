// Aligning through the command line only: what it writes, and what it refuses before the work.
#include "cli/program.h"
#include "cli/tiny.h"

#define SIDE 48

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    char folder[128];
    snprintf(folder, sizeof folder, "%s/tiny", scratch);
    tiny_capture(folder, SIDE);
    return 0;
}

// The capture written is like the given one, but for where devices look.
static void test_a_capture_like_the_given_one(void **state) {
    (void)state;
    char path[128];
    FfpCapture given, aligned;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/aligned", scratch, scratch), 0);
    assert_non_null(strstr(run.out, "aligned in"));
    assert_non_null(strstr(run.out, "all views"));
    snprintf(path, sizeof path, "%s/tiny", scratch);
    assert_true(ffp_capture_read(&given, path, NULL));
    snprintf(path, sizeof path, "%s/aligned", scratch);
    assert_true(ffp_capture_read(&aligned, path, NULL));
    assert_int_equal(aligned.n_views, given.n_views);
    assert_int_equal(aligned.n_patterns, given.n_patterns);
    for (int v = 0; v < given.n_views; v++) {
        const FfpView *a = &given.views[v], *b = &aligned.views[v];
        assert_string_equal(a->id, b->id);
        for (int k = 0; k < 3; k++) {
            assert_true(fabsf(a->camera.pose[4 * k + 3] - b->camera.pose[4 * k + 3]) < 1e-3F);
            assert_true(fabsf(a->camera.pose[4 * k + 2] - b->camera.pose[4 * k + 2]) < 0.02F);
        }
        for (int p = 0; p < given.n_patterns; p++)
            for (int i = 0; i < 3 * SIDE * SIDE; i++)
                assert_true(fabsf(a->images[p].data[i] - b->images[p].data[i]) < 0.02F);
    }
    ffp_capture_free(&given);
    ffp_capture_free(&aligned);
    assert_int_equal(
        run_format(&run, "reconstruct %s/aligned -o %s/a.ply --model none --polish 0", scratch, scratch), 0);
}

// Focal lengths change, a little and alike in all views, and are written.
static void test_focal_lengths(void **state) {
    (void)state;
    char path[128];
    FfpCapture given, aligned;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/focal --focal", scratch, scratch), 0);
    snprintf(path, sizeof path, "%s/tiny", scratch);
    assert_true(ffp_capture_read(&given, path, NULL));
    snprintf(path, sizeof path, "%s/focal", scratch);
    assert_true(ffp_capture_read(&aligned, path, NULL));
    const float factor = aligned.views[0].camera.fx / given.views[0].camera.fx;
    printf("%s", run.out);
    assert_true(factor > 0.97F && factor < 1.03F);
    assert_int_equal(factor != 1, strstr(run.out, "focal ") != NULL);
    for (int v = 1; v < given.n_views; v++)
        assert_true(fabsf(aligned.views[v].camera.fx / given.views[v].camera.fx - factor) < 1e-5F);
    ffp_capture_free(&given);
    ffp_capture_free(&aligned);
}

static void test_refusals_come_before_the_work(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/tiny", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "not empty"));
    assert_null(strstr(run.err, "aligning"));
    assert_int_equal(run_format(&run, "align %s/nothing -o %s/new", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "nothing"));
    assert_false(ffp_is_file(in_scratch("new/scene.json")));
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/new --pattern plaid", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "plaid"));
    assert_int_equal(access(in_scratch("new"), F_OK), -1);
    assert_int_equal(run_format(&run, "align %s/tiny", scratch), 2);
    assert_int_equal(run_format(&run, "align -o %s/new", scratch), 2);
    assert_int_equal(run_format(&run, "align --help"), 0);
    assert_non_null(strstr(run.out, "example"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_capture_like_the_given_one),
        cmocka_unit_test(test_focal_lengths),
        cmocka_unit_test(test_refusals_come_before_the_work),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
