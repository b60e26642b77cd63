// Fruit and plants.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/shape.h"

static FfpPart *ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    return ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

static void leaf(FfpShape *shape, FfpV3 at, float yaw, float pitch, float length) {
    const FfpV3 middle = ffp_v3(at.x + 0.8F * length * cosf(yaw), at.y + 0.8F * length * sinf(yaw), at.z);
    ffp_part_rotate(ffp_add_ellipsoid(shape, middle, ffp_v3(length, 0.45F * length, 0.045F), 0.03F), yaw,
                    pitch, 0.2F);
}

static void stalk(FfpShape *shape, float base, float thick) {
    ffp_add_cone(shape, ffp_v3(0, 0, base), ffp_v3(0.05F, 0.03F, base + 0.22F), thick * 1.2F, thick, 0.08F);
    ffp_add_cone(shape, ffp_v3(0.05F, 0.03F, base + 0.22F), ffp_v3(0.16F, 0.06F, base + 0.36F), thick,
                 thick * 1.1F, 0.03F);
}

static void pumpkin(FfpShape *shape) {
    for (int i = 0; i < 9; i++) {
        const float a = 2 * FFP_PI * (float)i / 9;
        ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(0.42F * cosf(a), 0.42F * sinf(a), 0),
                                          ffp_v3(0.42F, 0.27F, 0.52F), 0.05F),
                        a, 0, 0);
    }
    stalk(shape, 0.36F, 0.08F);
    leaf(shape, ffp_v3(0.05F, 0, 0.6F), 0.8F, -0.2F, 0.28F);
}

static void pear(FfpShape *shape) {
    ball(shape, ffp_v3(0, 0, 0), 0.62F, 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.05F, 0, 0.75F), ffp_v3(0.3F, 0.3F, 0.38F), 0.4F);
    stalk(shape, 1.05F, 0.05F);
    shape->bump = 0.02F, shape->bump_frequency = 1.5F;
}

static void bitten_apple(FfpShape *shape) {
    ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.34F, 0.45F, 0);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.2F), ffp_v3(0.5F, 0.5F, 0.42F), 0.25F);
    for (int i = 0; i < 7; i++) { // the marks of teeth
        const float a = 0.42F * (float)(i - 3);
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.92F, 0.55F * sinf(a), 0.52F * cosf(a) - 0.32F),
                                  ffp_v3(0.42F, 0.17F, 0.24F), 0.01F));
    }
    stalk(shape, 0.05F, 0.05F);
    leaf(shape, ffp_v3(0.06F, 0.03F, 0.3F), 2.4F, -0.3F, 0.26F);
}

static void cactus(FfpShape *shape) {
    static const float arm[4][4] = {
        {0, 0, 0.05F, 0.12F}, {0.42F, 0, 0.05F, 0.13F}, {0.5F, 0, 0.3F, 0.14F}, {0.5F, 0, 0.6F, 0.12F}};
    static const float low[4][4] = {
        {0, 0, -0.25F, 0.11F}, {0.35F, 0, -0.25F, 0.12F}, {0.42F, 0, -0.1F, 0.13F}, {0.42F, 0, 0.12F, 0.12F}};
    ffp_add_cone(shape, ffp_v3(0, 0, -0.7F), ffp_v3(0, 0, 0.85F), 0.24F, 0.2F, 0);
    ffp_add_tube(shape, arm, 4, 1, 0, 0.08F);
    ffp_add_tube(shape, low, 4, 1, 2.5F, 0.08F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.85F), 0.42F, 0.2F, 0.04F, 0.02F);
    ffp_add_torus(shape, ffp_v3(0, 0, -0.67F), 0.42F, 0.06F, 0.01F);
    shape->ribs = 12, shape->rib_depth = 0.02F;
}

static void mushrooms(FfpShape *shape) {
    static const float at[4][5] = {{0, 0, 0.95F, 0.48F, 0.3F},
                                   {0.45F, 0.3F, 0.5F, 0.3F, 0.22F},
                                   {-0.42F, 0.3F, 0.6F, 0.27F, 0.26F},
                                   {-0.1F, -0.5F, 0.38F, 0.22F, 0.2F}};
    for (int i = 0; i < 4; i++) {
        const FfpV3 head = ffp_v3(1.1F * at[i][0], 1.1F * at[i][1], at[i][2]);
        const float cap = at[i][3];
        ffp_add_ellipsoid(shape, head, ffp_v3(cap, cap, at[i][4]), 0.01F);
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(head.x, head.y, head.z - 0.26F),
                                  ffp_v3(0.88F * cap, 0.88F * cap, 0.3F), 0.02F));
    }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.05F), ffp_v3(0.75F, 0.7F, 0.16F), 0);
    for (int i = 0; i < 4; i++) {
        const float cap = at[i][3];
        ffp_add_cone(shape, ffp_v3(at[i][0], at[i][1], 0),
                     ffp_v3(1.1F * at[i][0], 1.1F * at[i][1], at[i][2] + 0.07F), 0.3F * cap, 0.22F * cap,
                     0.03F);
    }
}

static void bananas(FfpShape *shape) {
    static const float fruit[5][4] = {{0, 0, 0.7F, 0.05F},
                                      {0.22F, 0, 0.55F, 0.1F},
                                      {0.5F, 0, 0.1F, 0.15F},
                                      {0.5F, 0, -0.4F, 0.13F},
                                      {0.3F, 0, -0.8F, 0.05F}};
    for (int i = 0; i < 4; i++) ffp_add_tube(shape, fruit, 5, 1, 0.55F * (float)i, 0.02F);
    ffp_add_cone(shape, ffp_v3(0, 0, 0.65F), ffp_v3(-0.05F, -0.02F, 0.95F), 0.12F, 0.09F, 0.05F);
}

