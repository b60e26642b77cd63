// The looks are solid textures (Perlin 1985, Peachey 1985): no parametrisation, so they fit any mesh.
// Features are kept coarser than a pixel of the default rig (0.017 units), because finer ones are noise to a
// camera of 128 pixels.
#include "synth/material.h"

#include <math.h>
#include <string.h>
#include "base/rng.h"
#include "synth/noise.h"
#include "synth/synth.h"
#include "synth/scalar.h"

typedef struct Look {
    float mix[FFP_PALETTE]; // weights of the palette's colours; they need not sum to 1
    float rough;            // 0..1 within the material's range
} Look;

typedef struct Kind {
    const char *name;
    void (*look)(const FfpMaterial *m, const float q[3], Look *out);
    float (*relief)(const FfpMaterial *m, const float q[3]); // NULL: smooth; about [-1, 1]
    float relief_height;                                     // times the feature size
    float hue[2], saturation[2], value[2];                   // where the first colour lies (hue in turns)
    float spread;                                            // how far the others stray in hue; 1 = anywhere
    float contrast;                                          // how far the others stray in value
    float rough[2];
    float scale; // features a unit length
} Kind;

static float clamp01(float x) {
    return ffp_min(1, ffp_max(0, x));
}
static float step_between(float low, float high, float x) {
    const float t = clamp01((x - low) / (high - low));
    return t * t * (3 - 2 * t);
}
static void two(Look *out, float t) {
    out->mix[0] = 1 - t, out->mix[1] = t;
}
// A value in [0, 1] spread over all colours in turn.
static void ramp(Look *out, float t) {
    const float x = clamp01(t) * (FFP_PALETTE - 1);
    const int i = (int)ffp_min(x, FFP_PALETTE - 2);
    out->mix[i] = 1 - (x - (float)i), out->mix[i + 1] = x - (float)i;
}

static void marble(const FfpMaterial *m, const float q[3], Look *out) {
    const float warp = ffp_fbm(q, m->seed, 4), x = q[0] + (1.2F + 2 * m->vary[0]) * warp;
    const float vein = powf(fabsf(sinf(2.2F * x)), 0.35F + 0.5F * m->vary[1]);
    const float cloud =
        0.5F + 0.5F * ffp_noise((float[3]){0.7F * q[0], 0.7F * q[1], 0.7F * q[2]}, m->seed + 7);
    out->mix[1] = 1 - vein, out->mix[2] = 0.4F * vein * cloud, out->mix[0] = vein * (1 - 0.4F * cloud);
    out->rough = 0.3F + 0.7F * (1 - vein);
}

static void wood(const FfpMaterial *m, const float q[3], Look *out) {
    const float wobble = 0.35F * ffp_noise((float[3]){0.8F * q[0], 0.8F * q[1], 0.25F * q[2]}, m->seed);
    const float x = q[0] + 0.9F, r = sqrtf(x * x + q[1] * q[1]) * (1.6F + 1.5F * m->vary[0]) + wobble * 2;
    const float ring = r - floorf(r),
                late = step_between(0.45F, 0.95F, ring) * (1 - step_between(0.95F, 1, ring));
    const float grain = ffp_noise((float[3]){5 * q[0], 5 * q[1], 0.6F * q[2]}, m->seed + 3);
    two(out, clamp01(0.15F + 0.7F * late + 0.2F * grain));
    out->rough = clamp01(0.6F - 0.4F * late + 0.3F * grain);
}
static float wood_relief(const FfpMaterial *m, const float q[3]) {
    return ffp_noise((float[3]){5 * q[0], 5 * q[1], 0.6F * q[2]}, m->seed + 3);
}

static void granite(const FfpMaterial *m, const float q[3], Look *out) {
    const FfpCells c = ffp_cells((float[3]){3 * q[0], 3 * q[1], 3 * q[2]}, m->seed);
    const float pick = ffp_hash_unit(c.id), cloud = 0.5F + 0.5F * ffp_fbm(q, m->seed + 5, 3);
    out->mix[pick < 0.5F ? 0 : pick < 0.75F ? 1 : pick < 0.92F ? 2 : 3] = 0.75F;
    out->mix[0] += 0.25F * cloud, out->mix[2] += 0.25F * (1 - cloud);
    out->rough = pick < 0.5F ? 0.7F : 0.25F;
}

