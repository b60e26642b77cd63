// Animals: bodies of blended ellipsoids, limbs and tails of tubes. All look along +x.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/shape.h"

static void ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

static void eyes(FfpShape *shape, FfpV3 at, float r) {
    for (int side = -1; side <= 1; side += 2) ball(shape, ffp_v3(at.x, at.y * (float)side, at.z), r, 0.01F);
}

static void both(FfpShape *shape, const float (*tube)[4], int n, float blend) {
    for (int side = -1; side <= 1; side += 2) ffp_add_tube(shape, tube, n, (float)side, 0, blend);
}

static void horse(FfpShape *shape) {
    static const float fore[4][4] = {{0.42F, 0.13F, -0.05F, 0.17F},
                                     {0.5F, 0.15F, -0.45F, 0.08F},
                                     {0.44F, 0.15F, -0.8F, 0.06F},
                                     {0.5F, 0.15F, -1, 0.09F}};
    static const float hind[4][4] = {{-0.5F, 0.13F, 0, 0.2F},
                                     {-0.4F, 0.16F, -0.42F, 0.11F},
                                     {-0.62F, 0.16F, -0.7F, 0.06F},
                                     {-0.5F, 0.16F, -1, 0.09F}};
    static const float neck[4][4] = {
        {0.4F, 0, 0.1F, 0.26F}, {0.62F, 0, 0.42F, 0.2F}, {0.78F, 0, 0.75F, 0.15F}, {0.86F, 0, 0.9F, 0.15F}};
    static const float face[3][4] = {
        {0.82F, 0, 0.92F, 0.15F}, {1.05F, 0, 0.75F, 0.12F}, {1.22F, 0, 0.58F, 0.09F}};
    static const float tail[4][4] = {{-0.7F, 0, 0.15F, 0.08F},
                                     {-0.95F, 0, 0.05F, 0.11F},
                                     {-1.02F, 0, -0.35F, 0.1F},
                                     {-1, 0, -0.65F, 0.05F}};
    ffp_add_ellipsoid(shape, ffp_v3(-0.05F, 0, 0), ffp_v3(0.68F, 0.27F, 0.3F), 0);
    ffp_add_tube(shape, neck, 4, 1, 0, 0.15F);
    ffp_add_tube(shape, face, 3, 1, 0, 0.05F);
    both(shape, fore, 4, 0.08F);
    both(shape, hind, 4, 0.1F);
    ffp_add_tube(shape, tail, 4, 1, 0, 0.05F);
    for (int i = 0; i < 6; i++)
        ffp_add_ellipsoid(shape, ffp_v3(0.38F + 0.075F * (float)i, 0, 0.42F + 0.12F * (float)i),
                          ffp_v3(0.12F, 0.045F, 0.12F), 0.03F); // mane
    for (int side = -1; side <= 1; side += 2)
        ffp_add_cone(shape, ffp_v3(0.78F, 0.07F * (float)side, 1), ffp_v3(0.8F, 0.1F * (float)side, 1.2F),
                     0.06F, 0.03F, 0.02F);
}

static void carp(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.8F, 0.24F, 0.4F), 0);
    ffp_add_cone(shape, ffp_v3(-0.5F, 0, 0), ffp_v3(-0.95F, 0, 0), 0.2F, 0.08F, 0.15F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_rotate(
            ffp_add_ellipsoid(shape, ffp_v3(-1.12F, 0, 0.22F * s), ffp_v3(0.34F, 0.055F, 0.15F), 0.06F), 0,
            0.7F * s, 0);
        ffp_part_rotate(
            ffp_add_ellipsoid(shape, ffp_v3(0.15F, 0.3F * s, -0.1F), ffp_v3(0.26F, 0.14F, 0.045F), 0.04F),
            -0.6F * s, -0.3F, 0);
    }
    eyes(shape, ffp_v3(0.55F, 0.16F, 0.1F), 0.07F);
    ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(-0.05F, 0, 0.4F), ffp_v3(0.42F, 0.055F, 0.24F), 0.06F), 0,
                    0.25F, 0);
    ffp_add_cone(shape, ffp_v3(0.75F, 0, -0.02F), ffp_v3(0.86F, 0, -0.04F), 0.12F, 0.1F, 0.05F);
    shape->bump = 0.012F, shape->bump_frequency = 5;
}

