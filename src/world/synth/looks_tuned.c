// Procedures that several kinds of material share: what tune[] means stands before each. A relief reads the
// same numbers as its look, so that bumps lie where colours change.
#include <math.h>
#include "world/shapes/noise.h"
#include "world/synth/looks.h"

static void scaled(const float q[3], float x, float y, float z, float out[3]) {
    out[0] = x * q[0], out[1] = y * q[1], out[2] = z * q[2];
}
static float noise_at(const float q[3], float frequency, uint32_t seed, int octaves) {
    const float p[3] = {frequency * q[0], frequency * q[1], frequency * q[2]};
    return ffp_fbm(p, seed, octaves);
}

// Layers across z. tune: layers a unit; how far noise bends them; how hard their borders are; grain.
static float stratum(const FfpMaterial *m, const float q[3]) {
    const float *t = m->kind->tune;
    return t[0] * q[2] + t[1] * ffp_fbm(q, m->seed, 4);
}
void ffp_look_strata(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune, x = stratum(m, q), f = x - floorf(x);
    const float a = ffp_hash_unit(ffp_hash32((uint32_t)(int)floorf(x) + m->seed));
    const float b = ffp_hash_unit(ffp_hash32((uint32_t)(int)floorf(x) + 1 + m->seed));
    const float layer = a + (b - a) * ffp_step_between(0.98F * t[2], 1, f);
    ffp_mix_ramp(out, layer + t[3] * noise_at(q, 6, m->seed + 3, 2));
    out->rough = layer;
}
float ffp_relief_strata(const FfpMaterial *m, const float q[3]) {
    const float x = stratum(m, q), f = x - floorf(x);
    return ffp_step_between(0, 0.3F, f) * (1 - ffp_step_between(0.7F, 1, f)) +
           0.15F * noise_at(q, 3, m->seed + 3, 2);
}

// Clouds, and small pits or specks of the last colour. tune: contrast; share of pits; pits a unit; fine
// grain.
static float pit(const FfpMaterial *m, const float q[3]) {
    const float *t = m->kind->tune;
    if (t[1] <= 0) return 0;
    float p[3];
    scaled(q, t[2], t[2], t[2], p);
    const FfpCells c = ffp_cells(p, m->seed + 2);
    const float size = 0.2F + 0.25F * ffp_hash_unit(c.id + 1);
    return ffp_hash_unit(c.id) < t[1] ? 1 - ffp_step_between(size - 0.12F, size + 0.05F, c.nearest) : 0;
}
void ffp_look_cloud(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune, fine = t[3] > 0 ? t[3] * noise_at(q, 5, m->seed + 1, 1) : 0;
    const float cloud = ffp_clamp01(0.5F + t[0] * ffp_fbm(q, m->seed, 4) + fine), hole = pit(m, q);
    ffp_mix_over(out, cloud, FFP_PALETTE - 1);
    ffp_mix_last(out, hole);
    out->rough = ffp_clamp01(0.25F + 0.5F * cloud + 0.5F * hole);
}
float ffp_relief_cloud(const FfpMaterial *m, const float q[3]) {
    return 0.7F * noise_at(q, 2.4F, m->seed + 1, 2) - 0.8F * pit(m, q);
}

// Plates with joints of the last colour. tune: width of a joint; how unlike the plates are; how long they are
// compared with their width; shading towards their rims.
static FfpCells plate(const FfpMaterial *m, const float q[3]) {
    const float warp = 0.25F * ffp_noise(q, m->seed + 4),
                p[3] = {q[0] + warp, q[1] / m->kind->tune[2] - warp, q[2] + warp};
    return ffp_cells(p, m->seed);
}
void ffp_look_plates(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune;
    const FfpCells c = plate(m, q);
    const float edge = c.second - c.nearest, joint = 1 - ffp_step_between(0.4F * t[0], t[0], edge);
    const float cloud = 0.3F * noise_at(q, 1.3F, m->seed + 1, 3);
    ffp_mix_over(out, 0.5F + t[1] * (ffp_hash_unit(c.id + 1) - 0.5F) + cloud, FFP_PALETTE - 1);
    const float shade = 1 - t[3] * (1 - ffp_step_between(0, 0.5F, edge));
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= shade;
    ffp_mix_last(out, joint);
    out->rough = ffp_clamp01(0.3F * ffp_hash_unit(c.id + 2) + 0.3F * (1 - shade) + 0.6F * joint);
}
float ffp_relief_plates(const FfpMaterial *m, const float q[3]) {
    const FfpCells c = plate(m, q);
    return ffp_step_between(0, 0.35F, c.second - c.nearest);
}

