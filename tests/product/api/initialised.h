// small.h's capture and the classical initialisation's Gaussians of it, for tests of what is done with them.
#ifndef FFP_TESTS_INITIALISED_H
#define FFP_TESTS_INITIALISED_H

#include "small.h"

static FfpCapture *capture;
static FfpGaussians *gaussians;

static int setup(void **state) {
    FfpError err = {0};
    if (small_setup(state) != 0) return -1;
    capture = ffp_capture_open(NULL, in_scratch("capture"), NULL, &err);
    const FfpReconstruction how = {.size = sizeof how};
    gaussians = capture ? ffp_reconstruct(NULL, capture, &how, NULL, &err) : NULL;
    if (!gaussians) fprintf(stderr, "%s\n", err.text);
    return gaussians ? 0 : -1;
}

static int teardown(void **state) {
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return scratch_teardown(state);
}

#endif
