// Families with bodies: animals, figures, busts.
#include <math.h>
#include "synth/shape.h"
#include "synth/scalar.h"

#define PI 3.14159265F

static void legs(FfpShape *shape, FfpRng *rng, float length, float width, float height, float blend) {
    const float thick = ffp_draw(rng, 0.07F, 0.15F), foot = thick * ffp_draw(rng, 0.7F, 1.3F),
                drop = ffp_draw(rng, 0.35F, 0.75F);
    for (int i = 0; i < 4; i++) {
        const float x = (i & 1 ? 0.75F : -0.75F) * length, y = (i & 2 ? 0.75F : -0.75F) * width,
                    swing = ffp_draw(rng, -0.12F, 0.12F);
        const FfpV3 hip = ffp_v3(x, y, -0.2F * height),
                    knee = ffp_v3(x + swing, y, -0.2F * height - 0.5F * drop);
        const FfpV3 sole = ffp_v3(x - 0.3F * swing, y, -0.2F * height - drop);
        ffp_add_cone(shape, hip, knee, thick * 1.4F, thick, blend);
        ffp_add_cone(shape, knee, sole, thick, foot, 0.05F);
        ffp_add_ellipsoid(shape, ffp_v3(sole.x + 0.05F, sole.y, sole.z - 0.02F),
                          ffp_v3(foot * 1.4F, foot * 1.1F, foot * 0.8F), 0.04F);
    }
}

static void head(FfpShape *shape, FfpRng *rng, FfpV3 at, float size) {
    const float snout = ffp_draw(rng, 0.4F, 1.3F) * size, droop = ffp_draw(rng, 0.1F, 0.5F),
                blunt = ffp_draw(rng, 0.3F, 0.6F);
    ffp_add_ellipsoid(shape, at, ffp_v3(size * 1.1F, size * 0.85F, size * 0.95F), 0.12F);
    ffp_add_cone(shape, at, ffp_v3(at.x + size + 0.5F * snout, at.y, at.z - droop * size), size * 0.7F,
                 size * blunt, 0.08F);
    const float ear = ffp_draw(rng, 0.3F, 1.2F) * size, spread = ffp_draw(rng, 0.2F, 1.2F);
    const bool horns = ffp_pick(rng, 0, 2) == 0;
    for (int side = -1; side <= 1; side += 2) {
        const float y = at.y + 0.5F * size * (float)side;
        FfpPart *flap = ffp_add_ellipsoid(
            shape, ffp_v3(at.x - 0.3F * size, y + 0.35F * spread * ear * (float)side, at.z + 0.75F * size),
            ffp_v3(0.12F * size + 0.02F, 0.35F * size, ear * 0.6F + 0.05F), 0.05F);
        ffp_part_turn(flap, 0, -0.2F, -spread * (float)side);
        ffp_add_ellipsoid(shape, ffp_v3(at.x + 0.75F * size, y, at.z + 0.4F * size),
                          ffp_v3(0.17F * size, 0.17F * size, 0.17F * size), 0.01F);
        if (horns) {
            const FfpV3 root = ffp_v3(at.x, at.y + 0.3F * size * (float)side, at.z + 0.7F * size);
            ffp_add_cone(shape, root,
                         ffp_v3(root.x + 0.1F, root.y + 0.4F * size * (float)side, root.z + 0.7F * size),
                         0.06F, 0.025F, 0.03F);
        }
    }
}

static void quadruped(FfpShape *shape, FfpRng *rng) {
    const float length = ffp_draw(rng, 0.45F, 0.75F), width = ffp_draw(rng, 0.24F, 0.38F),
                height = ffp_draw(rng, 0.26F, 0.42F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.3F * length, 0, 0), ffp_v3(0.75F * length, width, height), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.45F * length, 0, ffp_draw(rng, 0, 0.1F)),
                      ffp_v3(0.65F * length, width * 0.95F, height * 0.95F), 0.2F);
    legs(shape, rng, length, width, height, 0.1F);
    const float neck = ffp_draw(rng, 0.15F, 0.7F), size = ffp_draw(rng, 0.2F, 0.34F);
    const FfpV3 at = ffp_v3(length + 0.2F + 0.2F * neck, 0, 0.25F + neck);
    ffp_add_cone(shape, ffp_v3(0.75F * length, 0, 0.05F), at, 0.75F * width, 0.6F * size, 0.15F);
    head(shape, rng, at, size);
    const FfpV3 root = ffp_v3(-1.0F * length, 0, 0.1F);
    const FfpV3 middle =
        ffp_draw3(rng, ffp_v3(root.x - 0.3F, 0, root.z - 0.2F), ffp_v3(root.x - 0.1F, 0, root.z + 0.3F));
    const FfpV3 tip = ffp_draw3(rng, ffp_v3(middle.x - 0.1F, -0.2F, middle.z - 0.2F),
                                ffp_v3(middle.x - 0.1F, 0.2F, middle.z + 0.2F));
    ffp_add_cone(shape, root, middle, 0.09F, 0.06F, 0.06F);
    ffp_add_cone(shape, middle, tip, 0.06F, 0.07F, 0.02F);
}

