// Things piled up, and things that run around: stacks, knots, chains, springs, rings.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/shape.h"

static void ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

static void ring_tower(FfpShape *shape) {
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.85F), 0.72F, 0.1F, 0.04F, 0);
    for (int i = 0; i < 5; i++)
        ffp_add_torus(shape, ffp_v3(0, 0, -0.6F + 0.27F * (float)i), 0.46F - 0.06F * (float)i,
                      0.155F - 0.005F * (float)i, 0.01F);
    ffp_add_cone(shape, ffp_v3(0, 0, -0.8F), ffp_v3(0, 0, 0.8F), 0.14F, 0.08F, 0);
    ball(shape, ffp_v3(0, 0, 0.85F), 0.19F, 0.01F);
}

static void box_tower(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    float z = -1;
    for (int i = 0; i < 6; i++) {
        const float s = 0.42F - 0.05F * (float)i, tall = s * ffp_draw(&rng, 0.5F, 0.9F),
                    yaw = ffp_draw(&rng, 0, FFP_PI);
        const float x = ffp_draw(&rng, -0.08F, 0.08F), y = ffp_draw(&rng, -0.08F, 0.08F);
        ffp_part_rotate(ffp_add_box(shape, ffp_v3(x, y, z + tall), ffp_v3(s, 0.85F * s, tall), 0.02F, 0), yaw,
                        0, 0);
        z += 2 * tall - 0.005F;
    }
    ffp_add_prism(shape, ffp_v3(0, 0, z + 0.14F), 4, 0.2F, 0.01F, 0.15F, 0);
}

static void ball_pyramid(FfpShape *shape) {
    for (int layer = 0; layer < 3; layer++)
        for (int i = 0; i < 3 - layer; i++)
            for (int k = 0; k < 3 - layer; k++) {
                const float low = -0.32F * (float)(2 - layer);
                ball(shape,
                     ffp_v3(low + 0.64F * (float)i, low + 0.64F * (float)k, -0.5F + 0.46F * (float)layer),
                     0.335F, 0);
            }
    ffp_part_rotate(ffp_add_prism(shape, ffp_v3(0, 0, -0.35F), 4, 1.15F, 0.3F, 0.45F, 0), 0.25F * FFP_PI, 0,
                    0);
    ffp_add_box(shape, ffp_v3(0, 0, -0.82F), ffp_v3(1, 1, 0.06F), 0.02F, 0);
}

static void crossing_boxes(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    for (int i = 0; i < 6; i++) {
        const FfpV3 at = ffp_draw3(&rng, ffp_v3(-0.35F, -0.35F, -0.35F), ffp_v3(0.35F, 0.35F, 0.35F)),
                    half = ffp_draw3(&rng, ffp_v3(0.18F, 0.18F, 0.35F), ffp_v3(0.36F, 0.36F, 0.75F));
        const FfpV3 turn = ffp_draw3(&rng, ffp_v3(0, -1.2F, -1.2F), ffp_v3(FFP_PI, 1.2F, 1.2F));
        ffp_part_rotate(ffp_add_box(shape, at, half, 0.02F, 0), turn.x, turn.y, turn.z);
    }
    shape->upright = false;
}

