// Colour profiles and tags in PNG and JPEG.
#include "core/base/alloc.h"
#include "core/image/profile.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    unsigned char inks[4] = {10, 200, 30, 40};
    FfpImage rgba = ffp_image_new(2, 1, 4), one = ffp_image_new(1, 1, 4);
    FfpColourProfile profile = ffp_profile_find(&(FfpEncoded){data, size, "fuzz"});
    ffp_profile_apply(&profile, &rgba, "fuzz");
    ffp_profile_inks(&profile, inks, true, &one, "fuzz");
    ffp_free(profile.icc);
    ffp_image_free(&rgba);
    ffp_image_free(&one);
    return 0;
}
