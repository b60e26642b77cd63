#include "world/synth/material_folder.h"
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/rng.h"
#include "core/image/image.h"
#include "world/synth/material.h"

static const float TILE_LEAST = 0.6F, TILE_MOST = 2; // world units
static const float ROUGH_LEAST = 0.25F, ROUGH_MOST = 0.9F;
// Of the linear albedo: what is photographed is neither black nor white.
static const float DARKEST = 0.02F, SPAN = 0.9F;

static bool path_of(const FfpMaterialFolder *materials, const char *name, char path[FFP_PATH_MAX],
                    FfpError *err) {
    return ffp_join_path(path, materials->folder, name) ||
           ffp_fail(err, FFP_ERROR_FILE, materials->folder, "the path of %s is too long", name);
}

// Keeps the names of materials, once each is known to be one.
static bool keep_materials(FfpMaterialFolder *materials, FfpError *err) {
    FfpListing *list = &materials->list;
    int kept = 0;
    for (int i = 0; i < list->count; i++) {
        char path[FFP_PATH_MAX], *name = list->names[i];
        int width, height;
        if (!path_of(materials, name, path, err)) return false;
        const bool maps = name[0] != '.' && ffp_is_folder(path);
        if (name[0] == '.' || (!maps && !ffp_image_has_ending(name))) continue;
        if (!(maps ? ffp_textures_check(path, err) : ffp_image_read_size(&width, &height, path, err)))
            return false;
        list->names[kept++] = name;
    }
    list->count = kept;
    return kept > 0 || ffp_fail(err, FFP_ERROR_FILE, materials->folder,
                                "contains neither pictures nor folders of maps to use as materials");
}

bool ffp_material_folder_open(FfpMaterialFolder *materials, const char *folder, FfpError *err) {
    *materials = (FfpMaterialFolder){.folder = folder};
    if (!ffp_list_folder(&materials->list, folder))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "is not a folder that can be read");
    if (keep_materials(materials, err)) return true;
    ffp_material_folder_close(materials);
    return false;
}

void ffp_material_folder_close(FfpMaterialFolder *materials) {
    ffp_free(materials->list.names);
    *materials = (FfpMaterialFolder){0};
}

FfpTextures *ffp_material_folder_draw(const FfpMaterialFolder *materials, uint64_t seed, const char **name,
                                      FfpError *err) {
    enum { STREAM = 0x91c7 };
    FfpRng rng = ffp_rng(seed, STREAM);
    const char *drawn = materials->list.names[ffp_rng_below(&rng, (uint32_t)materials->list.count)];
    char path[FFP_PATH_MAX];
    if (!path_of(materials, drawn, path, err)) return NULL;
    FfpTextures *textures =
        ffp_is_folder(path) ? ffp_textures_read_silently(path, err) : ffp_textures_read_picture(path, err);
    if (!textures) return NULL;
    FfpLaying laying = {.tile = TILE_LEAST * powf(TILE_MOST / TILE_LEAST, ffp_rng_uniform(&rng)),
                        .roughness = ffp_rng_range(&rng, ROUGH_LEAST, ROUGH_MOST),
                        .darkest = DARKEST,
                        .span = SPAN};
    const FfpMaterial turned = ffp_material_make(0, seed); // as generated ones are
    memcpy(laying.axes, turned.axes, sizeof laying.axes);
    ffp_textures_lay(textures, &laying);
    if (name) *name = drawn;
    return textures;
}
