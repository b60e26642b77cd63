// Things of rock: stones and pieces of land.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/scalar.h"
#include "world/shapes/shape.h"

static FfpV3 direction(FfpRng *rng) {
    const float z = ffp_draw(rng, -1, 1), a = ffp_draw(rng, 0, 2 * FFP_PI), r = sqrtf(1 - z * z);
    return ffp_v3(r * cosf(a), r * sinf(a), z);
}

static void roughen(FfpShape *shape, float bump, float frequency, bool ridged) {
    shape->bump = bump, shape->bump_frequency = frequency, shape->ridged = ridged;
    shape->lipschitz = 1.9F;
}

// An ellipsoid with flat faces cut off at random.
static void chiselled(FfpShape *shape, FfpV3 half, int faces) {
    FfpRng rng = ffp_shape_rng(shape);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), half, 0);
    for (int i = 0; i < faces; i++) {
        const FfpV3 d = direction(&rng);
        const FfpV3 h = ffp_v3(half.x * d.x, half.y * d.y, half.z * d.z);
        const float at = sqrtf(h.x * h.x + h.y * h.y + h.z * h.z) * ffp_draw(&rng, 0.62F, 0.9F) + 2;
        FfpPart *face = ffp_add_box(shape, ffp_v3(d.x * at, d.y * at, d.z * at), ffp_v3(3, 3, 2), 0, 0.06F);
        ffp_part_align(face, d);
        ffp_cut(face);
    }
}

static void boulder(FfpShape *shape) {
    chiselled(shape, ffp_v3(1, 0.85F, 0.8F), 12);
    roughen(shape, 0.03F, 2, false);
    shape->upright = false;
}

static void crag(FfpShape *shape) {
    chiselled(shape, ffp_v3(1, 0.6F, 0.75F), 7);
    roughen(shape, 0.11F, 1.9F, true);
    shape->upright = false;
}

static void pebble(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(1, 0.62F, 0.4F), 0);
    roughen(shape, 0.12F, 1, false);
    shape->upright = false;
}

static void menhir(FfpShape *shape) {
    chiselled(shape, ffp_v3(0.72F, 0.24F, 1.15F), 12);
    ffp_add_prism(shape, ffp_v3(0, 0, -0.95F), 9, 0.85F, 0.7F, 0.08F, 0.05F);
    roughen(shape, 0.05F, 2.2F, false);
}

static void flagstone(FfpShape *shape) {
    ffp_add_prism(shape, ffp_v3(0, 0, 0), 7, 0.95F, 0.85F, 0.13F, 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(1.45F, 0.5F, 0), ffp_v3(0.8F, 1, 1), 0, 0.02F));
    roughen(shape, 0.035F, 3, true);
    shape->upright = false;
}

static void rock_arch(FfpShape *shape) {
    static const float span[6][4] = {{-0.8F, 0, -0.6F, 0.32F},   {-0.62F, 0.05F, 0, 0.24F},
                                     {-0.3F, 0.1F, 0.42F, 0.2F}, {0.25F, 0, 0.45F, 0.24F},
                                     {0.62F, -0.05F, 0, 0.28F},  {0.7F, 0, -0.6F, 0.4F}};
    ffp_add_tube(shape, span, 6, 1, 0, 0.1F);
    ffp_add_box(shape, ffp_v3(0, 0, -0.72F), ffp_v3(1.05F, 0.45F, 0.14F), 0.1F, 0.15F);
    roughen(shape, 0.07F, 1.8F, true);
}

static void cairn(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    float z = -0.8F;
    for (int i = 0; i < 6; i++) {
        const float r = 0.62F - 0.085F * (float)i, h = r * ffp_draw(&rng, 0.34F, 0.46F);
        const float x = ffp_draw(&rng, -0.07F, 0.07F), yaw = ffp_draw(&rng, 0, FFP_PI);
        ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(x, -x, z), ffp_v3(r, 0.8F * r, h), 0.02F), yaw, x, 0);
        z += 1.75F * h;
    }
    roughen(shape, 0.03F, 2, false);
}

static void crystals(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    for (int i = 0; i < 11; i++) {
        const float a = 2.4F * (float)i, lean = 0.28F * sqrtf((float)i), r = ffp_draw(&rng, 0.11F, 0.19F),
                    half = ffp_draw(&rng, 0.3F, 0.5F) * (i == 0 ? 1.3F : 1);
        const FfpV3 d = ffp_v3(sinf(lean) * cosf(a), sinf(lean) * sinf(a), cosf(lean));
        ffp_part_align(ffp_add_prism(shape, ffp_v3(half * d.x, half * d.y, half * d.z), 6, r, r, half, 0), d);
        const float tip = 2 * half + 0.9F * r;
        ffp_part_align(
            ffp_add_prism(shape, ffp_v3(tip * d.x, tip * d.y, tip * d.z), 6, r, 0.01F, 0.9F * r, 0), d);
    }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.5F, 0.45F, 0.15F), 0.05F);
}

