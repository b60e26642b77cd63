// Furniture and vehicles. Fronts look along +x.
#include <math.h>
#include "world/shapes/shape.h"

static void chair(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.46F, 0.46F, 0.06F), 0.03F, 0);
    for (int i = 0; i < 4; i++) {
        const float x = i & 1 ? 0.38F : -0.38F, y = i & 2 ? 0.38F : -0.38F;
        ffp_add_cone(shape, ffp_v3(x, y, 0), ffp_v3(1.15F * x, 1.15F * y, -0.7F), 0.07F, 0.05F, 0.02F);
    }
    for (int side = -1; side <= 1; side += 2)
        ffp_add_cone(shape, ffp_v3(-0.4F, 0.38F * (float)side, 0), ffp_v3(-0.52F, 0.38F * (float)side, 1),
                     0.06F, 0.06F, 0.02F);
    for (int i = 0; i < 3; i++) // a back of bars: genus 3
        ffp_add_cone(shape, ffp_v3(-0.45F - 0.03F * (float)i, 0.38F, 0.36F + 0.27F * (float)i),
                     ffp_v3(-0.45F - 0.03F * (float)i, -0.38F, 0.36F + 0.27F * (float)i), 0.055F, 0.055F,
                     0.02F);
}

static void armchair(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0.05F, 0, -0.15F), ffp_v3(0.6F, 0.6F, 0.25F), 0.06F, 0);
    ffp_add_box(shape, ffp_v3(0.1F, 0, 0.18F), ffp_v3(0.55F, 0.44F, 0.14F), 0.1F, 0.02F);
    ffp_part_rotate(ffp_add_box(shape, ffp_v3(-0.52F, 0, 0.45F), ffp_v3(0.17F, 0.58F, 0.6F), 0.14F, 0.05F), 0,
                    -0.15F, 0);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_add_box(shape, ffp_v3(0.05F, 0.62F * s, 0.05F), ffp_v3(0.6F, 0.14F, 0.42F), 0.06F, 0.03F);
        ffp_add_cone(shape, ffp_v3(-0.45F, 0.64F * s, 0.48F), ffp_v3(0.62F, 0.64F * s, 0.44F), 0.19F, 0.19F,
                     0.04F);
        for (int end = -1; end <= 1; end += 2)
            ffp_add_cone(shape, ffp_v3(0.05F + 0.5F * (float)end, 0.55F * s, -0.35F),
                         ffp_v3(0.05F + 0.52F * (float)end, 0.56F * s, -0.58F), 0.08F, 0.06F, 0.01F);
    }
}

static void round_table(FfpShape *shape) {
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.9F, 0.06F, 0.03F, 0);
    ffp_add_cone(shape, ffp_v3(0, 0, 0), ffp_v3(0, 0, -0.6F), 0.12F, 0.1F, 0.1F);
    for (int i = 0; i < 3; i++) {
        const float a = 2.094F * (float)i;
        ffp_add_cone(shape, ffp_v3(0, 0, -0.5F), ffp_v3(0.55F * cosf(a), 0.55F * sinf(a), -0.72F), 0.1F,
                     0.07F, 0.05F);
    }
    ffp_add_ellipsoid(shape, ffp_v3(0.3F, 0.2F, 0.24F), ffp_v3(0.2F, 0.2F, 0.2F), 0.02F); // what stands on it
    ffp_add_cylinder(shape, ffp_v3(-0.35F, -0.2F, 0.3F), 0.13F, 0.28F, 0.03F, 0.02F);
    ffp_add_cylinder(shape, ffp_v3(-0.3F, 0.4F, 0.08F), 0.26F, 0.05F, 0.03F, 0.01F);
}

