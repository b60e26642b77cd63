// A fit without a prediction through the public header: it can be left while its points are still drawn.
#include <string.h>
#include "ffprocams/lab.h"
#include "small.h"

typedef struct Caller {
    int asked; // while points were drawn
    int64_t total;
} Caller;

static bool stop_at_the_points(void *user, const FfpProgress *progress) {
    Caller *caller = user;
    if (!progress->stage || strcmp(progress->stage, "drawing points") != 0) return true;
    caller->asked++, caller->total = progress->total;
    return false;
}

static void left_while_points_are_drawn(void **state) {
    (void)state;
    FfpError err = {0};
    Caller caller = {0};
    FfpContextSettings settings = ffp_context_defaults();
    settings.user = &caller, settings.progress = stop_at_the_points;
    FfpContext *context = ffp_context_new(&settings, &err);
    FfpCapture *capture = ffp_capture_open(NULL, in_scratch("capture"), NULL, &err);
    assert_non_null(context);
    assert_non_null(capture);
    const FfpRefinement how = {.size = sizeof how, .steps = 1};
    assert_null(ffp_fit_from_scratch(context, capture, NULL, &how, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_CANCELLED);
    assert_true(caller.asked == 1 && caller.total == 20000);
    ffp_capture_close(capture);
    ffp_context_free(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(left_while_points_are_drawn)};
    return cmocka_run_group_tests(tests, small_setup, scratch_teardown);
}