static void terracotta(const FfpMaterial *m, const float q[3], Look *out) {
    const float t = 0.5F + 0.6F * ffp_fbm(q, m->seed, 4);
    two(out, clamp01(t));
    out->mix[2] =
        0.35F * step_between(0.15F, 0.6F, ffp_fbm((float[3]){2 * q[0], 2 * q[1], 2 * q[2]}, m->seed + 9, 3));
    out->rough = clamp01(0.4F + 0.6F * t);
}
static float rough_relief(const FfpMaterial *m, const float q[3]) {
    return ffp_fbm((float[3]){2.4F * q[0], 2.4F * q[1], 2.4F * q[2]}, m->seed + 1, 2);
}

static void plaster(const FfpMaterial *m, const float q[3], Look *out) {
    const float t = 0.5F + 0.5F * ffp_fbm(q, m->seed, 3);
    two(out, 0.5F * t);
    out->rough = 0.4F + 0.6F * t;
}

static void plastic(const FfpMaterial *m, const float q[3], Look *out) {
    const int parts = 1 + (int)(3 * m->vary[0]); // one, two or three plain colours
    const float d = q[2] + 0.15F * sinf(2 * q[0]);
    const int i = parts == 1                            ? 0
                  : d < 0.9F * m->vary[1] - 0.6F        ? 0
                  : parts == 2 || d < 0.9F * m->vary[1] ? 1
                                                        : 2;
    out->mix[i] = 1;
    out->rough = parts == 1 ? 0.5F + 0.4F * ffp_noise(q, m->seed) : 0.4F * (float)i;
}

static void checks(const FfpMaterial *m, const float q[3], Look *out) {
    int odd = 0;
    float joint = 1;
    for (int a = 0; a < 3; a++) {
        const float x = q[a] + 0.31F * (float)(a + 1), f = x - floorf(x);
        odd += (int)floorf(x);
        joint = ffp_min(joint, ffp_min(f, 1 - f));
    }
    const uint32_t tile = ffp_hash32((uint32_t)(int)floorf(q[0] + 0.31F) * 73856093U ^
                                     (uint32_t)(int)floorf(q[1] + 0.62F) * 19349663U ^
                                     (uint32_t)(int)floorf(q[2] + 0.93F) * 83492791U ^ m->seed);
    const float grout = m->vary[0] < 0.5F ? 0 : 1 - step_between(0.03F, 0.06F, joint),
                shade = 0.75F + 0.25F * ffp_hash_unit(tile);
    out->mix[odd & 1] = (1 - grout) * shade;
    out->mix[4] = grout;
    out->rough = grout > 0 ? 0.5F + 0.5F * grout : 0.4F * (float)(odd & 1);
}

static void fabric(const FfpMaterial *m, const float q[3], Look *out) {
    const float warp = sinf(6.2832F * q[0]), weft = sinf(6.2832F * q[1] + 0.5F * q[2]),
                deep = sinf(6.2832F * q[2]);
    const float check = step_between(-0.15F, 0.15F, sinf(1.1F * q[0]) + (m->vary[0] - 0.5F)) +
                        step_between(-0.15F, 0.15F, sinf(1.3F * q[1]));
    const float thread = 0.5F + 0.5F * ffp_max(warp * weft, weft * deep);
    ramp(out, check / 2 * 0.75F);
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 0.7F + 0.3F * thread;
    out->rough = 0.5F + 0.5F * thread;
}
static float fabric_relief(const FfpMaterial *m, const float q[3]) {
    (void)m;
    return sinf(6.2832F * q[0]) * sinf(6.2832F * q[1]) + sinf(6.2832F * q[2]) * 0.5F;
}

static void spots(const FfpMaterial *m, const float q[3], Look *out) {
    const FfpCells c = ffp_cells(q, m->seed);
    const float size = 0.24F + 0.2F * m->vary[0] + 0.12F * ffp_hash_unit(c.id + 1);
    const float in = 1 - step_between(size - 0.03F, size + 0.03F, c.nearest);
    out->mix[0] = 1 - in;
    out->mix[1 + (int)(c.id % 3)] += in;
    out->rough = in;
}

