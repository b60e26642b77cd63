// Figures and busts. All look along +x.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/scalar.h"
#include "world/shapes/shape.h"

static void ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

// The joints of a body; the pairs are left (+y), right.
typedef struct Pose {
    FfpV3 pelvis, chest, head;
    FfpV3 elbow[2], hand[2], knee[2], foot[2];
} Pose;

static void limb(FfpShape *shape, FfpV3 a, FfpV3 b, FfpV3 c, float thick) {
    ffp_add_cone(shape, a, b, thick, 0.78F * thick, 0.05F);
    ffp_add_cone(shape, b, c, 0.8F * thick, 0.6F * thick, 0.01F);
}

// `build` is the width of the shoulders, `belly` that of the hips.
static void body(FfpShape *shape, const Pose *p, float build, float belly) {
    ffp_add_cone(shape, p->pelvis, p->chest, belly, 0.72F * build, 0);
    for (int i = 0; i < 2; i++) {
        const float s = i ? -1 : 1;
        const FfpV3 shoulder = ffp_v3(p->chest.x, p->chest.y + s * build, p->chest.z + 0.06F);
        const FfpV3 hip = ffp_v3(p->pelvis.x, p->pelvis.y + 0.55F * s * belly, p->pelvis.z - 0.05F);
        limb(shape, shoulder, p->elbow[i], p->hand[i], 0.09F);
        ball(shape, p->hand[i], 0.085F, 0.03F);
        limb(shape, hip, p->knee[i], p->foot[i], 0.125F);
        ffp_add_ellipsoid(shape, ffp_v3(p->foot[i].x + 0.07F, p->foot[i].y, p->foot[i].z - 0.02F),
                          ffp_v3(0.16F, 0.085F, 0.07F), 0.03F);
    }
    ffp_add_cone(shape, p->chest, p->head, 0.1F, 0.08F, 0.06F);
    ffp_add_ellipsoid(shape, p->head, ffp_v3(0.18F, 0.16F, 0.21F), 0.04F);
    ffp_add_cone(shape, ffp_v3(p->head.x + 0.16F, p->head.y, p->head.z),
                 ffp_v3(p->head.x + 0.21F, p->head.y, p->head.z - 0.04F), 0.035F, 0.045F, 0.02F);
}

static void walker(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.05F, 0, 0.42F},
                    {0.1F, 0, 0.82F},
                    {{-0.22F, 0.3F, 0.22F}, {0.25F, -0.32F, 0.24F}},
                    {{-0.1F, 0.36F, -0.1F}, {0.5F, -0.3F, 0.1F}},
                    {{0.32F, 0.12F, -0.42F}, {-0.1F, -0.12F, -0.48F}},
                    {{0.42F, 0.12F, -0.92F}, {-0.5F, -0.12F, -0.82F}}};
    body(shape, &p, 0.23F, 0.2F);
    ffp_add_cylinder(shape, ffp_v3(0.1F, 0, 0.95F), 0.32F, 0.03F, 0.02F, 0.02F);
    ffp_add_cylinder(shape, ffp_v3(0.1F, 0, 1.06F), 0.18F, 0.12F, 0.03F, 0.02F);
    ffp_add_cone(shape, ffp_v3(0.55F, -0.3F, 0.25F), ffp_v3(0.62F, -0.3F, -0.98F), 0.04F, 0.035F,
                 0); // a stick
}

static void dancer(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.02F, 0, 0.4F},
                    {0.05F, 0, 0.8F},
                    {{0, 0.42F, 0.75F}, {0.1F, -0.45F, 0.62F}},
                    {{0, 0.2F, 1.1F}, {0.1F, -0.85F, 0.72F}},
                    {{0, 0.06F, -0.5F}, {0.3F, -0.35F, -0.3F}},
                    {{0, 0.04F, -1}, {0.05F, -0.1F, -0.6F}}};
    body(shape, &p, 0.18F, 0.15F);
    ffp_add_prism(shape, ffp_v3(0, 0, -0.18F), 24, 0.62F, 0.16F, 0.2F, 0.04F);
    ball(shape, ffp_v3(-0.12F, 0, 0.98F), 0.1F, 0.02F);
    shape->ribs = 9, shape->rib_depth = 0.015F;
}

