// Families made by hand or machine: vases, teapots, furniture, cogs, solids, stacks, knots.
#include <math.h>
#include "synth/shape.h"
#include "synth/scalar.h"

#define PI 3.14159265F

// A smooth profile through `knots` random radii between z -1 and 1 (Catmull-Rom), n + 1 samples into r, z.
static void profile(const float *knot, int knots, int n, float *r, float *z) {
    for (int i = 0; i <= n; i++) {
        const float t = (float)i / (float)n * (float)(knots - 1);
        const int k = (int)ffp_min(t, (float)(knots - 2));
        const float u = t - (float)k, a = knot[k > 0 ? k - 1 : 0], b = knot[k], c = knot[k + 1];
        const float d = knot[k + 2 < knots ? k + 2 : knots - 1];
        r[i] = b + 0.5F * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
        r[i] = ffp_max(r[i], 0.06F);
        z[i] = -1 + 2 * (float)i / (float)n;
    }
}

// The outline of a vessel: outer wall up, and when hollow the inner wall down to the floor.
static void vessel(FfpShape *shape, const float *r, const float *z, int n, bool hollow, float wall,
                   float scale_z) {
    int k = 0;
    shape->outline[k][0] = 0, shape->outline[k++][1] = z[0] * scale_z;
    for (int i = 0; i <= n; i++) shape->outline[k][0] = r[i], shape->outline[k++][1] = z[i] * scale_z;
    for (int i = n; hollow && i >= 2; i -= 2)
        shape->outline[k][0] = ffp_max(r[i] - wall, 0.01F),
        shape->outline[k++][1] = z[i] * scale_z + (i == n ? 0 : 0.02F);
    shape->outline[k][0] = 0, shape->outline[k][1] = shape->outline[k - 1][1];
    shape->n_outline = k + 1;
}

// The least thickness of a vessel's wall, measured across it: `wall` is measured along r.
static float thinnest(const float *r, const float *z, int n, float wall, float scale_z) {
    float least = wall;
    for (int i = 1; i <= n; i++) {
        const float slope = (r[i] - r[i - 1]) / (scale_z * (z[i] - z[i - 1]));
        least = ffp_min(least, ffp_min(wall, r[i] - 0.01F) / sqrtf(1 + slope * slope));
    }
    return least;
}

void ffp_make_vase(FfpShape *shape, FfpRng *rng) {
    float knot[7] = {0}, r[19], z[19];
    const int knots = ffp_pick(rng, 4, 7);
    for (int i = 0; i < knots; i++) knot[i] = ffp_draw(rng, 0.22F, 0.72F);
    const bool bottle = ffp_pick(rng, 0, 2) == 0;
    if (bottle) knot[knots - 1] = knot[knots - 2] = ffp_draw(rng, 0.12F, 0.2F);
    profile(knot, knots, 18, r, z);
    const float wall = ffp_draw(rng, 0.07F, 0.11F), tall = ffp_draw(rng, 0.8F, 1.2F);
    vessel(shape, r, z, 18, !bottle, wall, tall);
    ffp_add_lathe(shape, 0.02F, 0);
    const int handles = ffp_pick(rng, 0, 3);
    for (int i = 0; i < handles && handles < 3; i++) {
        const float side = i ? -1 : 1, at = ffp_max(r[9], r[12]);
        FfpPart *ring = ffp_add_torus(shape, ffp_v3(side * (at + 0.05F), 0, 0.15F),
                                      ffp_draw(rng, 0.22F, 0.32F), 0.065F, 0.05F);
        ffp_part_turn(ring, 0, 0, 0.5F * PI);
    }
    if (!bottle &&
        (handles == 1 || handles == 2)) { // a handle must not show inside the vessel: cut the bore again
        float bore = 1;
        for (int i = 8; i <= 18; i++) bore = ffp_min(bore, r[i] - 1.2F * wall);
        if (bore > 0.05F)
            ffp_add_cylinder(shape, ffp_v3(0, 0, 0.9F), bore, 0.9F, 0.04F, 0)->join = FFP_JOIN_CUT;
    }
    if (ffp_pick(rng, 0, 3) == 0) {
        shape->ribs = (float)ffp_pick(rng, 8, 20);
        shape->rib_depth = 0.3F * thinnest(r, z, 18, wall, tall); // carved from both sides
        shape->twist = ffp_pick(rng, 0, 1) ? ffp_draw(rng, 0.5F, 1.2F) : 0;
    }
    shape->lipschitz = 1.5F;
}

