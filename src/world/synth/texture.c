#include "world/synth/texture.h"
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/listing.h"
#include "core/base/log.h"
#include "core/image/image.h"
#include "world/shapes/scalar.h"

enum { LEVELS = 16, SIDE_MAX = 4096 };
static const FfpLaying straight = {
    .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .tile = 1, .roughness = 0.6F, .span = 1};

typedef enum Role { ROLE_COLOUR, ROLE_ROUGHNESS, ROLE_NORMAL, ROLE_METALLIC, ROLES } Role;

typedef struct Map { // means over 2 x 2 pixels from level to level
    int levels;
    FfpImage level[LEVELS];
} Map;

struct FfpTextures {
    Map map[ROLE_METALLIC];
    bool down; // the normal map's green grows downwards (DirectX)
    FfpLaying laying;
    float height; // of a map where its width is 1
};

// --- Finding. ---

typedef struct Word {
    const char *text;
    Role role;
    bool down;
} Word;
static const Word word_table[] = {
    {"basecolor", ROLE_COLOUR, false},    {"basecolour", ROLE_COLOUR, false},
    {"color", ROLE_COLOUR, false},        {"colour", ROLE_COLOUR, false},
    {"col", ROLE_COLOUR, false},          {"albedo", ROLE_COLOUR, false},
    {"diffuse", ROLE_COLOUR, false},      {"diff", ROLE_COLOUR, false},
    {"roughness", ROLE_ROUGHNESS, false}, {"rough", ROLE_ROUGHNESS, false},
    {"normal", ROLE_NORMAL, false},       {"normals", ROLE_NORMAL, false},
    {"normalgl", ROLE_NORMAL, false},     {"normaldx", ROLE_NORMAL, true},
    {"nor", ROLE_NORMAL, false},          {"nrm", ROLE_NORMAL, false},
    {"metallic", ROLE_METALLIC, false},   {"metalness", ROLE_METALLIC, false},
    {"metal", ROLE_METALLIC, false},
};
enum { WORDS = sizeof word_table / sizeof word_table[0] };

// The role of a file by its name: the last word known counts ("rusty_metal_diff_2k.png" is a colour). False:
// nothing.
static bool role_of(const char *name, Role *role, bool *down) {
    const char *dot = strrchr(name, '.');
    if (!ffp_image_has_ending(name)) return false;
    bool found = false;
    for (const char *c = name; c < dot;) {
        size_t length = 0;
        while (c + length < dot && isalnum((unsigned char)c[length])) length++;
        for (int i = 0; i < WORDS; i++)
            if (strlen(word_table[i].text) == length && !strncasecmp(c, word_table[i].text, length))
                *role = word_table[i].role, *down = word_table[i].down, found = true;
        if (length == 2 && found && *role == ROLE_NORMAL && !strncasecmp(c, "dx", 2)) *down = true;
        c += length + 1;
    }
    return found;
}

typedef struct Found {
    char name[ROLES][256]; // empty: none
    bool down;
} Found;

// The first of each kind in alphabetical order, but OpenGL's normals before DirectX's.
static bool find_maps(const char *folder, Found *found, FfpError *err) {
    FfpListing listing;
    if (!ffp_list_folder(&listing, folder))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "is not a folder that can be read");
    *found = (Found){.down = false};
    for (int i = 0; i < listing.count; i++) {
        Role role = ROLE_COLOUR;
        bool down = false;
        const char *name = listing.names[i];
        if (role_of(name, &role, &down) && strlen(name) < sizeof found->name[role]) {
            char *slot = found->name[role];
            const bool better = role == ROLE_NORMAL && found->down && !down;
            if (slot[0] && !better && role != ROLE_NORMAL)
                ffp_warning("%s: %s is used, %s is not", folder, slot, name);
            if (!slot[0] || better) {
                memcpy(slot, name, strlen(name) + 1);
                if (role == ROLE_NORMAL) found->down = down;
            }
        }
    }
    ffp_free(listing.names);
    return true;
}

// --- Reading. ---

