// Code shared by all sources of scenes.
#ifndef FFP_TRAIN_PREPARE_H
#define FFP_TRAIN_PREPARE_H

#include "lab/train/train.h"

// Completes a scene whose normalised captures exist: matches the input views. Closes it on failure.
bool ffp_scene_match(FfpScene *scene, const FfpTrainConfig *config, FfpError *err);
// Moves the views of `more` behind those of `capture`, whose patterns are the first ones of `more`.
void ffp_scene_append_views(FfpCapture *capture, FfpCapture *more);
// Keeps only the chosen patterns, in that order; black is the first, white the second.
void ffp_scene_keep_patterns(FfpCapture *capture, const int *chosen, int count);

#endif
