// Shells and what lives on the shore.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/scalar.h"
#include "world/shapes/shape.h"

static FfpV3 along(FfpV3 a, FfpV3 d, float t) {
    return ffp_v3(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z);
}

static void ball(FfpShape *shape, FfpV3 at, float r, float blend) {
    ffp_add_ellipsoid(shape, at, ffp_v3(r, r, r), blend);
}

// A tube along a spiral that grows by `growth` a turn around z and sinks by `climb`; `thick` is its radius
// over its distance from the axis; `ribs` rings a turn.
typedef struct Spiral {
    float turns, growth, climb, thick, ribs;
    FfpV3 mouth, out; // the end's centre, and the way out of it
    float radius;
} Spiral;

static void spiral(FfpShape *shape, Spiral *s) {
    const int n = 110;
    FfpV3 last = ffp_v3(0, 0, 0);
    for (int i = 0; i <= n; i++) {
        const float t = (float)i / (float)n, size = powf(s->growth, s->turns * (t - 1)),
                    a = 2 * FFP_PI * s->turns * t;
        const FfpV3 at = ffp_v3(size * cosf(a), size * sinf(a), s->climb * (0.5F - size));
        const float wave = s->ribs > 0 ? 0.07F * sinf(2 * FFP_PI * s->ribs * s->turns * t) : 0;
        const float radius = ffp_max(s->thick * size * (1 + wave), 0.015F);
        if (i > 0) ffp_add_cone(shape, last, at, s->radius, radius, 0.02F);
        if (i == n) s->out = ffp_v3(at.x - last.x, at.y - last.y, at.z - last.z);
        last = at, s->radius = radius;
    }
    const float length = sqrtf(s->out.x * s->out.x + s->out.y * s->out.y + s->out.z * s->out.z);
    s->out = ffp_v3(s->out.x / length, s->out.y / length, s->out.z / length);
    s->mouth = last;
}

// Hollows the end out.
static void open_mouth(FfpShape *shape, const Spiral *s, float depth) {
    const float r = 0.78F * s->radius;
    ffp_add_cone(shape, along(s->mouth, s->out, -depth * s->radius), along(s->mouth, s->out, s->radius),
                 0.6F * r, 1.1F * r, 0.03F)
        ->join = FFP_CSG_DIFFERENCE;
    FfpPart *rim = ffp_add_cylinder(shape, along(s->mouth, s->out, 1.35F * s->radius), 1.6F * s->radius,
                                    s->radius, 0, 0.03F);
    ffp_part_align(rim, s->out);
    ffp_cut(rim);
}

static void ammonite(FfpShape *shape) {
    Spiral s = {.turns = 3.2F, .growth = 1.75F, .thick = 0.3F, .ribs = 11};
    spiral(shape, &s);
    shape->upright = false;
}

static void nautilus(FfpShape *shape) {
    Spiral s = {.turns = 1.6F, .growth = 2.9F, .thick = 0.56F};
    spiral(shape, &s);
    open_mouth(shape, &s, 1.6F);
    shape->upright = false;
}

static void turret(FfpShape *shape) {
    Spiral s = {.turns = 7, .growth = 1.32F, .climb = 5, .thick = 0.75F};
    spiral(shape, &s);
    shape->upright = false;
}

static void snail(FfpShape *shape) {
    static const float body[5][4] = {{-1.8F, 0, -1.55F, 0.12F},
                                     {-0.8F, 0, -1.5F, 0.34F},
                                     {0.6F, 0, -1.5F, 0.44F},
                                     {1.4F, 0, -1.3F, 0.42F},
                                     {1.7F, 0, -0.7F, 0.4F}};
    Spiral s = {.turns = 2.6F, .growth = 1.9F, .climb = 0.9F, .thick = 0.72F};
    spiral(shape, &s);
    for (int i = 0; i < shape->n_parts; i++) { // the shell stands on its edge
        FfpPart *part = &shape->parts[i];
        const float c[3] = {part->centre[0], part->centre[1], part->centre[2]};
        const FfpV3 way = ffp_v3(part->axes[6], -part->axes[8], part->axes[7]);
        part->centre[0] = c[0], part->centre[1] = -c[2], part->centre[2] = c[1];
        ffp_part_align(part, way);
    }
    ffp_add_tube(shape, body, 5, 1, 0, 0.15F);
    for (int side = -1; side <= 1; side += 2) {
        ffp_add_cone(shape, ffp_v3(1.75F, 0.15F * (float)side, -0.5F),
                     ffp_v3(2.05F, 0.4F * (float)side, 0.15F), 0.1F, 0.07F, 0.05F);
        ball(shape, ffp_v3(2.07F, 0.41F * (float)side, 0.2F), 0.14F, 0.02F);
    }
}

static void ram_horn(FfpShape *shape) {
    Spiral s = {.turns = 1.35F, .growth = 2.4F, .climb = 1.7F, .thick = 0.36F, .ribs = 13};
    spiral(shape, &s);
    shape->upright = false;
}

