// Machine parts and plain solids: sharp edges, bores, flat faces.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/shape.h"

static FfpPart *bore(FfpShape *shape, FfpV3 at, FfpV3 way, float radius) {
    FfpPart *hole = ffp_add_cylinder(shape, at, radius, 3, 0.01F, 0.01F);
    ffp_part_align(hole, way);
    return ffp_cut(hole);
}

static void spur_gear(FfpShape *shape) {
    ffp_add_cog(shape, ffp_v3(0, 0, 0), 0.74F, 0.2F, 0.2F, 16, 2.5F);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(0, 0, 0.22F), 0.58F, 0.12F, 0.02F, 0.02F));
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(0, 0, -0.22F), 0.58F, 0.12F, 0.02F, 0.02F));
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.3F, 0.3F, 0.03F, 0.03F);
    bore(shape, ffp_v3(0, 0, 0), ffp_v3(0, 0, 1), 0.15F);
    shape->lipschitz = 2;
    shape->upright = false;
}

static void spoked_wheel(FfpShape *shape) {
    FfpPart *rim = ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.82F, 0.15F, 0);
    ffp_part_align(rim, ffp_v3(0, 1, 0));
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.2F, 0.24F, 0.03F, 0), ffp_v3(0, 1, 0));
    for (int i = 0; i < 5; i++) {
        const float a = 0.4F * FFP_PI * (float)i;
        ffp_add_cone(shape, ffp_v3(0, 0, 0), ffp_v3(0.82F * cosf(a), 0, 0.82F * sinf(a)), 0.1F, 0.075F,
                     0.04F);
    }
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.1F, 0.4F, 0.03F, 0.01F), ffp_v3(0, 1, 0));
}

static void helical_gear(FfpShape *shape) {
    ffp_add_cog(shape, ffp_v3(0, 0, 0), 0.62F, 0.6F, 0.26F, 9, 1.4F);
    bore(shape, ffp_v3(0, 0, 0), ffp_v3(0, 0, 1), 0.26F);
    shape->twist = 1.1F;
    shape->lipschitz = 2;
}

static void gear_shaft(FfpShape *shape) {
    ffp_add_cog(shape, ffp_v3(0, 0, -0.35F), 0.6F, 0.16F, 0.18F, 14, 2.2F);
    ffp_add_cog(shape, ffp_v3(0, 0, 0.32F), 0.3F, 0.24F, 0.14F, 8, 1.8F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.15F, 1.05F, 0.03F, 0.02F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.85F), 0.26F, 0.08F, 0.02F, 0.01F);
    ffp_cut(ffp_add_box(shape, ffp_v3(0.14F, 0, 0.9F), ffp_v3(0.05F, 0.06F, 0.2F), 0, 0));
    shape->lipschitz = 2;
    shape->upright = false;
}

static void bolt(FfpShape *shape) {
    FfpV3 last = ffp_v3(0, 0, 0);
    ffp_add_prism(shape, ffp_v3(0, 0, 0.82F), 6, 0.52F, 0.52F, 0.18F, 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 1.04F), ffp_v3(0.3F, 0.3F, 0.1F), 0.02F));
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.1F), 0.22F, 0.9F, 0.06F, 0.01F);
    for (int i = 0; i <= 128; i++) {
        const float a = FFP_PI * (float)i / 8, z = -0.9F + 0.0098F * (float)i;
        const FfpV3 at = ffp_v3(0.24F * cosf(a), 0.24F * sinf(a), z);
        if (i > 0) ffp_add_cone(shape, last, at, 0.05F, 0.05F, 0);
        last = at;
    }
    ffp_add_prism(shape, ffp_v3(0, 0, 0.1F), 6, 0.46F, 0.46F, 0.14F, 0);
    shape->upright = false;
}

static void propeller(FfpShape *shape) {
    ffp_add_cone(shape, ffp_v3(0, 0, -0.25F), ffp_v3(0, 0, 0.3F), 0.24F, 0.12F, 0);
    for (int i = 0; i < 3; i++) {
        const float a = 2.0944F * (float)i;
        for (int k = 0; k < 5; k++) {
            const float r = 0.3F + 0.15F * (float)k, half = 0.2F + 0.09F * sinf(0.7F * (float)k);
            ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(r * cosf(a), r * sinf(a), 0),
                                              ffp_v3(0.16F, half, 0.06F), 0.06F),
                            a, 0, 0.95F - 0.15F * (float)k);
        }
    }
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.4F), 0.12F, 0.2F, 0.02F, 0.02F);
    shape->upright = false;
}

