#include "world/synth/material.h"
#include <math.h>
#include <string.h>
#include "core/base/rng.h"
#include "world/synth/looks.h"

// Hue, saturation, value (as a painter names sRGB colours) to linear RGB.
static void hsv_to_linear(float hue, float saturation, float value, float out[3]) {
    for (int c = 0; c < 3; c++) {
        const float k = fmodf(6 * (hue - floorf(hue)) + (c == 0 ? 5.0F : c == 1 ? 3.0F : 1.0F), 6);
        const float v = value * (1 - saturation * ffp_clamp01(ffp_min(k, 4 - k)));
        out[c] = v <= 0.04045F ? v / 12.92F : powf((v + 0.055F) / 1.055F, 2.4F);
    }
}

FfpMaterial ffp_material_make(int material, uint64_t seed) {
    const FfpMaterialKind *kind = &ffp_material_kinds[material];
    FfpRng rng = ffp_rng(seed ^ 0x3a7e91a1ULL, (uint64_t)material);
    FfpMaterial m = {.kind = kind, .seed = ffp_rng_u32(&rng)};
    const float hue = ffp_rng_range(&rng, kind->hue[0], kind->hue[1]);
    const float grey =
        ffp_rng_uniform(&rng) < 0.12F ? 0.1F : 1; // now and then the whole palette is nearly grey
    const float dark = ffp_rng_uniform(&rng) < 0.12F ? 0.55F : 1; // or dark
    for (int i = 0; i < FFP_PALETTE; i++) {
        const float stray = kind->spread * ffp_rng_range(&rng, -0.5F, 0.5F), h = hue + (i ? stray : 0);
        const float s = grey * ffp_rng_range(&rng, kind->saturation[0], kind->saturation[1]);
        const float base = ffp_rng_range(&rng, kind->value[0], kind->value[1]);
        const float darker = kind->contrast * ffp_rng_uniform(&rng), lift = 0.1F * ffp_rng_uniform(&rng);
        const float v = i ? base * (1 - darker) + lift : base, *at = kind->anchors ? kind->anchors[i] : NULL;
        if (at)
            hsv_to_linear(at[0] + h, ffp_clamp01(at[1] * s), dark * ffp_clamp01(at[2] * base), m.colour[i]);
        else // the power evens out linear albedo
            hsv_to_linear(h, s, dark * powf(ffp_clamp01(v), 0.45F), m.colour[i]);
    }
    const float middle = 0.5F * (kind->rough[0] + kind->rough[1]);
    m.rough[0] = kind->rough[0] + (middle - kind->rough[0]) * 0.7F * ffp_rng_uniform(&rng);
    m.rough[1] = kind->rough[1] - (kind->rough[1] - middle) * 0.7F * ffp_rng_uniform(&rng);
    m.scale = kind->scale * expf(ffp_rng_range(&rng, -0.45F, 0.45F));
    m.bump = kind->relief ? kind->relief_height / m.scale * ffp_rng_range(&rng, 0.4F, 1) : 0;
    for (int i = 0; i < 4; i++) m.vary[i] = ffp_rng_uniform(&rng);
    float q[4], n = 0; // a random quaternion turns the texture
    for (int i = 0; i < 4; i++) q[i] = ffp_rng_normal(&rng), n += q[i] * q[i];
    for (int i = 0; i < 4; i++) q[i] /= sqrtf(n);
    const float x = q[0], y = q[1], z = q[2], w = q[3];
    const float r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(m.axes, r, sizeof r);
    return m;
}

static void texture_point(const FfpMaterial *m, const float p[3], float q[3]) {
    for (int a = 0; a < 3; a++)
        q[a] = m->scale * (m->axes[3 * a] * p[0] + m->axes[3 * a + 1] * p[1] + m->axes[3 * a + 2] * p[2]);
}

void ffp_material_look(const FfpMaterial *m, const float p[3], float albedo[3], float *roughness) {
    float q[3];
    texture_point(m, p, q);
    FfpLook look = {{0}, 0};
    m->kind->look(m, q, &look);
    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < FFP_PALETTE; i++) sum += look.mix[i] * m->colour[i][c];
        albedo[c] = ffp_min(0.95F, ffp_max(0.02F, sum));
    }
    *roughness =
        ffp_min(0.95F, ffp_max(0.15F, m->rough[0] + (m->rough[1] - m->rough[0]) * ffp_clamp01(look.rough)));
}

void ffp_material_bump(const FfpMaterial *m, const float p[3], float normal[3]) {
    const FfpMaterialKind *kind = m->kind;
    if (!kind->relief || m->bump <= 0) return;
    const float e = 0.008F; // half a pixel: finer relief would only sparkle
    float q[3], slope[3], along = 0;
    texture_point(m, p, q);
    const float here = kind->relief(m, q);
    for (int a = 0; a < 3; a++) {
        const float moved[3] = {p[0] + (a == 0 ? e : 0), p[1] + (a == 1 ? e : 0), p[2] + (a == 2 ? e : 0)};
        texture_point(m, moved, q);
        slope[a] = m->bump * (kind->relief(m, q) - here) / e;
        along += slope[a] * normal[a];
    }
    float n[3], length = 0;
    for (int a = 0; a < 3; a++) n[a] = normal[a] - (slope[a] - along * normal[a]), length += n[a] * n[a];
    length = 1 / sqrtf(length);
    for (int a = 0; a < 3; a++) normal[a] = n[a] * length;
}
