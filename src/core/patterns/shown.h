// The folder that `patterns` wrote, as the list of what a rig was photographed under.
#ifndef FFP_PATTERNS_SHOWN_H
#define FFP_PATTERNS_SHOWN_H

#include "core/base/arena.h"
#include "core/base/error.h"

typedef struct FfpShownPattern {
    const char *name; // "lollipop_0"
    const char *file; // path of the picture that the projector showed
} FfpShownPattern;

typedef struct FfpShown {
    FfpArena *arena; // owns strings and lists
    const char *folder;
    int width, height;         // of the panel, pixels
    int n, n_codes;            // patterns that are photographed; of these, Gray codes, which come last
    FfpShownPattern *patterns; // [n] in the order in which they are shown: black, white, the others, codes
} FfpShown;

// Reads names and sizes, not pictures. The focus chart is passed over. Errors name the folder or the picture:
// no pictures called <number>_<name>.png, a number that is missing or comes twice, black and white that are
// not the first two, pictures of two sizes, Gray codes of another panel, incomplete or out of order.
bool ffp_shown_read(FfpShown *shown, const char *folder, FfpError *err);
void ffp_shown_free(FfpShown *shown);

#endif