static void desk(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0.4F), ffp_v3(0.5F, 1, 0.06F), 0.02F, 0);
    ffp_add_box(shape, ffp_v3(-0.02F, -0.66F, -0.1F), ffp_v3(0.44F, 0.28F, 0.5F), 0.01F, 0);
    for (int i = 0; i < 3; i++) { // drawers
        const float z = 0.2F - 0.3F * (float)i;
        ffp_cut(ffp_add_box(shape, ffp_v3(0.43F, -0.66F, z - 0.15F), ffp_v3(0.06F, 0.3F, 0.015F), 0, 0));
        ffp_add_cone(shape, ffp_v3(0.45F, -0.74F, z), ffp_v3(0.45F, -0.58F, z), 0.04F, 0.04F, 0);
    }
    for (int end = -1; end <= 1; end += 2)
        ffp_add_box(shape, ffp_v3(0.4F * (float)end, 0.88F, -0.1F), ffp_v3(0.06F, 0.06F, 0.5F), 0.01F, 0);
    ffp_add_box(shape, ffp_v3(-0.42F, 0.1F, 0.1F), ffp_v3(0.03F, 0.8F, 0.26F), 0, 0);
    ffp_part_rotate(ffp_add_box(shape, ffp_v3(-0.15F, 0.3F, 0.68F), ffp_v3(0.04F, 0.34F, 0.24F), 0.02F, 0),
                    0.3F, -0.15F, 0); // a screen
    ffp_add_box(shape, ffp_v3(-0.15F, 0.3F, 0.48F), ffp_v3(0.14F, 0.16F, 0.04F), 0.01F, 0);
    for (int i = 0; i < 3; i++)
        ffp_part_rotate(
            ffp_add_box(shape, ffp_v3(0, -0.55F, 0.5F + 0.08F * (float)i), ffp_v3(0.2F, 0.26F, 0.04F), 0, 0),
            0.4F * (float)i, 0, 0);
}

static void toy_car(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.95F, 0.4F, 0.18F), 0.08F, 0);
    ffp_add_box(shape, ffp_v3(-0.15F, 0, 0.32F), ffp_v3(0.45F, 0.36F, 0.24F), 0.1F, 0.06F);
    for (int side = -1; side <= 1; side += 2)
        ffp_cut(ffp_add_box(shape, ffp_v3(-0.15F, 0.42F * (float)side, 0.38F), ffp_v3(0.34F, 0.1F, 0.12F),
                            0.04F, 0.02F));
    ffp_cut(ffp_add_box(shape, ffp_v3(0.36F, 0, 0.38F), ffp_v3(0.1F, 0.28F, 0.12F), 0.04F, 0.02F));
    for (int i = 0; i < 4; i++) {
        const float x = i & 1 ? 0.58F : -0.58F, y = i & 2 ? 0.4F : -0.4F;
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(x, y, -0.18F), 0.25F, 0.1F, 0.03F, 0.01F),
                       ffp_v3(0, 1, 0));
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(x, 1.25F * y, -0.18F), 0.11F, 0.05F, 0.02F, 0.01F),
                       ffp_v3(0, 1, 0));
    }
    for (int side = -1; side <= 1; side += 2)
        ffp_add_ellipsoid(shape, ffp_v3(0.95F, 0.26F * (float)side, 0.05F), ffp_v3(0.06F, 0.1F, 0.1F), 0.01F);
    ffp_add_box(shape, ffp_v3(0.98F, 0, -0.12F), ffp_v3(0.05F, 0.42F, 0.06F), 0.03F, 0.01F);
}

static void stool(FfpShape *shape) {
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0.5F), 0.55F, 0.1F, 0.06F, 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.78F), ffp_v3(0.5F, 0.5F, 0.22F), 0.04F));
    for (int i = 0; i < 3; i++) {
        const float a = 2.094F * (float)i, b = a + 2.094F;
        ffp_add_cone(shape, ffp_v3(0.3F * cosf(a), 0.3F * sinf(a), 0.45F),
                     ffp_v3(0.62F * cosf(a), 0.62F * sinf(a), -0.85F), 0.085F, 0.065F, 0.03F);
        ffp_add_cone(shape, ffp_v3(0.5F * cosf(a), 0.5F * sinf(a), -0.35F),
                     ffp_v3(0.5F * cosf(b), 0.5F * sinf(b), -0.35F), 0.05F, 0.05F, 0.01F);
    }
}

// Open on both sides: genus 4.
static void bookshelf(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.28F, 0.66F, 0.95F), 0.01F, 0);
    for (int row = 0; row < 4; row++) {
        const float z = -0.68F + 0.455F * (float)row;
        ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, z), ffp_v3(1, 0.58F, 0.19F), 0, 0));
        float y = -0.55F;
        const float end = ffp_draw(&rng, -0.2F, 0.6F);
        while (y < end) {
            const float thick = ffp_draw(&rng, 0.04F, 0.075F), tall = ffp_draw(&rng, 0.12F, 0.17F);
            ffp_add_box(shape, ffp_v3(ffp_draw(&rng, -0.05F, 0.05F), y + thick, z - 0.2F + tall),
                        ffp_v3(0.2F, thick, tall), 0.01F, 0);
            y += 2 * thick;
        }
    }
}

