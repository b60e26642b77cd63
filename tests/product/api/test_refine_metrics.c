// A metrics file that cannot be written is an error of its own, and leaves the Gaussians as they were.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"
#include "ffprocams/lab.h"
#include "support.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"

static FfpCapture *capture;
static FfpGaussians *gaussians;

static int setup(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpReconstruction how = {.size = sizeof how};
    capture = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    gaussians = capture ? ffp_reconstruct(NULL, capture, &how, NULL, &err) : NULL;
    return gaussians ? 0 : -1;
}

static int teardown(void **state) {
    (void)state;
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return 0;
}

static void refuse(const char *metrics) {
    FfpError err = {0};
    const FfpRefinement how = {.size = sizeof how, .steps = 8, .metrics = metrics};
    FfpGaussians before = ffp_gaussians_copy(gaussians);
    assert_false(ffp_refine_gaussians(NULL, gaussians, capture, &how, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_IO);
    assert_non_null(strstr(err.text, metrics));
    assert_int_equal(gaussians->count, before.count);
    assert_memory_equal(gaussians->centre, before.centre, 3 * (size_t)before.count * sizeof(real));
    assert_memory_equal(gaussians->scale, before.scale, 3 * (size_t)before.count * sizeof(real));
    ffp_gaussians_free(&before);
    assert_null(ffp_fit_from_scratch(NULL, capture, NULL, &how, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_IO);
}

static void a_full_disk(void **state) {
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    refuse("/dev/full");
}

static void no_such_folder(void **state) {
    (void)state;
    refuse("no/such/folder/m.json");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_full_disk), cmocka_unit_test(no_such_folder)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