// Chips of two sizes in a plain ground, the first colour. tune: shares of large and small chips; how much
// finer the small ones are.
void ffp_look_chips(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune;
    float p[3], in = 0;
    int colour = 0;
    for (int size = 1; size >= 0; size--) { // the large ones lie over the small ones
        const float fine = size ? t[2] : 1;
        scaled(q, fine, fine, fine, p);
        const FfpCells c = ffp_cells(p, m->seed + 9 * (uint32_t)size);
        if (ffp_hash_unit(c.id) >= t[size]) continue;
        const float chip = ffp_step_between(0.1F, 0.16F, c.second - c.nearest);
        if (chip < 0.5F && in > 0) continue;
        in = chip, colour = 1 + (int)(c.id % (FFP_PALETTE - 1));
    }
    const float cloud = 0.9F + 0.1F * ffp_fbm(q, m->seed + 3, 3);
    out->mix[0] = (1 - in) * cloud;
    out->mix[colour] += in;
    out->rough = 0.7F * (1 - in) + 0.2F * ffp_hash_unit((uint32_t)colour);
}

// Twill weave: ribs aslant, warp and weft. tune: ribs a unit; how bright the weft shows; wear; stripes a
// unit.
static float rib(const FfpMaterial *m, const float q[3]) {
    return sinf(6.2831853F * m->kind->tune[0] * (q[0] + q[1] + 0.7F * q[2]) + ffp_noise(q, m->seed));
}
void ffp_look_twill(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune,
                slub = 0.25F * ffp_noise((float[3]){6 * q[0], 0.8F * q[1], 6 * q[2]}, m->seed + 2);
    const float weft = ffp_clamp01(t[1] * ffp_step_between(-0.4F, 0.9F, rib(m, q)) + slub);
    const float worn = t[2] * ffp_step_between(0, 0.5F, noise_at(q, 0.35F, m->seed + 5, 3));
    const float band = t[3] > 0 ? ffp_step_between(0.1F, 0.25F, sinf(6.2831853F * t[3] * q[2])) : 0;
    ffp_mix_two(out, weft);
    for (int i = 0; i < 2; i++) out->mix[i] *= 1 - worn;
    out->mix[2] = worn;
    for (int i = 0; i < 3; i++) out->mix[i] *= 1 - 0.8F * band;
    out->mix[3] = 0.8F * band;
    out->rough = 0.4F + 0.6F * weft;
}
float ffp_relief_twill(const FfpMaterial *m, const float q[3]) {
    return 0.5F * rib(m, q);
}

// Boards along y, laid in bond. tune: length; joint; how unlike the boards are; strength of the grain.
static float board(const FfpMaterial *m, const float q[3], uint32_t *id) {
    const float *t = m->kind->tune, row = floorf(q[0]), layer = floorf(q[2]);
    const uint32_t line =
        ffp_hash32((uint32_t)(int)row * 73856093U ^ (uint32_t)(int)layer * 83492791U ^ m->seed);
    const float y = q[1] / t[0] + ffp_hash_unit(line), fx = q[0] - row, fy = y - floorf(y), fz = q[2] - layer;
    *id = ffp_hash32(line + 19349663U * (uint32_t)(int)floorf(y));
    return ffp_min(ffp_min(fx, 1 - fx), ffp_min(t[0] * ffp_min(fy, 1 - fy), ffp_min(fz, 1 - fz)));
}
static float grain(const FfpMaterial *m, const float q[3], uint32_t id) {
    const float shift = 37 * ffp_hash_unit(id);
    return ffp_fbm((float[3]){3 * q[0] + shift, 0.5F * q[1], 3 * q[2] + shift}, m->seed + 3, 3);
}
void ffp_look_planks(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune;
    uint32_t id;
    const float joint = 1 - ffp_step_between(0.5F * t[1], t[1], board(m, q, &id)), fibre = grain(m, q, id);
    ffp_mix_over(out, 0.5F + t[2] * (ffp_hash_unit(id + 1) - 0.5F) + t[3] * fibre, FFP_PALETTE - 1);
    ffp_mix_last(out, joint);
    out->rough = ffp_clamp01(0.4F + 0.4F * fibre + 0.5F * joint);
}
float ffp_relief_planks(const FfpMaterial *m, const float q[3]) {
    uint32_t id;
    const float edge = board(m, q, &id);
    return ffp_step_between(0, 2 * m->kind->tune[1], edge) + 0.2F * grain(m, q, id);
}

