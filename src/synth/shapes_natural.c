// Families that grow or erode: stones, blobs, fruit, land, shells.
#include <math.h>
#include "synth/shape.h"
#include "synth/scalar.h"

#define PI 3.14159265F

static FfpV3 direction(FfpRng *rng) {
    const float z = ffp_draw(rng, -1, 1), a = ffp_draw(rng, 0, 2 * PI), r = sqrtf(1 - z * z);
    return ffp_v3(r * cosf(a), r * sinf(a), z);
}

// Round pebbles, or boulders with flat faces cut off.
void ffp_make_stone(FfpShape *shape, FfpRng *rng) {
    const int kind = ffp_pick(rng, 0, 2);
    const float a = ffp_draw(rng, 0.8F, 1.1F), b = ffp_draw(rng, 0.65F, 1), c = ffp_draw(rng, 0.5F, 0.9F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(a, b, c), 0);
    const int faces = kind == 0 ? 0 : ffp_pick(rng, 6, 14);
    for (int i = 0; i < faces; i++) {
        const FfpV3 d = direction(rng);
        const float reach = sqrtf(a * a * d.x * d.x + b * b * d.y * d.y + c * c * d.z * d.z);
        const float at = reach * ffp_draw(rng, 0.62F, 0.9F) + 2;
        FfpPart *face = ffp_add_box(shape, ffp_v3(d.x * at, d.y * at, d.z * at), ffp_v3(3, 3, 2), 0, 0.06F);
        face->join = FFP_JOIN_CUT;
        ffp_part_point(face, d);
    }
    shape->bump = kind == 0 ? ffp_draw(rng, 0.08F, 0.22F) : ffp_draw(rng, 0.02F, 0.09F);
    shape->bump_frequency = kind == 0 ? ffp_draw(rng, 0.9F, 1.8F) : ffp_draw(rng, 1.5F, 3);
    shape->ridged = kind == 2;
    shape->lipschitz = 1.9F;
    shape->upright = false;
}

// Soft balls run together.
void ffp_make_blob(FfpShape *shape, FfpRng *rng) {
    const int balls = ffp_pick(rng, 4, 10);
    const float blend = ffp_draw(rng, 0.15F, 0.5F);
    FfpV3 at = ffp_v3(0, 0, 0);
    for (int i = 0; i < balls; i++) {
        const float r = ffp_draw(rng, 0.22F, 0.5F);
        const bool oval = ffp_pick(rng, 0, 1);
        const FfpV3 stretch =
            oval ? ffp_draw3(rng, ffp_v3(1, 0.6F, 0.6F), ffp_v3(1, 1.3F, 1.3F)) : ffp_v3(1, 1, 1);
        const FfpV3 turn = ffp_draw3(rng, ffp_v3(0, 0, 0), ffp_v3(PI, PI, 0));
        FfpPart *ball = ffp_add_ellipsoid(shape, at, ffp_v3(r, r * stretch.y, r * stretch.z), blend);
        ffp_part_turn(ball, turn.x, turn.y, 0);
        const FfpV3 d = direction(rng);
        const float step = ffp_draw(rng, 0.4F, 0.75F), home = 0.8F; // a walk that is drawn back to the middle
        at = ffp_v3(home * at.x + step * d.x, home * at.y + step * d.y, home * at.z + step * d.z);
    }
    if (ffp_pick(rng, 0, 2) == 0) {
        FfpPart *hole = ffp_add_ellipsoid(shape, ffp_v3(ffp_draw(rng, -0.2F, 0.2F), 0.3F, 0.2F),
                                          ffp_v3(0.3F, 0.3F, 0.3F), 0.1F);
        hole->join = FFP_JOIN_CUT;
    }
    shape->bump = ffp_pick(rng, 0, 1) ? ffp_draw(rng, 0.01F, 0.05F) : 0;
    shape->bump_frequency = ffp_draw(rng, 2, 4);
    shape->lipschitz = 1.5F;
    shape->upright = false;
}

