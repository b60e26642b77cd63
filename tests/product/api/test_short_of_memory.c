// Compensation on a machine that is short of memory: coarser edges with a note, or an error before the work.
#include "engine/pipeline/need.h"
#include "engine/pipeline/relight.h"
#include "initialised.h"
#include "short_of_memory.h"

static char said[512];

static void keep_text(void *user, FfpLogLevel level, const char *text) {
    (void)user, (void)level;
    if (strstr(text, "memory")) snprintf(said, sizeof said, "%s", text);
}

// Leaves `share` of what the picture of one view takes at the camera's pixels.
static void leave_share(double share) {
    char kilobytes[16];
    const FfpView *view = &capture->views[0];
    const double bytes = ffp_compensation_bytes((double)ffp_gaussians_arrays(gaussians).count, &view, 1,
                                                ffp_drawing_settings((FfpDrawing){0}, NULL).samples);
    snprintf(kilobytes, sizeof kilobytes, "%.0f", share * bytes / 1024);
    leave_memory(kilobytes);
}

static bool compensate(const char *pattern, FfpError *err) {
    const char *id = ffp_capture_view_id(capture, 0), *target = in_scratch("target.png");
    FfpContextSettings settings = ffp_context_defaults();
    settings.log = keep_text;
    FfpContext *context = ffp_context_new(&settings, err);
    const FfpCompensation how = {.size = sizeof how,
                                 .views = &id,
                                 .n_views = 1,
                                 .targets = &target,
                                 .n_targets = 1,
                                 .paint = true,
                                 .steps = 2,
                                 .pattern = pattern};
    said[0] = 0;
    const bool ok = ffp_compensate(context, gaussians, capture, &how, NULL, err);
    ffp_context_free(context);
    return ok;
}

static FfpImage solved(const char *name, const char *text) {
    FfpError err = {0};
    FfpImage pattern = {0};
    if (!compensate(in_scratch(name), &err)) fail_msg("%s", err.text);
    if (!strstr(said, text) || (!*text && *said)) fail_msg("'%s' does not say '%s'", said, text);
    if (!ffp_image_read(&pattern, in_scratch(name), FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    return pattern;
}

static bool same(const FfpImage *a, const FfpImage *b) {
    assert_true(a->width == b->width && a->height == b->height && a->channels == b->channels);
    return memcmp(a->data, b->data, sizeof(real) * (size_t)(a->width * a->height * a->channels)) == 0;
}

static void edges_are_coarser_where_memory_is_short(void **state) {
    (void)state;
    FfpError err = {0};
    FfpImage target = ffp_image_new(SMALL_SIDE, SMALL_SIDE, 3);
    for (int i = 0; i < 3 * SMALL_SIDE * SMALL_SIDE; i++)
        target.data[i] = i / 3 % SMALL_SIDE < SMALL_SIDE / 2;
    assert_true(ffp_image_write_png(&target, in_scratch("target.png"), &err));
    FfpImage whole = solved("whole.png", "");
    leave_share(5);
    FfpImage twice = solved("twice.png", "edges are made at 2 instead of");
    leave_share(2);
    FfpImage once = solved("once.png", "edges are made at 1 instead of");
    meminfo = NULL;
    assert_true(!same(&whole, &twice) && !same(&twice, &once));
    ffp_image_free(&target), ffp_image_free(&whole), ffp_image_free(&twice), ffp_image_free(&once);
}

static void too_little_is_an_error_before_the_work(void **state) {
    (void)state;
    FfpError err = {0};
    leave_share(0.9);
    assert_false(compensate(in_scratch("none.png"), &err));
    meminfo = NULL;
    assert_int_equal(err.code, FFP_ERROR_MEMORY);
    assert_non_null(strstr(err.text, "use fewer views or a smaller camera picture"));
    assert_int_equal(access(in_scratch("none.png"), F_OK), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(edges_are_coarser_where_memory_is_short),
                                       cmocka_unit_test(too_little_is_an_error_before_the_work)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
