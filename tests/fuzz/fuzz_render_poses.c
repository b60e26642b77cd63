// Captures in the layout of the paper's generator, render_poses.json.
#include "core/capture/capture.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpCapture capture;
    FfpError err = {0};
    fuzz_verdict(ffp_capture_read(&capture, fuzz_neighbour("render_poses.json", data, size), &err), &err);
    ffp_capture_free(&capture);
    return 0;
}