static void pipe_tee(FfpShape *shape) {
    static const float way[3][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 0.4F, 0.92F}};
    for (int i = 0; i < 3; i++) {
        const FfpV3 d = ffp_v3(way[i][0], way[i][1], way[i][2]);
        ffp_part_align(
            ffp_add_cylinder(shape, ffp_v3(0.4F * d.x, 0.4F * d.y, 0.4F * d.z), 0.3F, 0.5F, 0.02F, 0.06F), d);
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0.88F * d.x, 0.88F * d.y, 0.88F * d.z), 0.46F, 0.09F,
                                        0.02F, 0.01F),
                       d);
    }
    for (int i = 0; i < 3; i++) {
        const FfpV3 d = ffp_v3(way[i][0], way[i][1], way[i][2]);
        FfpPart *hole =
            ffp_add_cylinder(shape, ffp_v3(0.6F * d.x, 0.6F * d.y, 0.6F * d.z), 0.21F, 0.65F, 0, 0.01F);
        ffp_part_align(hole, d);
        ffp_cut(hole);
    }
    shape->upright = false;
}

// A crankshaft: journals, webs and pins out of line.
static void crankshaft(FfpShape *shape) {
    for (int i = 0; i < 4; i++)
        ffp_add_cylinder(shape, ffp_v3(0, 0, -1 + 0.66F * (float)i), 0.16F, 0.17F, 0.02F, 0.01F);
    for (int i = 0; i < 3; i++) {
        const float a = 2.0944F * (float)i, z = -0.67F + 0.66F * (float)i, x = 0.36F * cosf(a),
                    y = 0.36F * sinf(a);
        ffp_add_cylinder(shape, ffp_v3(x, y, z), 0.13F, 0.22F, 0.01F, 0.01F);
        for (int side = -1; side <= 1; side += 2) {
            FfpPart *web = ffp_add_box(shape, ffp_v3(0.25F * x, 0.25F * y, z + 0.16F * (float)side),
                                       ffp_v3(0.5F, 0.24F, 0.06F), 0.04F, 0.01F);
            ffp_part_rotate(web, a, 0, 0);
        }
    }
    shape->upright = false;
}

static void pulley_block(FfpShape *shape) {
    for (int side = -1; side <= 1; side += 2) {
        ffp_add_box(shape, ffp_v3(0, 0.3F * (float)side, 0), ffp_v3(0.34F, 0.06F, 0.7F), 0.06F, 0);
        ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0.3F * (float)side, 0), 0.42F, 0.06F, 0.02F, 0.02F),
                       ffp_v3(0, 1, 0));
    }
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.14F, 0.46F, 0.03F, 0.01F), ffp_v3(0, 1, 0));
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.52F, 0.16F, 0.03F, 0), ffp_v3(0, 1, 0));
    FfpPart *groove = ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.56F, 0.12F, 0.01F);
    ffp_part_align(groove, ffp_v3(0, 1, 0));
    ffp_cut(groove);
    ffp_add_box(shape, ffp_v3(0, 0, 0.68F), ffp_v3(0.24F, 0.36F, 0.07F), 0.03F, 0.01F);
    ffp_add_box(shape, ffp_v3(0, 0, -0.68F), ffp_v3(0.24F, 0.36F, 0.07F), 0.03F, 0.01F);
    static const float hook[6][4] = {{0, 0, 0.7F, 0.08F},       {0, 0, 0.92F, 0.075F},
                                     {0.22F, 0, 1.08F, 0.075F}, {0.2F, 0, 1.35F, 0.075F},
                                     {-0.08F, 0, 1.4F, 0.065F}, {-0.2F, 0, 1.22F, 0.04F}};
    ffp_add_tube(shape, hook, 6, 1, 0, 0.03F);
}

static void spanner(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.85F, 0.13F, 0.07F), 0.03F, 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, 0.1F), ffp_v3(0.6F, 0.06F, 0.06F), 0.02F, 0.01F));
    ffp_add_cylinder(shape, ffp_v3(0.98F, 0, 0), 0.32F, 0.1F, 0.02F, 0.05F);
    ffp_add_cylinder(shape, ffp_v3(-0.95F, 0, 0), 0.25F, 0.1F, 0.02F, 0.05F);
    ffp_cut(ffp_add_prism(shape, ffp_v3(-0.95F, 0, 0), 6, 0.16F, 0.16F, 0.5F, 0));
    ffp_part_rotate(
        ffp_cut(ffp_add_box(shape, ffp_v3(1.15F, 0.04F, 0), ffp_v3(0.28F, 0.14F, 0.5F), 0.01F, 0)), 0.25F, 0,
        0);
    shape->upright = false;
}

