// The pictures that a projector shows while somebody photographs: a folder of `patterns`.
#ifndef FFP_SYNTH_PATTERN_FOLDER_H
#define FFP_SYNTH_PATTERN_FOLDER_H

#include "core/base/file.h"
#include "core/image/image.h"
#include "world/synth/synth.h"

typedef struct FfpNumbered {
    int number;
    char file[256], name[256]; // "002_black.png", "black"
} FfpNumbered;

typedef struct FfpPatternFolder {
    const char *folder;
    int count, width, height; // width, height: of every pattern, pixels
    FfpNumbered *list;        // [count] by their numbers
} FfpPatternFolder;

// Every <number>_<name>.png but those called focus; at most FFP_PATTERNS_MAX. Errors name the file: none,
// equal numbers, sizes that differ or are below 64 pixels a side. To be closed if it is true.
bool ffp_pattern_folder_open(FfpPatternFolder *patterns, const char *folder, FfpError *err);
void ffp_pattern_folder_close(FfpPatternFolder *patterns);
// The file of pattern `index`.
bool ffp_pattern_folder_path(const FfpPatternFolder *patterns, int index, char path[FFP_PATH_MAX],
                             FfpError *err);
// What a projector with these faults sends out for it, linear; a new image.
bool ffp_pattern_folder_emit(const FfpPatternFolder *patterns, int index, const FfpSensor *sensor,
                             FfpImage *emitted, FfpError *err);
// The same for a file anywhere.
bool ffp_pattern_emit(const char *path, const FfpSensor *sensor, FfpImage *emitted, FfpError *err);

#endif
