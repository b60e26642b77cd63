// The looks that draw their palettes: solid textures (Perlin 1985, Peachey 1985) without a parametrisation,
// so that they fit any mesh. Features are kept coarser than a pixel of the default rig (0.017 units), because
// finer ones are noise to a camera of 128 pixels.
#include "world/synth/looks.h"
#include <math.h>
#include "world/shapes/noise.h"

void ffp_look_marble(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float warp = ffp_fbm(q, m->seed, 4), x = q[0] + (1.2F + 2 * m->vary[0]) * warp;
    const float vein = powf(fabsf(sinf(2.2F * x)), 0.35F + 0.5F * m->vary[1]);
    const float cloud =
        0.5F + 0.5F * ffp_noise((float[3]){0.7F * q[0], 0.7F * q[1], 0.7F * q[2]}, m->seed + 7);
    out->mix[1] = 1 - vein, out->mix[2] = 0.4F * vein * cloud, out->mix[0] = vein * (1 - 0.4F * cloud);
    out->rough = 0.3F + 0.7F * (1 - vein);
}

void ffp_look_wood(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float wobble = 0.35F * ffp_noise((float[3]){0.8F * q[0], 0.8F * q[1], 0.25F * q[2]}, m->seed);
    const float x = q[0] + 0.9F, r = sqrtf(x * x + q[1] * q[1]) * (1.6F + 1.5F * m->vary[0]) + wobble * 2;
    const float ring = r - floorf(r),
                late = ffp_step_between(0.45F, 0.95F, ring) * (1 - ffp_step_between(0.95F, 1, ring));
    const float grain = ffp_noise((float[3]){5 * q[0], 5 * q[1], 0.6F * q[2]}, m->seed + 3);
    ffp_mix_two(out, ffp_clamp01(0.15F + 0.7F * late + 0.2F * grain));
    out->rough = ffp_clamp01(0.6F - 0.4F * late + 0.3F * grain);
}
float ffp_relief_wood(const FfpMaterial *m, const float q[3]) {
    return ffp_noise((float[3]){5 * q[0], 5 * q[1], 0.6F * q[2]}, m->seed + 3);
}

void ffp_look_granite(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const FfpCells c = ffp_cells((float[3]){3 * q[0], 3 * q[1], 3 * q[2]}, m->seed);
    const float pick = ffp_hash_unit(c.id), cloud = 0.5F + 0.5F * ffp_fbm(q, m->seed + 5, 3);
    out->mix[pick < 0.5F ? 0 : pick < 0.75F ? 1 : pick < 0.92F ? 2 : 3] = 0.75F;
    out->mix[0] += 0.25F * cloud, out->mix[2] += 0.25F * (1 - cloud);
    out->rough = pick < 0.5F ? 0.7F : 0.25F;
}

void ffp_look_terracotta(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float t = 0.5F + 0.6F * ffp_fbm(q, m->seed, 4);
    ffp_mix_two(out, ffp_clamp01(t));
    out->mix[2] = 0.35F * ffp_step_between(0.15F, 0.6F,
                                           ffp_fbm((float[3]){2 * q[0], 2 * q[1], 2 * q[2]}, m->seed + 9, 3));
    out->rough = ffp_clamp01(0.4F + 0.6F * t);
}
float ffp_relief_rough(const FfpMaterial *m, const float q[3]) {
    return ffp_fbm((float[3]){2.4F * q[0], 2.4F * q[1], 2.4F * q[2]}, m->seed + 1, 2);
}

void ffp_look_plaster(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float t = 0.5F + 0.5F * ffp_fbm(q, m->seed, 3);
    ffp_mix_two(out, 0.5F * t);
    out->rough = 0.4F + 0.6F * t;
}

void ffp_look_plastic(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const int parts = 1 + (int)(3 * m->vary[0]); // one, two or three plain colours
    const float d = q[2] + 0.15F * sinf(2 * q[0]);
    const int i = parts == 1                            ? 0
                  : d < 0.9F * m->vary[1] - 0.6F        ? 0
                  : parts == 2 || d < 0.9F * m->vary[1] ? 1
                                                        : 2;
    out->mix[i] = 1;
    out->rough = parts == 1 ? 0.5F + 0.4F * ffp_noise(q, m->seed) : 0.4F * (float)i;
}

