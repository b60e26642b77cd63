// A histogram that tells two objects apart, however they are turned.
#ifndef FFP_TESTS_MESH_SIGNATURE_H
#define FFP_TESTS_MESH_SIGNATURE_H

#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "world/shapes/mesh.h"

enum { SIGNATURE_DISTANCES = 24, SIGNATURE_ANGLES = 8, SIGNATURE = SIGNATURE_DISTANCES * SIGNATURE_ANGLES };

// Twice the area of triangle t.
static inline double twice_area(const FfpMesh *mesh, int t) {
    const uint32_t *v = mesh->triangles + 3 * (size_t)t;
    double e[2][3], square = 0;
    for (size_t k = 0; k < 3; k++) {
        const float a = mesh->positions[3 * (size_t)v[0] + k];
        e[0][k] = (double)(mesh->positions[3 * (size_t)v[1] + k] - a);
        e[1][k] = (double)(mesh->positions[3 * (size_t)v[2] + k] - a);
    }
    for (int k = 0; k < 3; k++) {
        const double n = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        square += n * n;
    }
    return sqrt(square);
}

enum { SIGNATURE_POINTS = 1200 };

// Points evenly spread over the area: every total / SIGNATURE_POINTS along the triangles' running sum, at a
// random place in the triangle (Osada et al. 2002, eq. 1). point[i]: position, unit normal.
static inline void signature_sample(const FfpMesh *mesh, float point[SIGNATURE_POINTS][6]) {
    FfpRng rng = ffp_rng(0xd2, 0);
    double total = 0, sum = 0;
    for (int t = 0; t < mesh->n_triangles; t++) total += twice_area(mesh, t);
    int next = 0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *v = mesh->triangles + 3 * (size_t)t;
        sum += twice_area(mesh, t);
        for (; next < SIGNATURE_POINTS && sum >= (next + 0.5) * total / SIGNATURE_POINTS; next++) {
            const float r = sqrtf(ffp_rng_uniform(&rng)), s = ffp_rng_uniform(&rng);
            const float weight[3] = {1 - r, r * (1 - s), r * s};
            float square = 0, *p = point[next];
            memset(p, 0, 6 * sizeof *p);
            for (int c = 0; c < 3; c++)
                for (size_t k = 0; k < 3; k++) {
                    p[k] += weight[c] * mesh->positions[3 * (size_t)v[c] + k];
                    p[3 + k] += weight[c] * mesh->normals[3 * (size_t)v[c] + k];
                }
            for (int k = 3; k < 6; k++) square += p[k] * p[k];
            for (int k = 3; k < 6 && square > 0; k++) p[k] /= sqrtf(square);
        }
    }
}

// Adds `share` to the two nearest bins each way, so that a small change of shape is a small change here.
static inline void signature_spread(float *histogram, float distance, float cosine, float share) {
    const float x = fminf(fmaxf(distance * SIGNATURE_DISTANCES - 0.5F, 0), SIGNATURE_DISTANCES - 1);
    const float y = fminf(fmaxf(0.5F * (cosine + 1) * SIGNATURE_ANGLES - 0.5F, 0), SIGNATURE_ANGLES - 1);
    const int i = (int)fminf(x, SIGNATURE_DISTANCES - 2), j = (int)fminf(y, SIGNATURE_ANGLES - 2);
    const float u = x - (float)i, v = y - (float)j;
    float *at = histogram + i * SIGNATURE_ANGLES + j;
    at[0] += share * (1 - u) * (1 - v);
    at[1] += share * (1 - u) * v;
    at[SIGNATURE_ANGLES] += share * u * (1 - v);
    at[SIGNATURE_ANGLES + 1] += share * u * v;
}

// Distribution over pairs of surface points of their distance and of the cosine between their normals:
// the shape distribution D2 (Osada et al. 2002) with one angle of the surflet pairs (Wahl et al. 2003).
// histogram[SIGNATURE] sums to 1. The mesh is placed, that is, within FFP_MESH_RADIUS.
static inline void mesh_signature(const FfpMesh *mesh, float *histogram) {
    float(*point)[6] = ffp_alloc(SIGNATURE_POINTS, sizeof *point);
    signature_sample(mesh, point);
    memset(histogram, 0, SIGNATURE * sizeof *histogram);
    const float share = 1.0F / (0.5F * SIGNATURE_POINTS * (SIGNATURE_POINTS - 1));
    for (int i = 0; i < SIGNATURE_POINTS; i++)
        for (int j = 0; j < i; j++) {
            float square = 0, cosine = 0;
            for (int k = 0; k < 3; k++) {
                const float d = point[i][k] - point[j][k];
                square += d * d;
                cosine += point[i][3 + k] * point[j][3 + k];
            }
            signature_spread(histogram, sqrtf(square) / (2 * FFP_MESH_RADIUS), cosine, share);
        }
    ffp_free(point);
}

// Half the sum of the absolute differences of two signatures: 0 for the same, 1 for nothing in common.
static inline float signature_distance(const float *a, const float *b) {
    float sum = 0;
    for (int i = 0; i < SIGNATURE; i++) sum += fabsf(a[i] - b[i]);
    return 0.5F * sum;
}

#endif