static void spout(FfpShape *shape, FfpRng *rng, float at) {
    const FfpV3 a = ffp_v3(0.6F * at, 0, -0.15F), b = ffp_v3(at + 0.3F, 0, ffp_draw(rng, -0.05F, 0.15F));
    const FfpV3 c = ffp_draw3(rng, ffp_v3(at + 0.4F, 0, 0.35F), ffp_v3(at + 0.6F, 0, 0.6F));
    ffp_add_cone(shape, a, b, 0.2F, 0.12F, 0.1F);
    ffp_add_cone(shape, b, c, 0.12F, 0.08F, 0.04F);
}

// Teapots, jugs and mugs.
void ffp_make_teapot(FfpShape *shape, FfpRng *rng) {
    const int kind = ffp_pick(rng, 0, 2); // pot, jug, mug
    float knot[5], r[13], z[13];
    const float wide = ffp_draw(rng, 0.55F, 0.75F);
    const float pot[5] = {0.55F * wide, 1.0F * wide, 1.05F * wide, 0.85F * wide, 0.4F * wide};
    const float jug[5] = {0.6F, 0.62F * ffp_draw(rng, 0.8F, 1.2F), 0.6F, 0.42F, 0.48F};
    for (int i = 0; i < 5; i++)
        knot[i] = kind == 0   ? pot[i]
                  : kind == 1 ? jug[i]
                              : 0.55F + 0.12F * (float)(i == 0 || i == 4) * ffp_draw(rng, -1, 0.6F);
    profile(knot, 5, 12, r, z);
    vessel(shape, r, z, 12, kind != 0, 0.085F, kind == 0 ? 0.6F : ffp_draw(rng, 0.65F, 0.95F));
    ffp_add_lathe(shape, 0.03F, 0);
    const float side = r[6], ring = ffp_draw(rng, 0.26F, 0.36F);
    FfpPart *handle =
        ffp_add_torus(shape, ffp_v3(-side - 0.12F, 0, 0.02F), ring, ffp_draw(rng, 0.055F, 0.085F), 0.04F);
    ffp_part_turn(handle, 0, 0, 0.5F * PI);
    if (kind == 0) {
        ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.55F),
                          ffp_v3(0.45F * wide + 0.08F, 0.45F * wide + 0.08F, 0.16F), 0.02F);
        ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.8F), ffp_v3(0.11F, 0.11F, 0.11F), 0.05F);
        spout(shape, rng, side);
    } else {
        const float bore = ffp_max(0.2F, ffp_min(r[4], ffp_min(r[6], r[8])) - 0.12F);
        ffp_add_cylinder(shape, ffp_v3(0, 0, 0.4F), bore, 0.75F, 0.08F, 0.03F)->join = FFP_JOIN_CUT;
    }
    shape->lipschitz = 1.4F;
}

static void chair(FfpShape *shape, FfpRng *rng) {
    const float w = ffp_draw(rng, 0.38F, 0.52F), leg = ffp_draw(rng, 0.045F, 0.075F),
                down = ffp_draw(rng, 0.5F, 0.7F), up = ffp_draw(rng, 0.6F, 1);
    const bool round = ffp_pick(rng, 0, 1);
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(w + 0.04F, w + 0.04F, 0.065F), 0.04F, 0);
    for (int i = 0; i < 4; i++) {
        const float x = (i & 1 ? 1 : -1) * (w - leg), y = (i & 2 ? 1 : -1) * (w - leg);
        if (round)
            ffp_add_cone(shape, ffp_v3(x, y, 0), ffp_v3(x * 1.15F, y * 1.15F, -down), leg * 1.1F, leg * 0.8F,
                         0.02F);
        else
            ffp_add_box(shape, ffp_v3(x, y, -0.5F * down), ffp_v3(leg, leg, 0.5F * down), 0.02F, 0.02F);
    }
    const int slats = ffp_pick(rng, 0, 5);
    for (int side = -1; side <= 1; side += 2)
        ffp_add_cone(shape, ffp_v3(-w + leg, (float)side * (w - leg), 0),
                     ffp_v3(-w - 0.08F, (float)side * (w - leg), up), leg, leg, 0.02F);
    for (int i = 0; i < slats; i++)
        ffp_add_box(shape, ffp_v3(-w - 0.02F, 0, up * (0.3F + 0.7F * (float)(i + 1) / (float)(slats + 1))),
                    ffp_v3(0.035F, w - leg, 0.3F * up / (float)(slats + 1) + 0.03F), 0.02F, 0.02F);
    if (slats == 0)
        ffp_add_box(shape, ffp_v3(-w - 0.03F, 0, 0.62F * up), ffp_v3(0.05F, w, 0.36F * up), 0.04F, 0.02F);
    for (int side = -1; side <= 1 && slats > 2; side += 2) { // arm rests
        const float y = (float)side * w;
        ffp_add_box(shape, ffp_v3(0, y, 0.35F), ffp_v3(w, 0.05F, 0.04F), 0.03F, 0.02F);
        ffp_add_cone(shape, ffp_v3(w - 0.1F, y, 0), ffp_v3(w - 0.1F, y, 0.35F), 0.045F, 0.045F, 0.02F);
    }
}

