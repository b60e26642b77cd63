#include "world/shapes/kernels/kernels.h"

float ffp_noise(const float p[3], uint32_t seed) {
    return ffp_shapes_kernels()->noise(p, seed);
}

float ffp_fbm(const float p[3], uint32_t seed, int octaves) {
    return ffp_shapes_kernels()->fbm(p, seed, octaves);
}

float ffp_ridges(const float p[3], uint32_t seed, int octaves) {
    return ffp_shapes_kernels()->ridges(p, seed, octaves);
}

FfpCells ffp_cells(const float p[3], uint32_t seed) {
    return ffp_shapes_kernels()->cells(p, seed);
}
