// A picture's description of its colours: an ICC profile (PNG, JPEG, TIFF, WebP), or a PNG's cICP, or its
// gAMA and cHRM, or otherwise Adobe RGB by EXIF; converted to sRGB by Little CMS.
#ifndef FFP_IMAGE_PROFILE_H
#define FFP_IMAGE_PROFILE_H

#include "core/image/codec.h"

#define FFP_PROFILE_MAX ((size_t)1 << 24) // bytes

// That of a picture in memory, of a TIFF only by EXIF; of others, of those without and of PNGs tagged as sRGB
// it is FFP_PROFILE_NONE. Bytes are released with ffp_free. A profile that cannot be parsed counts as none.
FfpColourProfile ffp_profile_find(const FfpEncoded *file);
// A copy of ICC bytes of another origin.
FfpColourProfile ffp_profile_of_icc(const void *bytes, size_t size);
// True if colours stay as they are, within a level of 8 bits.
bool ffp_profile_is_srgb(const FfpColourProfile *profile);
// Converts RGBA of [0,1] in place, relative to white, clipped to [0,1]; alpha stays. A note says from what,
// or why not: a profile that cannot be read, or of other colours than the picture's.
void ffp_profile_apply(const FfpColourProfile *profile, FfpImage *rgba, const char *path);
// The colours of inks (C M Y K, 255 all ink, or `inverted`), [height, width, 4]. False without a profile of
// inks.
bool ffp_profile_inks(const FfpColourProfile *profile, const unsigned char *inks, bool inverted,
                      FfpImage *rgba, const char *path);

#endif