static void turtle(FfpShape *shape) {
    static const float fore[3][4] = {
        {0.4F, 0.35F, -0.1F, 0.15F}, {0.7F, 0.7F, -0.16F, 0.11F}, {0.72F, 1, -0.25F, 0.06F}};
    static const float hind[3][4] = {
        {-0.5F, 0.35F, -0.1F, 0.14F}, {-0.8F, 0.5F, -0.18F, 0.12F}, {-0.95F, 0.62F, -0.22F, 0.08F}};
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.8F, 0.66F, 0.4F), 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, -0.62F), ffp_v3(2, 2, 0.5F), 0, 0.04F));
    for (int i = 0; i < 13; i++) { // the plates
        const float ring = i == 0  ? 0
                           : i < 6 ? 0.42F
                                   : 0.72F,
                    a = i < 6 ? 1.2566F * (float)i : 0.8976F * (float)i;
        const FfpV3 d = ffp_v3(0.8F * ring * cosf(a), 0.66F * ring * sinf(a), 0.4F * sqrtf(1 - ring * ring));
        ffp_part_align(ffp_add_prism(shape, d, 6, 0.2F, 0.13F, 0.05F, 0), ffp_v3(d.x, d.y, d.z * 4));
    }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.13F), ffp_v3(0.72F, 0.58F, 0.08F), 0.02F);
    both(shape, fore, 3, 0.05F);
    both(shape, hind, 3, 0.05F);
    ffp_add_cone(shape, ffp_v3(0.6F, 0, -0.08F), ffp_v3(1.05F, 0, 0.06F), 0.14F, 0.16F, 0.04F);
    ffp_add_ellipsoid(shape, ffp_v3(1.12F, 0, 0.08F), ffp_v3(0.22F, 0.16F, 0.15F), 0.03F);
    eyes(shape, ffp_v3(1.18F, 0.13F, 0.14F), 0.05F);
    ffp_add_cone(shape, ffp_v3(-0.7F, 0, -0.1F), ffp_v3(-1.05F, 0, -0.15F), 0.08F, 0.03F, 0.04F);
}

static void standing_bird(FfpShape *shape) {
    const float lean = -0.45F;
    ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.65F, 0.38F, 0.42F), 0), 0, lean, 0);
    const FfpV3 top = ffp_v3(0.48F, 0, 0.62F);
    ffp_add_cone(shape, ffp_v3(0.35F, 0, 0.1F), top, 0.25F, 0.17F, 0.12F);
    ball(shape, top, 0.26F, 0.1F);
    ffp_add_cone(shape, top, ffp_v3(1.05F, 0, 0.56F), 0.12F, 0.025F, 0.03F);
    eyes(shape, ffp_v3(0.6F, 0.2F, 0.7F), 0.06F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_rotate(
            ffp_add_ellipsoid(shape, ffp_v3(-0.15F, 0.37F * s, 0.02F), ffp_v3(0.56F, 0.09F, 0.27F), 0.03F),
            0.15F * s, lean - 0.2F, 0.2F * s);
        ffp_add_cone(shape, ffp_v3(0.02F, 0.17F * s, -0.3F), ffp_v3(0.08F, 0.2F * s, -0.8F), 0.09F, 0.05F,
                     0.06F);
        for (int toe = -1; toe <= 1; toe++)
            ffp_add_cone(shape, ffp_v3(0.08F, 0.2F * s, -0.8F),
                         ffp_v3(0.32F, 0.2F * s + 0.12F * (float)toe, -0.84F), 0.05F, 0.04F, 0.01F);
    }
    ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(-0.72F, 0, -0.28F), ffp_v3(0.45F, 0.2F, 0.07F), 0.08F), 0,
                    -0.25F, 0);
}

static void octopus(FfpShape *shape) {
    static const float arm[5][4] = {{0.15F, 0, -0.1F, 0.18F},
                                    {0.5F, 0.05F, -0.42F, 0.14F},
                                    {0.85F, 0.2F, -0.5F, 0.1F},
                                    {1.1F, 0.42F, -0.4F, 0.08F},
                                    {1.1F, 0.62F, -0.2F, 0.04F}};
    static const float curl[5][4] = {{0.15F, 0, -0.1F, 0.18F},
                                     {0.55F, -0.05F, -0.3F, 0.14F},
                                     {0.85F, -0.1F, -0.52F, 0.1F},
                                     {0.8F, -0.4F, -0.5F, 0.08F},
                                     {0.55F, -0.5F, -0.5F, 0.05F}};
    ffp_add_ellipsoid(shape, ffp_v3(-0.08F, 0, 0.5F), ffp_v3(0.42F, 0.38F, 0.52F), 0);
    ball(shape, ffp_v3(0, 0, 0), 0.3F, 0.15F);
    for (int i = 0; i < 8; i++)
        ffp_add_tube(shape, i & 1 ? curl : arm, 5, i < 4 ? 1 : -1, 0.25F * FFP_PI * (float)i, 0.12F);
    eyes(shape, ffp_v3(0.2F, 0.22F, 0.18F), 0.11F);
}

