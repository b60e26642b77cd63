// Kinds of materials: their colours, and the procedures that their look and relief are made of.
#ifndef FFP_SYNTH_LOOKS_H
#define FFP_SYNTH_LOOKS_H

#include "world/shapes/scalar.h"
#include "world/synth/material.h"

enum { FFP_MATERIAL_KINDS = 43, FFP_TUNE = 4 };

typedef struct FfpLook {
    float mix[FFP_PALETTE]; // weights of the palette's colours; they need not sum to 1
    float rough;            // 0..1 within the material's range
} FfpLook;

typedef void FfpLookAt(const FfpMaterial *m, const float q[3], FfpLook *out); // q: point of the texture
typedef float FfpReliefAt(const FfpMaterial *m, const float q[3]);            // about [-1, 1]

// Colours are either drawn (anchors NULL): the first one within hue, saturation and value, the others
// straying from it; or they are the anchors, all turned by a hue out of `hue`, their saturations and values
// multiplied by numbers out of `saturation` and `value`.
typedef struct FfpMaterialKind {
    const char *name;
    FfpLookAt *look;
    FfpReliefAt *relief;                   // NULL: smooth
    float relief_height;                   // times the feature size
    float hue[2], saturation[2], value[2]; // hue in turns
    float spread;                          // how far the others stray in hue; 1 = anywhere
    float contrast;                        // how far the others stray in value (drawn colours only)
    float rough[2];
    float scale;          // features a unit length
    float tune[FFP_TUNE]; // what the procedure of looks_tuned.c makes of them
    const float (
        *anchors)[3]; // [FFP_PALETTE] hue in turns, saturation, value as a painter names sRGB colours
} FfpMaterialKind;
extern const FfpMaterialKind ffp_material_kinds[FFP_MATERIAL_KINDS];

static inline float ffp_clamp01(float x) {
    return ffp_min(1, ffp_max(0, x));
}
static inline float ffp_step_between(float low, float high, float x) {
    const float t = ffp_clamp01((x - low) / (high - low));
    return t * t * (3 - 2 * t);
}
static inline void ffp_mix_two(FfpLook *out, float t) {
    out->mix[0] = 1 - t, out->mix[1] = t;
}
// A value in [0, 1] spread over the first `colours` colours in turn.
static inline void ffp_mix_over(FfpLook *out, float t, int colours) {
    const float x = ffp_clamp01(t) * (float)(colours - 1);
    const int i = (int)ffp_min(x, (float)(colours - 2));
    out->mix[i] = 1 - (x - (float)i), out->mix[i + 1] = x - (float)i;
}
static inline void ffp_mix_ramp(FfpLook *out, float t) {
    ffp_mix_over(out, t, FFP_PALETTE);
}
// Lays the last colour over the others.
static inline void ffp_mix_last(FfpLook *out, float share) {
    for (int i = 0; i < FFP_PALETTE; i++) out->mix[i] *= 1 - share;
    out->mix[FFP_PALETTE - 1] += share;
}

// One look each (looks.c).
FfpLookAt ffp_look_marble, ffp_look_wood, ffp_look_granite, ffp_look_terracotta, ffp_look_plaster,
    ffp_look_plastic, ffp_look_checks, ffp_look_fabric, ffp_look_spots, ffp_look_stripes, ffp_look_gradient,
    ffp_look_ground, ffp_look_ceramic, ffp_look_camouflage, ffp_look_mosaic, ffp_look_patina, ffp_look_brick,
    ffp_look_paint;
FfpReliefAt ffp_relief_wood, ffp_relief_rough, ffp_relief_fabric, ffp_relief_cell, ffp_relief_patina,
    ffp_relief_brick;
// Procedures that several kinds share, each with its own tune (looks_tuned.c).
FfpLookAt ffp_look_strata, ffp_look_cloud, ffp_look_plates, ffp_look_chips, ffp_look_twill, ffp_look_planks,
    ffp_look_ornament, ffp_look_drips, ffp_look_flakes, ffp_look_ridges;
FfpReliefAt ffp_relief_strata, ffp_relief_cloud, ffp_relief_plates, ffp_relief_twill, ffp_relief_planks,
    ffp_relief_flakes, ffp_relief_ridges;

#endif