static void stripes(const FfpMaterial *m, const float q[3], Look *out) {
    const float wave = q[0] + 0.6F * (m->vary[0] > 0.5F ? m->vary[1] : 0) * ffp_noise(q, m->seed);
    const float t = step_between(-0.2F, 0.2F, sinf(6.2832F * wave) + 0.6F * (m->vary[2] - 0.5F));
    const int other = 1 + (int)(ffp_hash32((uint32_t)(int)floorf(wave + 0.25F) + m->seed) % 3U);
    out->mix[0] = 1 - t, out->mix[m->vary[3] < 0.5F ? 1 : other] = t;
    out->rough = t;
}

static void gradient(const FfpMaterial *m, const float q[3], Look *out) {
    const float t = 0.5F + 0.55F * q[2] + 0.12F * (m->vary[0] - 0.3F) * ffp_fbm(q, m->seed, 3);
    ramp(out, t);
    out->rough = clamp01(m->vary[1] < 0.5F ? t : 1 - t);
}

static void ground(const FfpMaterial *m, const float q[3], Look *out) {
    const float t = 0.5F + 0.6F * ffp_fbm(q, m->seed, 5);
    const FfpCells c = ffp_cells((float[3]){2.2F * q[0], 2.2F * q[1], 2.2F * q[2]}, m->seed + 2);
    const float pebble = ffp_hash_unit(c.id) < 0.3F ? 1 - step_between(0.3F, 0.4F, c.nearest) : 0;
    ramp(out, 0.75F * t);
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - pebble;
    out->mix[4] += pebble * (0.6F + 0.4F * ffp_hash_unit(c.id + 5));
    out->rough = 1 - 0.6F * pebble;
}

static void ceramic(const FfpMaterial *m, const float q[3], Look *out) {
    const float warp = 0.2F * ffp_noise(q, m->seed + 4), w[3] = {q[0] + warp, q[1] - warp, q[2] + warp};
    const FfpCells c = ffp_cells(w, m->seed);
    const float crack = 1 - step_between(0.02F, 0.09F, c.second - c.nearest),
                pool = 0.5F + 0.5F * ffp_fbm(q, m->seed + 1, 3);
    out->mix[0] = (1 - crack) * (1 - 0.6F * pool), out->mix[1] = (1 - crack) * 0.6F * pool,
    out->mix[2] = crack;
    out->rough = 0.15F + 0.2F * pool + 0.65F * crack;
}

static void camouflage(const FfpMaterial *m, const float q[3], Look *out) {
    int layer = 0;
    for (int i = 1; i < 4; i++)
        if (ffp_fbm((float[3]){q[0] + 3.1F * (float)i, q[1], q[2]}, m->seed + 11 * (uint32_t)i, 3) >
            0.12F + 0.1F * m->vary[i])
            layer = i;
    out->mix[layer] = 1;
    out->rough = 0.33F * (float)layer;
}

static void mosaic(const FfpMaterial *m, const float q[3], Look *out) {
    const FfpCells c = ffp_cells(q, m->seed);
    const float joint = m->vary[0] < 0.5F ? 0 : 1 - step_between(0.02F, 0.08F, c.second - c.nearest);
    ramp(out, ffp_hash_unit(c.id + 1));
    const float shade = (1 - joint) * (0.6F + 0.4F * ffp_hash_unit(c.id + 2));
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= shade;
    out->mix[4] += 0.4F * joint;
    out->rough = ffp_max(joint, ffp_hash_unit(c.id + 3));
}
static float cell_relief(const FfpMaterial *m, const float q[3]) {
    const FfpCells c = ffp_cells(q, m->seed);
    return step_between(0, 0.25F, c.second - c.nearest);
}

static void patina(const FfpMaterial *m, const float q[3], Look *out) {
    const float t = step_between(-0.1F, 0.15F, ffp_fbm(q, m->seed, 5) + 0.5F * (m->vary[0] - 0.5F));
    const float fine = 0.5F + 0.5F * ffp_noise((float[3]){3 * q[0], 3 * q[1], 3 * q[2]}, m->seed + 3);
    out->mix[0] = 1 - t, out->mix[1] = t * fine, out->mix[2] = t * (1 - fine);
    out->rough = 0.1F + 0.9F * t;
}
static float patina_relief(const FfpMaterial *m, const float q[3]) {
    return step_between(-0.1F, 0.15F, ffp_fbm(q, m->seed, 3) + 0.5F * (m->vary[0] - 0.5F));
}

