// The hash grid: features of points, and back.
#include <stdint.h>
#include "lab/baselines/kernels/kernels.h"

enum { CORNERS = 8 };

// The features of a grid point, one vector.
typedef real Features __attribute__((vector_size(FFP_FIELD_FEATURES * sizeof(real))));
_Static_assert(FFP_FIELD_FEATURES == 4, "a point's features are one vector");

typedef struct Corners {
    uint32_t entry[CORNERS];
    real weight[CORNERS];
} Corners;

static inline real held(real x, real high) {
    return x < 0 ? 0 : x > high ? high : x;
}

// The primes of Mueller et al. 2022, Eq. 4.
static inline uint32_t hashed(uint32_t x, uint32_t y, uint32_t z) {
    return (x ^ y * 2654435761U ^ z * 805459861U) & (FFP_FIELD_TABLE - 1);
}

static inline Corners corners_of(const FfpGridLevel *level, real x, real y, real z) {
    const int n = level->resolution;
    const real half = (real)n / 2, px = held((x + 1) * half, (real)n), py = held((y + 1) * half, (real)n),
               pz = held((z + 1) * half, (real)n);
    const int last = n - 1, ix = (int)px < last ? (int)px : last, iy = (int)py < last ? (int)py : last,
              iz = (int)pz < last ? (int)pz : last;
    const real fx = px - (real)ix, fy = py - (real)iy, fz = pz - (real)iz;
    const uint32_t side = (uint32_t)n + 1;
    Corners c;
    for (int k = 0; k < CORNERS; k++) {
        const uint32_t cx = (uint32_t)ix + (k & 1), cy = (uint32_t)iy + (k >> 1 & 1),
                       cz = (uint32_t)iz + (uint32_t)(k >> 2);
        c.entry[k] = level->dense ? (cz * side + cy) * side + cx : hashed(cx, cy, cz);
        c.weight[k] = (k & 1 ? fx : 1 - fx) * (k >> 1 & 1 ? fy : 1 - fy) * (k >> 2 ? fz : 1 - fz);
    }
    return c;
}

static void encode_level(const FfpGridLevel *level, const real *parameters, const real *position,
                         int64_t count, int64_t stride, real *out) {
    const Features *table = (const Features *)(parameters + level->first);
    for (int64_t i = 0; i < count; i++) {
        const Corners c = corners_of(level, position[i], position[stride + i], position[2 * stride + i]);
        Features sum = c.weight[0] * table[c.entry[0]];
        for (int k = 1; k < CORNERS; k++) sum += c.weight[k] * table[c.entry[k]];
        for (int f = 0; f < FFP_FIELD_FEATURES; f++) out[f * stride + i] = sum[f];
    }
}

void FFP_K(field_encode)(const FfpFieldLayout *layout, const real *parameters, const real *position,
                         int64_t count, int64_t stride, real *encoded) {
    for (int l = 0; l < FFP_FIELD_LEVELS; l++)
        encode_level(&layout->levels[l], parameters, position, count, stride,
                     encoded + (int64_t)l * FFP_FIELD_FEATURES * stride);
    for (int64_t i = count; i < ffp_field_padded(count); i++)
        for (int f = 0; f < FFP_FIELD_ENCODED; f++) encoded[f * stride + i] = 0;
}

void FFP_K(field_scatter)(const FfpGridLevel *level, const real *position, int64_t count, int64_t stride,
                          const real *d_encoded, real *grad) {
    Features *table = (Features *)(grad + level->first);
    for (int64_t i = 0; i < count; i++) {
        Features d;
        for (int f = 0; f < FFP_FIELD_FEATURES; f++) d[f] = d_encoded[f * stride + i];
        const Corners c = corners_of(level, position[i], position[stride + i], position[2 * stride + i]);
        for (int k = 0; k < CORNERS; k++) table[c.entry[k]] += c.weight[k] * d;
    }
}