static void stalk(FfpShape *shape, FfpRng *rng, float base, float thick) {
    const FfpV3 a = ffp_v3(0, 0, base);
    const FfpV3 b = ffp_draw3(rng, ffp_v3(-0.1F, -0.1F, base + 0.15F), ffp_v3(0.1F, 0.1F, base + 0.3F));
    const FfpV3 c = ffp_draw3(rng, ffp_v3(b.x - 0.15F, b.y - 0.1F, b.z + 0.05F),
                              ffp_v3(b.x + 0.15F, b.y + 0.1F, b.z + 0.2F));
    ffp_add_cone(shape, a, b, thick * 1.2F, thick, 0.08F);
    ffp_add_cone(shape, b, c, thick, thick * 1.1F, 0.03F);
    if (ffp_pick(rng, 0, 1)) {
        const float yaw = ffp_draw(rng, 0, 2 * PI), droop = ffp_draw(rng, -0.5F, 0.1F),
                    tilt = ffp_draw(rng, -0.4F, 0.4F);
        FfpPart *leaf =
            ffp_add_ellipsoid(shape, ffp_v3(b.x + 0.26F * cosf(yaw), b.y + 0.26F * sinf(yaw), b.z + 0.05F),
                              ffp_v3(0.28F, 0.13F, 0.04F), 0.03F);
        ffp_part_turn(leaf, yaw, droop, tilt);
    }
}

static void pumpkin(FfpShape *shape, FfpRng *rng) {
    const int lobes = ffp_pick(rng, 7, 12);
    const float height = ffp_draw(rng, 0.4F, 0.75F);
    for (int i = 0; i < lobes; i++) {
        const float a = 2 * PI * (float)i / (float)lobes, w = 2.4F / (float)lobes;
        FfpPart *lobe = ffp_add_ellipsoid(shape, ffp_v3(0.42F * cosf(a), 0.42F * sinf(a), 0),
                                          ffp_v3(0.42F, w, height), 0.05F);
        ffp_part_turn(lobe, a, 0, 0);
    }
    stalk(shape, rng, 0.75F * height, 0.08F);
}

static void pear(FfpShape *shape, FfpRng *rng) {
    const float top = ffp_draw(rng, 0.5F, 0.9F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.62F, 0.62F, 0.58F), 0);
    ffp_add_ellipsoid(shape, ffp_v3(ffp_draw(rng, -0.06F, 0.06F), 0, top), ffp_v3(0.32F, 0.32F, 0.38F), 0.4F);
    stalk(shape, rng, top + 0.3F, 0.045F);
}

static void apple(FfpShape *shape, FfpRng *rng) {
    const float low = ffp_draw(rng, 0.3F, 0.45F);
    ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.34F, 0.45F, 0);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.2F), ffp_v3(0.5F, 0.5F, low), 0.25F);
    stalk(shape, rng, 0.05F, 0.04F);
}

static void cactus(FfpShape *shape, FfpRng *rng) {
    ffp_add_cone(shape, ffp_v3(0, 0, -0.7F), ffp_v3(0, 0, 0.8F), 0.26F, 0.22F, 0);
    const int arms = ffp_pick(rng, 2, 4);
    for (int i = 0; i < arms; i++) {
        const float a = 2 * PI * (float)i / (float)arms + ffp_draw(rng, -0.4F, 0.4F),
                    z = ffp_draw(rng, -0.3F, 0.3F);
        const float out = ffp_draw(rng, 0.4F, 0.55F), up = ffp_draw(rng, 0.3F, 0.6F);
        const FfpV3 elbow = ffp_v3(out * cosf(a), out * sinf(a), z);
        ffp_add_cone(shape, ffp_v3(0, 0, z - 0.05F), elbow, 0.13F, 0.14F, 0.08F);
        ffp_add_cone(shape, elbow, ffp_v3(elbow.x, elbow.y, z + up), 0.14F, 0.12F, 0.08F);
    }
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.85F), ffp_draw(rng, 0.4F, 0.55F), 0.18F, 0.04F, 0.02F);
}

static void mushrooms(FfpShape *shape, FfpRng *rng) {
    const int count = ffp_pick(rng, 1, 4);
    for (int i = 0; i < count; i++) {
        const float a = ffp_draw(rng, 0, 2 * PI), off = count == 1 ? 0 : ffp_draw(rng, 0.3F, 0.6F),
                    tall = ffp_draw(rng, 0.5F, 1.1F);
        const FfpV3 foot = ffp_v3(off * cosf(a), off * sinf(a), 0),
                    head = ffp_v3(1.3F * foot.x, 1.3F * foot.y, tall);
        const float cap = ffp_draw(rng, 0.3F, 0.5F);
        ffp_add_cone(shape, foot, head, 0.16F, 0.1F, 0.05F);
        ffp_add_ellipsoid(shape, head, ffp_v3(cap, cap, cap * ffp_draw(rng, 0.4F, 0.8F)), 0.03F);
        FfpPart *under = ffp_add_ellipsoid(shape, ffp_v3(head.x, head.y, head.z - 0.3F),
                                           ffp_v3(cap * 0.85F, cap * 0.85F, 0.26F), 0.03F);
        under->join = FFP_JOIN_CUT;
        ffp_add_cone(shape, foot, head, 0.13F, 0.09F, 0.02F);
    }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.05F), ffp_v3(0.75F, 0.7F, 0.16F), 0.15F);
}

