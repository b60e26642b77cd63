// Calibrations in one file: OpenCV's layouts in YAML, XML and JSON, camera_config.json, GS-ProCams' lists.
#include "fuzz.h"
#include "rig/optics/calibration.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *files[1] = {fuzz_file(data, size)};
    FfpCalibration calibration;
    FfpError err = {0};
    fuzz_verdict(ffp_calibration_read(&calibration, files, 1, "calib", &err), &err);
    ffp_calibration_free(&calibration);
    return 0;
}
