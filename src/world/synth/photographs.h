// Photographs of a rig as its owner would take them, of an object on the turntable under every pattern and of
// a chessboard for the calibration: with nothing around (bare_rig.h), or in a real room (room.h).
#ifndef FFP_SYNTH_PHOTOGRAPHS_H
#define FFP_SYNTH_PHOTOGRAPHS_H

#include "world/synth/synth.h"

typedef struct FfpPhotographs {
    const char *folder;   // new or empty
    const char *patterns; // what is shown (core/patterns/shown.h)
    int attitudes;        // of the board, which is photographed if there are Gray codes
    const char *only;     // one of the folders below; NULL: all
    bool room;            // in the room that `seed` draws
    uint64_t seed;
    int quality;          // of JPEG files, 1 to 100
    bool other_projector; // of a bare rig (ffp_bare_rig_exchange)
} FfpPhotographs;

// Written are <number>.png, 8-bit sRGB, or <number>.JPG in a room, of the same numbers as the patterns':
//   view-DDD/       the object turned by DDD degrees, one of spec->views stops, under all patterns
//   empty/          the stage without it, under all patterns but Gray codes
//   masks/          view-DDD.png: what of each pixel the object fills there
//   attitude-NN/    the board held before the devices, under black, white and Gray codes
//   turntable/      00.png and so on: the board on the turntable under white, at each of truth.json's
//                   board_angles
//   truth.json      the rig as it is: calibration and turntable as `import` reads both, board, attitudes.
//                   Lengths in millimetres
// and in a room, whose faults those of spec->sensor replace that are set:
//   view-022/, view-157/ two turns between the stops, without Gray codes
//   held-out/       photograph.png and map.png, which are shown besides the patterns, and in folders view-DDD
//                   the object under them
//   truth/          the photographs of the object, those that are held out, too, without noise and JPEG, but
//                   not of Gray codes
// Whole or not at all. Pictures are spec->resolution high and 4/3 as wide. Errors: of the patterns' folder;
// `only` that is none of them; poses' errors, since no pose is written; numbers out of range.
bool ffp_photographs_write(const FfpPhotographs *options, const FfpSceneSpec *spec, FfpError *err);
// Checks the demands of all photographs on a scene: a sensor without poses' errors, a resolution that is in
// range.
bool ffp_photographs_check(const FfpSceneSpec *spec, FfpError *err);

#endif
