// The folder that `patterns` wrote, as the list of what a rig was photographed under.
#ifndef FFP_PATTERNS_SHOWN_H
#define FFP_PATTERNS_SHOWN_H

#include <string.h>
#include "core/base/arena.h"
#include "core/base/error.h"

typedef struct FfpShownPattern {
    int number;       // of the file's name
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

// Reads names and sizes, not pictures, of every <number>_<name>.png but the focus chart. Errors name the
// folder or the picture: no such pictures, a number that comes twice, pictures of two sizes.
bool ffp_shown_list(FfpShown *shown, const char *folder, FfpError *err);
// The same of all that `patterns` wrote. Errors, too: a number that is missing, black and white that are not
// the first two, Gray codes of another panel, incomplete or out of order.
bool ffp_shown_read(FfpShown *shown, const char *folder, FfpError *err);
static inline bool ffp_shown_is_code(const FfpShown *shown, int pattern) {
    return strncmp(shown->patterns[pattern].name, "gray_", 5) == 0;
}
// The patterns that are photographed: everything, everything but the Gray codes, or these with black and
// white alone.
typedef enum FfpShownKind { FFP_SHOWN_ALL, FFP_SHOWN_PLAIN, FFP_SHOWN_CODES, FFP_SHOWN_KINDS } FfpShownKind;
// The first *plain patterns, and all of the codes or none (*codes: how many). False: there is no such kind,
// or it is one of those before.
bool ffp_shown_photographed(const FfpShown *shown, FfpShownKind kind, int *plain, int *codes);
void ffp_shown_free(FfpShown *shown);

#endif