static void book_pile(FfpShape *shape) {
    FfpRng rng = ffp_shape_rng(shape);
    float z = -0.6F;
    for (int i = 0; i < 6; i++) {
        const float thick = ffp_draw(&rng, 0.06F, 0.12F), w = ffp_draw(&rng, 0.42F, 0.56F),
                    d = ffp_draw(&rng, 0.6F, 0.85F), yaw = ffp_draw(&rng, -0.5F, 0.5F);
        const FfpV3 at = ffp_v3(0.02F * (float)(i & 1), 0, z + thick);
        ffp_part_rotate(ffp_add_box(shape, at, ffp_v3(w, d, thick), 0, 0), yaw, 0, 0);
        const FfpV3 edge = ffp_v3(at.x + 0.06F * cosf(yaw), at.y + 0.06F * sinf(yaw), at.z);
        FfpPart *pages =
            ffp_add_box(shape, ffp_v3(edge.x, edge.y, edge.z), ffp_v3(w, 1.2F * d, 0.62F * thick), 0, 0);
        ffp_part_rotate(pages, yaw, 0, 0);
        ffp_cut(pages);
        ffp_part_rotate(ffp_add_box(shape, at, ffp_v3(w - 0.04F, d - 0.05F, 0.8F * thick), 0, 0), yaw, 0, 0);
        ffp_part_rotate(ffp_add_box(shape, ffp_v3(at.x - w * cosf(yaw) + 0.02F, at.y - w * sinf(yaw), at.z),
                                    ffp_v3(0.05F, d, thick), 0.03F, 0),
                        yaw, 0, 0);
        z += 2 * thick - 0.01F;
    }
    ffp_add_torus(shape, ffp_v3(0.1F, 0.1F, z + 0.05F), 0.22F, 0.06F, 0);
}

static void log_pile(FfpShape *shape) {
    for (int layer = 0; layer < 3; layer++)
        for (int i = 0; i < 4 - layer; i++) {
            const float x = 0.42F * ((float)i - 0.5F * (float)(3 - layer)),
                        r = 0.2F + 0.025F * (float)((i + layer) & 1);
            ffp_part_align(
                ffp_add_cylinder(shape, ffp_v3(x, 0.06F * (float)(i - layer), -0.45F + 0.36F * (float)layer),
                                 r, 0.85F, 0.02F, 0.01F),
                ffp_v3(0, 1, 0));
        }
    ffp_add_box(shape, ffp_v3(0, 0, -0.45F), ffp_v3(0.55F, 0.8F, 0.1F), 0, 0);
    ffp_add_box(shape, ffp_v3(0, 0, -0.15F), ffp_v3(0.36F, 0.8F, 0.2F), 0, 0);
    for (int i = 0; i < 2; i++)
        ffp_add_cone(shape, ffp_v3(-0.62F, i ? 0.5F : -0.5F, -0.6F), ffp_v3(-0.95F, i ? 0.5F : -0.5F, 0.2F),
                     0.06F, 0.05F, 0.01F);
    shape->bump = 0.015F, shape->bump_frequency = 4, shape->ridged = true;
}

static void pagoda(FfpShape *shape) {
    float z = -1;
    ffp_add_box(shape, ffp_v3(0, 0, z), ffp_v3(0.7F, 0.7F, 0.06F), 0.01F, 0);
    for (int i = 0; i < 4; i++) {
        const float w = 0.42F - 0.07F * (float)i, tall = 0.17F - 0.02F * (float)i;
        ffp_add_box(shape, ffp_v3(0, 0, z + tall), ffp_v3(w, w, tall), 0.01F, 0);
        ffp_part_rotate(ffp_add_prism(shape, ffp_v3(0, 0, z + 2 * tall + 0.06F), 4, 2.1F * w + 0.12F,
                                      1.1F * w, 0.075F, 0),
                        0.25F * FFP_PI, 0, 0);
        z += 2 * tall + 0.12F;
    }
    ffp_add_cone(shape, ffp_v3(0, 0, z - 0.05F), ffp_v3(0, 0, z + 0.42F), 0.09F, 0.03F, 0.03F);
    for (int i = 0; i < 3; i++)
        ffp_add_torus(shape, ffp_v3(0, 0, z + 0.08F + 0.11F * (float)i), 0.09F - 0.02F * (float)i, 0.04F, 0);
}