const FfpFamily ffp_family_machine = {{{"spur gear", spur_gear},
                                       {"spoked wheel", spoked_wheel},
                                       {"helical gear", helical_gear},
                                       {"gear shaft", gear_shaft},
                                       {"bolt", bolt},
                                       {"propeller", propeller},
                                       {"pipe tee", pipe_tee},
                                       {"crankshaft", crankshaft},
                                       {"pulley block", pulley_block},
                                       {"spanner", spanner}}};

static void bored_cube(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.7F, 0.6F, 0.65F), 0.1F, 0);
    bore(shape, ffp_v3(0, 0, 0), ffp_v3(1, 0, 0), 0.3F);
    bore(shape, ffp_v3(0, 0, 0), ffp_v3(0, 1, 0), 0.26F);
    bore(shape, ffp_v3(0, 0, 0), ffp_v3(0, 0, 1), 0.34F);
    shape->upright = false;
}

static void crate(FfpShape *shape) {
    const float half[3] = {0.75F, 0.5F, 0.45F};
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(half[0], half[1], half[2]), 0.02F, 0);
    for (int i = 0; i < 6; i++) { // sunk panels with a board across
        const int a = i / 2;
        float at[3] = {0, 0, 0}, panel[3] = {0.78F * half[0], 0.76F * half[1], 0.74F * half[2]}, board[3];
        at[a] = i & 1 ? half[a] : -half[a], panel[a] = 0.09F;
        for (int k = 0; k < 3; k++) board[k] = k == a ? 0.03F : k == (a + 1) % 3 ? 0.1F : 0.95F * half[k];
        ffp_cut(
            ffp_add_box(shape, ffp_v3(at[0], at[1], at[2]), ffp_v3(panel[0], panel[1], panel[2]), 0.01F, 0));
        for (int k = 0; k < 3; k++) at[k] *= 0.93F;
        ffp_add_box(shape, ffp_v3(at[0], at[1], at[2]), ffp_v3(board[0], board[1], board[2]), 0, 0);
    }
    shape->upright = false;
}

static void die(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.62F, 0.62F, 0.62F), 0.04F, 0);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.86F, 0.86F, 0.86F), 0.04F)->join =
        FFP_CSG_INTERSECTION;
    static const float dots[7][3] = {{0, 0, 1}, {1, -0.26F, 0.26F}, {1, 0.26F, -0.26F}, {-0.28F, 1, -0.28F},
                                     {0, 1, 0}, {0.28F, 1, 0.28F},  {0, 0, 0}};
    for (int i = 0; i < 6; i++) {
        const float *d = dots[i], far = 0.66F;
        const FfpV3 at = ffp_v3(fabsf(d[0]) == 1 ? far * d[0] : d[0], fabsf(d[1]) == 1 ? far * d[1] : d[1],
                                fabsf(d[2]) == 1 ? far * d[2] : d[2]);
        ffp_cut(ffp_add_ellipsoid(shape, at, ffp_v3(0.14F, 0.14F, 0.14F), 0.01F));
    }
    for (int i = 0; i < 14; i++) { // four, five and five on the other faces
        const int face = i / 5, k = i % 5;
        const float u = k == 4  ? 0
                        : k & 1 ? 0.26F
                                : -0.26F,
                    v = k == 4  ? 0
                        : k & 2 ? 0.26F
                                : -0.26F,
                    far = -0.66F;
        ffp_cut(ffp_add_ellipsoid(shape,
                                  ffp_v3(face == 0 ? far : u,
                                         face == 1   ? far
                                         : face == 0 ? u
                                                     : v,
                                         face == 2 ? far : v),
                                  ffp_v3(0.14F, 0.14F, 0.14F), 0.01F));
    }
    shape->upright = false;
}

// Two tetrahedra through each other: Kepler's stella octangula, each a corner cut off a cube four times.
static void star_octahedron(FfpShape *shape) {
    static const float corner[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (int c = 0; c < 4; c++)
        for (int other = -1; other <= 1; other += 2) {
            const float s = (float)other / 1.7321F;
            const FfpV3 d = ffp_v3(s * corner[c][0], s * corner[c][1], s * corner[c][2]);
            ffp_part_align(ffp_add_prism(shape, ffp_v3(0.55F * d.x, 0.55F * d.y, 0.55F * d.z), 3, 0.62F,
                                         0.01F, 0.44F, 0),
                           d);
        }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.4F, 0.4F, 0.4F), 0);
    shape->upright = false;
}