static void sitter(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.12F, 0, 0.45F},
                    {0.3F, 0, 0.8F},
                    {{0.4F, 0.3F, 0.2F}, {0.42F, -0.24F, 0.18F}},
                    {{0.52F, 0.2F, -0.02F}, {0.48F, -0.02F, 0.56F}},
                    {{0.52F, 0.2F, -0.02F}, {0.52F, -0.2F, 0.05F}},
                    {{0.5F, 0.22F, -0.55F}, {0.6F, -0.2F, -0.5F}}};
    body(shape, &p, 0.25F, 0.24F);
    ffp_add_box(shape, ffp_v3(-0.05F, 0, -0.42F), ffp_v3(0.36F, 0.42F, 0.24F), 0.04F,
                0.02F); // the thinker's block
    ffp_add_box(shape, ffp_v3(0.15F, 0, -0.68F), ffp_v3(0.7F, 0.5F, 0.07F), 0.02F, 0.01F);
}

static void handstand(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.02F, 0, -0.42F},
                    {0.12F, 0, -0.76F},
                    {{0.02F, 0.36F, -0.72F}, {0.02F, -0.36F, -0.72F}},
                    {{0.05F, 0.3F, -1.1F}, {0.05F, -0.3F, -1.1F}},
                    {{0.25F, 0.3F, 0.35F}, {-0.15F, -0.35F, 0.38F}},
                    {{0.5F, 0.45F, 0.72F}, {-0.55F, -0.42F, 0.65F}}};
    body(shape, &p, 0.23F, 0.18F);
    ffp_add_cylinder(shape, ffp_v3(0.05F, 0, -1.2F), 0.5F, 0.05F, 0.02F, 0.02F);
}

static void archer(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0, 0, 0.42F},
                    {0.02F, 0.05F, 0.8F},
                    {{0.3F, 0.42F, 0.5F}, {-0.3F, -0.5F, 0.5F}},
                    {{0.62F, 0.66F, 0.52F}, {0.05F, -0.1F, 0.52F}},
                    {{0.42F, 0.2F, -0.22F}, {-0.15F, -0.25F, -0.45F}},
                    {{0.45F, 0.3F, -0.62F}, {-0.62F, -0.3F, -0.58F}}};
    static const float bow[5][4] = {{0.4F, 0.42F, -0.3F, 0.04F},
                                    {0.62F, 0.66F, 0, 0.05F},
                                    {0.68F, 0.72F, 0.5F, 0.055F},
                                    {0.62F, 0.66F, 1, 0.05F},
                                    {0.4F, 0.42F, 1.3F, 0.04F}};
    body(shape, &p, 0.24F, 0.2F);
    ffp_add_tube(shape, bow, 5, 1, 0, 0.02F);
    ffp_add_cone(shape, ffp_v3(0.4F, 0.42F, -0.3F), ffp_v3(0.05F, -0.1F, 0.52F), 0.03F, 0.03F, 0);
    ffp_add_cone(shape, ffp_v3(0.05F, -0.1F, 0.52F), ffp_v3(0.4F, 0.42F, 1.3F), 0.03F, 0.03F, 0);
    ffp_add_box(shape, ffp_v3(0, 0, -0.74F), ffp_v3(0.85F, 0.5F, 0.06F), 0.02F, 0);
}

