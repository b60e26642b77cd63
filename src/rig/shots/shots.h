// Which file shows which view under which pattern.
#ifndef FFP_SHOTS_SHOTS_H
#define FFP_SHOTS_SHOTS_H

#include "core/base/arena.h"
#include "core/patterns/shown.h"
#include "ffprocams.h" // options, types alone
#include "rig/optics/calibration.h"

typedef struct FfpShotPattern {
    char name[FFP_NAME_MAX];
    const char *file; // what was projected; NULL for black, white and Gray codes
    int code;         // the Gray code with this number, from 1 (graycode.h); 0: none
    bool novel;
} FfpShotPattern;

typedef struct FfpShots {
    FfpArena *arena; // owns all strings and lists but those of `shown`
    int n_patterns, black, white;
    FfpShotPattern *patterns; // [FFP_PATTERNS_MAX]
    const char **pictures;    // [n_stops, FFP_PATTERNS_MAX]; NULL: none, or made from the codes (graycode.h)
    const char **masks;       // [n_stops]; NULL: there are no mask files
    const char **empty;       // as pictures, of the stage without the object; NULL: there are none
    const char **codes;       // [n_stops, n_codes] photographs of Gray codes; NULL: there are none
    int n_codes, others;      // patterns whose photographs may be among the codes'
    const char **greys;       // [n_stops, n_greys] photographs of even greys
    int n_greys, *grey;       // [n_greys] the greys' values, 1 to 254
    FfpShown shown;           // empty where the sources name none
} FfpShots;

// Finds all files for the calibration's stops. Afterwards each picture is known to exist, and so are black
// and white, unless there are Gray codes, and the file of every other pattern.
bool ffp_shots_find(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                    FfpError *err);
// The photographs of the Gray codes of a panel of this size, where the sources name them. Where they name no
// pattern besides black and white, or only some that are held out, one of the codes becomes the pattern: of
// columns or of rows (axis 0, 1).
bool ffp_shots_find_codes(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                          int width, int height, int axis, FfpError *err);
// A view's photograph under white, or another that was taken with it where nobody photographed white.
const char *ffp_shots_white(const FfpShots *shots, int stop);
void ffp_shots_free(FfpShots *shots);

#endif
