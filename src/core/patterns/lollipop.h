#ifndef FFP_PATTERNS_LOLLIPOP_H
#define FFP_PATTERNS_LOLLIPOP_H

#include <stdint.h>
#include "core/image/image.h"

enum {
    FFP_LOLLIPOP_SECTORS = 8,
    FFP_LOLLIPOP_RINGS = 30,
    FFP_LOLLIPOP_FIELDS = FFP_LOLLIPOP_SECTORS * FFP_LOLLIPOP_RINGS
};

// The field (ring * 8 + sector) of each pixel, FFP_LOLLIPOP_FIELDS for the black outside; width*height, to be
// ffp_free()d.
uint8_t *ffp_lollipop_map(int width, int height);
// Fills the map's fields with random 8-bit colours.
FfpImage ffp_lollipop_paint(const uint8_t *map, int width, int height, uint64_t seed);
// Both: 8 sectors x 30 rings of random colours, black outside; encoded 8-bit values / 255 decoded to linear.
FfpImage ffp_lollipop_pattern(int width, int height, uint64_t seed);

#endif