// Fruit and other things with a stalk.
void ffp_make_fruit(FfpShape *shape, FfpRng *rng) {
    void (*const kinds[5])(FfpShape *, FfpRng *) = {pumpkin, pear, apple, cactus, mushrooms};
    kinds[ffp_pick(rng, 0, 4)](shape, rng);
    shape->lipschitz = 1.4F;
    if (ffp_pick(rng, 0, 1)) shape->bump = 0.02F, shape->bump_frequency = ffp_draw(rng, 1.5F, 3);
}

// A slab of land, hilly or ridged; sometimes with boulders.
void ffp_make_land(FfpShape *shape, FfpRng *rng) {
    shape->ridged = ffp_pick(rng, 0, 1);
    const float side = ffp_draw(rng, 0.7F, 1), hills = ffp_draw(rng, 0.35F, 0.6F);
    if (ffp_pick(rng, 0, 2) == 0) {
        ffp_add_land(shape, ffp_v3(1, 1, 0.35F), hills);
        FfpPart *round = ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.95F, 2, 0.02F, 0.02F);
        round->join = FFP_JOIN_KEEP;
    } else {
        ffp_add_land(shape, ffp_v3(1, side, 0.35F), hills);
    }
    const int rocks = ffp_pick(rng, 0, 5);
    for (int i = 0; i < rocks; i++) {
        const float r = ffp_draw(rng, 0.1F, 0.22F);
        const FfpV3 at = ffp_draw3(rng, ffp_v3(-0.7F, -0.6F, 0.1F), ffp_v3(0.7F, 0.6F, 0.4F));
        const FfpV3 turn = ffp_draw3(rng, ffp_v3(0, 0, 0), ffp_v3(PI, 1, 0));
        ffp_part_turn(ffp_add_ellipsoid(shape, at, ffp_v3(r, r * 0.8F, r * 0.7F), 0.06F), turn.x, turn.y, 0);
    }
    shape->lipschitz = 1.8F;
    shape->upright = ffp_pick(rng, 0, 1); // half of them tipped over, so that the hills face a level camera
}

// Snail shells: cones that grow along a spiral. Flat ones, steep ones, horns.
void ffp_make_shell(FfpShape *shape, FfpRng *rng) {
    const int n = 84;
    const float turns = ffp_draw(rng, 1.2F, 3.4F), growth = ffp_draw(rng, 1.2F, 2.1F),
                climb = ffp_draw(rng, 0, 1.5F);
    const float thick = ffp_draw(rng, 0.38F, 0.52F);
    FfpV3 last = {0};
    float last_radius = 0;
    for (int i = 0; i <= n; i++) {
        const float t = (float)i / (float)n, size = powf(growth, turns * (t - 1)), a = 2 * PI * turns * t;
        const FfpV3 at = ffp_v3(size * cosf(a), size * sinf(a), climb * (1 - size) * 1.4F);
        const float radius = ffp_max(thick * size * (1 + 0.06F * sinf(40 * t * turns)), 0.02F);
        if (i > 0) ffp_add_cone(shape, last, at, last_radius, radius, 0.02F);
        last = at, last_radius = radius;
    }
    if (ffp_pick(rng, 0, 1)) { // an open mouth
        const float a = 2 * PI * turns;
        const FfpV3 mouth =
            ffp_v3(last.x - 0.6F * last_radius * sinf(a), last.y + 0.6F * last_radius * cosf(a), last.z);
        const float r = 0.8F * last_radius;
        ffp_add_ellipsoid(shape, mouth, ffp_v3(r, r, r), 0.03F)->join = FFP_JOIN_CUT;
    }
    if (ffp_pick(rng, 0, 2) == 0) shape->bump = 0.02F, shape->bump_frequency = 3;
    shape->lipschitz = 1.4F;
    shape->upright = false;
}