static void trilithons(FfpShape *shape) {
    for (int i = 0; i < 2; i++) { // two gates of stone, one across the other's end
        const float yaw = 1.2F * (float)i, c = cosf(yaw), s = sinf(yaw), x = i ? 0.5F : -0.35F,
                    y = i ? 0.25F : -0.3F;
        for (int side = -1; side <= 1; side += 2) {
            const float t = 0.38F * (float)side;
            ffp_part_rotate(
                ffp_add_box(shape, ffp_v3(x + t * c, y + t * s, -0.1F), ffp_v3(0.16F, 0.15F, 0.6F), 0.04F, 0),
                yaw + 0.1F * (float)side, 0, 0.04F);
        }
        ffp_part_rotate(ffp_add_box(shape, ffp_v3(x, y, 0.58F), ffp_v3(0.6F, 0.18F, 0.13F), 0.04F, 0.01F),
                        yaw, 0.03F, 0);
    }
    ffp_add_cylinder(shape, ffp_v3(0.05F, 0, -0.72F), 1, 0.1F, 0.04F, 0.02F);
    shape->bump = 0.025F, shape->bump_frequency = 2.5F, shape->ridged = true;
}

static void snowman(FfpShape *shape) {
    ball(shape, ffp_v3(0, 0, -0.6F), 0.52F, 0);
    ball(shape, ffp_v3(0, 0, 0.08F), 0.38F, 0.04F);
    ball(shape, ffp_v3(0, 0, 0.6F), 0.27F, 0.04F);
    ffp_add_cone(shape, ffp_v3(0.2F, 0, 0.62F), ffp_v3(0.58F, 0, 0.58F), 0.06F, 0.025F, 0.01F);
    ffp_add_prism(shape, ffp_v3(0, 0, 0.98F), 32, 0.2F, 0.25F, 0.16F, 0);
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0.83F), 0.33F, 0.035F, 0.01F, 0);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_add_cone(shape, ffp_v3(0, 0.3F * s, 0.15F), ffp_v3(0.1F, 0.85F * s, 0.42F), 0.05F, 0.035F, 0.01F);
        ffp_add_cone(shape, ffp_v3(0.07F, 0.7F * s, 0.35F), ffp_v3(0.2F, 0.86F * s, 0.28F), 0.035F, 0.03F,
                     0.01F);
        ball(shape, ffp_v3(0.23F, 0.1F * s, 0.7F), 0.045F, 0);
    }
    for (int i = 0; i < 3; i++)
        ball(shape, ffp_v3(0.36F - 0.03F * (float)(i * i - 2 * i), 0, 0.25F - 0.16F * (float)i), 0.05F, 0);
    ffp_add_torus(shape, ffp_v3(0, 0, 0.38F), 0.25F, 0.07F, 0.02F);
    ffp_add_cone(shape, ffp_v3(0.22F, 0.12F, 0.36F), ffp_v3(0.42F, 0.2F, 0.02F), 0.07F, 0.06F, 0.02F);
}

static void rocket(FfpShape *shape) {
    static const float hull[5][4] = {{0, 0, -0.75F, 0.2F},
                                     {0, 0, -0.4F, 0.3F},
                                     {0, 0, 0.1F, 0.32F},
                                     {0, 0, 0.6F, 0.22F},
                                     {0, 0, 1, 0.03F}};
    ffp_add_tube(shape, hull, 5, 1, 0, 0);
    for (int i = 0; i < 3; i++) {
        const float a = 2.0944F * (float)i;
        ffp_part_rotate(ffp_add_box(shape, ffp_v3(0.42F * cosf(a), 0.42F * sinf(a), -0.7F),
                                    ffp_v3(0.28F, 0.04F, 0.22F), 0.03F, 0.02F),
                        a, 0.6F, 0);
        ffp_add_cone(shape, ffp_v3(0.66F * cosf(a), 0.66F * sinf(a), -0.75F),
                     ffp_v3(0.68F * cosf(a), 0.68F * sinf(a), -1.15F), 0.07F, 0.05F, 0.03F);
    }
    ffp_add_prism(shape, ffp_v3(0, 0, -0.98F), 32, 0.24F, 0.16F, 0.1F, 0);
    ffp_part_align(ffp_add_torus(shape, ffp_v3(0.31F, 0, 0.15F), 0.13F, 0.045F, 0.01F), ffp_v3(1, 0, 0));
    ffp_add_torus(shape, ffp_v3(0, 0, -0.35F), 0.31F, 0.04F, 0.01F);
}

