// COLMAP's cameras.txt and images.txt, in one input with a line "----" between them.
#define _GNU_SOURCE // memmem
#include <string.h>
#include "fuzz.h"
#include "rig/optics/calibration.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char line[] = "----\n";
    const size_t length = sizeof line - 1;
    const uint8_t *middle = size > 0 ? memmem(data, size, line, length) : NULL;
    if (!middle) return 0;
    const size_t before = (size_t)(middle - data);
    fuzz_neighbour("images.txt", middle + length, size - before - length);
    const char *files[1] = {fuzz_neighbour("cameras.txt", data, before)};
    FfpCalibration calibration;
    FfpError err = {0};
    fuzz_verdict(ffp_calibration_read(&calibration, files, 1, "calib", &err), &err);
    ffp_calibration_free(&calibration);
    return 0;
}