static void robot(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0.1F), ffp_v3(0.26F, 0.38F, 0.4F), 0.03F, 0);
    ffp_add_box(shape, ffp_v3(0, 0, 0.76F), ffp_v3(0.24F, 0.26F, 0.2F), 0.03F, 0);
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0.53F), 0.12F, 0.06F, 0.01F, 0);
    ffp_add_cone(shape, ffp_v3(0, 0, 0.95F), ffp_v3(0, 0, 1.2F), 0.04F, 0.03F, 0);
    ball(shape, ffp_v3(0, 0, 1.22F), 0.07F, 0);
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0.26F, 0, 0.15F), 0.18F, 0.04F, 0.01F, 0), ffp_v3(1, 0, 0));
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0.24F, 0.11F * s, 0.8F), 0.075F, 0.05F, 0.01F, 0),
                       ffp_v3(1, 0, 0));
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0.45F * s, 0.36F), 0.13F, 0.09F, 0.02F, 0),
                       ffp_v3(0, 1, 0));
        ffp_add_box(shape, ffp_v3(0, 0.52F * s, 0.12F), ffp_v3(0.09F, 0.08F, 0.26F), 0.02F, 0);
        ffp_part_rotate(
            ffp_add_box(shape, ffp_v3(0.2F, 0.52F * s, -0.16F), ffp_v3(0.26F, 0.09F, 0.09F), 0.02F, 0), 0,
            -0.3F * s, 0);
        ffp_add_box(shape, ffp_v3(0.45F, 0.44F * s, -0.16F + 0.1F * s), ffp_v3(0.1F, 0.035F, 0.06F), 0.01F,
                    0);
        ffp_add_box(shape, ffp_v3(0.45F, 0.6F * s, -0.16F + 0.1F * s), ffp_v3(0.1F, 0.035F, 0.06F), 0.01F, 0);
        ffp_add_box(shape, ffp_v3(0, 0.2F * s, -0.55F), ffp_v3(0.12F, 0.11F, 0.34F), 0.02F, 0);
        ffp_add_box(shape, ffp_v3(0.07F, 0.2F * s, -0.92F), ffp_v3(0.24F, 0.15F, 0.09F), 0.03F, 0);
    }
}

static void angel(FfpShape *shape) {
    static const float robe[5][4] = {{0, 0, 0.4F, 0.2F},
                                     {0, 0, 0.1F, 0.18F},
                                     {0.02F, 0, -0.3F, 0.26F},
                                     {0, 0, -0.65F, 0.34F},
                                     {-0.04F, 0, -0.8F, 0.38F}};
    ffp_add_tube(shape, robe, 5, 1, 0, 0);
    ffp_add_cone(shape, ffp_v3(0, 0, 0.4F), ffp_v3(0.06F, 0, 0.75F), 0.1F, 0.09F, 0.06F);
    ffp_add_ellipsoid(shape, ffp_v3(0.08F, 0, 0.8F), ffp_v3(0.17F, 0.16F, 0.2F), 0.03F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        limb(shape, ffp_v3(0, 0.2F * s, 0.45F), ffp_v3(0.22F, 0.3F * s, 0.2F),
             ffp_v3(0.42F, 0.02F * s, 0.32F), 0.09F);
        for (int i = 0; i < 5; i++) { // feathers
            const float a = 0.9F - 0.42F * (float)i, length = 0.5F - 0.05F * (float)i;
            const FfpV3 at =
                ffp_v3(-0.2F, (0.15F + 0.75F * length * cosf(a)) * s, 0.42F + 0.75F * length * sinf(a));
            ffp_part_rotate(ffp_add_ellipsoid(shape, at, ffp_v3(0.05F, length, 0.13F), 0.03F), 0, 0, a * s);
        }
    }
    ball(shape, ffp_v3(-0.12F, 0, 0.42F), 0.16F, 0.06F);
    ffp_add_torus(shape, ffp_v3(0.05F, 0, 1.12F), 0.18F, 0.04F, 0);
    ffp_add_cone(shape, ffp_v3(-0.1F, 0, 0.85F), ffp_v3(-0.13F, 0, 1.12F), 0.05F, 0.035F, 0);
}