static void elephant(FfpShape *shape) {
    static const float trunk[5][4] = {{0.9F, 0, 0.32F, 0.22F},
                                      {1.22F, 0, 0.1F, 0.14F},
                                      {1.3F, 0, -0.3F, 0.11F},
                                      {1.42F, 0, -0.6F, 0.09F},
                                      {1.62F, 0, -0.62F, 0.075F}};
    static const float tusk[3][4] = {
        {1, 0.15F, 0.1F, 0.07F}, {1.25F, 0.22F, -0.05F, 0.06F}, {1.5F, 0.2F, 0.08F, 0.03F}};
    ffp_add_ellipsoid(shape, ffp_v3(-0.1F, 0, 0.1F), ffp_v3(0.75F, 0.5F, 0.52F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.82F, 0, 0.38F), ffp_v3(0.36F, 0.32F, 0.38F), 0.15F);
    ffp_add_tube(shape, trunk, 5, 1, 0, 0.1F);
    both(shape, tusk, 3, 0.02F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_rotate(
            ffp_add_ellipsoid(shape, ffp_v3(0.68F, 0.5F * s, 0.36F), ffp_v3(0.07F, 0.32F, 0.38F), 0.04F),
            -0.5F * s, 0.1F, 0.1F * s);
        ffp_add_cone(shape, ffp_v3(0.35F, 0.26F * s, -0.2F), ffp_v3(0.4F, 0.28F * s, -0.82F), 0.22F, 0.18F,
                     0.08F);
        ffp_add_cone(shape, ffp_v3(-0.5F, 0.26F * s, -0.2F), ffp_v3(-0.52F, 0.28F * s, -0.82F), 0.24F, 0.18F,
                     0.08F);
    }
    ffp_add_cone(shape, ffp_v3(-0.8F, 0, 0.2F), ffp_v3(-0.98F, 0, -0.3F), 0.06F, 0.04F, 0.04F);
    eyes(shape, ffp_v3(1.06F, 0.24F, 0.45F), 0.05F);
}

static void rabbit(FfpShape *shape) {
    static const float ear[4][4] = {{0.3F, 0.1F, 0.75F, 0.08F},
                                    {0.22F, 0.14F, 1.05F, 0.12F},
                                    {0.12F, 0.2F, 1.35F, 0.1F},
                                    {0.06F, 0.22F, 1.5F, 0.05F}};
    ffp_add_ellipsoid(shape, ffp_v3(-0.2F, 0, -0.1F), ffp_v3(0.5F, 0.42F, 0.48F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.15F, 0, 0.05F), ffp_v3(0.32F, 0.3F, 0.4F), 0.15F);
    ffp_add_ellipsoid(shape, ffp_v3(0.35F, 0, 0.58F), ffp_v3(0.3F, 0.25F, 0.26F), 0.08F);
    both(shape, ear, 4, 0.04F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_add_ellipsoid(shape, ffp_v3(-0.15F, 0.34F * s, -0.25F), ffp_v3(0.32F, 0.16F, 0.3F), 0.06F);
        ffp_add_ellipsoid(shape, ffp_v3(0.12F, 0.36F * s, -0.52F), ffp_v3(0.34F, 0.12F, 0.09F), 0.04F);
        ffp_add_cone(shape, ffp_v3(0.3F, 0.16F * s, -0.1F), ffp_v3(0.42F, 0.15F * s, -0.52F), 0.12F, 0.09F,
                     0.05F);
    }
    ball(shape, ffp_v3(-0.7F, 0, -0.3F), 0.15F, 0.03F);
    ball(shape, ffp_v3(0.62F, 0, 0.5F), 0.1F, 0.05F);
    eyes(shape, ffp_v3(0.5F, 0.18F, 0.66F), 0.06F);
}

static void seahorse(FfpShape *shape) {
    static const float body[11][4] = {
        {0.1F, 0, 0.95F, 0.2F},     {-0.15F, 0, 0.72F, 0.2F},  {-0.12F, 0, 0.4F, 0.25F},
        {0.05F, 0, 0.1F, 0.32F},    {0.05F, 0, -0.25F, 0.28F}, {-0.1F, 0, -0.55F, 0.19F},
        {-0.08F, 0, -0.85F, 0.14F}, {0.15F, 0, -1.05F, 0.11F}, {0.4F, 0, -0.92F, 0.09F},
        {0.4F, 0, -0.7F, 0.08F},    {0.24F, 0, -0.72F, 0.06F}};
    ffp_add_tube(shape, body, 11, 1, 0, 0);
    ffp_add_cone(shape, ffp_v3(0.15F, 0, 0.95F), ffp_v3(0.62F, 0, 0.82F), 0.15F, 0.08F, 0.06F);
    for (int i = 0; i < 5; i++)
        ffp_add_cone(shape, ffp_v3(-0.02F - 0.07F * (float)i, 0, 1.1F - 0.05F * (float)i),
                     ffp_v3(-0.05F - 0.13F * (float)i, 0, 1.3F - 0.12F * (float)i), 0.06F, 0.035F, 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.32F, 0, -0.05F), ffp_v3(0.26F, 0.05F, 0.26F), 0.04F);
    for (int i = 0; i < 9; i++) { // the rings of its armour
        const float z = 0.45F - 0.11F * (float)i,
                    x = i < 3 ? -0.1F + 0.06F * (float)i : 0.05F - 0.01F * (float)i;
        ffp_add_torus(shape, ffp_v3(x, 0, z), 0.25F + 0.02F * sinf(0.4F * (float)i), 0.045F, 0.02F);
    }
    eyes(shape, ffp_v3(0.22F, 0.17F, 1), 0.06F);
}