static void table(FfpShape *shape, FfpRng *rng) {
    const float w = ffp_draw(rng, 0.6F, 0.9F), d = ffp_draw(rng, 0.5F, 0.8F),
                down = ffp_draw(rng, 0.5F, 0.8F);
    if (ffp_pick(rng, 0, 1)) {
        ffp_add_cylinder(shape, ffp_v3(0, 0, 0), w, 0.06F, 0.03F, 0);
        ffp_add_cone(shape, ffp_v3(0, 0, 0), ffp_v3(0, 0, -down), 0.12F, 0.09F, 0.1F);
        const int feet = ffp_pick(rng, 3, 5);
        for (int i = 0; i < feet; i++) {
            const float a = 2 * PI * (float)i / (float)feet;
            ffp_add_cone(shape, ffp_v3(0, 0, -down + 0.12F),
                         ffp_v3(0.5F * cosf(a), 0.5F * sinf(a), -down - 0.05F), 0.08F, 0.06F, 0.05F);
        }
    } else {
        ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(w, d, 0.06F), 0.03F, 0);
        ffp_add_box(shape, ffp_v3(0, 0, -0.13F), ffp_v3(w - 0.1F, d - 0.1F, 0.09F), 0.02F, 0.01F);
        for (int i = 0; i < 4; i++) {
            const float x = (i & 1 ? 1 : -1) * (w - 0.12F), y = (i & 2 ? 1 : -1) * (d - 0.12F);
            ffp_add_cone(shape, ffp_v3(x, y, -0.05F), ffp_v3(x, y, -down), 0.09F, 0.05F, 0.02F);
        }
    }
    const int things = ffp_pick(rng, 1, 3);
    for (int i = 0; i < things; i++) { // what stands on it
        const float x = ffp_draw(rng, -0.35F, 0.35F), y = ffp_draw(rng, -0.3F, 0.3F),
                    s = ffp_draw(rng, 0.12F, 0.24F);
        const int kind = ffp_pick(rng, 0, 2);
        if (kind == 0)
            ffp_add_ellipsoid(shape, ffp_v3(x, y, s), ffp_v3(s, s, s), 0.02F);
        else if (kind == 1)
            ffp_add_cylinder(shape, ffp_v3(x, y, 1.4F * s), 0.6F * s, 1.4F * s, 0.03F, 0.02F);
        else
            ffp_part_turn(ffp_add_box(shape, ffp_v3(x, y, s), ffp_v3(s, 0.8F * s, s), 0.03F, 0.02F),
                          ffp_draw(rng, 0, PI), 0, 0);
    }
}