static FfpImage halve(const FfpImage *from) {
    return ffp_image_resize(from, from->width > 1 ? from->width / 2 : 1,
                            from->height > 1 ? from->height / 2 : 1);
}

// Three channels of the file at all levels.
static bool read_map(Map *map, const char *path, Role role, FfpError *err) {
    int width, height;
    if (!ffp_image_read_size(&width, &height, path, err)) return false;
    if (width > FFP_IMAGE_SIDE_MAX / 2 || height > FFP_IMAGE_SIDE_MAX / 2)
        return ffp_fail(err, FFP_ERROR_FILE, path, "a map of %d x %d is too large", width, height);
    FfpImage read;
    if (!ffp_image_read(&read, path, role == ROLE_COLOUR ? FFP_COLOUR_LINEAR : FFP_COLOUR_STORED, err))
        return false;
    FfpImage top = ffp_image_new(width, height, 3);
    const size_t pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < pixels; i++) memcpy(top.data + 3 * i, read.data + 4 * i, 3 * sizeof(real));
    ffp_image_free(&read);
    if (width > SIDE_MAX || height > SIDE_MAX) {
        FfpImage smaller = ffp_image_resize(&top, width < SIDE_MAX ? width : SIDE_MAX,
                                            height < SIDE_MAX ? height : SIDE_MAX);
        ffp_image_free(&top);
        top = smaller;
    }
    map->level[map->levels++] = top;
    for (const FfpImage *last = &map->level[0]; last->width > 1 || last->height > 1;
         last = &map->level[map->levels - 1]) {
        map->level[map->levels] = halve(last);
        map->levels++;
    }
    return true;
}

static bool read_named(Map *map, const char *folder, const char *name, Role role, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_join_path(path, folder, name))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    return read_map(map, path, role, err);
}

static FfpTextures *new_textures(void) {
    FfpTextures *textures = ffp_alloc(1, sizeof *textures);
    textures->laying = straight, textures->height = 1;
    return textures;
}

static bool find_colour(const char *folder, Found *found, FfpError *err) {
    return find_maps(folder, found, err) &&
           (found->name[ROLE_COLOUR][0] ||
            ffp_fail(err, FFP_ERROR_FILE, folder, "no map is called basecolor, albedo, diffuse or color"));
}

bool ffp_textures_check(const char *folder, FfpError *err) {
    Found found = {0};
    return find_colour(folder, &found, err);
}

static FfpTextures *read_found(const char *folder, const Found *found, FfpError *err) {
    FfpTextures *textures = new_textures();
    textures->down = found->down;
    for (Role role = ROLE_COLOUR; role < ROLE_METALLIC; role++)
        if (found->name[role][0] && !read_named(&textures->map[role], folder, found->name[role], role, err)) {
            ffp_textures_free(textures);
            return NULL;
        }
    return textures;
}

FfpTextures *ffp_textures_read(const char *folder, FfpError *err) {
    Found found = {0};
    if (!find_colour(folder, &found, err)) return NULL;
    if (found.name[ROLE_METALLIC][0])
        ffp_warning("%s: metals are not supported: %s is not used, the surface is a dielectric", folder,
                    found.name[ROLE_METALLIC]);
    if (!found.name[ROLE_ROUGHNESS][0])
        ffp_note("%s: no roughness map: %g everywhere", folder, (double)straight.roughness);
    return read_found(folder, &found, err);
}

FfpTextures *ffp_textures_read_silently(const char *folder, FfpError *err) {
    Found found = {0};
    return find_colour(folder, &found, err) ? read_found(folder, &found, err) : NULL;
}

FfpTextures *ffp_textures_read_picture(const char *path, FfpError *err) {
    FfpTextures *textures = new_textures();
    if (read_map(&textures->map[ROLE_COLOUR], path, ROLE_COLOUR, err)) return textures;
    ffp_textures_free(textures);
    return NULL;
}