static void bird(FfpShape *shape, FfpRng *rng) {
    const float lean = ffp_draw(rng, -0.7F, -0.1F), size = ffp_draw(rng, 0.22F, 0.34F);
    ffp_part_turn(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.65F, 0.4F, 0.42F), 0), 0, lean, 0);
    const FfpV3 top = ffp_v3(0.45F, 0, ffp_draw(rng, 0.45F, 0.8F));
    ffp_add_cone(shape, ffp_v3(0.35F, 0, 0.1F), top, 0.25F, 0.6F * size, 0.12F);
    ffp_add_ellipsoid(shape, top, ffp_v3(size, size * 0.9F, size), 0.1F);
    ffp_add_cone(shape, top, ffp_v3(top.x + size + ffp_draw(rng, 0.1F, 0.35F), 0, top.z - 0.08F), 0.12F,
                 0.02F, 0.03F);
    for (int side = -1; side <= 1; side += 2) {
        FfpPart *wing = ffp_add_ellipsoid(shape, ffp_v3(-0.12F, 0.38F * (float)side, 0.05F),
                                          ffp_v3(0.52F, 0.09F, 0.26F), 0.04F);
        ffp_part_turn(wing, 0.15F * (float)side, lean - 0.2F, ffp_draw(rng, -0.2F, 0.5F) * (float)side);
        const FfpV3 hip = ffp_v3(0.02F, 0.17F * (float)side, -0.3F),
                    foot = ffp_v3(0.08F, 0.2F * (float)side, -0.75F);
        ffp_add_cone(shape, hip, foot, 0.09F, 0.045F, 0.06F);
        ffp_add_ellipsoid(shape, ffp_v3(0.15F, foot.y, -0.77F), ffp_v3(0.16F, 0.1F, 0.05F), 0.03F);
    }
    FfpPart *tail =
        ffp_add_ellipsoid(shape, ffp_v3(-0.7F, 0, 0.35F * lean), ffp_v3(0.42F, 0.2F, 0.07F), 0.08F);
    ffp_part_turn(tail, 0, lean + ffp_draw(rng, 0, 0.8F), 0);
}

static void fish(FfpShape *shape, FfpRng *rng) {
    const float tall = ffp_draw(rng, 0.3F, 0.55F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.8F, 0.26F, tall), 0);
    ffp_add_cone(shape, ffp_v3(-0.5F, 0, 0), ffp_v3(-0.95F, 0, 0), 0.2F, 0.08F, 0.15F);
    for (int side = -1; side <= 1; side += 2) {
        ffp_part_turn(ffp_add_ellipsoid(shape, ffp_v3(-1.1F, 0, 0.22F * (float)side),
                                        ffp_v3(0.34F, 0.05F, 0.15F), 0.06F),
                      0, 0.7F * (float)side, 0);
        ffp_part_turn(ffp_add_ellipsoid(shape, ffp_v3(0.15F, 0.3F * (float)side, -0.1F),
                                        ffp_v3(0.26F, 0.14F, 0.04F), 0.04F),
                      0.6F * (float)-side, -0.3F, 0);
        ffp_add_ellipsoid(shape, ffp_v3(0.55F, 0.17F * (float)side, 0.1F), ffp_v3(0.07F, 0.05F, 0.07F),
                          0.01F);
    }
    ffp_part_turn(ffp_add_ellipsoid(shape, ffp_v3(-0.05F, 0, tall),
                                    ffp_v3(0.42F, 0.05F, ffp_draw(rng, 0.15F, 0.3F)), 0.06F),
                  0, 0.25F, 0);
    ffp_add_cone(shape, ffp_v3(0, 0, -tall), ffp_v3(0, 0, -tall - 0.35F), 0.1F, 0.08F, 0.08F);
    ffp_add_cylinder(shape, ffp_v3(0, 0, -tall - 0.4F), 0.35F, 0.08F, 0.03F, 0.04F);
}

