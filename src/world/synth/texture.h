// A user's material: maps in a folder, laid on a mesh by its texture coordinates or, where it has none, from
// three sides.
#ifndef FFP_SYNTH_TEXTURE_H
#define FFP_SYNTH_TEXTURE_H

#include "core/base/error.h"
#include "world/synth/trace.h"

typedef struct FfpTextures FfpTextures;

// Finds the maps in `folder` by the words of their names (docs/reference/formats.md): a base colour, which
// must be there, roughness and normals. A metallic map is not used, with a warning: the light model knows
// dielectrics only. NULL with an error.
FfpTextures *ffp_textures_read(const char *folder, FfpError *err);
void ffp_textures_free(FfpTextures *textures); // NULL is allowed

// Linear albedo in [0, 1] and roughness in [0.05, 1] at a hit, averaged over about `footprint` world units.
void ffp_textures_look(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float albedo[3], float *roughness);
// Bends the unit normal at the hit by the normal map.
void ffp_textures_bump(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float normal[3]);

#endif
