// Which file shows which view under which pattern.
#ifndef FFP_RIG_PICTURES_H
#define FFP_RIG_PICTURES_H

#include "base/arena.h"
#include "rig/calibration.h"

typedef struct FfpShotPattern {
    char name[FFP_NAME_MAX];
    const char *file; // what was projected; NULL: black or white
    bool novel;
} FfpShotPattern;

typedef struct FfpShots {
    FfpArena *arena; // owns all strings and lists
    int n_patterns, black, white;
    FfpShotPattern *patterns; // [FFP_PATTERNS_MAX]
    const char **pictures;    // [n_stops, FFP_PATTERNS_MAX]; NULL: none
    const char **masks;       // [n_stops]; NULL: there are no mask files
} FfpShots;

// Resolves --images, --pattern, --held-out and --mask (ffprocams.h, FfpImport) for the calibration's stops.
// Each picture is known to exist afterwards; black and white are there, and every other pattern has its file.
bool ffp_shots_find(FfpShots *shots, const FfpImport *options, const FfpCalibration *calibration,
                    FfpError *err);
void ffp_shots_free(FfpShots *shots);

// Whether a comes before b when runs of digits count as numbers: "img_9" before "img_10".
int ffp_natural_order(const char *a, const char *b);

#endif
