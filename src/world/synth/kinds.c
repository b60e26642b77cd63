// The 43 kinds of material, about three for each of MatSynth's categories (Vecchio and Deschaintre 2024).
#include <stddef.h>
#include "world/synth/looks.h"
#include "world/synth/synth.h"

// clang-format off
#define COLOURS (const float[FFP_PALETTE][3])

const FfpMaterialKind ffp_material_kinds[FFP_MATERIAL_KINDS] = {
    // drawn palettes: name, look, relief and its height, hue, saturation, value, spread, contrast, roughness, scale
    {"marble", ffp_look_marble, NULL, 0, {0, 1}, {0.02F, 0.3F}, {0.75F, 0.95F}, 0.3F, 0.6F, {0.15F, 0.45F}, 1.6F, {0}, NULL},
    {"wood", ffp_look_wood, ffp_relief_wood, 0.03F, {0.04F, 0.11F}, {0.4F, 0.75F}, {0.55F, 0.85F}, 0.04F, 0.45F, {0.3F, 0.75F}, 2.2F, {0}, NULL},
    {"granite", ffp_look_granite, NULL, 0, {0, 1}, {0, 0.3F}, {0.5F, 0.8F}, 0.3F, 0.6F, {0.3F, 0.8F}, 3, {0}, NULL},
    {"terracotta", ffp_look_terracotta, ffp_relief_rough, 0.06F, {0.01F, 0.09F}, {0.5F, 0.8F}, {0.6F, 0.85F}, 0.03F, 0.3F, {0.7F, 0.95F}, 1.8F, {0}, NULL},
    {"plaster", ffp_look_plaster, ffp_relief_rough, 0.05F, {0, 1}, {0, 0.18F}, {0.8F, 0.96F}, 0.1F, 0.2F, {0.75F, 0.95F}, 1.6F, {0}, NULL},
    {"plastic", ffp_look_plastic, NULL, 0, {0, 1}, {0.4F, 1}, {0.55F, 0.95F}, 1, 0.4F, {0.15F, 0.45F}, 1.2F, {0}, NULL},
    {"checks", ffp_look_checks, NULL, 0, {0, 1}, {0.1F, 0.9F}, {0.3F, 0.95F}, 1, 0.6F, {0.2F, 0.8F}, 3, {0}, NULL},
    {"fabric", ffp_look_fabric, ffp_relief_fabric, 0.05F, {0, 1}, {0.2F, 0.85F}, {0.4F, 0.9F}, 0.6F, 0.4F, {0.75F, 0.95F}, 7, {0}, NULL},
    {"spots", ffp_look_spots, NULL, 0, {0, 1}, {0.2F, 0.9F}, {0.5F, 0.95F}, 1, 0.5F, {0.25F, 0.8F}, 3, {0}, NULL},
    {"stripes", ffp_look_stripes, NULL, 0, {0, 1}, {0.3F, 0.9F}, {0.4F, 0.95F}, 1, 0.5F, {0.25F, 0.8F}, 3.5F, {0}, NULL},
    {"gradient", ffp_look_gradient, NULL, 0, {0, 1}, {0.4F, 0.9F}, {0.5F, 0.95F}, 0.5F, 0.4F, {0.2F, 0.9F}, 1, {0}, NULL},
    {"ground", ffp_look_ground, ffp_relief_rough, 0.09F, {0.05F, 0.25F}, {0.25F, 0.6F}, {0.35F, 0.65F}, 0.08F, 0.5F, {0.45F, 0.95F}, 2.2F, {0}, NULL},
    {"ceramic", ffp_look_ceramic, NULL, 0, {0, 1}, {0.2F, 0.8F}, {0.6F, 0.95F}, 0.25F, 0.5F, {0.15F, 0.6F}, 3, {0}, NULL},
    {"camouflage", ffp_look_camouflage, NULL, 0, {0.1F, 0.4F}, {0.2F, 0.6F}, {0.35F, 0.75F}, 0.2F, 0.5F, {0.45F, 0.9F}, 2, {0}, NULL},
    {"mosaic", ffp_look_mosaic, ffp_relief_cell, 0.05F, {0, 1}, {0.3F, 0.9F}, {0.5F, 0.95F}, 1, 0.5F, {0.2F, 0.8F}, 4, {0}, NULL},
    {"patina", ffp_look_patina, ffp_relief_patina, 0.04F, {0, 1}, {0.1F, 0.7F}, {0.35F, 0.8F}, 0.5F, 0.5F, {0.2F, 0.95F}, 2, {0}, NULL},
    {"brick", ffp_look_brick, ffp_relief_brick, 0.05F, {0, 0.1F}, {0.3F, 0.7F}, {0.5F, 0.8F}, 0.06F, 0.4F, {0.6F, 0.95F}, 3, {0}, NULL},
    {"paint", ffp_look_paint, NULL, 0, {0, 1}, {0.4F, 1}, {0.5F, 1}, 1, 0.5F, {0.2F, 0.7F}, 1.3F, {0}, NULL},

    // anchored palettes: the same, then what tunes the procedure, and the colours
    {"agate", ffp_look_strata, NULL, 0, {-0.5F, 0.5F}, {0.8F, 1.1F}, {0.85F, 1.05F}, 0.1F, 0, {0.15F, 0.3F}, 1.1F, {10, 4.5F, 0.4F, 0.03F},
        COLOURS{{0.03F, 0.75F, 0.7F}, {0.06F, 0.35F, 0.95F}, {0.98F, 0.8F, 0.45F}, {0.08F, 0.12F, 0.97F}, {0.06F, 0.65F, 0.85F}}},
    {"onyx", ffp_look_marble, NULL, 0, {-0.5F, 0.5F}, {0.5F, 1.2F}, {0.8F, 1.2F}, 0.15F, 0, {0.15F, 0.25F}, 1.8F, {0},
        COLOURS{{0.6F, 0.3F, 0.22F}, {0.1F, 0.15F, 0.92F}, {0.55F, 0.4F, 0.4F}, {0, 0, 0.5F}, {0, 0, 0.5F}}},
    {"sandstone", ffp_look_strata, ffp_relief_strata, 0.05F, {-0.02F, 0.02F}, {0.7F, 1.2F}, {0.85F, 1.1F}, 0.02F, 0, {0.75F, 0.95F}, 2, {2.2F, 0.5F, 0, 0.25F},
        COLOURS{{0.09F, 0.35F, 0.88F}, {0.07F, 0.5F, 0.75F}, {0.05F, 0.55F, 0.6F}, {0.1F, 0.3F, 0.93F}, {0.04F, 0.6F, 0.5F}}},
    {"slate", ffp_look_ridges, ffp_relief_ridges, 0.035F, {-0.1F, 0.1F}, {0.6F, 1.6F}, {0.8F, 1.25F}, 0.1F, 0, {0.35F, 0.7F}, 1.6F, {0.22F, 3, 2, 0.35F},
        COLOURS{{0.6F, 0.14F, 0.3F}, {0.58F, 0.12F, 0.38F}, {0.55F, 0.1F, 0.45F}, {0.5F, 0.08F, 0.56F}, {0.07F, 0.5F, 0.5F}}},
    {"concrete", ffp_look_cloud, ffp_relief_cloud, 0.035F, {-0.05F, 0.05F}, {0.5F, 1.5F}, {0.85F, 1.1F}, 0.05F, 0, {0.7F, 0.95F}, 1.8F, {0.8F, 0.5F, 4, 0.2F},
        COLOURS{{0.1F, 0.06F, 0.5F}, {0.1F, 0.05F, 0.62F}, {0.12F, 0.04F, 0.7F}, {0.1F, 0.03F, 0.8F}, {0.08F, 0.1F, 0.33F}}},
    {"formwork", ffp_look_planks, ffp_relief_planks, 0.04F, {-0.1F, 0.1F}, {0.4F, 1.6F}, {0.85F, 1.15F}, 0.1F, 0, {0.6F, 0.9F}, 3, {6, 0.06F, 0.7F, 0.3F},
        COLOURS{{0.1F, 0.06F, 0.45F}, {0.1F, 0.06F, 0.58F}, {0.12F, 0.05F, 0.68F}, {0.1F, 0.05F, 0.76F}, {0.08F, 0.08F, 0.3F}}},
    {"terrazzo", ffp_look_chips, NULL, 0, {-0.5F, 0.5F}, {0.6F, 1.2F}, {0.85F, 1.1F}, 0.2F, 0, {0.2F, 0.5F}, 3.5F, {0.5F, 0.35F, 2, 0},
        COLOURS{{0.1F, 0.05F, 0.88F}, {0.02F, 0.6F, 0.7F}, {0.55F, 0.45F, 0.4F}, {0.11F, 0.55F, 0.85F}, {0, 0.05F, 0.25F}}},
    {"asphalt", ffp_look_cloud, ffp_relief_rough, 0.09F, {-0.5F, 0.5F}, {0.3F, 1.5F}, {0.75F, 1.2F}, 0.1F, 0, {0.7F, 0.95F}, 4, {0.35F, 0.35F, 1.8F, 0.2F},
        COLOURS{{0.6F, 0.08F, 0.17F}, {0.6F, 0.06F, 0.23F}, {0.6F, 0.05F, 0.28F}, {0.1F, 0.05F, 0.34F}, {0.1F, 0.08F, 0.58F}}},
    {"moss", ffp_look_cloud, ffp_relief_cloud, 0.09F, {-0.05F, 0.05F}, {0.8F, 1.1F}, {0.75F, 1.15F}, 0.04F, 0, {0.8F, 0.95F}, 3, {0.75F, 0.25F, 1.3F, 0.35F},
        COLOURS{{0.28F, 0.7F, 0.22F}, {0.25F, 0.75F, 0.38F}, {0.22F, 0.7F, 0.52F}, {0.18F, 0.65F, 0.68F}, {0.08F, 0.5F, 0.36F}}},
    {"mud", ffp_look_plates, ffp_relief_plates, 0.06F, {-0.03F, 0.03F}, {0.6F, 1.3F}, {0.8F, 1.15F}, 0.03F, 0, {0.75F, 0.95F}, 2.6F, {0.13F, 0.5F, 1, 0.25F},
        COLOURS{{0.08F, 0.4F, 0.55F}, {0.08F, 0.35F, 0.63F}, {0.09F, 0.3F, 0.7F}, {0.09F, 0.25F, 0.78F}, {0.06F, 0.5F, 0.2F}}},
    {"leather", ffp_look_plates, ffp_relief_plates, 0.035F, {-0.04F, 0.03F}, {0.8F, 1.15F}, {0.6F, 1.3F}, 0.02F, 0, {0.35F, 0.65F}, 10, {0.12F, 0.3F, 1, 0.25F},
        COLOURS{{0.06F, 0.75F, 0.42F}, {0.065F, 0.7F, 0.52F}, {0.07F, 0.65F, 0.6F}, {0.07F, 0.6F, 0.68F}, {0.04F, 0.7F, 0.25F}}},
    {"crocodile", ffp_look_plates, ffp_relief_plates, 0.06F, {-0.5F, 0.5F}, {0.6F, 1.1F}, {0.6F, 1.3F}, 0.06F, 0, {0.2F, 0.45F}, 4, {0.14F, 0.8F, 1.7F, 0.45F},
        COLOURS{{0.3F, 0.6F, 0.22F}, {0.28F, 0.6F, 0.32F}, {0.22F, 0.55F, 0.4F}, {0.17F, 0.5F, 0.55F}, {0.2F, 0.4F, 0.1F}}},
    {"suede", ffp_look_cloud, ffp_relief_cloud, 0.02F, {-0.5F, 0.5F}, {0.7F, 1.1F}, {0.8F, 1.15F}, 0.02F, 0, {0.85F, 0.95F}, 1.6F, {1.3F, 0, 0, 0.35F},
        COLOURS{{0, 0.68F, 0.5F}, {0.005F, 0.62F, 0.6F}, {0.01F, 0.58F, 0.68F}, {0.02F, 0.5F, 0.78F}, {0, 0.6F, 0.4F}}},
    {"denim", ffp_look_twill, ffp_relief_twill, 0.03F, {-0.04F, 0.04F}, {0.7F, 1.15F}, {0.75F, 1.15F}, 0.02F, 0, {0.8F, 0.95F}, 8, {1, 0.7F, 0.4F, 0},
        COLOURS{{0.61F, 0.7F, 0.32F}, {0.6F, 0.4F, 0.68F}, {0.58F, 0.22F, 0.82F}, {0, 0, 0}, {0, 0, 0}}},
    {"deckchair", ffp_look_twill, ffp_relief_twill, 0.025F, {-0.5F, 0.5F}, {0.8F, 1.1F}, {0.85F, 1.05F}, 0.15F, 0, {0.75F, 0.95F}, 5, {1.2F, 0.25F, 0.1F, 0.5F},
        COLOURS{{0.1F, 0.12F, 0.93F}, {0.1F, 0.2F, 0.8F}, {0.12F, 0.1F, 0.98F}, {0.02F, 0.8F, 0.75F}, {0, 0, 0}}},
    {"enamel", ffp_look_flakes, ffp_relief_flakes, 0.02F, {-0.5F, 0.5F}, {0.9F, 1.1F}, {0.8F, 1.05F}, 0.5F, 0, {0.15F, 0.5F}, 2, {-0.62F, 0.04F, 1.3F, 0.5F},
        COLOURS{{0.01F, 0.88F, 0.78F}, {0.13F, 0.1F, 0.95F}, {0, 0.05F, 0.15F}, {0.05F, 0.2F, 0.22F}, {0, 0, 0}}},
    {"rust", ffp_look_flakes, ffp_relief_flakes, 0.04F, {-0.03F, 0.03F}, {0.8F, 1.15F}, {0.8F, 1.15F}, 0.02F, 0, {0.35F, 0.95F}, 2, {-0.05F, 0.25F, 1, 0},
        COLOURS{{0.5F, 0.4F, 0.62F}, {0, 0, 0.5F}, {0.06F, 0.8F, 0.62F}, {0.035F, 0.75F, 0.3F}, {0, 0, 0}}},
    {"azulejo", ffp_look_ornament, NULL, 0, {-0.1F, 0.1F}, {0.8F, 1.1F}, {0.85F, 1.05F}, 0.06F, 0, {0.15F, 0.5F}, 2.2F, {0.025F, 5, 1, 0.1F},
        COLOURS{{0.12F, 0.06F, 0.95F}, {0.62F, 0.85F, 0.45F}, {0.12F, 0.75F, 0.9F}, {0.56F, 0.55F, 0.75F}, {0.1F, 0.08F, 0.6F}}},
    {"porcelain", ffp_look_ornament, NULL, 0, {-0.5F, 0.5F}, {0.8F, 1.1F}, {0.9F, 1.03F}, 0.1F, 0, {0.15F, 0.22F}, 2.8F, {0, 6, 0.85F, 0.08F},
        COLOURS{{0.14F, 0.03F, 0.97F}, {0.62F, 0.8F, 0.5F}, {0.6F, 0.5F, 0.8F}, {0.97F, 0.55F, 0.8F}, {0, 0, 0}}},
    {"raku", ffp_look_drips, NULL, 0, {-0.5F, 0.5F}, {0.7F, 1.15F}, {0.8F, 1.1F}, 0.06F, 0, {0.15F, 0.85F}, 1.6F, {0.8F, 0.25F, 1, 0.5F},
        COLOURS{{0.48F, 0.75F, 0.35F}, {0.47F, 0.65F, 0.55F}, {0.45F, 0.5F, 0.75F}, {0.13F, 0.25F, 0.9F}, {0.06F, 0.45F, 0.3F}}},
    {"parquet", ffp_look_planks, ffp_relief_planks, 0.015F, {-0.03F, 0.02F}, {0.8F, 1.15F}, {0.7F, 1.15F}, 0.02F, 0, {0.2F, 0.5F}, 4, {4, 0.04F, 0.9F, 0.45F},
        COLOURS{{0.05F, 0.7F, 0.35F}, {0.065F, 0.65F, 0.55F}, {0.08F, 0.55F, 0.72F}, {0.095F, 0.45F, 0.88F}, {0.05F, 0.6F, 0.14F}}},
    {"bark", ffp_look_ridges, ffp_relief_ridges, 0.06F, {-0.03F, 0.03F}, {0.5F, 1.3F}, {0.75F, 1.2F}, 0.03F, 0, {0.8F, 0.95F}, 4, {4, 3, 2.6F, 0.6F},
        COLOURS{{0.06F, 0.5F, 0.14F}, {0.07F, 0.45F, 0.3F}, {0.08F, 0.4F, 0.44F}, {0.09F, 0.3F, 0.58F}, {0.24F, 0.4F, 0.5F}}},
    {"stucco", ffp_look_ridges, ffp_relief_ridges, 0.06F, {-0.5F, 0.5F}, {0.5F, 1.1F}, {0.9F, 1.05F}, 0.03F, 0, {0.8F, 0.95F}, 3.2F, {1, 3, 1.2F, 0.2F},
        COLOURS{{0.1F, 0.5F, 0.72F}, {0.1F, 0.42F, 0.82F}, {0.1F, 0.38F, 0.88F}, {0.1F, 0.34F, 0.94F}, {0.08F, 0.45F, 0.62F}}},
    {"fresco", ffp_look_flakes, ffp_relief_flakes, 0.02F, {-0.5F, 0.5F}, {0.6F, 1}, {0.85F, 1.1F}, 0.1F, 0, {0.7F, 0.95F}, 1.6F, {-0.2F, 0.12F, 1, 0.5F},
        COLOURS{{0.02F, 0.6F, 0.68F}, {0.58F, 0.45F, 0.62F}, {0.11F, 0.15F, 0.93F}, {0.1F, 0.2F, 0.78F}, {0, 0, 0}}},
    {"rubber", ffp_look_strata, ffp_relief_strata, 0.06F, {-0.5F, 0.5F}, {0.2F, 1.2F}, {0.7F, 1.4F}, 0.1F, 0, {0.45F, 0.75F}, 4, {1.6F, 0, 0.9F, 0.05F},
        COLOURS{{0.6F, 0.1F, 0.18F}, {0.6F, 0.1F, 0.2F}, {0.6F, 0.1F, 0.22F}, {0.6F, 0.1F, 0.2F}, {0.02F, 0.6F, 0.42F}}},
};
// clang-format on

int ffp_material_count(void) {
    return FFP_MATERIAL_KINDS;
}
const char *ffp_material_name(int material) {
    return material >= 0 && material < FFP_MATERIAL_KINDS ? ffp_material_kinds[material].name : "unknown";
}