static void grapes(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    for (int row = 0; row < 7; row++) {
        const float z = 0.55F - 0.22F * (float)row, ring = 0.5F * (1 - (float)row / 7);
        const int count = row < 2 ? 9 : 8 - row;
        for (int i = 0; i < count; i++) {
            const float a = 2 * FFP_PI * ((float)i + 0.5F * (float)(row & 1)) / (float)count,
                        r = ffp_draw(&rng, 0.14F, 0.17F);
            ball(shape, ffp_v3(ring * cosf(a), ring * sinf(a), z + ffp_draw(&rng, -0.04F, 0.04F)), r, 0.01F);
        }
    }
    ffp_add_cone(shape, ffp_v3(0, 0, -0.75F), ffp_v3(0, 0, 0.45F), 0.1F, 0.46F, 0.02F);
    ffp_add_cone(shape, ffp_v3(0, 0, 0.6F), ffp_v3(0.1F, 0, 0.95F), 0.06F, 0.06F, 0.02F);
    leaf(shape, ffp_v3(0.05F, 0, 0.8F), 2.5F, 0.3F, 0.36F);
}

static void pineapple(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.35F), ffp_v3(0.44F, 0.44F, 0.58F), 0);
    for (int i = 0; i < 70; i++) {
        const float t = ((float)i + 0.5F) / 70, z = 1 - 2 * t, a = 2.39996F * (float)i, r = sqrtf(1 - z * z);
        ball(shape, ffp_v3(0.44F * r * cosf(a), 0.44F * r * sinf(a), -0.35F + 0.58F * z), 0.085F, 0.01F);
    }
    static const float blade[3][4] = {
        {0.03F, 0, 0.1F, 0.06F}, {0.16F, 0, 0.45F, 0.06F}, {0.4F, 0, 0.62F, 0.02F}};
    static const float tall[3][4] = {
        {0.02F, 0, 0.1F, 0.07F}, {0.07F, 0, 0.6F, 0.06F}, {0.18F, 0, 0.92F, 0.02F}};
    for (int i = 0; i < 6; i++) {
        ffp_add_tube(shape, blade, 3, 1, 1.05F * (float)i, 0.03F);
        ffp_add_tube(shape, tall, 3, 1, 1.05F * (float)i + 0.5F, 0.03F);
    }
}

static void cherries(FfpShape *shape) {
    static const float stem[4][4] = {
        {0, 0, 0.85F, 0.07F}, {0.12F, 0, 0.55F, 0.04F}, {0.35F, 0, 0.15F, 0.04F}, {0.45F, 0, -0.25F, 0.045F}};
    ffp_add_tube(shape, stem, 4, 1, 0, 0.02F);
    ffp_add_tube(shape, stem, 4, 1, 2.7F, 0.02F);
    for (int i = 0; i < 2; i++) {
        const float a = 2.7F * (float)i, x = 0.47F * cosf(a), y = 0.47F * sinf(a);
        ffp_add_ellipsoid(shape, ffp_v3(x, y, -0.5F), ffp_v3(0.38F, 0.38F, 0.35F), 0.01F);
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(x, y, -0.12F), ffp_v3(0.1F, 0.1F, 0.1F), 0.02F));
        ffp_add_cone(shape, ffp_v3(0.37F * cosf(a), 0.37F * sinf(a), 0.1F), ffp_v3(x, y, -0.4F), 0.04F, 0.05F,
                     0);
    }
    leaf(shape, ffp_v3(0, 0, 0.85F), -0.8F, 0.2F, 0.34F);
}

// A wedge of a ball, its seeds on both faces.
static void melon_slice(FfpShape *shape) {
    const float open = 0.45F; // half the angle between the faces
    ball(shape, ffp_v3(0, 0, 0), 1, 0);
    for (int side = -1; side <= 1; side += 2) {
        const FfpV3 out = ffp_v3(0, cosf(open) * (float)side, sinf(open));
        FfpPart *face =
            ffp_add_box(shape, ffp_v3(0, 1.5F * out.y, 1.5F * out.z), ffp_v3(2, 2, 1.5F), 0, 0.01F);
        ffp_part_align(face, out);
        ffp_cut(face);
        for (int i = 0; i < 6; i++) {
            const float a = 0.45F + 0.45F * (float)i, r = 0.55F + 0.08F * (float)(i & 1);
            const FfpV3 at =
                ffp_v3(r * cosf(a), r * sinf(a) * sinf(open) * (float)side, -r * sinf(a) * cosf(open));
            ball(shape, at, 0.055F, 0.01F);
        }
    }
    ffp_cut(ball(shape, ffp_v3(0.42F, 0, 0.02F), 0.24F, 0.02F)); // a bite
    shape->upright = false;
}

const FfpFamily ffp_family_fruit = {{{"pumpkin", pumpkin},
                                     {"pear", pear},
                                     {"bitten apple", bitten_apple},
                                     {"cactus", cactus},
                                     {"mushrooms", mushrooms},
                                     {"bananas", bananas},
                                     {"grapes", grapes},
                                     {"pineapple", pineapple},
                                     {"cherries", cherries},
                                     {"melon slice", melon_slice}}};