static float brick_joint(const float q[3], uint32_t *id) {
    const float row = floorf(1.8F * q[2]), shift = fmodf(row, 2) == 0 ? 0 : 0.5F;
    const float x = q[0] + shift, y = q[1] + shift, fx = x - floorf(x), fy = y - floorf(y),
                fz = 1.8F * q[2] - row;
    *id = ffp_hash32((uint32_t)(int)floorf(x) * 73856093U ^ (uint32_t)(int)floorf(y) * 19349663U ^
                     (uint32_t)(int)row * 83492791U);
    return ffp_min(ffp_min(fx, 1 - fx), ffp_min(ffp_min(fy, 1 - fy), 0.55F * ffp_min(fz, 1 - fz)));
}
static void brick(const FfpMaterial *m, const float q[3], Look *out) {
    uint32_t id;
    const float joint = 1 - step_between(0.03F, 0.07F, brick_joint(q, &id)),
                stain = 0.25F * ffp_fbm(q, m->seed, 3);
    ramp(out, 0.7F * clamp01(ffp_hash_unit(id + m->seed) + stain));
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - joint;
    out->mix[4] += joint;
    out->rough = 0.3F + 0.4F * ffp_hash_unit(id + 3) + 0.3F * joint;
}
static float brick_relief(const FfpMaterial *m, const float q[3]) {
    uint32_t id;
    (void)m;
    return step_between(0.01F, 0.09F, brick_joint(q, &id));
}

static void paint(const FfpMaterial *m, const float q[3], Look *out) {
    const float a = ffp_fbm(q, m->seed, 2), b = ffp_fbm((float[3]){q[0] + 5, q[1], q[2]}, m->seed + 1, 2);
    const float w[3] = {q[0] + 1.6F * a, q[1] + 1.6F * b, q[2] + 1.6F * a * b},
                t = 0.5F + 0.8F * ffp_fbm(w, m->seed + 2, 3);
    ramp(out, m->vary[0] < 0.5F ? t : floorf(7 * t) / 6); // blended, or in flat bands
    out->rough = clamp01(t);
}

// clang-format off
static const Kind kind_table[] = {
    {"marble", marble, NULL, 0, {0, 1}, {0.02F, 0.3F}, {0.75F, 0.95F}, 0.3F, 0.6F, {0.15F, 0.45F}, 1.6F},
    {"wood", wood, wood_relief, 0.03F, {0.04F, 0.11F}, {0.4F, 0.75F}, {0.55F, 0.85F}, 0.04F, 0.45F, {0.3F, 0.75F}, 2.2F},
    {"granite", granite, NULL, 0, {0, 1}, {0, 0.3F}, {0.5F, 0.8F}, 0.3F, 0.6F, {0.3F, 0.8F}, 3},
    {"terracotta", terracotta, rough_relief, 0.06F, {0.01F, 0.09F}, {0.5F, 0.8F}, {0.6F, 0.85F}, 0.03F, 0.3F, {0.7F, 0.95F}, 1.8F},
    {"plaster", plaster, rough_relief, 0.05F, {0, 1}, {0, 0.18F}, {0.8F, 0.96F}, 0.1F, 0.2F, {0.75F, 0.95F}, 1.6F},
    {"plastic", plastic, NULL, 0, {0, 1}, {0.4F, 1}, {0.55F, 0.95F}, 1, 0.4F, {0.15F, 0.45F}, 1.2F},
    {"checks", checks, NULL, 0, {0, 1}, {0.1F, 0.9F}, {0.3F, 0.95F}, 1, 0.6F, {0.2F, 0.8F}, 3},
    {"fabric", fabric, fabric_relief, 0.05F, {0, 1}, {0.2F, 0.85F}, {0.4F, 0.9F}, 0.6F, 0.4F, {0.75F, 0.95F}, 7},
    {"spots", spots, NULL, 0, {0, 1}, {0.2F, 0.9F}, {0.5F, 0.95F}, 1, 0.5F, {0.25F, 0.8F}, 3},
    {"stripes", stripes, NULL, 0, {0, 1}, {0.3F, 0.9F}, {0.4F, 0.95F}, 1, 0.5F, {0.25F, 0.8F}, 3.5F},
    {"gradient", gradient, NULL, 0, {0, 1}, {0.4F, 0.9F}, {0.5F, 0.95F}, 0.5F, 0.4F, {0.2F, 0.9F}, 1},
    {"ground", ground, rough_relief, 0.09F, {0.05F, 0.25F}, {0.25F, 0.6F}, {0.35F, 0.65F}, 0.08F, 0.5F, {0.45F, 0.95F}, 2.2F},
    {"ceramic", ceramic, NULL, 0, {0, 1}, {0.2F, 0.8F}, {0.6F, 0.95F}, 0.25F, 0.5F, {0.15F, 0.6F}, 3},
    {"camouflage", camouflage, NULL, 0, {0.1F, 0.4F}, {0.2F, 0.6F}, {0.35F, 0.75F}, 0.2F, 0.5F, {0.45F, 0.9F}, 2},
    {"mosaic", mosaic, cell_relief, 0.05F, {0, 1}, {0.3F, 0.9F}, {0.5F, 0.95F}, 1, 0.5F, {0.2F, 0.8F}, 4},
    {"patina", patina, patina_relief, 0.04F, {0, 1}, {0.1F, 0.7F}, {0.35F, 0.8F}, 0.5F, 0.5F, {0.2F, 0.95F}, 2},
    {"brick", brick, brick_relief, 0.05F, {0, 0.1F}, {0.3F, 0.7F}, {0.5F, 0.8F}, 0.06F, 0.4F, {0.6F, 0.95F}, 3},
    {"paint", paint, NULL, 0, {0, 1}, {0.4F, 1}, {0.5F, 1}, 1, 0.5F, {0.2F, 0.7F}, 1.3F},
};
// clang-format on
enum { KINDS = sizeof kind_table / sizeof kind_table[0] };