static void cart(FfpShape *shape, FfpRng *rng) {
    const float length = ffp_draw(rng, 0.7F, 0.95F), w = ffp_draw(rng, 0.34F, 0.46F),
                wheel = ffp_draw(rng, 0.2F, 0.3F);
    ffp_add_box(shape, ffp_v3(0, 0, 0), ffp_v3(length, w, ffp_draw(rng, 0.16F, 0.24F)), 0.08F, 0);
    const float cabin = ffp_draw(rng, -0.3F, 0.2F), share = ffp_draw(rng, 0.35F, 0.6F);
    ffp_add_box(shape, ffp_v3(cabin, 0, 0.32F), ffp_v3(length * share, w * 0.9F, 0.24F), 0.1F, 0.06F);
    for (int i = 0; i < 4; i++) {
        const float x = (i & 1 ? 0.6F : -0.6F) * length, y = (i & 2 ? 1 : -1) * w;
        ffp_part_point(ffp_add_cylinder(shape, ffp_v3(x, y, -0.2F), wheel, 0.1F, 0.03F, 0.01F),
                       ffp_v3(0, 1, 0));
        ffp_part_point(
            ffp_add_cylinder(shape, ffp_v3(x, y * 1.25F, -0.2F), 0.4F * wheel, 0.05F, 0.02F, 0.01F),
            ffp_v3(0, 1, 0));
    }
    if (ffp_pick(rng, 0, 1))
        ffp_add_cone(shape, ffp_v3(0.7F * length, 0, 0.1F), ffp_v3(0.7F * length, 0, 0.6F), 0.11F, 0.14F,
                     0.02F);
}

// Chairs, tables and toy carts.
void ffp_make_furniture(FfpShape *shape, FfpRng *rng) {
    void (*const kinds[4])(FfpShape *, FfpRng *) = {chair, table, cart, chair};
    kinds[ffp_pick(rng, 0, 3)](shape, rng);
    shape->lipschitz = 1.3F;
}

// Gears, stars and flowers, plain, twisted or with hubs and holes.
void ffp_make_cog(FfpShape *shape, FfpRng *rng) {
    const int teeth = ffp_pick(rng, 3, 14);
    const float tooth = ffp_draw(rng, 0.15F, 0.35F), half = ffp_draw(rng, 0.18F, 0.6F),
                sharp = ffp_draw(rng, 0.9F, teeth > 6 ? 2.5F : 1.6F);
    ffp_add_cog(shape, ffp_v3(0, 0, 0), 0.65F, half, tooth, teeth, sharp);
    const int hub = ffp_pick(rng, 0, 3);
    const float core = ffp_draw(rng, 0.2F, 0.4F), out = ffp_draw(rng, 0.1F, 0.4F);
    if (hub == 1) ffp_add_cylinder(shape, ffp_v3(0, 0, 0), core, half + out, 0.04F, 0.04F);
    if (hub == 2) ffp_add_cylinder(shape, ffp_v3(0, 0, 0), core, 2, 0.02F, 0.03F)->join = FFP_JOIN_CUT;
    if (hub == 3) {
        ffp_add_cog(shape, ffp_v3(0, 0, half + 0.15F), 0.35F, 0.22F, 0.6F * tooth, ffp_pick(rng, 3, 9),
                    sharp);
        ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.13F, half + 0.6F, 0.03F, 0.02F);
    }
    if (half > 0.35F && ffp_pick(rng, 0, 1)) shape->twist = ffp_draw(rng, 0.4F, 1.1F);
    if (ffp_pick(rng, 0, 3) == 0 && half > 0.3F) {
        FfpPart *ball =
            ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.95F, 0.95F, half * 1.3F + 0.2F), 0.05F);
        ball->join = FFP_JOIN_KEEP;
    }
    shape->lipschitz = 2;
    shape->upright = ffp_pick(rng, 0, 1);
}