void ffp_textures_lay(FfpTextures *textures, const FfpLaying *laying) {
    const FfpImage *colour = &textures->map[ROLE_COLOUR].level[0];
    textures->laying = *laying;
    textures->height = (float)colour->height / (float)colour->width;
}

void ffp_textures_free(FfpTextures *textures) {
    if (!textures) return;
    for (int m = 0; m < ROLE_METALLIC; m++)
        for (int i = 0; i < textures->map[m].levels; i++) ffp_image_free(&textures->map[m].level[i]);
    ffp_free(textures);
}

// --- Laying. ---

// Where a hit lies in the maps: in one place by its texture coordinates, or in three, one a world axis.
typedef struct Place {
    int count;
    float weight[3], uv[3][2], right[3][3], up[3][3]; // unit directions in which u and v grow; 0: unknown
    float units;                                      // of u or v a world unit
} Place;

static void place_by_coordinates(const FfpMesh *mesh, const FfpHit *hit, Place *place) {
    const uint32_t *corner = mesh->triangles + 3 * (size_t)hit->triangle;
    const float *a = mesh->uv + 2 * (size_t)corner[0], *b = mesh->uv + 2 * (size_t)corner[1],
                *c = mesh->uv + 2 * (size_t)corner[2];
    *place = (Place){.count = 1, .weight = {1}};
    for (int k = 0; k < 2; k++)
        place->uv[0][k] = (1 - hit->u - hit->v) * a[k] + hit->u * b[k] + hit->v * c[k];
    const float *p[3];
    for (int k = 0; k < 3; k++) p[k] = mesh->positions + 3 * (size_t)corner[k];
    const float b0 = b[0] - a[0], b1 = b[1] - a[1], c0 = c[0] - a[0], c1 = c[1] - a[1];
    const float area = b0 * c1 - c0 * b1;
    float right = 0, up = 0; // lengths of dP/du and dP/dv
    for (int k = 0; k < 3 && fabsf(area) > 1e-14F; k++) {
        const float e = p[1][k] - p[0][k], f = p[2][k] - p[0][k];
        place->right[0][k] = (c1 * e - b1 * f) / area, place->up[0][k] = (b0 * f - c0 * e) / area;
        right += place->right[0][k] * place->right[0][k], up += place->up[0][k] * place->up[0][k];
    }
    right = sqrtf(right), up = sqrtf(up);
    for (int k = 0; k < 3; k++) {
        if (right > 0) place->right[0][k] /= right;
        if (up > 0) place->up[0][k] /= up;
    }
    place->units = right > 0 && up > 0 ? 1 / ffp_min(right, up) : 0;
}

// The three projections along the maps' axes, blended by the fourth power of the normal's parts.
static void place_by_axes(const FfpTextures *textures, const FfpHit *hit, Place *place) {
    const FfpLaying *laying = &textures->laying;
    const float width = laying->tile, height = laying->tile * textures->height;
    *place = (Place){.count = 3, .units = 1 / ffp_min(width, height)};
    float normal[3], point[3], total = 0;
    for (int a = 0; a < 3; a++) {
        const float *axis = laying->axes + 3 * a;
        normal[a] = axis[0] * hit->normal[0] + axis[1] * hit->normal[1] + axis[2] * hit->normal[2];
        point[a] = axis[0] * hit->point[0] + axis[1] * hit->point[1] + axis[2] * hit->point[2];
    }
    for (int a = 0; a < 3; a++) {
        const float square = normal[a] * normal[a], sign = normal[a] < 0 ? -1 : 1;
        const int r = a == 0 ? 1 : 0, u = a == 2 ? 1 : 2;
        const float mirror = a == 1 ? -sign : sign; // so that a picture is not seen from behind
        place->weight[a] = square * square;
        total += place->weight[a];
        place->uv[a][0] = mirror * point[r] / width, place->uv[a][1] = point[u] / height;
        for (int k = 0; k < 3; k++) {
            place->right[a][k] = mirror * laying->axes[3 * r + k];
            place->up[a][k] = laying->axes[3 * u + k];
        }
    }
    float kept = 0; // what would hardly show is not looked up
    for (int a = 0; a < 3; a++) {
        place->weight[a] = place->weight[a] > 0.01F * total ? place->weight[a] : 0;
        kept += place->weight[a];
    }
    for (int a = 0; a < 3; a++) place->weight[a] /= kept;
}

