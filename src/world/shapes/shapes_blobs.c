// Soft forms: balls and tubes run together.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/shape.h"

static FfpV3 along(FfpV3 a, FfpV3 d, float t) {
    return ffp_v3(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z);
}

static FfpV3 direction(FfpRng *rng) {
    const float z = ffp_draw(rng, -1, 1), a = ffp_draw(rng, 0, 2 * FFP_PI), r = sqrtf(1 - z * z);
    return ffp_v3(r * cosf(a), r * sinf(a), z);
}

static void ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

static void clump(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    FfpV3 at = ffp_v3(0, 0, 0);
    for (int i = 0; i < 8; i++) { // a walk that is drawn back to the middle
        ball(shape, at, ffp_draw(&rng, 0.22F, 0.42F), 0.12F);
        at = along(ffp_v3(0.75F * at.x, 0.75F * at.y, 0.75F * at.z), direction(&rng),
                   ffp_draw(&rng, 0.4F, 0.7F));
    }
    shape->upright = false;
}

static void worm(FfpShape *shape) {
    static const float path[8][4] = {{-1, 0, -0.3F, 0.1F},        {-0.6F, 0.3F, -0.2F, 0.2F},
                                     {-0.2F, -0.1F, 0.1F, 0.24F}, {0, -0.4F, 0.5F, 0.22F},
                                     {0.4F, -0.1F, 0.6F, 0.24F},  {0.5F, 0.3F, 0.1F, 0.26F},
                                     {0.7F, 0.1F, -0.4F, 0.22F},  {1.1F, -0.2F, -0.4F, 0.16F}};
    ffp_add_tube(shape, path, 8, 1, 0, 0);
    shape->bump = 0.05F, shape->bump_frequency = 2.5F;
    shape->upright = false;
}

static void jack(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    ball(shape, ffp_v3(0, 0, 0), 0.34F, 0);
    for (int i = 0; i < 7; i++) {
        const float z = -0.86F + 0.286F * (float)i, a = 2.4F * (float)i, r = sqrtf(1 - z * z),
                    reach = ffp_draw(&rng, 0.65F, 0.95F);
        const FfpV3 end = ffp_v3(reach * r * cosf(a), reach * r * sinf(a), reach * z);
        ffp_add_cone(shape, ffp_v3(0, 0, 0), end, 0.16F, 0.1F, 0.15F);
        ball(shape, end, ffp_draw(&rng, 0.14F, 0.24F), 0.08F);
    }
    shape->upright = false;
}

static void bead_ring(FfpShape *shape) {
    for (int i = 0; i < 11; i++) {
        const float a = 2 * FFP_PI * (float)i / 11, r = 0.25F + 0.05F * cosf(a) + 0.05F * (float)(i & 1);
        ball(shape, ffp_v3(0.72F * cosf(a), 0.72F * sinf(a), 0.18F * sinf(2 * a)), r, 0.1F);
    }
    shape->upright = false;
}

static void sponge(FfpShape *shape) {
    ball(shape, ffp_v3(0, 0, 0), 0.85F, 0);
    for (int a = 0; a < 3; a++) {
        FfpPart *bore = ffp_add_cylinder(shape, ffp_v3(0.06F * (float)a, 0.05F, -0.04F * (float)a), 0.34F, 2,
                                         0.02F, 0.3F);
        ffp_part_align(bore, ffp_v3(a == 0, a == 1, a == 2));
        ffp_cut(bore);
    }
    shape->bump = 0.05F, shape->bump_frequency = 2;
    shape->upright = false;
}

static void cloud(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    for (int i = 0; i < 18; i++) {
        const float x = ffp_draw(&rng, -0.75F, 0.75F), y = ffp_draw(&rng, -0.28F, 0.28F),
                    r = ffp_draw(&rng, 0.2F, 0.34F) * (1.1F - 0.4F * fabsf(x));
        ball(shape, ffp_v3(x, y, ffp_draw(&rng, 0.05F, 0.45F) * (1 - 0.8F * fabsf(x))), r, 0.03F);
    }
    ffp_add_box(shape, ffp_v3(0, 0, -0.02F), ffp_v3(0.7F, 0.25F, 0.12F), 0.1F, 0.05F);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, -1.12F), ffp_v3(2, 2, 1), 0, 0.08F));
}

