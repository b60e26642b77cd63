#include "world/synth/kernels/kernels.h"

float ffp_noise(const float p[3], uint32_t seed) {
    return ffp_synth_kernels()->noise(p, seed);
}

float ffp_fbm(const float p[3], uint32_t seed, int octaves) {
    return ffp_synth_kernels()->fbm(p, seed, octaves);
}

float ffp_ridges(const float p[3], uint32_t seed, int octaves) {
    return ffp_synth_kernels()->ridges(p, seed, octaves);
}

FfpCells ffp_cells(const float p[3], uint32_t seed) {
    return ffp_synth_kernels()->cells(p, seed);
}