static void fencer(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.18F, 0, 0.4F},
                    {0.32F, 0, 0.74F},
                    {{-0.2F, 0.3F, 0.55F}, {0.55F, -0.22F, 0.45F}},
                    {{-0.45F, 0.25F, 0.85F}, {0.95F, -0.18F, 0.5F}},
                    {{-0.32F, 0.16F, -0.32F}, {0.55F, -0.12F, -0.12F}},
                    {{-0.85F, 0.2F, -0.58F}, {0.6F, -0.12F, -0.62F}}};
    body(shape, &p, 0.22F, 0.18F);
    ffp_add_cone(shape, ffp_v3(0.9F, -0.18F, 0.49F), ffp_v3(1.75F, -0.15F, 0.62F), 0.04F, 0.03F, 0);
    ffp_part_align(ffp_add_ellipsoid(shape, ffp_v3(1.05F, -0.175F, 0.51F), ffp_v3(0.12F, 0.12F, 0.04F), 0),
                   ffp_v3(1, 0, 0.15F));
}

static void couple(FfpShape *shape) {
    const Pose a = {{0, 0.42F, 0},
                    {0, 0.44F, 0.42F},
                    {0.04F, 0.44F, 0.82F},
                    {{0.05F, 0.9F, 0.3F}, {0.05F, 0.12F, 0.2F}},
                    {{0.3F, 1.05F, 0.5F}, {0.12F, 0, 0}},
                    {{0.1F, 0.52F, -0.46F}, {0, 0.3F, -0.48F}},
                    {{0, 0.54F, -0.95F}, {0, 0.28F, -0.95F}}};
    const Pose b = {{0, -0.42F, -0.1F},
                    {0, -0.42F, 0.25F},
                    {0.04F, -0.42F, 0.6F},
                    {{0.05F, -0.12F, 0.1F}, {-0.05F, -0.8F, 0.1F}},
                    {{0.12F, 0, 0}, {0.05F, -0.85F, -0.2F}},
                    {{0.05F, -0.3F, -0.5F}, {0.05F, -0.54F, -0.5F}},
                    {{0, -0.3F, -0.95F}, {0, -0.56F, -0.95F}}};
    body(shape, &a, 0.22F, 0.18F);
    body(shape, &b, 0.16F, 0.17F);
    ffp_add_cone(shape, ffp_v3(0, -0.42F, 0.1F), ffp_v3(0, -0.42F, -0.5F), 0.15F, 0.3F, 0.05F);
    ffp_add_box(shape, ffp_v3(0.05F, 0, -1.05F), ffp_v3(0.4F, 0.9F, 0.07F), 0.03F, 0);
}

static void sleeper(FfpShape *shape) {
    const Pose p = {{0, 0, 0},
                    {0.55F, 0.02F, 0.05F},
                    {0.95F, 0.05F, 0.14F},
                    {{0.9F, 0.45F, -0.05F}, {0.35F, -0.36F, 0.05F}},
                    {{1.15F, 0.2F, -0.05F}, {0.05F, -0.25F, 0.2F}},
                    {{-0.4F, 0.25F, 0.32F}, {-0.5F, -0.16F, -0.02F}},
                    {{-0.75F, 0.2F, -0.08F}, {-1.05F, -0.18F, -0.06F}}};
    body(shape, &p, 0.24F, 0.2F);
    ffp_add_box(shape, ffp_v3(0.05F, 0, -0.25F), ffp_v3(1.25F, 0.5F, 0.12F), 0.06F, 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(1, 0.05F, -0.1F), ffp_v3(0.26F, 0.4F, 0.14F), 0.03F);
}

const FfpFamily ffp_family_figure = {{{"walker", walker},
                                      {"dancer", dancer},
                                      {"sitter", sitter},
                                      {"handstand", handstand},
                                      {"archer", archer},
                                      {"robot", robot},
                                      {"angel", angel},
                                      {"fencer", fencer},
                                      {"couple", couple},
                                      {"sleeper", sleeper}}};