static void ladder(FfpShape *shape) {
    for (int side = -1; side <= 1; side += 2)
        ffp_add_cone(shape, ffp_v3(-0.1F, 0.42F * (float)side, -1.1F),
                     ffp_v3(0.05F, 0.3F * (float)side, 1.1F), 0.075F, 0.07F, 0);
    for (int i = 0; i < 5; i++) { // five rungs, four openings
        const float t = 0.12F + 0.19F * (float)i, x = -0.1F + 0.15F * t, y = 0.42F - 0.12F * t,
                    z = -1.1F + 2.2F * t;
        ffp_add_cone(shape, ffp_v3(x, y, z), ffp_v3(x, -y, z), 0.06F, 0.06F, 0.02F);
    }
    shape->upright = false;
}

static void bed(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, -0.2F), ffp_v3(1, 0.58F, 0.1F), 0.02F, 0);
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.96F, 0.55F, 0.15F), 0.08F, 0.01F);
    ffp_add_box(shape, ffp_v3(-1, 0, 0.15F), ffp_v3(0.06F, 0.62F, 0.5F), 0.03F, 0.01F);
    ffp_add_box(shape, ffp_v3(1, 0, 0), ffp_v3(0.06F, 0.62F, 0.3F), 0.03F, 0.01F);
    for (int i = 0; i < 4; i++)
        ffp_add_cone(shape, ffp_v3(i & 1 ? 1 : -1, i & 2 ? 0.58F : -0.58F, -0.5F),
                     ffp_v3(i & 1 ? 1 : -1, i & 2 ? 0.58F : -0.58F, i & 1 ? 0.4F : 0.75F), 0.08F, 0.08F,
                     0.01F);
    for (int side = -1; side <= 1; side += 2)
        ffp_add_superquadric(shape, ffp_v3(-0.68F, 0.27F * (float)side, 0.22F), ffp_v3(0.22F, 0.25F, 0.12F),
                             1, 0.4F);
    ffp_add_ellipsoid(shape, ffp_v3(0.25F, 0, 0.1F), ffp_v3(0.78F, 0.62F, 0.15F), 0.05F);
    shape->bump = 0.012F, shape->bump_frequency = 2.5F;
}

static void desk_lamp(FfpShape *shape) {
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.95F), 0.42F, 0.07F, 0.03F, 0);
    ffp_add_cone(shape, ffp_v3(0, 0, -0.9F), ffp_v3(-0.45F, 0, -0.1F), 0.06F, 0.06F, 0.02F);
    ffp_add_cone(shape, ffp_v3(-0.45F, 0, -0.1F), ffp_v3(0.2F, 0, 0.62F), 0.06F, 0.06F, 0.01F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.45F, 0, -0.1F), ffp_v3(0.11F, 0.11F, 0.11F), 0.01F);
    ffp_add_ellipsoid(shape, ffp_v3(0.2F, 0, 0.62F), ffp_v3(0.11F, 0.11F, 0.11F), 0.01F);
    const FfpV3 aim = ffp_v3(0.75F, 0, -0.6F);
    ffp_part_align(ffp_add_prism(shape, ffp_v3(0.45F, 0, 0.45F), 40, 0.14F, 0.46F, 0.3F, 0.02F), aim);
    FfpPart *hollow = ffp_add_prism(shape, ffp_v3(0.54F, 0, 0.38F), 40, 0.1F, 0.44F, 0.31F, 0.01F);
    ffp_part_align(hollow, aim);
    ffp_cut(hollow);
    ffp_add_cone(shape, ffp_v3(0.2F, 0, 0.62F), ffp_v3(0.5F, 0, 0.4F), 0.07F, 0.14F, 0.02F);
}

const FfpFamily ffp_family_furniture = {{{"chair", chair},
                                         {"armchair", armchair},
                                         {"round table", round_table},
                                         {"desk", desk},
                                         {"toy car", toy_car},
                                         {"stool", stool},
                                         {"bookshelf", bookshelf},
                                         {"ladder", ladder},
                                         {"bed", bed},
                                         {"desk lamp", desk_lamp}}};
