// Materials from pictures: a folder of them.
#ifndef FFP_SYNTH_MATERIAL_FOLDER_H
#define FFP_SYNTH_MATERIAL_FOLDER_H

#include "core/base/listing.h"
#include "world/synth/texture.h"

// Each picture in the folder is a material, of which it is the base colour, and so is each folder of maps in
// it (texture.h).
typedef struct FfpMaterialFolder {
    const char *folder;
    FfpListing list; // names, in alphabetical order
} FfpMaterialFolder;

// Looks into every file's head; errors name the picture that cannot be read, or the folder without a base
// colour. A folder without any material is an error. Names that begin with a dot and other files are passed
// over. To be closed if it is true.
bool ffp_material_folder_open(FfpMaterialFolder *materials, const char *folder, FfpError *err);
void ffp_material_folder_close(FfpMaterialFolder *materials); // {0} is allowed

// Reads the material that `seed` draws, and lays it on objects as the seed says: turned at random, repeated
// every 0.6 to 2 world units, with linear albedos of 0.02 + 0.9 times the picture's and, without a map of it,
// a roughness in [0.25, 0.9]. *name, which may be NULL, receives its name, which lives as long as
// `materials`. NULL with an error.
FfpTextures *ffp_material_folder_draw(const FfpMaterialFolder *materials, uint64_t seed, const char **name,
                                      FfpError *err);

#endif
