// JPEG files: their size, their colours, and how they were held.
#include "core/image/codec.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const FfpEncoded file = {data, size, "fuzz.jpeg"};
    FfpError err = {0};
    int width = 0, height = 0;
    if (!ffp_jpeg_is(&file)) return 0;
    fuzz_verdict(ffp_jpeg_size(&file, &width, &height, &err), &err);
    FfpDecoded decoded = {0};
    fuzz_verdict(ffp_jpeg_decode(&file, &decoded, &err), &err);
    if (decoded.image.data) ffp_orient(&decoded.image, decoded.orientation);
    ffp_image_free(&decoded.image);
    return 0;
}
