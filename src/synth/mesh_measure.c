// What a mesh is like, in figures that do not depend on how it is turned: the handles of its surface, and a
// histogram that tells two objects apart.
#include "synth/mesh_measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/rng.h"

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

typedef struct HalfEdge {
    uint32_t low, high;               // vertices
    uint32_t low_corner, high_corner; // of the triangle that it bounds, 3 * triangle + place
} HalfEdge;

static int compare_edges(const void *a, const void *b) {
    const HalfEdge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b) {
    parent[root_of(parent, a)] = root_of(parent, b);
}

static int count_roots(const uint32_t *parent, uint32_t count) {
    int roots = 0;
    for (uint32_t i = 0; i < count; i++) roots += parent[i] == i;
    return roots;
}

// V counts the fans of triangles around vertices, so that two sheets that touch in a vertex do not count as
// joined there.
int ffp_mesh_genus(const FfpMesh *mesh, int *components) {
    const uint32_t corners = 3 * (uint32_t)mesh->n_triangles;
    HalfEdge *edges = ffp_alloc(corners, sizeof *edges);
    uint32_t *fans = ffp_alloc(corners, sizeof *fans), *pieces = ffp_alloc(corners, sizeof *pieces);
    for (uint32_t i = 0; i < corners; i++) {
        const uint32_t j = i % 3 == 2 ? i - 2 : i + 1, a = mesh->triangles[i], b = mesh->triangles[j];
        edges[i] = a < b ? (HalfEdge){a, b, i, j} : (HalfEdge){b, a, j, i};
        fans[i] = i, pieces[i] = i - i % 3; // a piece is named by a triangle's first corner
    }
    qsort(edges, corners, sizeof *edges, compare_edges);
    for (uint32_t i = 0; i + 1 < corners; i += 2) {
        join(fans, edges[i].low_corner, edges[i + 1].low_corner);
        join(fans, edges[i].high_corner, edges[i + 1].high_corner);
        join(pieces, edges[i].low_corner, edges[i + 1].low_corner);
    }
    *components = count_roots(pieces, corners);
    const int vertices = count_roots(fans, corners);
    ffp_free(edges);
    ffp_free(fans);
    ffp_free(pieces);
    return *components - (vertices - mesh->n_triangles / 2) / 2;
}

// Twice the area of triangle t.
static double twice_area(const FfpMesh *mesh, int t) {
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

enum { POINTS = 1200 };

// Points evenly spread over the area: every total / POINTS along the triangles' running sum, at a random
// place in the triangle (Osada et al. 2002, eq. 1). point[i]: position, unit normal.
static void sample(const FfpMesh *mesh, float point[POINTS][6]) {
    FfpRng rng = ffp_rng(0xd2, 0);
    double total = 0, sum = 0;
    for (int t = 0; t < mesh->n_triangles; t++) total += twice_area(mesh, t);
    int next = 0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *v = mesh->triangles + 3 * (size_t)t;
        sum += twice_area(mesh, t);
        for (; next < POINTS && sum >= (next + 0.5) * total / POINTS; next++) {
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
static void spread(float *histogram, float distance, float cosine, float share) {
    const float x = fminf(fmaxf(distance * FFP_SIGNATURE_DISTANCES - 0.5F, 0), FFP_SIGNATURE_DISTANCES - 1);
    const float y =
        fminf(fmaxf(0.5F * (cosine + 1) * FFP_SIGNATURE_ANGLES - 0.5F, 0), FFP_SIGNATURE_ANGLES - 1);
    const int i = (int)fminf(x, FFP_SIGNATURE_DISTANCES - 2), j = (int)fminf(y, FFP_SIGNATURE_ANGLES - 2);
    const float u = x - (float)i, v = y - (float)j;
    float *at = histogram + i * FFP_SIGNATURE_ANGLES + j;
    at[0] += share * (1 - u) * (1 - v);
    at[1] += share * (1 - u) * v;
    at[FFP_SIGNATURE_ANGLES] += share * u * (1 - v);
    at[FFP_SIGNATURE_ANGLES + 1] += share * u * v;
}

void ffp_mesh_signature(const FfpMesh *mesh, float *histogram) {
    float(*point)[6] = ffp_alloc(POINTS, sizeof *point);
    sample(mesh, point);
    memset(histogram, 0, FFP_SIGNATURE * sizeof *histogram);
    const float share = 1.0F / (0.5F * POINTS * (POINTS - 1));
    for (int i = 0; i < POINTS; i++)
        for (int j = 0; j < i; j++) {
            float square = 0, cosine = 0;
            for (int k = 0; k < 3; k++) {
                const float d = point[i][k] - point[j][k];
                square += d * d;
                cosine += point[i][3 + k] * point[j][3 + k];
            }
            spread(histogram, sqrtf(square) / (2 * FFP_MESH_RADIUS), cosine, share);
        }
    ffp_free(point);
}

float ffp_signature_distance(const float *a, const float *b) {
    float sum = 0;
    for (int i = 0; i < FFP_SIGNATURE; i++) sum += fabsf(a[i] - b[i]);
    return 0.5F * sum;
}