// A hollow half stone, crystals growing inwards.
static void geode(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.95F, 0.85F, 0.85F), 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.05F), ffp_v3(0.74F, 0.64F, 0.66F), 0.02F));
    for (int i = 0; i < 60; i++) {
        FfpV3 d = direction(&rng);
        d.z = -fabsf(d.z);
        const FfpV3 at = ffp_v3(0.76F * d.x, 0.66F * d.y, 0.66F * d.z);
        const float length = ffp_draw(&rng, 0.06F, 0.16F);
        ffp_part_align(ffp_add_prism(shape, at, 5, 0.09F, 0.01F, length, 0), ffp_v3(-d.x, -d.y, -d.z));
    }
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, 1.15F), ffp_v3(2, 2, 1), 0, 0.02F));
    roughen(shape, 0.02F, 3, false);
}

static void pumice(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.9F, 0.75F, 0.7F), 0);
    for (int i = 0; i < 46; i++) {
        const FfpV3 d = direction(&rng);
        const float r = ffp_draw(&rng, 0.08F, 0.26F);
        ffp_cut(
            ffp_add_ellipsoid(shape, ffp_v3(0.92F * d.x, 0.77F * d.y, 0.72F * d.z), ffp_v3(r, r, r), 0.03F));
    }
    roughen(shape, 0.03F, 2, false);
    shape->upright = false;
}

const FfpFamily ffp_family_stone = {{{"boulder", boulder},
                                     {"crag", crag},
                                     {"pebble", pebble},
                                     {"menhir", menhir},
                                     {"flagstone", flagstone},
                                     {"rock arch", rock_arch},
                                     {"cairn", cairn},
                                     {"crystals", crystals},
                                     {"geode", geode},
                                     {"pumice", pumice}}};

static void rocks(FfpShape *shape, int count) {
    FfpRng rng = ffp_shape_rng(shape);
    for (int i = 0; i < count; i++) {
        const float r = ffp_draw(&rng, 0.12F, 0.22F);
        const FfpV3 at = ffp_draw3(&rng, ffp_v3(-0.7F, -0.6F, 0), ffp_v3(0.7F, 0.6F, 0.15F));
        ffp_part_rotate(ffp_add_ellipsoid(shape, at, ffp_v3(r, r * 0.8F, r * 0.7F), 0.06F), r * 20, r, 0);
    }
}

static void hills(FfpShape *shape) {
    ffp_add_land(shape, ffp_v3(1, 0.8F, 0.2F), 0.45F);
    rocks(shape, 3);
    shape->lipschitz = 1.9F;
}

static void rugged_island(FfpShape *shape) {
    shape->ridged = true;
    ffp_add_land(shape, ffp_v3(1, 1, 0.35F), 0.55F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.95F, 2, 0.02F, 0.02F)->join = FFP_CSG_INTERSECTION;
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.2F, 0.1F, 0.5F), ffp_v3(0.45F, 0.4F, 0.5F), 0.1F));
    shape->lipschitz = 1.9F;
}

static void volcano(FfpShape *shape) {
    ffp_add_cone(shape, ffp_v3(0, 0, -0.3F), ffp_v3(0, 0, 0.55F), 0.62F, 0.22F, 0);
    ffp_add_prism(shape, ffp_v3(0, 0, -0.42F), 40, 1, 0.8F, 0.2F, 0.25F);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.85F), ffp_v3(0.26F, 0.26F, 0.5F), 0.05F));
    static const float lava[4][4] = {{0.2F, 0, 0.6F, 0.06F},
                                     {0.4F, 0.05F, 0.3F, 0.08F},
                                     {0.62F, 0.2F, -0.05F, 0.1F},
                                     {0.85F, 0.2F, -0.28F, 0.14F}};
    ffp_add_tube(shape, lava, 4, 1, 0, 0.08F);
    ffp_add_tube(shape, lava, 4, 1, 2.4F, 0.08F);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, -1.62F), ffp_v3(2, 2, 1), 0, 0));
    roughen(shape, 0.05F, 1.8F, true);
}

static void terraces(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    float x = 0, y = 0;
    for (int i = 0; i < 6; i++) {
        const float r = 0.95F - 0.145F * (float)i;
        ffp_add_cylinder(shape, ffp_v3(x, y, -0.45F + 0.17F * (float)i), r, 0.1F, 0.015F, 0.01F);
        ffp_add_cylinder(shape, ffp_v3(x + 0.5F * r, y + 0.5F * r, -0.45F + 0.17F * (float)i), 0.45F * r,
                         0.1F, 0.015F, 0.01F);
        x += ffp_draw(&rng, -0.1F, 0.05F), y += ffp_draw(&rng, -0.1F, 0.05F);
    }
}

