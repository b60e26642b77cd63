// Photographs in a real room (room.h) as somebody would take them who reconstructs an object, with the truth.
#ifndef FFP_SYNTH_ROOM_PHOTOGRAPHS_H
#define FFP_SYNTH_ROOM_PHOTOGRAPHS_H

#include "world/synth/synth.h"

typedef struct FfpRoomPhotographs {
    const char *folder;   // new or empty
    const char *patterns; // folder of <number>_<name>.png, black and white among them (pattern_folder.h)
    uint64_t seed;        // of the room
    int attitudes;        // of the board
    int quality;          // of the JPEG files, 1 to 100
} FfpRoomPhotographs;

// Written are, VIEW being each of spec->views stops (000 and so on, degrees) and new22 and new157 between
// them, NAME a pattern's name without its number:
//   photographs/VIEW/NAME.JPG   by camera and projector with the room's faults; those that spec->sensor sets
//                               take their place
//   empty/NAME.JPG              the stage without the object
//   graycode/VIEW/              the patterns that are called gray_, at the stops alone
//   truth/VIEW/NAME.png         the photographs without noise and JPEG
//   masks/VIEW.png              the object's share of each pixel
//   patterns/NAME.png           what was sent to the projector, in folders likewise; "photograph" and "map"
//                               are drawn here, and are held out: the empty stage lacks them
//   attitude-NN/, turntable/    as in photographs.h, NNN.JPG and NN.JPG, if there are Gray codes
//   calibration.xml, axis.json  as they are, as `import` reads them, in millimetres; true_... the same
// Whole or not at all. Pictures are spec->resolution high and 4/3 as wide. Errors: sensor, resolution,
// attitudes or quality out of range, and as ffp_pattern_folder_open's.
bool ffp_room_photographs_write(const FfpRoomPhotographs *options, const FfpSceneSpec *spec, FfpError *err);

#endif
