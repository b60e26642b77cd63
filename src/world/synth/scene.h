// Scenes with what only the generator knows of them.
#ifndef FFP_SYNTH_SCENE_H
#define FFP_SYNTH_SCENE_H

#include "world/synth/synth.h"

// As ffp_scene_make; besides, visibility[i] (spec->views + spec->targets images, or NULL) receives for each
// view the share of every pixel's covered samples in no shadow (ffp_simulate_view). The images are the
// caller's to free.
bool ffp_scene_make_lit(FfpCapture *capture, const FfpSceneSpec *spec, FfpImage *visibility, FfpError *err);

#endif
