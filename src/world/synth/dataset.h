// Generated captures on disk.
#ifndef FFP_SYNTH_DATASET_H
#define FFP_SYNTH_DATASET_H

#include <stdbool.h>
#include <stdint.h>
#include "world/synth/synth.h"

// How many scenes a split has: every mesh of it under every material. split NULL: all splits' meshes.
int64_t ffp_dataset_size(const char *split); // 0: no such split
// Mesh, material and seed of scene `index` in 0 .. ffp_dataset_size()-1, in a fixed order: scene i has mesh i
// % M of the split's M meshes, and material (i / M + 7 * (i % M)) % K of the K materials. So every run of M
// scenes shows all meshes, nearly all materials, and no pair comes twice. The rest of the spec stays as it
// is.
void ffp_dataset_scene(const char *split, int64_t index, uint64_t seed, FfpSceneSpec *spec);

typedef enum FfpDatasetPreset {
    FFP_DATASET_PAPER,   // 6 lollipops, 6 new poses, 16 samples a pixel
    FFP_DATASET_SMOKE,   // small, quick
    FFP_DATASET_TRAINING // what the trainer makes by default
} FfpDatasetPreset;

typedef struct FfpDatasetSettings {
    const char *folder; // one capture folder a scene goes here
    const char *split;  // "train", "validation", "test"; NULL: all
    FfpDatasetPreset preset;
    int64_t first, count; // scenes of the split; count -1: to the end, or one with `mesh`
    int resolution;       // image side; 0: as the preset says
    FfpSceneRig rig;
    int views; // input views, 1..360; 0: as the preset says
    uint64_t seed;
    const char *mesh;      // a user's file instead of the generated meshes; NULL: none
    const char *material;  // a user's folder instead of the generated materials; NULL: none
    const char *materials; // or a folder of pictures, each of them a material (picture_folder.h)
    const char *
        patterns; // folder of pictures in place of all lollipops but the first (picture_folder.h); NULL: none
    FfpSensor sensor;
    const char *photographs; // folder of patterns: one object before a bare rig (photographs.h); NULL: scenes
    int attitudes;           // of its chessboard
    const char *only;        // one of the folders of its photographs; NULL: all
    bool room;               // the rig stands in a room (photographs.h), with photographs only
    int quality;             // of the room's JPEG files
    bool other_projector;    // of a bare rig, with photographs only
} FfpDatasetSettings;

// Scenes that exist already are kept; one appears under its name only when it is whole. Of several ranks
// (the context's) each makes those whose turn it is.
bool ffp_dataset_write(const FfpDatasetSettings *settings, FfpError *err);
// Checks that all of them exist; the error names those that do not.
bool ffp_dataset_check(const FfpDatasetSettings *settings, FfpError *err);

#endif