const FfpFamily ffp_family_stack = {{{"ring tower", ring_tower},
                                     {"box tower", box_tower},
                                     {"ball pyramid", ball_pyramid},
                                     {"crossing boxes", crossing_boxes},
                                     {"book pile", book_pile},
                                     {"log pile", log_pile},
                                     {"pagoda", pagoda},
                                     {"trilithons", trilithons},
                                     {"snowman", snowman},
                                     {"rocket", rocket}}};

// The torus knot that winds p times around the axis and q times around the ring.
static void torus_knot(FfpShape *shape, int p, int q, float ring, float wave, float tube) {
    const int n = 200;
    FfpV3 last = ffp_v3(0, 0, 0);
    for (int i = 0; i <= n; i++) {
        const float t = 2 * FFP_PI * (float)i / (float)n, r = ring + wave * cosf((float)q * t);
        const FfpV3 at =
            ffp_v3(r * cosf((float)p * t), r * sinf((float)p * t), -1.2F * wave * sinf((float)q * t));
        if (i > 0) ffp_add_cone(shape, last, at, tube, tube, 0);
        last = at;
    }
    shape->upright = false;
}

static void trefoil(FfpShape *shape) {
    torus_knot(shape, 2, 3, 0.6F, 0.32F, 0.17F);
}

static void cinquefoil(FfpShape *shape) {
    torus_knot(shape, 2, 5, 0.68F, 0.26F, 0.1F);
}

static void woven_ring(FfpShape *shape) {
    torus_knot(shape, 3, 7, 0.7F, 0.24F, 0.07F);
}

static void figure_eight(FfpShape *shape) {
    const int n = 180;
    FfpV3 last = ffp_v3(0, 0, 0);
    for (int i = 0; i <= n; i++) {
        const float t = 2 * FFP_PI * (float)i / (float)n, r = 0.32F * (2 + cosf(2 * t));
        const FfpV3 at = ffp_v3(r * cosf(3 * t), r * sinf(3 * t), 0.45F * sinf(4 * t));
        if (i > 0) ffp_add_cone(shape, last, at, 0.15F, 0.15F, 0);
        last = at;
    }
    shape->upright = false;
}

static void chain(FfpShape *shape) {
    for (int i = 0; i < 6; i++) {
        const float a = FFP_PI * (float)i / 3;
        ffp_part_rotate(ffp_add_torus(shape, ffp_v3(0.62F * cosf(a), 0.62F * sinf(a), 0), 0.42F, 0.085F, 0),
                        a + 0.5F * FFP_PI, 0, (i & 1 ? 0.5F : 0) * FFP_PI + 0.2F);
    }
    shape->upright = false;
}

static void spring(FfpShape *shape) {
    FfpV3 last = ffp_v3(0, 0, 0);
    for (int i = 0; i <= 160; i++) {
        const float t = (float)i / 160, a = 2 * FFP_PI * 5 * t, flat = fminf(1, 8 * fminf(t, 1 - t));
        const FfpV3 at = ffp_v3(0.5F * cosf(a), 0.5F * sinf(a),
                                1.7F * (t - 0.5F) + 0.1F * (t < 0.5F ? 1 - flat : flat - 1));
        if (i > 0) ffp_add_cone(shape, last, at, 0.1F, 0.1F, 0);
        last = at;
    }
    shape->upright = false;
}

static void bumpy_torus(FfpShape *shape) {
    ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.62F, 0.34F, 0);
    shape->bump = 0.09F, shape->bump_frequency = 1.8F;
    shape->upright = false;
}