static void canyon(FfpShape *shape) {
    static const float river[6][4] = {{-1.3F, 0.3F, 0.4F, 0.2F},  {-0.7F, 0.2F, 0.1F, 0.22F},
                                      {-0.2F, -0.3F, 0.1F, 0.2F}, {0.3F, 0.25F, 0.05F, 0.22F},
                                      {0.8F, 0, 0, 0.24F},        {1.3F, -0.3F, 0, 0.26F}};
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(1, 0.8F, 0.34F), 0.02F, 0);
    const int first = shape->n_parts;
    for (int level = 0; level < 3; level++) {
        float bed[6][4];
        for (int i = 0; i < 6; i++)
            for (int k = 0; k < 4; k++)
                bed[i][k] = river[i][k] + (k == 2 ? 0.2F * (float)level : k == 3 ? 0.06F * (float)level : 0);
        ffp_add_tube(shape, bed, 6, 1, 0, 0);
    }
    for (int i = first; i < shape->n_parts; i++) shape->parts[i].join = FFP_CSG_DIFFERENCE;
    roughen(shape, 0.045F, 2.5F, true);
    shape->upright = false;
}

static void buttes(FfpShape *shape) {
    static const float at[4][4] = {{-0.45F, 0.3F, 0.34F, 0.55F},
                                   {0.45F, 0.35F, 0.22F, 0.7F},
                                   {0.25F, -0.4F, 0.3F, 0.35F},
                                   {-0.5F, -0.45F, 0.16F, 0.5F}};
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.5F), 1, 0.1F, 0.03F, 0);
    for (int i = 0; i < 4; i++) {
        const float r = at[i][2], h = 0.5F * at[i][3];
        ffp_add_prism(shape, ffp_v3(at[i][0], at[i][1], -0.4F + 0.45F * h), 9, 1.5F * r, r, 0.6F * h, 0.08F);
        ffp_add_prism(shape, ffp_v3(at[i][0], at[i][1], -0.4F + h), 9, 0.95F * r, 0.85F * r, h, 0.03F);
    }
    roughen(shape, 0.03F, 2.5F, true);
}

static void village(FfpShape *shape) {
    static const float at[6][4] = {{-0.55F, 0.5F, 0.3F, 0.2F},  {0.1F, 0.5F, 0.1F, 0.26F},
                                   {0.6F, 0.2F, 1.2F, 0.2F},    {-0.5F, -0.15F, 1.6F, 0.22F},
                                   {0.1F, -0.45F, 0.2F, 0.24F}, {0.62F, -0.5F, 0.5F, 0.18F}};
    ffp_add_box(shape, ffp_v3(0, 0, -0.35F), ffp_v3(1, 0.85F, 0.1F), 0.03F, 0);
    for (int i = 0; i < 6; i++) {
        const float w = at[i][3], yaw = at[i][2], c = cosf(yaw), s = sinf(yaw);
        ffp_part_rotate(ffp_add_box(shape, ffp_v3(at[i][0], at[i][1], -0.1F),
                                    ffp_v3(1.3F * w, 0.8F * w, 0.18F), 0.01F, 0),
                        yaw, 0, 0);
        const FfpV3 ridge = ffp_v3(at[i][0], at[i][1], 0.08F + 0.2F * w);
        ffp_part_rotate(ffp_add_prism(shape, ridge, 3, 0.95F * w, 0.95F * w, 1.4F * w, 0), yaw,
                        -0.5F * FFP_PI,
                        0); // a gable roof
        ffp_add_box(shape, ffp_v3(at[i][0] + 0.7F * w * c, at[i][1] + 0.7F * w * s, 0.1F + 0.7F * w),
                    ffp_v3(0.045F, 0.045F, 0.2F), 0.01F, 0);
    }
    ffp_add_prism(shape, ffp_v3(-0.02F, 0.05F, 0.1F), 4, 0.14F, 0.14F, 0.4F, 0);
    ffp_add_prism(shape, ffp_v3(-0.02F, 0.05F, 0.75F), 4, 0.19F, 0.01F, 0.25F, 0);
}

