// EXR files: their size, their colours, and the raw numbers of depth maps.
#include "core/image/codec.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const FfpEncoded file = {data, size, "fuzz.exr"};
    FfpError err = {0};
    int width = 0, height = 0;
    if (!ffp_exr_is(&file)) return 0;
    fuzz_verdict(ffp_exr_size(&file, &width, &height, &err), &err);
    FfpDecoded decoded = {0};
    fuzz_verdict(ffp_exr_decode(&file, &decoded, &err), &err);
    ffp_image_free(&decoded.image);
    FfpDecoded raw = {0};
    fuzz_verdict(ffp_exr_decode_raw(&file, &raw, &err), &err);
    ffp_image_free(&raw.image);
    return 0;
}
