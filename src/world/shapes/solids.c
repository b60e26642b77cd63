#include "world/shapes/solids.h"
#include <math.h>
#include "core/base/alloc.h"

enum { SEGMENTS = 128 };

static FfpMesh mesh_of(int vertices, int triangles) {
    return (FfpMesh){.n_vertices = vertices,
                     .n_triangles = triangles,
                     .positions = ffp_alloc((size_t)vertices * 3 + 1, sizeof(float)),
                     .normals = ffp_alloc((size_t)vertices * 3, sizeof(float)),
                     .triangles = ffp_alloc((size_t)triangles * 3, sizeof(uint32_t))};
}

static void set_vertex(FfpMesh *mesh, int i, const float position[3], const float normal[3]) {
    for (size_t k = 0; k < 3; k++) {
        mesh->positions[3 * (size_t)i + k] = position[k];
        mesh->normals[3 * (size_t)i + k] = normal[k];
    }
}

static void set_triangle(FfpMesh *mesh, int i, int a, int b, int c) {
    uint32_t *to = mesh->triangles + 3 * (size_t)i;
    to[0] = (uint32_t)a, to[1] = (uint32_t)b, to[2] = (uint32_t)c;
}

// Side 2 a + 0 or 1 of a box looks along axis a, backwards or forwards, and has four corners of its own.
FfpMesh ffp_solid_box(const float centre[3], const float half[3], float angle) {
    const float cosine = cosf(angle), sine = sinf(angle);
    FfpMesh mesh = mesh_of(24, 12);
    for (int side = 0; side < 6; side++) {
        const int a = side / 2, b = (a + 1) % 3, c = (a + 2) % 3;
        const float sign = side % 2 ? 1 : -1;
        for (int corner = 0; corner < 4; corner++) {
            float p[3], n[3] = {0, 0, 0};
            n[a] = sign;
            p[a] = sign * half[a];
            p[b] = (corner == 1 || corner == 2 ? 1 : -1) * half[b];
            p[c] = (corner >= 2 ? 1 : -1) * half[c];
            const float position[3] = {centre[0] + cosine * p[0] - sine * p[1],
                                       centre[1] + sine * p[0] + cosine * p[1], centre[2] + p[2]};
            const float normal[3] = {cosine * n[0] - sine * n[1], sine * n[0] + cosine * n[1], n[2]};
            set_vertex(&mesh, 4 * side + corner, position, normal);
        }
        const int v = 4 * side, second = sign > 0 ? 1 : 3, last = sign > 0 ? 3 : 1;
        set_triangle(&mesh, 2 * side, v, v + second, v + 2);
        set_triangle(&mesh, 2 * side + 1, v, v + 2, v + last);
    }
    return mesh;
}

// Of each segment the vertices below and above on the side, then those of bottom and top; their middles last.
FfpMesh ffp_solid_cylinder(float radius, float bottom, float top) {
    FfpMesh mesh = mesh_of(4 * SEGMENTS + 2, 4 * SEGMENTS);
    const float down[3] = {0, 0, -1}, up[3] = {0, 0, 1};
    const int middle = 4 * SEGMENTS;
    set_vertex(&mesh, middle, (float[3]){0, 0, bottom}, down);
    set_vertex(&mesh, middle + 1, (float[3]){0, 0, top}, up);
    for (int i = 0; i < SEGMENTS; i++) {
        const float angle = 6.2831853F * (float)i / SEGMENTS, out[3] = {cosf(angle), sinf(angle), 0};
        const float low[3] = {radius * out[0], radius * out[1], bottom},
                    high[3] = {radius * out[0], radius * out[1], top};
        const int v = 4 * i, next = 4 * ((i + 1) % SEGMENTS);
        set_vertex(&mesh, v, low, out), set_vertex(&mesh, v + 1, high, out);
        set_vertex(&mesh, v + 2, low, down), set_vertex(&mesh, v + 3, high, up);
        set_triangle(&mesh, 4 * i, v, next, next + 1);
        set_triangle(&mesh, 4 * i + 1, v, next + 1, v + 1);
        set_triangle(&mesh, 4 * i + 2, middle, next + 2, v + 2);
        set_triangle(&mesh, 4 * i + 3, middle + 1, v + 3, next + 3);
    }
    return mesh;
}