static void crate(FfpShape *shape, FfpRng *rng) {
    const FfpV3 half = ffp_draw3(rng, ffp_v3(0.5F, 0.45F, 0.4F), ffp_v3(0.9F, 0.8F, 0.8F));
    ffp_add_box(shape, ffp_v3(0, 0, 0), half, ffp_draw(rng, 0.02F, 0.2F), 0);
    const int kind = ffp_pick(rng, 0, 2);
    const float inset = ffp_draw(rng, 0.05F, 0.12F);
    for (int i = 0; i < 6 && kind == 0; i++) { // panels
        const int a = i / 2;
        const float s = i & 1 ? 1 : -1;
        FfpV3 at = ffp_v3(0, 0, 0), panel = ffp_v3(0.72F * half.x, 0.72F * half.y, 0.72F * half.z);
        if (a == 0)
            at.x = s * half.x, panel.x = inset;
        else if (a == 1)
            at.y = s * half.y, panel.y = inset;
        else
            at.z = s * half.z, panel.z = inset;
        ffp_add_box(shape, at, panel, 0.02F, 0.02F)->join = FFP_JOIN_CUT;
    }
    for (int a = 0; a < 3 && kind == 1; a++) { // bored through
        FfpPart *bore = ffp_add_cylinder(shape, ffp_v3(0, 0, 0), ffp_draw(rng, 0.2F, 0.32F), 2, 0.02F, 0.03F);
        ffp_part_point(bore, ffp_v3(a == 0, a == 1, a == 2));
        bore->join = FFP_JOIN_CUT;
    }
    const int knobs = kind == 2 ? ffp_pick(rng, 3, 8) : 0;
    for (int i = 0; i < knobs; i++) {
        const float x = ffp_draw(rng, -0.8F, 0.8F) * half.x, y = ffp_draw(rng, -0.8F, 0.8F) * half.y,
                    s = ffp_draw(rng, 0.1F, 0.2F);
        if (i & 1)
            ffp_add_ellipsoid(shape, ffp_v3(x, half.y, ffp_draw(rng, -0.7F, 0.7F) * half.z), ffp_v3(s, s, s),
                              0.03F);
        else
            ffp_add_cylinder(shape, ffp_v3(x, y, half.z), s, s, 0.03F, 0.02F);
    }
}

// Superquadrics, alone or crossed, and boxes with panels, bores or knobs.
void ffp_make_solid(FfpShape *shape, FfpRng *rng) {
    const int kind = ffp_pick(rng, 0, 3);
    shape->lipschitz = 2;
    shape->upright = false;
    if (kind >= 2) {
        crate(shape, rng);
        shape->lipschitz = 1.3F;
        return;
    }
    const FfpV3 half = ffp_draw3(rng, ffp_v3(0.55F, 0.55F, 0.55F), ffp_v3(1, 1, 1));
    const FfpV3 form = ffp_draw3(rng, ffp_v3(0.25F, 0.25F, 0), ffp_v3(1.9F, 1.9F, 0));
    ffp_add_superquadric(shape, ffp_v3(0, 0, 0), half, form.x, form.y);
    if (kind == 1) {
        const FfpV3 thin = ffp_v3(0.4F * half.x, 1.25F * half.y, 0.4F * half.z);
        const FfpV3 square = ffp_draw3(rng, ffp_v3(0.3F, 0.3F, 0), ffp_v3(1, 1, 0));
        const FfpV3 turn = ffp_draw3(rng, ffp_v3(0, -0.5F, -0.5F), ffp_v3(PI, 0.5F, 0.5F));
        FfpPart *bar = ffp_add_superquadric(shape, ffp_v3(0, 0, 0), thin, square.x, square.y);
        bar->blend = 0.06F;
        ffp_part_turn(bar, turn.x, turn.y, turn.z);
    }
    shape->twist = ffp_pick(rng, 0, 2) == 0 ? ffp_draw(rng, -0.9F, 0.9F) : 0;
}

// Solids piled up or run into each other.
void ffp_make_stack(FfpShape *shape, FfpRng *rng) {
    const int count = ffp_pick(rng, 3, 7);
    const bool pile = ffp_pick(rng, 0, 2) > 0;
    float z = 0;
    for (int i = 0; i < count; i++) {
        const float s = ffp_draw(rng, 0.22F, 0.45F) * (pile ? 1.15F - 0.1F * (float)i : 1.1F),
                    tall = s * ffp_draw(rng, 0.5F, 1);
        const float off = pile ? 0.12F : 0.4F, low = pile ? z + tall * 0.93F : -0.5F,
                    high = pile ? low : 0.5F;
        const FfpV3 at = ffp_draw3(rng, ffp_v3(-off, -off, low), ffp_v3(off, off, high));
        const FfpV3 turn = ffp_draw3(rng, ffp_v3(0, -0.8F, -0.8F), ffp_v3(PI, 0.8F, 0.8F));
        FfpPart *part;
        switch (ffp_pick(rng, 0, 4)) {
        case 0:
            part = ffp_add_ellipsoid(shape, at, ffp_v3(s, s, tall), 0.02F);
            break;
        case 1:
            part = ffp_add_cylinder(shape, at, s, tall, 0.03F, 0.02F);
            break;
        case 2:
            part = ffp_add_torus(shape, at, s, ffp_min(0.5F * tall, 0.6F * s), 0.02F);
            break;
        case 3:
            part = ffp_add_cog(shape, at, 0.75F * s, tall, 0.3F * s, ffp_pick(rng, 3, 8), 1.2F);
            break;
        default:
            part = ffp_add_box(shape, at, ffp_v3(s, 0.85F * s, tall), 0.03F, 0.02F);
            break;
        }
        ffp_part_turn(part, turn.x, pile ? 0 : turn.y, pile ? 0 : turn.z);
        z += tall * 1.8F;
    }
    ffp_add_cylinder(shape, ffp_v3(0, 0, pile ? 0.5F * z : 0), 0.08F, pile ? 0.5F * z + 0.05F : 0.7F, 0.02F,
                     0.02F);
    shape->lipschitz = 1.6F;
    shape->upright = pile;
}

