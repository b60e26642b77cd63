// Solid noise: functions of a point in space that the shapes are displaced and the materials coloured with.
#ifndef FFP_SHAPES_NOISE_H
#define FFP_SHAPES_NOISE_H

#include <stdint.h>

// A well mixed 32-bit hash, and its value as a number in [0, 1).
static inline uint32_t ffp_hash32(uint32_t h) {
    h ^= h >> 15, h *= 0x2c1b3c6dU;
    h ^= h >> 12, h *= 0x297a2d39U;
    return h ^ (h >> 15);
}
static inline float ffp_hash_unit(uint32_t h) {
    return (float)(h >> 8) * (1.0F / 16777216.0F);
}

// Gradient noise (Perlin 2002, quintic fade): about [-1, 1], mean 0, one feature a unit.
float ffp_noise(const float p[3], uint32_t seed);
// Sum of octaves, each twice as fine and half as strong; about [-1, 1].
float ffp_fbm(const float p[3], uint32_t seed, int octaves);
// The same of 1 - |noise|: sharp ridges; about [0, 1].
float ffp_ridges(const float p[3], uint32_t seed, int octaves);

// Cellular noise (Worley 1996), one jittered point a unit cube.
typedef struct FfpCells {
    float nearest, second; // distances to the nearest and second nearest point
    uint32_t id;           // hash of the nearest point: the cell's identity
} FfpCells;
FfpCells ffp_cells(const float p[3], uint32_t seed);

#endif