static void castle(FfpShape *shape) {
    ffp_add_prism(shape, ffp_v3(0, 0, -0.62F), 12, 1.05F, 0.9F, 0.16F, 0);
    ffp_add_box(shape, ffp_v3(0, 0, -0.25F), ffp_v3(0.55F, 0.55F, 0.3F), 0.01F, 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, 0.05F), ffp_v3(0.44F, 0.44F, 0.4F), 0.01F, 0));
    ffp_add_box(shape, ffp_v3(-0.1F, 0.05F, -0.05F), ffp_v3(0.2F, 0.22F, 0.45F), 0.01F, 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(0.55F, 0, -0.3F), ffp_v3(0.3F, 0.12F, 0.17F), 0.01F, 0)); // the gate
    for (int i = 0; i < 4; i++) {
        const float x = i & 1 ? 0.55F : -0.55F, y = i & 2 ? 0.55F : -0.55F, top = 0.15F + 0.1F * (float)i;
        ffp_add_cylinder(shape, ffp_v3(x, y, 0.5F * top - 0.3F), 0.17F, 0.5F * top + 0.25F, 0.01F, 0);
        ffp_add_prism(shape, ffp_v3(x, y, top + 0.12F), 24, 0.24F, 0.01F, 0.19F, 0);
    }
    ffp_add_prism(shape, ffp_v3(-0.1F, 0.05F, 0.6F), 4, 0.36F, 0.01F, 0.22F, 0);
    roughen(shape, 0.012F, 4, true);
    shape->lipschitz = 1.5F;
}

static void arched_bridge(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, -0.1F), ffp_v3(1, 0.3F, 0.36F), 0.02F, 0);
    for (int i = 0; i < 3; i++) {
        const float x = 0.62F * (float)(i - 1);
        FfpPart *bay = ffp_add_cylinder(shape, ffp_v3(x, 0, -0.14F), 0.23F, 1, 0.01F, 0.01F);
        ffp_part_align(bay, ffp_v3(0, 1, 0));
        ffp_cut(bay);
        ffp_cut(ffp_add_box(shape, ffp_v3(x, 0, -0.35F), ffp_v3(0.23F, 1, 0.2F), 0.01F, 0.01F));
    }
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, 0.3F), ffp_v3(2, 0.22F, 0.15F), 0.01F,
                        0)); // the road between its walls
    ffp_add_box(shape, ffp_v3(0, 0, -0.55F), ffp_v3(1.05F, 0.62F, 0.1F), 0.04F, 0.02F);
    ffp_add_prism(shape, ffp_v3(0.31F, 0, -0.3F), 4, 0.42F, 0.16F, 0.2F, 0);
    ffp_add_prism(shape, ffp_v3(-0.31F, 0, -0.3F), 4, 0.42F, 0.16F, 0.2F, 0);
    roughen(shape, 0.012F, 4, true);
    shape->lipschitz = 1.5F;
}

static void palm_island(FfpShape *shape) {
    static const float trunk[4][4] = {{0, 0, -0.5F, 0.13F},
                                      {0.08F, 0, -0.1F, 0.09F},
                                      {0.2F, 0.02F, 0.3F, 0.075F},
                                      {0.42F, 0.04F, 0.68F, 0.08F}};
    static const float leaf[4][4] = {
        {0, 0, 0, 0.06F}, {0.22F, 0, 0.12F, 0.07F}, {0.45F, 0, 0.02F, 0.065F}, {0.58F, 0, -0.22F, 0.03F}};
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.62F), ffp_v3(0.95F, 0.8F, 0.24F), 0);
    ffp_add_tube(shape, trunk, 4, 1, 0, 0.1F);
    for (int i = 0; i < 7; i++) {
        const float yaw = 0.9F * (float)i, c = cosf(yaw), s = sinf(yaw);
        float moved[4][4];
        for (int k = 0; k < 4; k++) {
            moved[k][0] = 0.42F + c * leaf[k][0], moved[k][1] = 0.04F + s * leaf[k][0];
            moved[k][2] = 0.72F + leaf[k][2], moved[k][3] = leaf[k][3];
        }
        ffp_add_tube(shape, moved, 4, 1, 0, 0.03F);
    }
    for (int i = 0; i < 3; i++)
        ffp_add_ellipsoid(
            shape, ffp_v3(0.42F + 0.1F * cosf(2.1F * (float)i), 0.04F + 0.1F * sinf(2.1F * (float)i), 0.6F),
            ffp_v3(0.09F, 0.09F, 0.1F), 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.5F, 0.2F, -0.4F), ffp_v3(0.22F, 0.18F, 0.16F), 0.04F);
    roughen(shape, 0.02F, 3, false);
    shape->lipschitz = 1.5F;
}

const FfpFamily ffp_family_land = {{{"hills", hills},
                                    {"rugged island", rugged_island},
                                    {"volcano", volcano},
                                    {"terraces", terraces},
                                    {"canyon", canyon},
                                    {"buttes", buttes},
                                    {"village", village},
                                    {"castle", castle},
                                    {"arched bridge", arched_bridge},
                                    {"palm island", palm_island}}};
