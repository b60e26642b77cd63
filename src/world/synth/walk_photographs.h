// Photographs of a whole scene (walk.h) as somebody would take them who walks around with a camera, with the
// truth.
#ifndef FFP_SYNTH_WALK_PHOTOGRAPHS_H
#define FFP_SYNTH_WALK_PHOTOGRAPHS_H

#include "world/synth/synth.h"

// Written into a new or empty folder are, `patterns` being what is shown (core/patterns/shown.h):
//   place-NN/  one of spec->views places of the camera under all patterns, <number>.png, 8-bit sRGB; lenses
//              distort, principal points lie beside the middle
//   colmap/    the devices as they are, as `import` reads them, in metres; the projector is calib.jpg
// Whole or not at all. Pictures are spec->resolution high and 4/3 as wide. Errors: of
// the patterns' folder; poses' errors, since no pose is written; a resolution out of range.
bool ffp_walk_photographs_write(const char *folder, const char *patterns, const FfpSceneSpec *spec,
                                FfpError *err);

#endif