void ffp_look_checks(const FfpMaterial *m, const float q[3], FfpLook *out) {
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
    const float grout = m->vary[0] < 0.5F ? 0 : 1 - ffp_step_between(0.03F, 0.06F, joint),
                shade = 0.75F + 0.25F * ffp_hash_unit(tile);
    out->mix[odd & 1] = (1 - grout) * shade;
    out->mix[4] = grout;
    out->rough = grout > 0 ? 0.5F + 0.5F * grout : 0.4F * (float)(odd & 1);
}

void ffp_look_fabric(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float warp = sinf(6.2832F * q[0]), weft = sinf(6.2832F * q[1] + 0.5F * q[2]),
                deep = sinf(6.2832F * q[2]);
    const float check = ffp_step_between(-0.15F, 0.15F, sinf(1.1F * q[0]) + (m->vary[0] - 0.5F)) +
                        ffp_step_between(-0.15F, 0.15F, sinf(1.3F * q[1]));
    const float thread = 0.5F + 0.5F * ffp_max(warp * weft, weft * deep);
    ffp_mix_ramp(out, check / 2 * 0.75F);
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 0.7F + 0.3F * thread;
    out->rough = 0.5F + 0.5F * thread;
}
float ffp_relief_fabric(const FfpMaterial *m, const float q[3]) {
    (void)m;
    return sinf(6.2832F * q[0]) * sinf(6.2832F * q[1]) + sinf(6.2832F * q[2]) * 0.5F;
}

void ffp_look_spots(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const FfpCells c = ffp_cells(q, m->seed);
    const float size = 0.24F + 0.2F * m->vary[0] + 0.12F * ffp_hash_unit(c.id + 1);
    const float in = 1 - ffp_step_between(size - 0.03F, size + 0.03F, c.nearest);
    out->mix[0] = 1 - in;
    out->mix[1 + (int)(c.id % 3)] += in;
    out->rough = in;
}

void ffp_look_stripes(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float wave = q[0] + 0.6F * (m->vary[0] > 0.5F ? m->vary[1] : 0) * ffp_noise(q, m->seed);
    const float t = ffp_step_between(-0.2F, 0.2F, sinf(6.2832F * wave) + 0.6F * (m->vary[2] - 0.5F));
    const int other = 1 + (int)(ffp_hash32((uint32_t)(int)floorf(wave + 0.25F) + m->seed) % 3U);
    out->mix[0] = 1 - t, out->mix[m->vary[3] < 0.5F ? 1 : other] = t;
    out->rough = t;
}

void ffp_look_gradient(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float t = 0.5F + 0.55F * q[2] + 0.12F * (m->vary[0] - 0.3F) * ffp_fbm(q, m->seed, 3);
    ffp_mix_ramp(out, t);
    out->rough = ffp_clamp01(m->vary[1] < 0.5F ? t : 1 - t);
}

void ffp_look_ground(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float t = 0.5F + 0.6F * ffp_fbm(q, m->seed, 5);
    const FfpCells c = ffp_cells((float[3]){2.2F * q[0], 2.2F * q[1], 2.2F * q[2]}, m->seed + 2);
    const float pebble = ffp_hash_unit(c.id) < 0.3F ? 1 - ffp_step_between(0.3F, 0.4F, c.nearest) : 0;
    ffp_mix_ramp(out, 0.75F * t);
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - pebble;
    out->mix[4] += pebble * (0.6F + 0.4F * ffp_hash_unit(c.id + 5));
    out->rough = 1 - 0.6F * pebble;
}

void ffp_look_ceramic(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float warp = 0.2F * ffp_noise(q, m->seed + 4), w[3] = {q[0] + warp, q[1] - warp, q[2] + warp};
    const FfpCells c = ffp_cells(w, m->seed);
    const float crack = 1 - ffp_step_between(0.02F, 0.09F, c.second - c.nearest),
                pool = 0.5F + 0.5F * ffp_fbm(q, m->seed + 1, 3);
    out->mix[0] = (1 - crack) * (1 - 0.6F * pool), out->mix[1] = (1 - crack) * 0.6F * pool,
    out->mix[2] = crack;
    out->rough = 0.15F + 0.2F * pool + 0.65F * crack;
}

