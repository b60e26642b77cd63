// nepmap's transforms.json, with pictures beside it.
#include "fuzz.h"
#include "rig/optics/calibration.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *files[1] = {fuzz_neighbour("transforms.json", data, size)};
    FfpCalibration calibration;
    FfpError err = {0};
    fuzz_verdict(ffp_calibration_read(&calibration, files, 1, "calib", &err), &err);
    ffp_calibration_free(&calibration);
    return 0;
}
