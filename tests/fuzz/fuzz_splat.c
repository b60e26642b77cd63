// Splats in rows of 32 bytes.
#include "core/gaussians/elsewhere.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpGaussians gaussians;
    FfpError err = {0};
    fuzz_verdict(ffp_gaussians_read_splat(&gaussians, fuzz_file(data, size), &err), &err);
    ffp_gaussians_free(&gaussians);
    return 0;
}