static void features(FfpShape *shape, float nose) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.5F), ffp_v3(0.42F, 0.36F, 0.46F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.16F, 0, 0.26F), ffp_v3(0.27F, 0.23F, 0.3F), 0.12F); // jaw
    ffp_add_cone(shape, ffp_v3(0.38F, 0, 0.56F), ffp_v3(0.38F + nose, 0, 0.36F), 0.045F, 0.08F, 0.05F);
    ffp_add_ellipsoid(shape, ffp_v3(0.37F, 0, 0.66F), ffp_v3(0.07F, 0.27F, 0.05F), 0.08F); // brow
    ffp_add_ellipsoid(shape, ffp_v3(0.4F, 0, 0.2F), ffp_v3(0.06F, 0.12F, 0.03F), 0.03F);   // lips
    ffp_add_ellipsoid(shape, ffp_v3(0.36F, 0, 0.03F), ffp_v3(0.1F, 0.1F, 0.09F), 0.08F);   // chin
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_cut(
            ffp_add_ellipsoid(shape, ffp_v3(0.43F, 0.155F * s, 0.56F), ffp_v3(0.09F, 0.09F, 0.055F), 0.05F));
        ball(shape, ffp_v3(0.345F, 0.15F * s, 0.56F), 0.065F, 0.01F);
        ffp_add_ellipsoid(shape, ffp_v3(0, 0.37F * s, 0.47F), ffp_v3(0.1F, 0.05F, 0.14F), 0.03F); // ear
    }
}

static void shoulders(FfpShape *shape, float broad) {
    ffp_add_cone(shape, ffp_v3(-0.05F, 0, 0.3F), ffp_v3(-0.08F, 0, -0.3F), 0.22F, 0.25F, 0.1F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.08F, 0, -0.45F), ffp_v3(0.32F, broad, 0.26F), 0.15F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.02F, 0, -0.65F), ffp_v3(0.34F, 0.75F * broad, 0.28F), 0.15F);
}

static void plinth(FfpShape *shape) {
    ffp_add_cylinder(shape, ffp_v3(-0.03F, 0, -0.95F), 0.2F, 0.15F, 0.02F, 0.06F);
    ffp_add_box(shape, ffp_v3(-0.03F, 0, -1.12F), ffp_v3(0.34F, 0.34F, 0.1F), 0.03F, 0.02F);
}

static void bald_head(FfpShape *shape) {
    features(shape, 0.16F);
    shoulders(shape, 0.5F);
    plinth(shape);
}

static void top_hat(FfpShape *shape) {
    features(shape, 0.1F);
    ffp_add_cone(shape, ffp_v3(-0.05F, 0, 0.3F), ffp_v3(-0.08F, 0, -0.25F), 0.2F, 0.24F, 0.1F);
    ffp_add_cylinder(shape, ffp_v3(-0.08F, 0, -0.3F), 0.42F, 0.06F, 0.02F, 0.08F); // a ruff
    ffp_add_cylinder(shape, ffp_v3(-0.02F, 0, 0.78F), 0.6F, 0.035F, 0.03F, 0.03F);
    ffp_add_prism(shape, ffp_v3(-0.02F, 0, 1.15F), 64, 0.36F, 0.42F, 0.38F, 0.03F);
}

static void curly_bust(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    features(shape, 0.12F);
    shoulders(shape, 0.8F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.16F, 0, 0.55F), ffp_v3(0.4F, 0.46F, 0.46F), 0.02F);
    for (int i = 0; i < 46; i++) {
        const float a = ffp_draw(&rng, 0.8F, 2 * FFP_PI - 0.8F), z = ffp_draw(&rng, -0.6F, 0.95F),
                    r = 0.44F * sqrtf(ffp_max(0.1F, 1 - z * z)) + 0.05F;
        ball(shape, ffp_v3(-0.06F + r * cosf(a), r * sinf(a), 0.52F + 0.44F * z),
             ffp_draw(&rng, 0.09F, 0.17F), 0.03F);
    }
}