int ffp_material_count(void) {
    return KINDS;
}
const char *ffp_material_name(int material) {
    return material >= 0 && material < KINDS ? kind_table[material].name : "unknown";
}

// Hue, saturation, value (as a painter names sRGB colours) to linear RGB.
static void hsv_to_linear(float hue, float saturation, float value, float out[3]) {
    for (int c = 0; c < 3; c++) {
        const float k = fmodf(6 * (hue - floorf(hue)) + (c == 0 ? 5.0F : c == 1 ? 3.0F : 1.0F), 6);
        const float v = value * (1 - saturation * clamp01(ffp_min(k, 4 - k)));
        out[c] = v <= 0.04045F ? v / 12.92F : powf((v + 0.055F) / 1.055F, 2.4F);
    }
}

FfpMaterial ffp_material_make(int material, uint64_t seed) {
    const Kind *kind = &kind_table[material];
    FfpRng rng = ffp_rng(seed ^ 0x3a7e91a1ULL, (uint64_t)material);
    FfpMaterial m = {.kind = material, .seed = ffp_rng_u32(&rng)};
    const float hue = ffp_rng_range(&rng, kind->hue[0], kind->hue[1]);
    const float grey =
        ffp_rng_uniform(&rng) < 0.12F ? 0.1F : 1; // now and then the whole palette is nearly grey
    const float dark = ffp_rng_uniform(&rng) < 0.12F ? 0.55F : 1; // or dark
    for (int i = 0; i < FFP_PALETTE; i++) {
        const float stray = kind->spread * ffp_rng_range(&rng, -0.5F, 0.5F), h = hue + (i ? stray : 0);
        const float s = grey * clamp01(ffp_rng_range(&rng, kind->saturation[0], kind->saturation[1]));
        const float base = ffp_rng_range(&rng, kind->value[0], kind->value[1]);
        const float darker = kind->contrast * ffp_rng_uniform(&rng), lift = 0.1F * ffp_rng_uniform(&rng);
        const float v = i ? base * (1 - darker) + lift : base;
        hsv_to_linear(h, s, dark * powf(clamp01(v), 0.45F), m.colour[i]); // the power evens out linear albedo
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
    Look look = {{0}, 0};
    kind_table[m->kind].look(m, q, &look);
    for (int c = 0; c < 3; c++) {
        float sum = 0;
        for (int i = 0; i < FFP_PALETTE; i++) sum += look.mix[i] * m->colour[i][c];
        albedo[c] = ffp_min(0.95F, ffp_max(0.02F, sum));
    }
    *roughness =
        ffp_min(0.95F, ffp_max(0.15F, m->rough[0] + (m->rough[1] - m->rough[0]) * clamp01(look.rough)));
}

void ffp_material_bump(const FfpMaterial *m, const float p[3], float normal[3]) {
    const Kind *kind = &kind_table[m->kind];
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
