// Generated captures on disk, behind `ffprocams generate` (ffp_generate in ffprocams.h).
#ifndef FFP_SYNTH_DATASET_H
#define FFP_SYNTH_DATASET_H

#include <stdbool.h>
#include <stdint.h>
#include "synth/synth.h"

// How many scenes a split has: every mesh of it under every material. split NULL: all splits' meshes.
int64_t ffp_dataset_size(const char *split); // 0: no such split
// Mesh, material and seed of scene `index` in 0 .. ffp_dataset_size()-1, in a fixed order: scene i has mesh i
// % M of the split's M meshes, and material (i / M + 7 * (i % M)) % K of the K materials. So every run of M
// scenes shows all meshes, nearly all materials, and no pair comes twice. The rest of the spec stays as it
// is.
void ffp_dataset_scene(const char *split, int64_t index, uint64_t seed, FfpSceneSpec *spec);

#endif