static void mask(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.5F, 0.62F, 0.9F), 0);
    ffp_add_cone(shape, ffp_v3(0.42F, 0, 0.25F), ffp_v3(0.62F, 0, -0.12F), 0.09F, 0.13F, 0.08F);
    ffp_add_ellipsoid(shape, ffp_v3(0.42F, 0, 0.42F), ffp_v3(0.12F, 0.45F, 0.1F), 0.1F);
    ffp_add_ellipsoid(shape, ffp_v3(0.38F, 0, -0.42F), ffp_v3(0.16F, 0.3F, 0.16F), 0.1F);
    ffp_add_ellipsoid(shape, ffp_v3(0.22F, 0, -0.78F), ffp_v3(0.2F, 0.2F, 0.2F), 0.1F);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(-0.12F, 0, 0), ffp_v3(0.48F, 0.52F, 0.8F), 0.03F));
    ffp_cut(ffp_add_box(shape, ffp_v3(-1.05F, 0, 0), ffp_v3(1, 2, 2), 0, 0.02F));
    for (int side = -1; side <= 1; side += 2) {
        FfpPart *eye = ffp_add_ellipsoid(shape, ffp_v3(0.4F, 0.24F * (float)side, 0.22F),
                                         ffp_v3(0.5F, 0.13F, 0.08F), 0.02F);
        ffp_part_rotate(eye, 0, 0, 0.25F * (float)side);
        ffp_cut(eye);
        ffp_add_cone(shape, ffp_v3(0.1F, 0.4F * (float)side, 0.7F), ffp_v3(0.05F, 0.75F * (float)side, 1.1F),
                     0.13F, 0.04F, 0.04F); // horns
    }
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.4F, 0, -0.42F), ffp_v3(0.5F, 0.2F, 0.07F), 0.02F));
}

static void bearded_head(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    features(shape, 0.14F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.14F, 0, 0.35F), ffp_v3(0.38F, 0.46F, 0.62F), 0.04F); // long hair
    for (int i = 0; i < 12; i++) {
        const float y = 0.05F * ((float)i - 5.5F), low = ffp_draw(&rng, -0.75F, -0.5F) + 3 * y * y;
        ffp_add_cone(shape, ffp_v3(0.32F - 0.4F * fabsf(y), y, 0.12F),
                     ffp_v3(0.4F - 0.3F * fabsf(y), 0.8F * y, low), 0.07F, 0.045F, 0.02F);
    }
    for (int side = -1; side <= 1; side += 2)
        ffp_add_cone(shape, ffp_v3(0.42F, 0.04F * (float)side, 0.27F),
                     ffp_v3(0.36F, 0.26F * (float)side, 0.16F), 0.05F, 0.03F, 0.02F);
    ffp_add_cylinder(shape, ffp_v3(-0.1F, 0, -0.45F), 0.36F, 0.32F, 0.06F, 0.1F);
    ffp_add_torus(shape, ffp_v3(-0.03F, 0, 0.72F), 0.41F, 0.06F, 0.01F);
}

static void helmet(FfpShape *shape) {
    features(shape, 0.1F);
    ffp_add_cone(shape, ffp_v3(-0.05F, 0, 0.3F), ffp_v3(-0.08F, 0, -0.5F), 0.2F, 0.34F, 0.1F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.06F, 0, 0.56F), ffp_v3(0.47F, 0.43F, 0.52F), 0.01F);
    ffp_cut(ffp_add_box(shape, ffp_v3(0.6F, 0, 0.22F), ffp_v3(0.45F, 0.22F, 0.42F), 0.05F, 0.02F));
    features(shape, 0.1F);
    for (int i = 0; i < 14; i++) { // the crest
        const float a = -0.35F + 0.19F * (float)i, x = -0.06F - 0.62F * sinf(a - 0.6F),
                    z = 0.56F + 0.66F * cosf(a - 0.6F);
        ffp_add_cone(shape, ffp_v3(-0.06F - 0.45F * sinf(a - 0.6F), 0, 0.56F + 0.48F * cosf(a - 0.6F)),
                     ffp_v3(1.15F * x, 0, 0.56F + 1.25F * (z - 0.56F)), 0.07F, 0.08F, 0.01F);
    }
    ffp_add_box(shape, ffp_v3(-0.05F, 0, -0.6F), ffp_v3(0.4F, 0.55F, 0.12F), 0.06F, 0.1F);
}