void ffp_make_animal(FfpShape *shape, FfpRng *rng) {
    const int kind = ffp_pick(rng, 0, 4);
    if (kind == 3)
        bird(shape, rng);
    else if (kind == 4)
        fish(shape, rng);
    else
        quadruped(shape, rng);
    if (ffp_pick(rng, 0, 2) == 0) shape->bump = 0.015F, shape->bump_frequency = 4;
    shape->lipschitz = 1.5F;
}

static FfpV3 limb(FfpShape *shape, FfpRng *rng, FfpV3 a, FfpV3 aim, float upper, float lower, float thick,
                  float bend) {
    const FfpV3 b = ffp_v3(a.x + upper * aim.x, a.y + upper * aim.y, a.z + upper * aim.z);
    const FfpV3 turn = ffp_draw3(rng, ffp_v3(0.2F, 0.2F, -0.2F), ffp_v3(1, 1, 0.2F));
    const FfpV3 d = ffp_v3(aim.x + bend * turn.x, aim.y * turn.y, aim.z + turn.z);
    const float n = lower / sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
    const FfpV3 c = ffp_v3(b.x + n * d.x, b.y + n * d.y, b.z + n * d.z);
    ffp_add_cone(shape, a, b, thick, 0.8F * thick, 0.06F);
    ffp_add_cone(shape, b, c, 0.8F * thick, 0.6F * thick, 0.04F);
    return c;
}

static FfpV3 aim_of(FfpRng *rng, float side, float out_low, float out_high, float forward) {
    const float out = ffp_draw(rng, out_low, out_high), front = ffp_draw(rng, -forward, forward);
    const FfpV3 d = ffp_v3(front, side * sinf(out), -cosf(out));
    const float n = 1 / sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
    return ffp_v3(n * d.x, n * d.y, n * d.z);
}

// A standing or dancing figure.
void ffp_make_figure(FfpShape *shape, FfpRng *rng) {
    const float broad = ffp_draw(rng, 0.18F, 0.32F), belly = ffp_draw(rng, 0.14F, 0.32F),
                size = ffp_draw(rng, 0.14F, 0.26F);
    const float lean = ffp_draw(rng, -0.12F, 0.12F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(belly * 0.85F, belly, 0.22F), 0);
    ffp_add_cone(shape, ffp_v3(0, 0, 0), ffp_v3(lean, 0, 0.42F), belly * 0.8F, broad * 0.75F, 0.08F);
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        const FfpV3 shoulder = ffp_v3(lean, s * broad, 0.46F), hip = ffp_v3(0, s * 0.13F, -0.1F);
        const float arm = ffp_draw(rng, 0.08F, 0.11F), leg = ffp_draw(rng, 0.11F, 0.15F);
        const FfpV3 hand =
            limb(shape, rng, shoulder, aim_of(rng, s, 0.2F, 2.4F, 0.6F), 0.32F, 0.32F, arm, 0.8F);
        ffp_add_ellipsoid(shape, hand, ffp_v3(0.09F, 0.09F, 0.09F), 0.03F);
        const FfpV3 foot = limb(shape, rng, hip, aim_of(rng, s, 0.05F, 0.5F, 0.4F), 0.42F, 0.4F, leg, -0.3F);
        ffp_add_ellipsoid(shape, ffp_v3(foot.x + 0.07F, foot.y, foot.z - 0.03F), ffp_v3(0.17F, 0.09F, 0.07F),
                          0.03F);
    }
    const FfpV3 top = ffp_v3(lean * 1.4F, ffp_draw(rng, -0.05F, 0.05F), 0.58F + size);
    ffp_add_cone(shape, ffp_v3(lean, 0, 0.42F), top, 0.09F, 0.08F, 0.05F);
    ffp_add_ellipsoid(shape, top, ffp_v3(size, size * 0.9F, size * 1.15F), 0.04F);
    ffp_add_ellipsoid(shape, ffp_v3(top.x + size, top.y, top.z - 0.02F), ffp_v3(0.06F, 0.04F, 0.05F), 0.03F);
    if (ffp_pick(rng, 0, 1)) // a hat
        ffp_add_cone(shape, ffp_v3(top.x, top.y, top.z + 0.5F * size),
                     ffp_v3(top.x - 0.05F, top.y, top.z + ffp_draw(rng, 1.4F, 2.6F) * size), size, 0.04F,
                     0.03F);
    if (ffp_pick(rng, 0, 1)) // a skirt
        ffp_add_cone(shape, ffp_v3(0, 0, 0.1F), ffp_v3(0, 0, -0.4F), belly * 0.8F, 0.38F, 0.05F);
    shape->lipschitz = 1.4F;
}

