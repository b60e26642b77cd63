#include "world/synth/picture_folder.h"
#include <math.h>
#include <stdio.h>
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

// Of a pattern's square: its share of the picture's shorter side.
static const float SQUARE_LEAST = 0.5F;

static bool path_of(const FfpPictureFolder *pictures, const char *name, char path[FFP_PATH_MAX],
                    FfpError *err) {
    return ffp_join_path(path, pictures->folder, name) ||
           ffp_fail(err, FFP_ERROR_FILE, pictures->folder, "the path of %s is too long", name);
}

// Keeps the names of pictures and folders of maps, once each is known to be one.
static bool keep_pictures(FfpPictureFolder *pictures, bool with_maps, FfpError *err) {
    FfpListing *list = &pictures->list;
    int kept = 0;
    for (int i = 0; i < list->count; i++) {
        char path[FFP_PATH_MAX], *name = list->names[i];
        int width, height;
        if (!path_of(pictures, name, path, err)) return false;
        const bool maps = with_maps && name[0] != '.' && ffp_is_folder(path);
        if (name[0] == '.' || (!maps && !ffp_image_has_ending(name))) continue;
        if (!(maps ? ffp_textures_check(path, err) : ffp_image_read_size(&width, &height, path, err)))
            return false;
        list->names[kept++] = name;
    }
    list->count = kept;
    return kept > 0 ||
           ffp_fail(err, FFP_ERROR_FILE, pictures->folder,
                    with_maps ? "contains neither pictures nor folders of maps to use as materials"
                              : "contains no pictures to use as patterns");
}

bool ffp_picture_folder_open(FfpPictureFolder *pictures, const char *folder, bool maps, FfpError *err) {
    *pictures = (FfpPictureFolder){.folder = folder};
    if (!ffp_list_folder(&pictures->list, folder))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "is not a folder that can be read");
    if (keep_pictures(pictures, maps, err)) return true;
    ffp_picture_folder_close(pictures);
    return false;
}

void ffp_picture_folder_close(FfpPictureFolder *pictures) {
    ffp_free(pictures->list.names);
    *pictures = (FfpPictureFolder){0};
}

static const char *draw_name(const FfpPictureFolder *pictures, FfpRng *rng) {
    return pictures->list.names[ffp_rng_below(rng, (uint32_t)pictures->list.count)];
}

FfpTextures *ffp_picture_folder_material(const FfpPictureFolder *pictures, uint64_t seed, const char **name,
                                         FfpError *err) {
    enum { STREAM = 0x91c7 };
    FfpRng rng = ffp_rng(seed, STREAM);
    const char *drawn = draw_name(pictures, &rng);
    char path[FFP_PATH_MAX];
    if (!path_of(pictures, drawn, path, err)) return NULL;
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

// A square of the picture, side x side, of 8 bits.
static FfpImage cut_square(const FfpImage *picture, int side, FfpRng *rng) {
    const int shorter = picture->width < picture->height ? picture->width : picture->height;
    const int length = (int)ceilf(ffp_rng_range(rng, SQUARE_LEAST, 1) * (float)shorter);
    const int x = (int)ffp_rng_below(rng, (uint32_t)(picture->width - length) + 1);
    const int y = (int)ffp_rng_below(rng, (uint32_t)(picture->height - length) + 1);
    FfpImage square = ffp_image_new(length, length, 3);
    for (int row = 0; row < length; row++)
        memcpy(square.data + (size_t)row * (size_t)length * 3,
               picture->data + ((size_t)(y + row) * (size_t)picture->width + (size_t)x) * 3,
               (size_t)length * 3 * sizeof(real));
    FfpImage pattern = ffp_image_resize(&square, side, side);
    ffp_image_free(&square);
    ffp_image_to_srgb(&pattern);
    for (size_t i = 0; i < (size_t)side * (size_t)side * 3; i++)
        pattern.data[i] = ffp_srgb_decode(roundf(255 * (float)pattern.data[i]) / 255);
    return pattern;
}

static bool read_pattern(const FfpPictureFolder *pictures, int number, int side, FfpRng *rng,
                         FfpPattern *pattern, FfpError *err) {
    const char *drawn = draw_name(pictures, rng);
    char path[FFP_PATH_MAX], name[FFP_NAME_MAX];
    FfpImage picture;
    if (!path_of(pictures, drawn, path, err) || !ffp_image_read_over_black(&picture, NULL, path, err))
        return false;
    ffp_asset_name(drawn, name);
    snprintf(pattern->name, sizeof pattern->name, "picture_%d_%.40s", number, name);
    pattern->image = cut_square(&picture, side, rng);
    ffp_image_free(&picture);
    return true;
}

FfpPattern *ffp_picture_folder_patterns(const FfpPictureFolder *pictures, uint64_t seed, int count, int side,
                                        FfpError *err) {
    enum { STREAM = 0x91c8 };
    FfpRng rng = ffp_rng(seed, STREAM);
    FfpPattern *patterns = ffp_alloc((size_t)count, sizeof *patterns);
    for (int i = 0; i < count; i++)
        if (!read_pattern(pictures, i + 1, side, &rng, &patterns[i], err)) {
            ffp_picture_patterns_free(patterns, count);
            return NULL;
        }
    return patterns;
}

void ffp_picture_patterns_free(FfpPattern *patterns, int count) {
    for (int i = 0; patterns && i < count; i++) ffp_image_free(&patterns[i].image);
    ffp_free(patterns);
}

bool ffp_stock_open(FfpStock *stock, const char *materials, const char *patterns, FfpError *err) {
    *stock = (FfpStock){0};
    if (materials && materials[0] && !ffp_picture_folder_open(&stock->materials, materials, true, err))
        return false;
    if (!patterns || !patterns[0] || ffp_picture_folder_open(&stock->patterns, patterns, false, err))
        return true;
    ffp_stock_close(stock);
    return false;
}

void ffp_stock_close(FfpStock *stock) {
    ffp_picture_folder_close(&stock->materials);
    ffp_picture_folder_close(&stock->patterns);
}

bool ffp_stock_dress(const FfpStock *stock, FfpSceneSpec *spec, FfpError *err) {
    if (stock->materials.folder) {
        spec->own_textures =
            ffp_picture_folder_material(&stock->materials, spec->seed, &spec->own_material, err);
        if (!spec->own_textures) return false;
    }
    if (!stock->patterns.folder || spec->lollipops < 2) return true;
    spec->own_patterns = ffp_picture_folder_patterns(&stock->patterns, spec->seed, spec->lollipops - 1,
                                                     spec->pattern_side, err);
    return spec->own_patterns != NULL;
}

void ffp_stock_undress(const FfpStock *stock, FfpSceneSpec *spec) {
    if (stock->materials.folder) {
        ffp_textures_free((FfpTextures *)spec->own_textures);
        spec->own_textures = NULL, spec->own_material = NULL;
    }
    ffp_picture_patterns_free((FfpPattern *)spec->own_patterns, spec->lollipops - 1);
    spec->own_patterns = NULL;
}