static void moai(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0.1F), ffp_v3(0.34F, 0.34F, 0.85F), 0.1F, 0);
    ffp_add_box(shape, ffp_v3(0.3F, 0, 0.62F), ffp_v3(0.16F, 0.4F, 0.1F), 0.05F, 0.06F); // brow
    ffp_add_prism(shape, ffp_v3(0.36F, 0, 0.25F), 4, 0.24F, 0.1F, 0.36F, 0.06F);
    ffp_add_box(shape, ffp_v3(0.34F, 0, -0.28F), ffp_v3(0.1F, 0.24F, 0.05F), 0.04F, 0.04F);
    ffp_add_box(shape, ffp_v3(0.34F, 0, -0.42F), ffp_v3(0.1F, 0.22F, 0.045F), 0.04F, 0.04F);
    ffp_add_box(shape, ffp_v3(0.26F, 0, -0.66F), ffp_v3(0.18F, 0.28F, 0.14F), 0.07F, 0.08F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.4F, 0.2F * s, 0.42F), ffp_v3(0.12F, 0.12F, 0.12F), 0.05F));
        ffp_add_box(shape, ffp_v3(-0.05F, 0.37F * s, 0.2F), ffp_v3(0.09F, 0.06F, 0.42F), 0.04F, 0.02F);
    }
    ffp_add_box(shape, ffp_v3(-0.1F, 0, -1.05F), ffp_v3(0.44F, 0.62F, 0.35F), 0.15F, 0.1F);
    shape->bump = 0.03F, shape->bump_frequency = 2.5F;
}

static void skull(FfpShape *shape) {
    static const float jaw[5][4] = {{-0.12F, 0.42F, -0.05F, 0.09F},
                                    {-0.08F, 0.4F, -0.4F, 0.11F},
                                    {0.2F, 0.3F, -0.6F, 0.1F},
                                    {0.42F, 0.14F, -0.68F, 0.11F},
                                    {0.46F, 0, -0.68F, 0.12F}};
    static const float cheek[4][4] = {{0.5F, 0.14F, -0.08F, 0.1F},
                                      {0.42F, 0.34F, -0.06F, 0.08F},
                                      {0.15F, 0.46F, -0.05F, 0.06F},
                                      {-0.1F, 0.46F, 0, 0.06F}};
    ffp_add_ellipsoid(shape, ffp_v3(-0.15F, 0, 0.28F), ffp_v3(0.62F, 0.47F, 0.48F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.22F, 0, -0.05F), ffp_v3(0.36F, 0.32F, 0.42F), 0.12F);
    ffp_add_box(shape, ffp_v3(0.42F, 0, -0.36F), ffp_v3(0.14F, 0.2F, 0.12F), 0.08F, 0.08F);
    for (int side = -1; side <= 1; side += 2) {
        ffp_add_tube(shape, jaw, 5, (float)side, 0, 0.03F);
        ffp_add_tube(shape, cheek, 4, (float)side, 0, 0.03F);
    }
    for (int side = -1; side <= 1; side += 2)
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.52F, 0.19F * (float)side, 0.12F),
                                  ffp_v3(0.24F, 0.14F, 0.13F), 0.03F));
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.58F, 0, -0.13F), ffp_v3(0.12F, 0.07F, 0.11F), 0.02F));
    for (int i = 0; i < 14; i++) { // two rows of teeth
        const float a = 0.3F * ((float)(i % 7) - 3);
        ffp_add_box(shape, ffp_v3(0.3F + 0.24F * cosf(a), 0.24F * sinf(a), i < 7 ? -0.47F : -0.57F),
                    ffp_v3(0.045F, 0.035F, 0.055F), 0.02F, 0);
    }
}