static void crossed_bars(FfpShape *shape) {
    ffp_add_superquadric(shape, ffp_v3(0, 0, 0), ffp_v3(0.95F, 0.3F, 0.24F), 0.3F, 0.3F);
    FfpPart *bar = ffp_add_superquadric(shape, ffp_v3(0.1F, 0, 0), ffp_v3(0.3F, 0.9F, 0.3F), 0.5F, 1);
    ffp_part_rotate(bar, 0.3F, 0.2F, 0);
    ffp_part_rotate(ffp_add_superquadric(shape, ffp_v3(-0.2F, 0.1F, 0), ffp_v3(0.2F, 0.26F, 1), 1, 0.25F),
                    0.2F, 0.3F, 0);
    shape->lipschitz = 2;
    shape->upright = false;
}

static void twisted_column(FfpShape *shape) {
    ffp_add_prism(shape, ffp_v3(0, 0, 0), 4, 0.46F, 0.46F, 0.85F, 0);
    ffp_add_prism(shape, ffp_v3(0, 0, -0.92F), 4, 0.66F, 0.6F, 0.13F, 0);
    ffp_add_prism(shape, ffp_v3(0, 0, 0.92F), 4, 0.6F, 0.66F, 0.13F, 0);
    shape->twist = 1.7F;
    shape->lipschitz = 2;
}

static void cube_frame(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.62F, 0.62F, 0.62F), 0.02F, 0);
    for (int a = 0; a < 3; a++)
        ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, 0),
                            ffp_v3(a == 0 ? 2 : 0.46F, a == 1 ? 2 : 0.46F, a == 2 ? 2 : 0.46F), 0, 0));
    shape->upright = false;
}

// A slab with four windows, a pane each way in relief: genus 4.
static void window_frame(FfpShape *shape) {
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(0.72F, 0.1F, 0.9F), 0.03F, 0);
    for (int i = 0; i < 4; i++)
        ffp_cut(ffp_add_box(shape, ffp_v3(i & 1 ? 0.31F : -0.31F, 0, i & 2 ? 0.4F : -0.4F),
                            ffp_v3(0.23F, 1, 0.32F), 0.02F, 0.02F));
    ffp_add_box(shape, ffp_v3(0, 0.1F, -0.92F), ffp_v3(0.85F, 0.26F, 0.07F), 0.02F, 0.01F);
    ffp_add_box(shape, ffp_v3(0, 0.05F, 0.93F), ffp_v3(0.85F, 0.18F, 0.06F), 0.02F, 0.01F);
}

static void stairs(FfpShape *shape) {
    for (int i = 0; i < 6; i++)
        ffp_add_box(shape, ffp_v3(-0.75F + 0.3F * (float)i, 0, -0.5F + 0.11F * (float)i),
                    ffp_v3(0.16F, 0.5F, 0.11F + 0.11F * (float)i), 0.01F, 0);
    ffp_add_box(shape, ffp_v3(1.02F, 0, 0.06F), ffp_v3(0.18F, 0.5F, 0.67F), 0.01F, 0);
    for (int i = 0; i < 2; i++)
        ffp_add_box(shape, ffp_v3(0.85F, i ? 0.46F : -0.46F, 0.5F), ffp_v3(0.34F, 0.05F, 0.42F), 0.01F, 0);
    bore(shape, ffp_v3(0.7F, 0, -0.35F), ffp_v3(0, 1, 0), 0.22F);
}

static void pinched_cushion(FfpShape *shape) {
    ffp_add_superquadric(shape, ffp_v3(0, 0, 0), ffp_v3(0.9F, 0.9F, 0.7F), 1.4F, 2.3F);
    shape->lipschitz = 2;
    shape->twist = 0.5F;
    shape->upright = false;
}

const FfpFamily ffp_family_solid = {{{"bored cube", bored_cube},
                                     {"crate", crate},
                                     {"die", die},
                                     {"star octahedron", star_octahedron},
                                     {"crossed bars", crossed_bars},
                                     {"twisted column", twisted_column},
                                     {"cube frame", cube_frame},
                                     {"window frame", window_frame},
                                     {"stairs", stairs},
                                     {"pinched cushion", pinched_cushion}}};
