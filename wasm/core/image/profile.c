// The page has no Little CMS: browsers convert the pictures that they decode.
#include "core/image/profile.h"
#include "core/base/log.h"

bool ffp_profile_is_srgb(const FfpColourProfile *profile) {
    return profile->kind == FFP_PROFILE_NONE;
}

void ffp_profile_apply(const FfpColourProfile *profile, FfpImage *rgba, const char *path) {
    (void)rgba;
    if (profile->kind != FFP_PROFILE_NONE) ffp_note("%s: its colour profile is ignored", path);
}

bool ffp_profile_inks(const FfpColourProfile *profile, const unsigned char *inks, bool inverted,
                      FfpImage *rgba, const char *path) {
    (void)profile, (void)inks, (void)inverted, (void)rgba, (void)path;
    return false;
}
