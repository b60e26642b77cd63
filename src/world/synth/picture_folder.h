// Folders of pictures that scenes are made with: materials, and patterns for the projector.
#ifndef FFP_SYNTH_PICTURE_FOLDER_H
#define FFP_SYNTH_PICTURE_FOLDER_H

#include "core/base/listing.h"
#include "world/synth/synth.h"
#include "world/synth/texture.h"

typedef struct FfpPictureFolder {
    const char *folder; // NULL: none
    FfpListing list;    // names, in alphabetical order
} FfpPictureFolder;

// The pictures in a folder and, with `maps`, its folders of maps (texture.h). Looks into every file's head;
// errors name the picture that cannot be read, or the folder without a base colour. A folder without any is
// an error. Names that begin with a dot and other files are passed over. To be closed if it is true.
bool ffp_picture_folder_open(FfpPictureFolder *pictures, const char *folder, bool maps, FfpError *err);
void ffp_picture_folder_close(FfpPictureFolder *pictures); // {0} is allowed

// Reads the material that `seed` draws (a picture is its base colour) and lays it on objects as the seed
// says: turned at random, repeated every 0.6 to 2 world units, with linear albedos of 0.02 + 0.9 times the
// picture's and, without a map of it, a roughness in [0.25, 0.9]. *name, which may be NULL, receives its
// name, which lives as long as `pictures`. NULL with an error.
FfpTextures *ffp_picture_folder_material(const FfpPictureFolder *pictures, uint64_t seed, const char **name,
                                         FfpError *err);

// Reads the pictures that `seed` draws as patterns 1 .. count of a projector: of each a square at a random
// place, half to all of its shorter side long, as side x side values of 8 bits, decoded to linear. They
// are called picture_1_NAME and so on, NAME being the picture's without ending. [count], to be given back to
// ffp_picture_patterns_free with as many. NULL with an error.
FfpPattern *ffp_picture_folder_patterns(const FfpPictureFolder *pictures, uint64_t seed, int count, int side,
                                        FfpError *err);
void ffp_picture_patterns_free(FfpPattern *patterns, int count); // NULL is allowed

// The two folders of a job.
typedef struct FfpStock {
    FfpPictureFolder materials, patterns;
} FfpStock;

// NULL or "": none. To be closed if it is true.
bool ffp_stock_open(FfpStock *stock, const char *materials, const char *patterns, FfpError *err);
void ffp_stock_close(FfpStock *stock); // {0} is allowed
// Puts pictures that the scene's seed draws from the folders in place of its material and of all its
// lollipops but the first; _undress takes them away again, with the same stock, whether it succeeded or not.
bool ffp_stock_dress(const FfpStock *stock, FfpSceneSpec *spec, FfpError *err);
void ffp_stock_undress(const FfpStock *stock, FfpSceneSpec *spec);

#endif
