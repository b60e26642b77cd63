// The 150 meshes: which family each number is, how it is turned, and the splits.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "world/shapes/mesh.h"
#include "world/shapes/noise.h"

enum { MESHES = FFP_FAMILIES * FFP_KINDS };

// Mesh m is kind m / FFP_FAMILIES of family m % FFP_FAMILIES.
static const FfpFamily *const family_table[FFP_FAMILIES] = {
    &ffp_family_stone,     &ffp_family_blob,    &ffp_family_fruit, &ffp_family_land,  &ffp_family_shell,
    &ffp_family_animal,    &ffp_family_figure,  &ffp_family_bust,  &ffp_family_vase,  &ffp_family_kitchen,
    &ffp_family_furniture, &ffp_family_machine, &ffp_family_solid, &ffp_family_stack, &ffp_family_knot,
};

int ffp_mesh_count(void) {
    return MESHES;
}

const char *ffp_mesh_name(int mesh) {
    if (mesh < 0 || mesh >= MESHES) return "unknown";
    return family_table[mesh % FFP_FAMILIES]->kinds[mesh / FFP_FAMILIES].name;
}

// Uniform rotation from a random quaternion (Shoemake 1992), or only a turn around z.
static void random_rotation(FfpRng *rng, bool upright, float r[9]) {
    const float a = ffp_rng_uniform(rng), b = 6.2831853F * ffp_rng_uniform(rng),
                c = 6.2831853F * ffp_rng_uniform(rng);
    const float s = sqrtf(1 - a), t = sqrtf(a);
    const float x = upright ? 0 : s * sinf(b), y = upright ? 0 : s * cosf(b);
    const float z = upright ? sinf(0.5F * b) : t * sinf(c), w = upright ? cosf(0.5F * b) : t * cosf(c);
    const float m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(r, m, sizeof m);
}

FfpMesh ffp_mesh_make(int mesh) {
    FfpRng rng = ffp_rng(0x5eedf0ca75ULL, (uint64_t)mesh);
    FfpShape *shape = ffp_alloc(1, sizeof *shape);
    ffp_shape_init(shape, ffp_rng_u32(&rng));
    family_table[mesh % FFP_FAMILIES]->kinds[mesh / FFP_FAMILIES].make(shape);
    FfpMesh out = ffp_mesh_from_shape(shape);
    float rotation[9];
    random_rotation(&rng, shape->upright, rotation);
    ffp_mesh_place(&out, rotation);
    ffp_free(shape);
    return out;
}

// Each family's ten kinds go 7 : 1 : 2 to train, validation and test; a per-family shuffle decides which.
int ffp_split_meshes(const char *split, int *out, int capacity) {
    const int first = !strcmp(split, "train")        ? 0
                      : !strcmp(split, "validation") ? 7
                      : !strcmp(split, "test")       ? 8
                                                     : 10;
    const int end = first == 0 ? 7 : first == 7 ? 8 : 10;
    int count = 0;
    for (int rank = first; rank < end; rank++)
        for (int family = 0; family < FFP_FAMILIES; family++) {
            int order[FFP_KINDS];
            FfpRng rng = ffp_rng(0x5911dULL, (uint64_t)family);
            for (int i = 0; i < FFP_KINDS; i++) order[i] = i;
            for (int i = FFP_KINDS - 1; i > 0; i--) {
                const int j = (int)ffp_rng_below(&rng, (uint32_t)i + 1), keep = order[i];
                order[i] = order[j], order[j] = keep;
            }
            if (count < capacity) out[count] = order[rank] * FFP_FAMILIES + family;
            count++;
        }
    return count;
}
