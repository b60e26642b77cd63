// A training run's state on a device: the weights with their moments and averages, and the scenes in use.
#ifndef FFP_TRAIN_MIRROR_H
#define FFP_TRAIN_MIRROR_H

#include "lab/train/train.h"

// The data that a step needs from a scene made while the device was offered, on the device in use.
void ffp_scene_upload(FfpScene *there, const FfpScene *scene);
void ffp_scene_upload_free(FfpScene *there); // safe on {0}

typedef struct FfpMirror {
    FfpModel model; // values on the device, all else the original's
    FfpAdam adam;
    FfpScene *scenes; // [pool] {0}: not uploaded yet
} FfpMirror;

// All of these by a thread that works on the device.
FfpMirror *ffp_mirror_new(const FfpModel *model, const FfpAdam *adam, const FfpTrainConfig *config);
void ffp_mirror_free(FfpMirror *mirror, const FfpTrainConfig *config); // NULL is allowed
// The scene of slot `slot` on the device, uploaded if it is `fresh`.
const FfpScene *ffp_mirror_scene(FfpMirror *mirror, int slot, bool fresh, const FfpScene *scene);
// Copies weights, moments, averages and the step back to the host.
void ffp_mirror_download(const FfpMirror *mirror, FfpModel *model, FfpAdam *adam);

#endif