// Three rings, each turning on pins in the next around an axis across the last one's.
static void gimbal(FfpShape *shape) {
    const float c = cosf(0.9F), s = sinf(0.9F);
    const FfpV3 pin = ffp_v3(0, c, s), middle = ffp_v3(0, -s, c);
    const FfpV3 inner = ffp_v3(sinf(0.8F), cosf(0.8F) * middle.y, cosf(0.8F) * middle.z),
                spindle = ffp_v3(cosf(0.8F), -sinf(0.8F) * middle.y, -sinf(0.8F) * middle.z);
    ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.87F, 0.075F, 0);
    ffp_part_align(ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.65F, 0.07F, 0), middle);
    ffp_part_align(ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.43F, 0.065F, 0), inner);
    for (int side = -1; side <= 1; side += 2) {
        const float t = (float)side;
        ffp_add_cone(shape, ffp_v3(0.87F * t, 0, 0), ffp_v3(0.65F * t, 0, 0), 0.06F, 0.06F, 0.02F);
        ffp_add_cone(shape, ffp_v3(0, 0.65F * t * pin.y, 0.65F * t * pin.z),
                     ffp_v3(0, 0.43F * t * pin.y, 0.43F * t * pin.z), 0.055F, 0.055F, 0.02F);
        ffp_add_cone(shape, ffp_v3(0, 0, 0),
                     ffp_v3(0.43F * t * spindle.x, 0.43F * t * spindle.y, 0.43F * t * spindle.z), 0.06F,
                     0.05F, 0.02F);
    }
    ball(shape, ffp_v3(0, 0, 0), 0.2F, 0.03F);
    shape->upright = false;
}

// Salt dough: a rope with its ends laid over the bow.
static void pretzel(FfpShape *shape) {
    static const float rope[11][4] = {
        {-0.32F, 0.08F, -0.62F, 0.09F}, {-0.1F, 0.14F, -0.2F, 0.11F},  {0.2F, 0.1F, 0.1F, 0.13F},
        {0.62F, 0, 0.1F, 0.15F},        {0.72F, 0, -0.3F, 0.16F},      {0, 0, -0.75F, 0.19F},
        {-0.72F, 0, -0.3F, 0.16F},      {-0.62F, 0, 0.1F, 0.15F},      {-0.2F, -0.1F, 0.1F, 0.13F},
        {0.1F, -0.14F, -0.2F, 0.11F},   {0.32F, -0.08F, -0.62F, 0.09F}};
    ffp_add_tube(shape, rope, 11, 1, 0, 0);
    shape->bump = 0.02F, shape->bump_frequency = 2.5F;
    shape->upright = false;
}

// Four handles on a ball: genus 4.
static void ball_of_handles(FfpShape *shape) {
    ball(shape, ffp_v3(0, 0, 0), 0.5F, 0);
    for (int i = 0; i < 4; i++) {
        const float s = i < 2 ? 1 : -1, t = i & 1 ? 1 : -1;
        const FfpV3 d = ffp_v3(0.577F * s, 0.577F * t, 0.577F * s * t);
        ffp_part_rotate(
            ffp_add_torus(shape, ffp_v3(0.62F * d.x, 0.62F * d.y, 0.62F * d.z), 0.3F, 0.085F, 0.08F),
            0.785F * t * s + (s < 0 ? FFP_PI : 0), 0, 0.5F * FFP_PI);
    }
    shape->upright = false;
}

const FfpFamily ffp_family_knot = {{{"trefoil", trefoil},
                                    {"cinquefoil", cinquefoil},
                                    {"figure eight", figure_eight},
                                    {"chain", chain},
                                    {"spring", spring},
                                    {"bumpy torus", bumpy_torus},
                                    {"gimbal", gimbal},
                                    {"pretzel", pretzel},
                                    {"woven ring", woven_ring},
                                    {"ball of handles", ball_of_handles}}};