// One ornament in every cube, folded along the cube's planes of symmetry, so that any cut through it shows a
// rosette. tune: joint; fineness of the ornament; share of cubes that bear one; width of its outline.
void ffp_look_ornament(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune;
    float a[3], joint = 0.5F, square = 0;
    uint32_t id = m->seed;
    for (int k = 0; k < 3; k++) {
        const float cell = floorf(q[k]);
        a[k] = fabsf(q[k] - cell - 0.5F), square += a[k] * a[k];
        joint = ffp_min(joint, 0.5F - a[k]);
        id = ffp_hash32(id + (uint32_t)(int)cell);
    }
    for (int i = 0; i < 3; i++) { // sorting folds the 48 mirror images onto one
        const int k = i % 2;
        if (a[k] < a[k + 1]) {
            const float keep = a[k];
            a[k] = a[k + 1], a[k + 1] = keep;
        }
    }
    const float n = noise_at(a, t[1], m->seed + 1, 2), petal = noise_at(a, 0.7F * t[1], m->seed + 2, 2);
    const float here =
        ffp_hash_unit(id) < t[2] ? 1 - ffp_step_between(0.4F, 0.5F, t[0] > 0 ? 0 : sqrtf(square)) : 0;
    const float line = here * (1 - ffp_step_between(0.5F * t[3], t[3], fabsf(n)));
    const float fill = here * (1 - line) * ffp_step_between(0.02F, 0.08F, n);
    const int colour = petal > 0.05F ? 2 : petal < -0.15F ? 3 : 0;
    out->mix[0] = 1 - line - fill, out->mix[1] = line;
    out->mix[colour] += fill;
    ffp_mix_last(out, t[0] > 0 ? 1 - ffp_step_between(0.5F * t[0], t[0], joint) : 0);
    out->rough = ffp_clamp01(0.5F * out->mix[4] + 0.5F * (0.5F + 0.5F * petal));
}

// Glaze that has run down over a body of the last colour. tune: how long the runs are; how ragged; crackle;
// clouds in the glaze.
void ffp_look_drips(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune, run = t[0] * ffp_fbm((float[3]){q[0], q[1], 0.15F * q[2]}, m->seed, 2);
    const float edge = 0.9F * q[2] + 1.2F * (m->vary[0] - 0.5F) + run + t[1] * noise_at(q, 2, m->seed + 1, 3);
    const float bare = 1 - ffp_step_between(-0.05F, 0.05F, edge),
                rim = 1 - ffp_step_between(0, 0.35F, fabsf(edge));
    float p[3];
    scaled(q, 2.2F, 2.2F, 2.2F, p);
    const FfpCells c = ffp_cells(p, m->seed + 6);
    const float crack = t[2] * (1 - ffp_step_between(0.02F, 0.07F, c.second - c.nearest));
    ffp_mix_over(out, 0.4F + t[3] * ffp_fbm(q, m->seed + 2, 4) + 0.5F * rim, FFP_PALETTE - 1);
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - 0.8F * crack;
    ffp_mix_last(out, bare);
    out->rough = ffp_max(bare, 0.1F + 0.4F * crack);
}

// Paint, the first colour, that flakes off what has gone underneath. tune: how much is gone, -1 to 1; width
// of the stained rim; fineness; second coat, as the first but in the second colour.
static float gone(const FfpMaterial *m, const float q[3]) {
    const float *t = m->kind->tune;
    return noise_at(q, t[2], m->seed, 4) + t[0] + 0.2F * (m->vary[0] - 0.5F);
}
void ffp_look_flakes(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune, n = gone(m, q), bare = ffp_step_between(-0.01F, 0.03F, n);
    const float stain = ffp_step_between(-t[1], 0, n) * (1 - bare), fine = noise_at(q, 4, m->seed + 3, 3);
    const float coat =
        t[3] > 0 ? ffp_step_between(-0.02F, 0.02F, noise_at(q, 0.6F, m->seed + 7, 2) + t[3] - 0.5F) : 0;
    const float rust = ffp_clamp01(0.5F + 0.9F * fine);
    out->mix[0] = (1 - bare) * (1 - 0.7F * stain) * (1 - coat),
    out->mix[1] = (1 - bare) * (1 - 0.7F * stain) * coat;
    out->mix[2] = bare * rust + 0.7F * stain, out->mix[3] = bare * (1 - rust);
    out->rough = ffp_max(bare, 0.6F * stain);
}
float ffp_relief_flakes(const FfpMaterial *m, const float q[3]) {
    const float n = gone(m, q), bare = ffp_step_between(-0.02F, 0.06F, n);
    return 1 - bare + 0.25F * bare * noise_at(q, 3, m->seed + 3, 2) +
           0.08F * noise_at(q, 1.5F, m->seed + 4, 1);
}

// Ridges drawn out along z. tune: how far; octaves; how hard they stand out; stain of the last colour.
static float ridge(const FfpMaterial *m, const float q[3]) {
    const float *t = m->kind->tune;
    return ffp_ridges((float[3]){q[0], q[1], q[2] / t[0]}, m->seed, (int)t[1]);
}
void ffp_look_ridges(const FfpMaterial *m, const float q[3], FfpLook *out) {
    const float *t = m->kind->tune, r = ffp_clamp01(0.5F + t[2] * (ridge(m, q) - 0.62F));
    const float stain = t[3] * ffp_step_between(0.05F, 0.5F, noise_at(q, 0.7F, m->seed + 5, 4));
    ffp_mix_over(out, r, FFP_PALETTE - 1);
    ffp_mix_last(out, stain);
    out->rough = 1 - 0.6F * r;
}
float ffp_relief_ridges(const FfpMaterial *m, const float q[3]) {
    return 1.5F * ridge(m, q);
}
