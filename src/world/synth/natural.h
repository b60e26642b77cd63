// Patterns as a show or a lecture would project them. Only scenes of the test split have them, and training
// never sees one: they tell whether a reconstruction can be relit with pictures unlike those it was made
// from.
#ifndef FFP_SYNTH_NATURAL_H
#define FFP_SYNTH_NATURAL_H

#include <stdint.h>
#include "core/image/image.h"

enum { FFP_NATURAL_KINDS = 5 };

// Natural pattern `index` >= 0 of a scene: the kinds in turn, each a pure function of size, kind, index and
// seed. 8-bit sRGB values decoded to linear. [height, width, 3]
FfpImage ffp_natural_pattern(int width, int height, int index, uint64_t seed);
const char *ffp_natural_name(int index); // of its kind: "gradient", "text", "photograph", "clock", "map"

#endif
