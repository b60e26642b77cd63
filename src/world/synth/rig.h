// Where cameras and projectors stand.
#ifndef FFP_SYNTH_RIG_H
#define FFP_SYNTH_RIG_H

#include "core/capture/capture.h"
#include "world/synth/synth.h"

typedef struct FfpRigLight {
    float intensity[3], ambient;
} FfpRigLight;

// Light levels of the spec: the default rig's, or jittered from its seed.
FfpRigLight ffp_rig_light(const FfpSceneSpec *spec);
// Poses, intrinsics and id of input view `index` of spec->views, and of target `index`: a new direction every
// time.
void ffp_rig_input(const FfpSceneSpec *spec, int index, FfpView *view);
void ffp_rig_target(const FfpSceneSpec *spec, int index, FfpView *view);

// The pose of a device at (radius, polar, azimuth in degrees) that looks at `aim`, its image upright (z up).
void ffp_rig_place(FfpCamera *camera, double radius, double polar, double azimuth, const double aim[3]);

#endif
