// Materials: solid textures that give albedo, roughness and bump at every point of space.
#ifndef FFP_SYNTH_MATERIAL_H
#define FFP_SYNTH_MATERIAL_H

#include <stdint.h>

#define FFP_PALETTE 5

// One material with its colours and sizes drawn. Read-only while rendering.
typedef struct FfpMaterial {
    const struct FfpMaterialKind *kind; // looks.h
    uint32_t seed;
    float colour[FFP_PALETTE][3]; // linear albedo
    float rough[2];               // the roughness range that the look moves in
    float scale;                  // features a unit length, relative to the kind's own
    float bump;                   // relief height
    float vary[4];                // kind-specific random numbers in [0, 1)
    float axes[9];                // rows: the texture's frame in the world
} FfpMaterial;

// Material number `material` of ffp_material_count() in the colours of `seed`.
FfpMaterial ffp_material_make(int material, uint64_t seed);
// Linear albedo in [0.02, 0.95] and roughness in [0.15, 0.95] at world point p.
void ffp_material_look(const FfpMaterial *material, const float p[3], float albedo[3], float *roughness);
// Bends the unit normal at p by the gradient of the relief. Unchanged where the material is smooth.
void ffp_material_bump(const FfpMaterial *material, const float p[3], float normal[3]);

#endif