static void chess_knight(FfpShape *shape) {
    static const float neck[4][4] = {{-0.05F, 0, -0.6F, 0.36F},
                                     {-0.25F, 0, -0.1F, 0.34F},
                                     {-0.15F, 0, 0.4F, 0.28F},
                                     {0.08F, 0, 0.68F, 0.22F}};
    ffp_add_tube(shape, neck, 4, 1, 0, 0);
    ffp_add_cone(shape, ffp_v3(0.05F, 0, 0.66F), ffp_v3(0.62F, 0, 0.32F), 0.24F, 0.15F, 0.06F);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.66F, 0, 0.25F), ffp_v3(0.22F, 0.3F, 0.025F), 0.02F));
    for (int i = 0; i < 8; i++)
        ffp_add_ellipsoid(shape, ffp_v3(-0.1F - 0.5F * sinf(0.4F * (float)i), 0, 0.8F - 0.17F * (float)i),
                          ffp_v3(0.15F, 0.07F, 0.12F), 0.02F);
    for (int side = -1; side <= 1; side += 2) {
        ffp_add_prism(shape, ffp_v3(-0.02F, 0.11F * (float)side, 0.95F), 4, 0.1F, 0.02F, 0.14F, 0.03F);
        ball(shape, ffp_v3(0.24F, 0.17F * (float)side, 0.66F), 0.06F, 0.01F);
        ball(shape, ffp_v3(0.68F, 0.09F * (float)side, 0.38F), 0.05F, 0.02F);
    }
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.72F), 0.46F, 0.07F, 0.05F, 0.03F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.9F), 0.56F, 0.12F, 0.05F, 0.03F);
}

static void fox_head(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.1F), ffp_v3(0.52F, 0.56F, 0.5F), 0);
    ffp_add_cone(shape, ffp_v3(0.3F, 0, 0), ffp_v3(1, 0, -0.18F), 0.3F, 0.1F, 0.12F);
    ball(shape, ffp_v3(1.06F, 0, -0.14F), 0.1F, 0.02F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_rotate(ffp_add_prism(shape, ffp_v3(-0.05F, 0.38F * s, 0.72F), 4, 0.27F, 0.02F, 0.36F, 0.04F),
                        0, 0, -0.2F * s);
        ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.12F, 0.4F * s, 0.68F), ffp_v3(0.12F, 0.12F, 0.24F), 0.03F));
        ffp_add_cone(shape, ffp_v3(0.1F, 0.4F * s, -0.1F), ffp_v3(-0.05F, 0.85F * s, -0.22F), 0.26F, 0.05F,
                     0.08F); // whiskers' tuft
        ffp_add_ellipsoid(shape, ffp_v3(0.46F, 0.24F * s, 0.2F), ffp_v3(0.07F, 0.08F, 0.07F), 0.01F);
    }
    ffp_add_cone(shape, ffp_v3(-0.1F, 0, -0.1F), ffp_v3(-0.15F, 0, -0.7F), 0.4F, 0.45F, 0.1F);
    ffp_add_cylinder(shape, ffp_v3(-0.15F, 0, -0.85F), 0.52F, 0.1F, 0.03F, 0.02F);
}

const FfpFamily ffp_family_bust = {{{"bald head", bald_head},
                                    {"top hat", top_hat},
                                    {"curly bust", curly_bust},
                                    {"mask", mask},
                                    {"bearded head", bearded_head},
                                    {"helmet", helmet},
                                    {"moai", moai},
                                    {"skull", skull},
                                    {"chess knight", chess_knight},
                                    {"fox head", fox_head}}};