static void torus_knot(FfpShape *shape, FfpRng *rng, int p, int q) {
    const int n = 140;
    const float ring = ffp_draw(rng, 0.55F, 0.7F), wave = ffp_draw(rng, 0.24F, 0.34F),
                tube = ffp_draw(rng, 0.09F, 0.15F);
    FfpV3 last = {0};
    for (int i = 0; i <= n; i++) {
        const float t = 2 * PI * (float)i / (float)n, r = ring + wave * cosf((float)q * t);
        const FfpV3 at =
            ffp_v3(r * cosf((float)p * t), r * sinf((float)p * t), -1.2F * wave * sinf((float)q * t));
        if (i > 0) ffp_add_cone(shape, last, at, tube, tube, 0.01F);
        last = at;
    }
}

static void chain(FfpShape *shape, FfpRng *rng) {
    const int links = ffp_pick(rng, 3, 9);
    const float radius = links < 4 ? 0.35F : 0.75F, ring = PI * radius / (float)links * 1.35F,
                tube = ring * ffp_draw(rng, 0.26F, 0.34F);
    for (int i = 0; i < links; i++) {
        const float a = 2 * PI * (float)i / (float)links;
        FfpPart *link = ffp_add_torus(shape, ffp_v3(radius * cosf(a), radius * sinf(a), 0), ring, tube, 0);
        ffp_part_turn(link, a + 0.5F * PI, 0, (i & 1 ? 0.5F : 0) * PI + ffp_draw(rng, -0.3F, 0.3F));
    }
}

// Tori, torus knots, springs and chains.
void ffp_make_knot(FfpShape *shape, FfpRng *rng) {
    static const int turns[5][2] = {{2, 3}, {3, 2}, {2, 5}, {3, 4}, {1, 3}};
    const int kind = ffp_pick(rng, 0, 4);
    if (kind <= 1) {
        const int k = ffp_pick(rng, 0, 4);
        torus_knot(shape, rng, turns[k][0], turns[k][1]);
    } else if (kind == 2) {
        const float ring = ffp_draw(rng, 0.5F, 0.7F);
        ffp_add_torus(shape, ffp_v3(0, 0, 0), ring, ffp_draw(rng, 0.18F, 0.35F), 0);
        if (ffp_pick(rng, 0, 1))
            ffp_part_turn(ffp_add_torus(shape, ffp_v3(ring, 0, 0), ring, 0.14F, 0), 0, 0, 0.5F * PI);
        shape->bump = ffp_draw(rng, 0, 0.06F), shape->bump_frequency = ffp_draw(rng, 1.5F, 3);
    } else if (kind == 3) {
        chain(shape, rng);
    } else { // a spring
        const float loops = ffp_draw(rng, 2.5F, 5), tube = ffp_draw(rng, 0.09F, 0.13F),
                    ring = ffp_draw(rng, 0.4F, 0.6F);
        FfpV3 last = {0};
        for (int i = 0; i <= 150; i++) {
            const float t = (float)i / 150, a = 2 * PI * loops * t;
            const FfpV3 at = ffp_v3(ring * cosf(a), ring * sinf(a), loops * 0.34F * (t - 0.5F));
            if (i > 0) ffp_add_cone(shape, last, at, tube, tube, 0);
            last = at;
        }
    }
    shape->lipschitz = 1.4F;
    shape->upright = false;
}