static void place_hit(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, Place *place) {
    if (mesh->uv)
        place_by_coordinates(mesh, hit, place);
    else
        place_by_axes(textures, hit, place);
}

static int wrap(int i, int side) {
    const int r = i % side;
    return r < 0 ? r + side : r;
}

// Bilinear and repeated, at the level whose pixels are nearest to `width` (in units of u).
static void add_sample(const Map *map, const float uv[2], float width, float weight, float sum[3]) {
    const float texels = width * (float)map->level[0].width;
    const int level = texels > 1 ? (int)ffp_min(log2f(texels) + 0.5F, (float)(map->levels - 1)) : 0;
    const FfpImage *image = &map->level[level];
    const float s = uv[0] - floorf(uv[0]), t = 1 - (uv[1] - floorf(uv[1]));
    const float x = s * (float)image->width - 0.5F, y = t * (float)image->height - 0.5F;
    const float fx = x - floorf(x), fy = y - floorf(y);
    const int i = (int)floorf(x), j = (int)floorf(y);
    for (int k = 0; k < 4; k++) {
        const int column = wrap(i + (k & 1), image->width), row = wrap(j + (k >> 1), image->height);
        const float w = weight * (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy);
        const real *p = image->data + 3 * ((size_t)row * (size_t)image->width + (size_t)column);
        for (int c = 0; c < 3; c++) sum[c] += w * (float)p[c];
    }
}

void ffp_textures_look(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float albedo[3], float *roughness) {
    Place place;
    place_hit(textures, mesh, hit, &place);
    const Map *rough = &textures->map[ROLE_ROUGHNESS];
    float colour[3] = {0, 0, 0}, value[3] = {0, 0, 0};
    for (int i = 0; i < place.count; i++) {
        if (place.weight[i] <= 0) continue;
        const float width = footprint * place.units;
        add_sample(&textures->map[ROLE_COLOUR], place.uv[i], width, place.weight[i], colour);
        if (rough->levels > 0) add_sample(rough, place.uv[i], width, place.weight[i], value);
    }
    const FfpLaying *laying = &textures->laying;
    for (int c = 0; c < 3; c++)
        albedo[c] = laying->darkest + laying->span * ffp_min(1, ffp_max(0, colour[c]));
    *roughness = rough->levels > 0 ? ffp_min(1, ffp_max(0.05F, value[0])) : laying->roughness;
}

void ffp_textures_bump(const FfpTextures *textures, const FfpMesh *mesh, const FfpHit *hit, float footprint,
                       float normal[3]) {
    const Map *map = &textures->map[ROLE_NORMAL];
    if (map->levels == 0) return;
    Place place;
    place_hit(textures, mesh, hit, &place);
    float bent[3] = {0, 0, 0};
    for (int i = 0; i < place.count; i++) {
        if (place.weight[i] <= 0) continue;
        float n[3] = {0, 0, 0}, right = 0, up = 0;
        add_sample(map, place.uv[i], footprint * place.units, 1, n);
        for (int k = 0; k < 3; k++) n[k] = 2 * n[k] - 1;
        if (textures->down) n[1] = -n[1];
        for (int k = 0; k < 3; k++) right += place.right[i][k] * normal[k], up += place.up[i][k] * normal[k];
        for (int k = 0; k < 3; k++)
            bent[k] += place.weight[i] *
                       (n[0] * (place.right[i][k] - right * normal[k]) +
                        n[1] * (place.up[i][k] - up * normal[k]) + ffp_max(n[2], 0.05F) * normal[k]);
    }
    const float length = sqrtf(bent[0] * bent[0] + bent[1] * bent[1] + bent[2] * bent[2]);
    for (int k = 0; k < 3 && length > 1e-6F; k++) normal[k] = bent[k] / length;
}