static void face(FfpShape *shape, FfpRng *rng) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.5F), ffp_v3(0.42F, 0.36F, 0.46F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.16F, 0, 0.26F), ffp_v3(0.27F, 0.23F, ffp_draw(rng, 0.26F, 0.36F)),
                      0.12F); // jaw
    const float nose = ffp_draw(rng, 0.08F, 0.2F);
    ffp_add_cone(shape, ffp_v3(0.38F, 0, 0.56F), ffp_v3(0.38F + nose, 0, 0.36F), 0.045F,
                 ffp_draw(rng, 0.06F, 0.1F), 0.05F);
    ffp_add_ellipsoid(shape, ffp_v3(0.37F, 0, 0.66F), ffp_v3(0.07F, 0.27F, 0.05F), 0.08F); // brow
    ffp_add_ellipsoid(shape, ffp_v3(0.4F, 0, 0.2F), ffp_v3(0.06F, 0.12F, 0.03F), 0.03F);   // lips
    ffp_add_ellipsoid(shape, ffp_v3(0.36F, 0, 0.03F), ffp_v3(0.1F, 0.1F, 0.09F), 0.08F);   // chin
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        FfpPart *socket =
            ffp_add_ellipsoid(shape, ffp_v3(0.43F, 0.155F * s, 0.56F), ffp_v3(0.09F, 0.09F, 0.055F), 0.05F);
        socket->join = FFP_JOIN_CUT;
        ffp_add_ellipsoid(shape, ffp_v3(0.345F, 0.15F * s, 0.56F), ffp_v3(0.065F, 0.065F, 0.065F), 0.01F);
        ffp_add_ellipsoid(shape, ffp_v3(0.0F, 0.37F * s, 0.47F), ffp_v3(0.1F, 0.05F, 0.14F), 0.03F); // ear
    }
}

// Head and shoulders, with hair or a hat, mostly on a base.
void ffp_make_bust(FfpShape *shape, FfpRng *rng) {
    face(shape, rng);
    const float broad = ffp_draw(rng, 0.45F, 0.75F);
    ffp_add_cone(shape, ffp_v3(-0.05F, 0, 0.3F), ffp_v3(-0.08F, 0, -0.3F), ffp_draw(rng, 0.18F, 0.25F), 0.25F,
                 0.1F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.08F, 0, -0.45F), ffp_v3(0.32F, broad, 0.26F), 0.15F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.02F, 0, -0.65F), ffp_v3(0.34F, broad * 0.75F, 0.28F), 0.15F);
    const int hair = ffp_pick(rng, 0, 3);
    if (hair == 1) ffp_add_ellipsoid(shape, ffp_v3(-0.1F, 0, 0.68F), ffp_v3(0.42F, 0.41F, 0.36F), 0.03F);
    if (hair == 2) {
        ffp_add_cylinder(shape, ffp_v3(-0.02F, 0, 0.78F), 0.56F, 0.03F, 0.03F, 0.03F);
        ffp_add_cylinder(shape, ffp_v3(-0.02F, 0, 0.95F), 0.36F, ffp_draw(rng, 0.15F, 0.35F), 0.06F, 0.03F);
    }
    for (int i = 0; hair == 3 && i < 22; i++) { // curls
        const float a = ffp_draw(rng, 0.9F, 2 * PI - 0.9F), z = ffp_draw(rng, 0.1F, 0.95F),
                    r = 0.42F * sqrtf(ffp_max(0.1F, 1 - z * z));
        const float q = ffp_draw(rng, 0.09F, 0.15F);
        ffp_add_ellipsoid(shape, ffp_v3(-0.06F + r * cosf(a), r * sinf(a), 0.52F + 0.42F * z),
                          ffp_v3(q, q, q), 0.03F);
    }
    if (ffp_pick(rng, 0, 3)) {
        ffp_add_cylinder(shape, ffp_v3(-0.03F, 0, -0.95F), 0.2F, 0.15F, 0.02F, 0.06F);
        ffp_add_box(shape, ffp_v3(-0.03F, 0, -1.12F), ffp_v3(0.34F, 0.34F, 0.1F), 0.03F, 0.02F);
    }
    if (ffp_pick(rng, 0, 2) == 0) shape->bump = 0.012F, shape->bump_frequency = 5;
    shape->lipschitz = 1.5F;
}
