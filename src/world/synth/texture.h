// A user's material: maps in a folder, laid on a mesh by its texture coordinates or, where it has none, from
// three sides.
#ifndef FFP_SYNTH_TEXTURE_H
#define FFP_SYNTH_TEXTURE_H

#include "core/base/error.h"
#include "world/synth/trace.h"

typedef struct FfpTextures FfpTextures;

// Finds the maps in `folder` by the words of their names (docs/reference/formats/pictures.md): a base colour,
// which must be there, roughness and normals. A metallic map is not used, with a warning: the light model
// knows dielectrics only. NULL with an error.
FfpTextures *ffp_textures_read(const char *folder, FfpError *err);
// The same without the warning, and without the note on a roughness that no map gives.
FfpTextures *ffp_textures_read_silently(const char *folder, FfpError *err);
// Checks that it has a base colour, without reading it.
bool ffp_textures_check(const char *folder, FfpError *err);
// One picture as the base colour, without other maps.
FfpTextures *ffp_textures_read_picture(const char *path, FfpError *err);
void ffp_textures_free(FfpTextures *textures); // NULL is allowed

// How maps lie on an object.
typedef struct FfpLaying {
    float axes[9];   // rows: their frame in the world; like `tile`, where the mesh has no texture coordinates
    float tile;      // world units that a map's width covers
    float roughness; // where no map of it is
    float darkest, span; // linear albedo where the base colour is 0, and what is added up to 1
} FfpLaying;
// After reading: along the world's axes, repeated every unit (a map of any shape covers a square), roughness
// 0.6, albedo as it is. Laid in another way, maps keep their shape.
void ffp_textures_lay(FfpTextures *textures, const FfpLaying *laying);

// Linear albedo in [0, 1] and roughness in [0.05, 1] at a hit, averaged over about `footprint` world units.
void ffp_textures_look(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float albedo[3], float *roughness);
// Bends the unit normal at the hit by the normal map.
void ffp_textures_bump(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float normal[3]);

#endif