static void coiled_snake(FfpShape *shape) {
    float path[22][4];
    for (int i = 0; i < 22; i++) {
        const float t = (float)i, a = 0.85F * t, r = i < 17 ? 0.85F - 0.03F * t : 0.34F - 0.03F * (t - 17);
        path[i][0] = r * cosf(a), path[i][1] = r * sinf(a), path[i][2] = -0.6F + 0.047F * t;
        path[i][3] = 0.05F + 0.13F * fminf(1, 0.12F * t);
    }
    static const float head[5][4] = {{0.1F, 0, 0.5F, 0.17F},
                                     {0.05F, 0, 0.8F, 0.14F},
                                     {0.15F, 0, 1.1F, 0.13F},
                                     {0.42F, 0, 1.2F, 0.17F},
                                     {0.72F, 0, 1.12F, 0.1F}};
    for (int i = 18; i < 22; i++) path[i][2] += 0.06F * (float)(i - 17);
    ffp_add_tube(shape, path, 22, 1, 0, 0);
    ffp_add_cone(shape, ffp_v3(path[21][0], path[21][1], path[21][2]), ffp_v3(0.1F, 0, 0.5F), 0.17F, 0.17F,
                 0.1F);
    ffp_add_tube(shape, head, 5, 1, 0, 0.05F);
    eyes(shape, ffp_v3(0.5F, 0.13F, 1.27F), 0.055F);
}

static void crab(FfpShape *shape) {
    static const float leg[4][4] = {
        {0, 0.4F, 0, 0.1F}, {0, 0.8F, 0.2F, 0.08F}, {0, 1.05F, 0, 0.065F}, {0, 1.12F, -0.35F, 0.04F}};
    static const float arm[4][4] = {{0.3F, 0.4F, 0, 0.11F},
                                    {0.5F, 0.75F, 0.05F, 0.1F},
                                    {0.8F, 0.8F, 0.08F, 0.1F},
                                    {0.92F, 0.62F, 0.1F, 0.13F}};
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.48F, 0.65F, 0.26F), 0);
    for (int i = 0; i < 3; i++) {
        float moved[4][4];
        for (int p = 0; p < 4; p++)
            for (int k = 0; k < 4; k++)
                moved[p][k] =
                    leg[p][k] - (k == 0 ? (0.25F + 0.15F * (float)p) * (float)i - 0.12F * (float)p : 0);
        both(shape, moved, 4, 0.03F);
    }
    both(shape, arm, 4, 0.03F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_add_ellipsoid(shape, ffp_v3(1.02F, 0.5F * s, 0.12F), ffp_v3(0.22F, 0.16F, 0.13F), 0.04F);
        ffp_add_cone(shape, ffp_v3(1.1F, 0.52F * s, 0.12F), ffp_v3(1.35F, 0.3F * s, 0.12F), 0.09F, 0.04F,
                     0.02F);
        ffp_add_cone(shape, ffp_v3(1.05F, 0.38F * s, 0.12F), ffp_v3(1.22F, 0.12F * s, 0.12F), 0.08F, 0.035F,
                     0.02F);
        ffp_add_cone(shape, ffp_v3(0.42F, 0.16F * s, 0.12F), ffp_v3(0.52F, 0.18F * s, 0.4F), 0.05F, 0.045F,
                     0.02F);
        ball(shape, ffp_v3(0.52F, 0.18F * s, 0.42F), 0.08F, 0.01F);
    }
    shape->bump = 0.012F, shape->bump_frequency = 5;
}

const FfpFamily ffp_family_animal = {{{"carp", carp},
                                      {"horse", horse},
                                      {"turtle", turtle},
                                      {"standing bird", standing_bird},
                                      {"octopus", octopus},
                                      {"elephant", elephant},
                                      {"rabbit", rabbit},
                                      {"seahorse", seahorse},
                                      {"coiled snake", coiled_snake},
                                      {"crab", crab}}};