static void scallop(FfpShape *shape) {
    for (int i = 0; i < 11; i++) {
        const float a = 0.24F * (float)(i - 5), r = 1 - 0.03F * (float)((i - 5) * (i - 5)) * 0.4F;
        const FfpV3 end = ffp_v3(1.5F * r * sinf(a), 0, 1.5F * r * cosf(a) - 0.7F),
                    middle = ffp_v3(0.8F * r * sinf(a), 0.34F, 0.8F * r * cosf(a) - 0.7F);
        ffp_add_cone(shape, ffp_v3(0, 0.05F, -0.75F), middle, 0.07F, 0.13F, 0.02F);
        ffp_add_cone(shape, middle, end, 0.13F, 0.15F, 0.02F);
    }
    ffp_add_ellipsoid(shape, ffp_v3(0, 0.16F, 0.05F), ffp_v3(0.9F, 0.14F, 0.72F), 0.02F);
    ffp_add_box(shape, ffp_v3(0, 0.05F, -0.72F), ffp_v3(0.36F, 0.08F, 0.12F), 0.05F, 0.05F);
    shape->upright = false;
}

// Two hollow valves that open towards +x, and a pearl.
static void open_clam(FfpShape *shape) {
    for (int side = -1; side <= 1; side += 2) {
        const float s = (float)side;
        ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.42F * s), ffp_v3(0.85F, 0.72F, 0.3F), 0.02F),
                        0, -0.55F * s, 0);
        FfpPart *inner =
            ffp_add_ellipsoid(shape, ffp_v3(0.08F, 0, 0.3F * s), ffp_v3(0.74F, 0.62F, 0.26F), 0.02F);
        ffp_part_rotate(inner, 0, -0.55F * s, 0);
        ffp_cut(inner);
    }
    ffp_part_align(ffp_add_cylinder(shape, ffp_v3(-0.68F, 0, 0), 0.14F, 0.3F, 0.05F, 0.06F), ffp_v3(0, 1, 0));
    ball(shape, ffp_v3(0, 0, -0.42F), 0.2F, 0.01F);
}

static void urchin(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.5F, 0.5F, 0.42F), 0);
    for (int i = 0; i < 64; i++) {
        const float z = 1 - 2 * ((float)i + 0.5F) / 64, a = 2.39996F * (float)i, r = sqrtf(1 - z * z);
        const float far = 0.85F + 0.12F * sinf(5 * a);
        ffp_add_cone(shape, ffp_v3(0.45F * r * cosf(a), 0.45F * r * sinf(a), 0.38F * z),
                     ffp_v3(far * r * cosf(a), far * r * sinf(a), far * z), 0.055F, 0.025F, 0.02F);
    }
    shape->upright = false;
}

static void starfish(FfpShape *shape) {
    static const float arm[4][4] = {{0, 0, 0.05F, 0.24F},
                                    {0.4F, 0.02F, 0.06F, 0.18F},
                                    {0.75F, 0.1F, 0.02F, 0.12F},
                                    {1, 0.24F, 0.08F, 0.06F}};
    for (int i = 0; i < 5; i++) ffp_add_tube(shape, arm, 4, 1, 0.4F * FFP_PI * (float)i, 0.1F);
    for (int i = 0; i < 5; i++)
        for (int k = 1; k < 6; k++) {
            const float a = 0.4F * FFP_PI * (float)i + 0.04F * (float)k, r = 0.14F * (float)k;
            ball(shape, ffp_v3(r * cosf(a), r * sinf(a), 0.29F - 0.03F * (float)k), 0.05F, 0.01F);
        }
    shape->upright = false;
}

static void murex(FfpShape *shape) {
    Spiral s = {.turns = 4, .growth = 1.7F, .climb = 2.2F, .thick = 0.66F};
    spiral(shape, &s);
    for (int i = 0; i < 14; i++) {
        const float t = 0.42F + 0.043F * (float)i, size = powf(s.growth, s.turns * (t - 1)),
                    a = 2 * FFP_PI * s.turns * t;
        const FfpV3 at =
            ffp_v3(1.3F * size * cosf(a), 1.3F * size * sinf(a), s.climb * (0.5F - size) + 0.4F * size);
        ffp_add_cone(shape, at, ffp_v3(1.75F * at.x, 1.75F * at.y, at.z + 0.4F * size), 0.28F * size, 0.04F,
                     0.05F);
    }
    open_mouth(shape, &s, 1);
    ffp_add_cone(shape, ffp_v3(0.4F, 0, -1.6F), ffp_v3(0.2F, 0, -2.9F), 0.4F, 0.1F, 0.1F);
    shape->upright = false;
}

const FfpFamily ffp_family_shell = {{{"ammonite", ammonite},
                                     {"nautilus", nautilus},
                                     {"turret", turret},
                                     {"snail", snail},
                                     {"ram horn", ram_horn},
                                     {"scallop", scallop},
                                     {"open clam", open_clam},
                                     {"urchin", urchin},
                                     {"starfish", starfish},
                                     {"murex", murex}}};