static void stalagmite(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    static const float column[4][4] = {{0.05F, 0.3F, 0.8F, 0.16F},
                                       {-0.1F, 0.35F, 0.62F, 0.13F},
                                       {0.35F, -0.25F, 0.5F, 0.14F},
                                       {-0.35F, -0.3F, 0.35F, 0.12F}};
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.75F), ffp_v3(0.75F, 0.7F, 0.2F), 0);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 7; k++) {
            const float t = (float)k / 6, h = 2.1F * column[i][2] * t,
                        r = column[i][3] * (1.5F - t) * ffp_draw(&rng, 0.9F, 1.15F);
            ffp_add_ellipsoid(shape, ffp_v3(column[i][0], column[i][1], -0.75F + h),
                              ffp_v3(r, r, 0.22F * column[i][2]), 0.06F);
        }
    shape->bump = 0.02F, shape->bump_frequency = 3;
}

static void branch(FfpShape *shape, FfpRng *rng, FfpV3 at, FfpV3 way, float length, float thick, int depth) {
    const FfpV3 end = along(at, way, length);
    ffp_add_cone(shape, at, end, thick, 0.75F * thick, 0.08F);
    if (depth == 0) {
        ball(shape, end, thick, 0.04F);
        return;
    }
    const float turn = ffp_draw(rng, 0, 2 * FFP_PI);
    for (int i = 0; i < (depth == 3 ? 4 : 2); i++) {
        const float a = turn + 2 * FFP_PI * (float)i / (depth == 3 ? 4 : 2), out = ffp_draw(rng, 0.5F, 0.9F);
        const FfpV3 d = ffp_v3(way.x + out * cosf(a), way.y + out * sinf(a), 0.7F * way.z + 0.3F);
        const float n = 1 / sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
        branch(shape, rng, end, ffp_v3(n * d.x, n * d.y, n * d.z), 0.82F * length, 0.76F * thick, depth - 1);
    }
}

static void coral(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    branch(shape, &rng, ffp_v3(0, 0, -0.9F), ffp_v3(0, 0, 1), 0.5F, 0.2F, 3);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.9F), ffp_v3(0.5F, 0.5F, 0.14F), 0.1F);
}

static void splash(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.4F), ffp_v3(0.9F, 0.9F, 0.14F), 0);
    ffp_add_torus(shape, ffp_v3(0, 0, -0.22F), 0.6F, 0.13F, 0.15F);
    for (int i = 0; i < 10; i++) {
        const float a = 2 * FFP_PI * (float)i / 10, h = ffp_draw(&rng, 0.1F, 0.55F), r = 0.62F + 0.25F * h;
        const FfpV3 foot = ffp_v3(0.6F * cosf(a), 0.6F * sinf(a), -0.2F),
                    top = ffp_v3(r * cosf(a), r * sinf(a), h);
        ffp_add_cone(shape, foot, top, 0.12F, 0.05F, 0.15F);
        ball(shape, top, ffp_draw(&rng, 0.07F, 0.13F), 0.06F);
    }
    ffp_add_cone(shape, ffp_v3(0, 0, -0.35F), ffp_v3(0, 0, 0.45F), 0.12F, 0.05F, 0.2F);
    ball(shape, ffp_v3(0, 0, 0.5F), 0.15F, 0.08F);
}

static void double_hole(FfpShape *shape) {
    ffp_add_torus(shape, ffp_v3(-0.48F, 0, 0), 0.42F, 0.22F, 0);
    ffp_part_rotate(ffp_add_torus(shape, ffp_v3(0.46F, 0, 0.1F), 0.36F, 0.2F, 0.3F), 0, 0.3F, 0.7F);
    ball(shape, ffp_v3(0, 0.1F, 0), 0.3F, 0.3F);
    shape->upright = false;
}

const FfpFamily ffp_family_blob = {{{"clump", clump},
                                    {"worm", worm},
                                    {"jack", jack},
                                    {"bead ring", bead_ring},
                                    {"sponge", sponge},
                                    {"cloud", cloud},
                                    {"stalagmite", stalagmite},
                                    {"coral", coral},
                                    {"splash", splash},
                                    {"double hole", double_hole}}};
