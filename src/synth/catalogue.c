// The 150 meshes: which family each number is, how it is turned, and the splits.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "synth/mesh.h"
#include "synth/noise.h"
#include "synth/synth.h"

enum { FAMILIES = 15, VARIANTS = 10, MESHES = FAMILIES * VARIANTS };

static const FfpFamily family_table[FAMILIES] = {
    {"stone", ffp_make_stone},   {"blob", ffp_make_blob},           {"fruit", ffp_make_fruit},
    {"land", ffp_make_land},     {"shell", ffp_make_shell},         {"animal", ffp_make_animal},
    {"figure", ffp_make_figure}, {"bust", ffp_make_bust},           {"vase", ffp_make_vase},
    {"teapot", ffp_make_teapot}, {"furniture", ffp_make_furniture}, {"cog", ffp_make_cog},
    {"solid", ffp_make_solid},   {"stack", ffp_make_stack},         {"knot", ffp_make_knot},
};

int ffp_mesh_count(void) {
    return MESHES;
}

// Written out once, so that a name can be handed out without memory of its own.
#define TEN(f) f "_0", f "_1", f "_2", f "_3", f "_4", f "_5", f "_6", f "_7", f "_8", f "_9"
static const char *const name_table[FAMILIES][VARIANTS] = {
    {TEN("stone")},     {TEN("blob")},   {TEN("fruit")}, {TEN("land")},  {TEN("shell")},
    {TEN("animal")},    {TEN("figure")}, {TEN("bust")},  {TEN("vase")},  {TEN("teapot")},
    {TEN("furniture")}, {TEN("cog")},    {TEN("solid")}, {TEN("stack")}, {TEN("knot")},
};

const char *ffp_mesh_name(int mesh) {
    return mesh >= 0 && mesh < MESHES ? name_table[mesh % FAMILIES][mesh / FAMILIES] : "unknown";
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
    family_table[mesh % FAMILIES].make(shape, &rng);
    FfpMesh out = ffp_mesh_from_shape(shape);
    float rotation[9];
    random_rotation(&rng, shape->upright, rotation);
    ffp_mesh_place(&out, rotation);
    free(shape);
    return out;
}

// Each family's ten variants go 7 : 1 : 2 to train, validation and test; a per-family shuffle decides which.
int ffp_split_meshes(const char *split, int *out, int capacity) {
    const int first = !strcmp(split, "train")        ? 0
                      : !strcmp(split, "validation") ? 7
                      : !strcmp(split, "test")       ? 8
                                                     : 10;
    const int end = first == 0 ? 7 : first == 7 ? 8 : 10;
    int count = 0;
    for (int rank = first; rank < end; rank++)
        for (int family = 0; family < FAMILIES; family++) {
            int order[VARIANTS];
            FfpRng rng = ffp_rng(0x5911dULL, (uint64_t)family);
            for (int i = 0; i < VARIANTS; i++) order[i] = i;
            for (int i = VARIANTS - 1; i > 0; i--) {
                const int j = (int)ffp_rng_below(&rng, (uint32_t)i + 1), keep = order[i];
                order[i] = order[j], order[j] = keep;
            }
            if (count < capacity) out[count] = order[rank] * FAMILIES + family;
            count++;
        }
    return count;
}