void ffp_look_camouflage(const FfpMaterial *m, const float q[3], FfpLook *out) {
    int layer = 0;
    for (int i = 1; i < 4; i++)
        if (ffp_fbm((float[3]){q[0] + 3.1F * (float)i, q[1], q[2]}, m->seed + 11 * (uint32_t)i, 3) >
            0.12F + 0.1F * m->vary[i])
            layer = i;
    out->mix[layer] = 1;
    out->rough = 0.33F * (float)layer;
}

void ffp_look_mosaic(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const FfpCells c = ffp_cells(q, m->seed);
    const float joint = m->vary[0] < 0.5F ? 0 : 1 - ffp_step_between(0.02F, 0.08F, c.second - c.nearest);
    ffp_mix_ramp(out, ffp_hash_unit(c.id + 1));
    const float shade = (1 - joint) * (0.6F + 0.4F * ffp_hash_unit(c.id + 2));
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= shade;
    out->mix[4] += 0.4F * joint;
    out->rough = ffp_max(joint, ffp_hash_unit(c.id + 3));
}
float ffp_relief_cell(const FfpMaterial *m, const float q[3]) {
    const FfpCells c = ffp_cells(q, m->seed);
    return ffp_step_between(0, 0.25F, c.second - c.nearest);
}

void ffp_look_patina(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float t = ffp_step_between(-0.1F, 0.15F, ffp_fbm(q, m->seed, 5) + 0.5F * (m->vary[0] - 0.5F));
    const float fine = 0.5F + 0.5F * ffp_noise((float[3]){3 * q[0], 3 * q[1], 3 * q[2]}, m->seed + 3);
    out->mix[0] = 1 - t, out->mix[1] = t * fine, out->mix[2] = t * (1 - fine);
    out->rough = 0.1F + 0.9F * t;
}
float ffp_relief_patina(const FfpMaterial *m, const float q[3]) {
    return ffp_step_between(-0.1F, 0.15F, ffp_fbm(q, m->seed, 3) + 0.5F * (m->vary[0] - 0.5F));
}

static float brick_joint(const float q[3], uint32_t *id) {
    const float row = floorf(1.8F * q[2]), shift = fmodf(row, 2) == 0 ? 0 : 0.5F;
    const float x = q[0] + shift, y = q[1] + shift, fx = x - floorf(x), fy = y - floorf(y),
                fz = 1.8F * q[2] - row;
    *id = ffp_hash32((uint32_t)(int)floorf(x) * 73856093U ^ (uint32_t)(int)floorf(y) * 19349663U ^
                     (uint32_t)(int)row * 83492791U);
    return ffp_min(ffp_min(fx, 1 - fx), ffp_min(ffp_min(fy, 1 - fy), 0.55F * ffp_min(fz, 1 - fz)));
}
void ffp_look_brick(const FfpMaterial *m, const float q[3], FfpLook *out) {
    uint32_t id;
    const float joint = 1 - ffp_step_between(0.03F, 0.07F, brick_joint(q, &id)),
                stain = 0.25F * ffp_fbm(q, m->seed, 3);
    ffp_mix_ramp(out, 0.7F * ffp_clamp01(ffp_hash_unit(id + m->seed) + stain));
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - joint;
    out->mix[4] += joint;
    out->rough = 0.3F + 0.4F * ffp_hash_unit(id + 3) + 0.3F * joint;
}
float ffp_relief_brick(const FfpMaterial *m, const float q[3]) {
    uint32_t id;
    (void)m;
    return ffp_step_between(0.01F, 0.09F, brick_joint(q, &id));
}

void ffp_look_paint(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float a = ffp_fbm(q, m->seed, 2), b = ffp_fbm((float[3]){q[0] + 5, q[1], q[2]}, m->seed + 1, 2);
    const float w[3] = {q[0] + 1.6F * a, q[1] + 1.6F * b, q[2] + 1.6F * a * b},
                t = 0.5F + 0.8F * ffp_fbm(w, m->seed + 2, 3);
    ffp_mix_ramp(out, m->vary[0] < 0.5F ? t : floorf(7 * t) / 6); // blended, or in flat bands
    out->rough = ffp_clamp01(t);
}
