// Photographs of a bare rig (bare_rig.h) as its owner would take them: of an object on the turntable under
// every pattern, and of a chessboard for the calibration.
#ifndef FFP_SYNTH_PHOTOGRAPHS_H
#define FFP_SYNTH_PHOTOGRAPHS_H

#include "world/synth/synth.h"

typedef struct FfpPhotographs {
    const char *folder;   // new or empty
    const char *patterns; // folder of <number>_<name>.png
    int attitudes;        // of the board
    const char *only;     // one of the folders below; NULL: all
} FfpPhotographs;

// Written are <number>.png, 8-bit sRGB, of the same numbers as the patterns':
//   view-DDD/       the object turned by DDD degrees, one of spec->views, under all patterns but those called
//                   focus
//   empty/          nothing, under all patterns but focus and Gray codes: darkness and noise
//   masks/          view-DDD.png: what of each pixel the object fills there
//   attitude-NN/    the board held before the devices, under black, white and Gray codes
//   turntable/      00.png and so on: the board on the turntable under white, at each of truth.json's
//                   board_angles
//   truth.json      the rig as it is: calibration and turntable as `import` reads both, board, attitudes.
//                   Lengths in millimetres
// Whole or not at all. Pictures are spec->resolution high and 4/3 as wide. Of the sensor, errors of poses are
// refused: no pose is written. Errors name the pattern's
// file, or `only` that is none of them.
bool ffp_photographs_write(const FfpPhotographs *options, const FfpSceneSpec *spec, FfpError *err);

#endif
