// Solid noise (world/shapes/noise.h), and the table of one CPU level.
#include <math.h>
#include <string.h>
#include "world/shapes/kernels/kernels.h"
#include "world/shapes/scalar.h"

static inline uint32_t lattice_hash(int x, int y, int z, uint32_t seed) {
    return ffp_hash32((uint32_t)x * 0x9e3779b1U ^ (uint32_t)y * 0x85ebca77U ^ (uint32_t)z * 0xc2b2ae3dU ^
                      seed);
}

static inline float fade(float t) {
    return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F);
}

float FFP_K(noise)(const float p[3], uint32_t seed) {
    const float fx = floorf(p[0]), fy = floorf(p[1]), fz = floorf(p[2]);
    const int x = (int)fx, y = (int)fy, z = (int)fz;
    const float rx = p[0] - fx, ry = p[1] - fy, rz = p[2] - fz;
    const float sx = fade(rx), sy = fade(ry), sz = fade(rz);
    float corner[8];
    for (int c = 0; c < 8; c++) {
        const int i = c & 1, j = (c >> 1) & 1, k = c >> 2;
        const uint32_t h = lattice_hash(x + i, y + j, z + k, seed);
        // ten bits a component: gradients fill a cube, which no picture tells from a sphere
        const float gx = (float)(int)(h & 1023) - 511.5F, gy = (float)(int)((h >> 10) & 1023) - 511.5F;
        const float gz = (float)(int)((h >> 20) & 1023) - 511.5F;
        const float wx = i ? sx : 1 - sx, wy = j ? sy : 1 - sy, wz = k ? sz : 1 - sz;
        corner[c] = wx * wy * wz * (gx * (rx - (float)i) + gy * (ry - (float)j) + gz * (rz - (float)k));
    }
    float sum = 0;
    for (int c = 0; c < 8; c++) sum += corner[c];
    return sum * (1.5F / 511.5F);
}

float FFP_K(fbm)(const float p[3], uint32_t seed, int octaves) {
    float sum = 0, weight = 1, total = 0, q[3] = {p[0], p[1], p[2]};
    for (int i = 0; i < octaves; i++) {
        sum += weight * FFP_K(noise)(q, seed + 0x632be5abU * (uint32_t)i);
        total += weight;
        weight *= 0.5F;
        for (int a = 0; a < 3; a++) q[a] = 2.0F * q[a] + 0.37F; // the offset keeps lattice zeros apart
    }
    return 1.4F * sum / total;
}

float FFP_K(ridges)(const float p[3], uint32_t seed, int octaves) {
    float sum = 0, weight = 1, total = 0, q[3] = {p[0], p[1], p[2]};
    for (int i = 0; i < octaves; i++) {
        sum += weight * (1 - ffp_min(fabsf(FFP_K(noise)(q, seed + 0x632be5abU * (uint32_t)i)) * 1.6F, 1));
        total += weight;
        weight *= 0.5F;
        for (int a = 0; a < 3; a++) q[a] = 2.0F * q[a] + 0.37F;
    }
    return sum / total;
}

// The 27 cubes around a point's own. The padding of the vectors lies too far off to be the nearest.
enum { CUBES = 32, FAR = 1024 };
static const int32_t cube_offset[3][CUBES] = {
    {-1, 0, 1,  -1, 0, 1,  -1, 0, 1,  -1, 0, 1,   -1,  0,   1,   -1,
     0,  1, -1, 0,  1, -1, 0,  1, -1, 0,  1, FAR, FAR, FAR, FAR, FAR},
    {-1, -1, -1, 0,  0,  0, 1, 1, 1, -1, -1, -1,  0,   0,   0,   1,
     1,  1,  -1, -1, -1, 0, 0, 0, 1, 1,  1,  FAR, FAR, FAR, FAR, FAR},
    {-1, -1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0,   0,   0,   0,   0,
     0,  0,  1,  1,  1,  1,  1,  1,  1,  1, 1, FAR, FAR, FAR, FAR, FAR}};

// Squared distances from p to the points of all cubes, as bits: those of floats from 0 on have their order.
static inline void cube_distances(const float p[3], uint32_t seed, uint32_t hash[CUBES],
                                  uint32_t bits[CUBES]) {
    const float fx = floorf(p[0]), fy = floorf(p[1]), fz = floorf(p[2]);
    float square[CUBES];
    for (int c = 0; c < CUBES; c++) {
        const int i = cube_offset[0][c], j = cube_offset[1][c], k = cube_offset[2][c];
        const uint32_t h = lattice_hash((int)fx + i, (int)fy + j, (int)fz + k, seed);
        const float x = fx + (float)i + (float)(int)(h & 1023) / 1024.0F - p[0];
        const float y = fy + (float)j + (float)(int)((h >> 10) & 1023) / 1024.0F - p[1];
        const float z = fz + (float)k + (float)(int)((h >> 20) & 1023) / 1024.0F - p[2];
        square[c] = x * x + y * y + z * z;
        hash[c] = h;
    }
    memcpy(bits, square, sizeof square);
}

static inline float float_of(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

FfpCells FFP_K(cells)(const float p[3], uint32_t seed) {
    uint32_t hash[CUBES], bits[CUBES], nearest = UINT32_MAX, second = UINT32_MAX, id = 0, at_nearest = 0;
    cube_distances(p, seed, hash, bits);
    for (int c = 0; c < CUBES; c++) nearest = bits[c] < nearest ? bits[c] : nearest;
    for (int c = 0; c < CUBES; c++) {
        const uint32_t own = bits[c] == nearest ? hash[c] : 0,
                       other = bits[c] == nearest ? UINT32_MAX : bits[c];
        id = own > id ? own : id;
        second = other < second ? other : second;
        at_nearest += bits[c] == nearest;
    }
    return (FfpCells){.nearest = sqrtf(float_of(nearest)),
                      .second = sqrtf(float_of(at_nearest > 1 ? nearest : second)),
                      .id = ffp_hash32(id ^ 0x5bd1e995U)};
}

const FfpShapesKernels FFP_K(shapes) = {
    .noise = FFP_K(noise),
    .fbm = FFP_K(fbm),
    .ridges = FFP_K(ridges),
    .cells = FFP_K(cells),
};
