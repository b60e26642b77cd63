// Surface nets over a block-wise sampled distance function. Blocks that the surface cannot reach are never
// sampled, and in the others only the parts that can matter are asked, which is what makes a mesh cost a
// tenth of a second.
#include "world/shapes/mesh.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/numerics/surface_nets.h"
#include "world/shapes/scalar.h"

#define BLOCK 8

typedef struct Grid {
    const FfpShape *shape;
    float origin[3], step;
    int n[3], blocks[3]; // points, blocks of BLOCK^3 points
    float *value;        // [n[2], n[1], n[0]]
    uint8_t *inside;     // the same: 1 where value < 0, after repair
    uint8_t *lists;      // [block, FFP_PARTS_MAX] the parts that matter there
    int *counts;         // [block]
} Grid;

static inline size_t point_index(const Grid *g, int x, int y, int z) {
    return ((size_t)z * (size_t)g->n[1] + (size_t)y) * (size_t)g->n[0] + (size_t)x;
}

static FfpNetGrid net_of(const Grid *g) {
    return (FfpNetGrid){{g->n[0], g->n[1], g->n[2]}, g->value, g->inside};
}

static Grid grid_new(const FfpShape *shape, int resolution) {
    Grid g = {.shape = shape};
    float low[3], high[3], longest = 0;
    ffp_shape_bounds(shape, low, high);
    for (int a = 0; a < 3; a++) longest = ffp_max(longest, high[a] - low[a]);
    g.step = longest / (float)resolution;
    for (int a = 0; a < 3; a++) {
        g.n[a] = (int)ceilf((high[a] - low[a]) / g.step) + 6; // three cells of air around
        g.blocks[a] = (g.n[a] + BLOCK - 1) / BLOCK;
        g.origin[a] = 0.5F * (low[a] + high[a]) - 0.5F * (float)(g.n[a] - 1) * g.step;
    }
    const size_t points = (size_t)g.n[0] * (size_t)g.n[1] * (size_t)g.n[2];
    const size_t blocks = (size_t)g.blocks[0] * (size_t)g.blocks[1] * (size_t)g.blocks[2];
    g.value = ffp_alloc(points, sizeof *g.value);
    g.inside = ffp_alloc(points, 1);
    g.lists = ffp_alloc(blocks, FFP_PARTS_MAX);
    g.counts = ffp_alloc(blocks, sizeof *g.counts);
    return g;
}

static void grid_free(Grid *g) {
    ffp_free(g->value);
    ffp_free(g->inside);
    ffp_free(g->lists);
    ffp_free(g->counts);
}

// The parts whose surface, blend or cut can reach a ball around p. A part further off than that cannot change
// a sign.
static int relevant_parts(const FfpShape *shape, const float p[3], float reach, uint8_t *list) {
    float q[3] = {p[0], p[1], p[2]};
    if (shape->twist != 0) {
        const float c = cosf(shape->twist * p[2]), s = sinf(shape->twist * p[2]);
        q[0] = c * p[0] - s * p[1], q[1] = s * p[0] + c * p[1];
    }
    int count = 0;
    for (int i = 0; i < shape->n_parts; i++) {
        const FfpPart *part = &shape->parts[i];
        const float d = ffp_part_distance(shape, part, q), far = reach + part->blend;
        if (part->join == FFP_CSG_INTERSECTION ? d >= -far : d <= far) list[count++] = (uint8_t)i;
    }
    return count;
}

static void fill_block(Grid *g, int bx, int by, int bz) {
    const FfpShape *shape = g->shape;
    const int block = (bz * g->blocks[1] + by) * g->blocks[0] + bx,
              first[3] = {bx * BLOCK, by * BLOCK, bz * BLOCK};
    float centre[3];
    for (int a = 0; a < 3; a++) centre[a] = g->origin[a] + ((float)first[a] + 0.5F * (BLOCK - 1)) * g->step;
    // half the diagonal, and one step more, because cells reach into the next block
    const float ball = (0.5F * (BLOCK - 1) * 1.7321F + 1.8F) * g->step * shape->lipschitz;
    const float reach = ball + 1.5F * (shape->bump + shape->rib_depth);
    uint8_t *list = g->lists + (size_t)block * FFP_PARTS_MAX;
    const int count = g->counts[block] = relevant_parts(shape, centre, reach, list);
    const float middle = ffp_shape_distance(shape, list, count, centre);
    const bool near = fabsf(middle) <= reach;
    for (int z = first[2]; z < first[2] + BLOCK && z < g->n[2]; z++)
        for (int y = first[1]; y < first[1] + BLOCK && y < g->n[1]; y++)
            for (int x = first[0]; x < first[0] + BLOCK && x < g->n[0]; x++) {
                const float p[3] = {g->origin[0] + (float)x * g->step, g->origin[1] + (float)y * g->step,
                                    g->origin[2] + (float)z * g->step};
                float v = near ? ffp_shape_distance(shape, list, count, p) : middle;
                const bool border =
                    x < 2 || y < 2 || z < 2 || x >= g->n[0] - 2 || y >= g->n[1] - 2 || z >= g->n[2] - 2;
                if (border && v < 0) v = g->step;
                const size_t i = point_index(g, x, y, z);
                g->value[i] = v;
                g->inside[i] = v < 0;
            }
}

static void grid_fill(Grid *g) {
    const int total = g->blocks[0] * g->blocks[1] * g->blocks[2];
#pragma omp parallel for schedule(dynamic, 4)
    for (int b = 0; b < total; b++)
        fill_block(g, b % g->blocks[0], b / g->blocks[0] % g->blocks[1], b / g->blocks[0] / g->blocks[1]);
}

// Visits all points joined to `start` by steps along the axes that lie on its side of the surface. Their
// indices stand in queue[0 .. result).
static size_t flood(const Grid *g, size_t start, bool *seen, size_t *queue) {
    const size_t n[3] = {(size_t)g->n[0], (size_t)g->n[1], (size_t)g->n[2]};
    const size_t stride[3] = {1, n[0], n[0] * n[1]};
    size_t count = 1;
    queue[0] = start, seen[start] = true;
    for (size_t next = 0; next < count; next++) {
        const size_t i = queue[next], at[3] = {i % n[0], i / n[0] % n[1], i / stride[2]};
        for (int side = 0; side < 6; side++) {
            const int a = side / 2;
            if (side % 2 ? at[a] + 1 == n[a] : at[a] == 0) continue;
            const size_t j = side % 2 ? i + stride[a] : i - stride[a];
            if (seen[j] || g->inside[j] != g->inside[i]) continue;
            seen[j] = true;
            queue[count++] = j;
        }
    }
    return count;
}

// Leaves only what belongs to the object: fills bubbles that the air outside does not reach, and sweeps away
// crumbs of less than a five-hundredth of the solid.
static void sweep(Grid *g) {
    const size_t points = (size_t)g->n[0] * (size_t)g->n[1] * (size_t)g->n[2];
    bool *seen = ffp_alloc(points, sizeof *seen);
    size_t *queue = ffp_alloc(points, sizeof *queue), solid = 0;
    flood(g, 0, seen, queue); // the corner is air
    for (size_t i = 0; i < points; i++) {
        if (!seen[i] && !g->inside[i]) g->inside[i] = 1, g->value[i] = -g->step;
        solid += g->inside[i];
    }
    for (size_t i = 0; i < points; i++) {
        if (seen[i]) continue;
        const size_t count = flood(g, i, seen, queue);
        for (size_t k = 0; k < count && 500 * count < solid; k++)
            g->inside[queue[k]] = 0, g->value[queue[k]] = g->step;
    }
    ffp_free(seen);
    ffp_free(queue);
}

static const int *block_list(const Grid *g, const int cell[3], const uint8_t **list) {
    const int b = (cell[2] / BLOCK * g->blocks[1] + cell[1] / BLOCK) * g->blocks[0] + cell[0] / BLOCK;
    *list = g->lists + (size_t)b * FFP_PARTS_MAX;
    return &g->counts[b];
}

// Gradient by the four corners of a tetrahedron, half a step wide: as sharp as the mesh can be. Returns the
// mean value.
static float gradient(const FfpShape *shape, const uint8_t *list, int count, const float p[3], float e,
                      float out[3]) {
    static const float corner[4][3] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
    float sum = 0;
    out[0] = out[1] = out[2] = 0;
    for (int c = 0; c < 4; c++) {
        const float q[3] = {p[0] + e * corner[c][0], p[1] + e * corner[c][1], p[2] + e * corner[c][2]};
        const float d = ffp_shape_distance(shape, list, count, q);
        for (int a = 0; a < 3; a++) out[a] += d * corner[c][a] / (4 * e);
        sum += 0.25F * d;
    }
    return sum;
}

// The mean of the cell's edge crossings, then moved along the gradient onto the surface, but never out of the
// cell.
static void place_vertex(const Grid *g, const int cell[3], float position[3], float normal[3]) {
    const FfpNetGrid net = net_of(g);
    float mean[3];
    ffp_net_crossing(&net, cell, mean);
    for (int k = 0; k < 3; k++) position[k] = g->origin[k] + mean[k] * g->step;
    const uint8_t *list;
    const int count = *block_list(g, cell, &list);
    for (int pass = 0; pass < 2; pass++) {
        float way[3];
        const float d = gradient(g->shape, list, count, position, 0.35F * g->step, way);
        const float square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        const float move = fabsf(d) < 2 * g->step ? d / ffp_max(square, 0.25F) : 0;
        for (int k = 0; k < 3; k++) {
            const float low = g->origin[k] + ((float)cell[k] + 0.02F) * g->step;
            position[k] = ffp_max(low, ffp_min(low + 0.96F * g->step, position[k] - move * way[k]));
        }
        const float length = sqrtf(square);
        for (int k = 0; k < 3; k++) normal[k] = length > 1e-6F ? way[k] / length : (k == 2 ? 1.0F : 0.0F);
    }
}

// Split along the shorter diagonal.
static void add_quad(void *context, const uint32_t q[4], bool flip) {
    FfpMesh *mesh = context;
    float d02 = 0, d13 = 0;
    for (int k = 0; k < 3; k++) {
        const float a = mesh->positions[3 * q[0] + k] - mesh->positions[3 * q[2] + k];
        const float b = mesh->positions[3 * q[1] + k] - mesh->positions[3 * q[3] + k];
        d02 += a * a, d13 += b * b;
    }
    static const int split[2][6] = {{0, 1, 2, 0, 2, 3}, {1, 2, 3, 1, 3, 0}};
    const int *order = split[d13 < d02];
    uint32_t *t = mesh->triangles + (size_t)mesh->n_triangles * 3;
    for (int half = 0; half < 2; half++, t += 3) {
        t[0] = q[order[3 * half]];
        t[1] = q[order[3 * half + (flip ? 2 : 1)]], t[2] = q[order[3 * half + (flip ? 1 : 2)]];
    }
    mesh->n_triangles += 2;
}

FfpMesh ffp_mesh_from_shape(const FfpShape *shape) {
    int resolution = 80, quads = 0;
    Grid g = {0};
    FfpNetGrid net = {0};
    for (int pass = 0; pass < 4; pass++) { // area decides the number of triangles: adjust once it is known
        g = grid_new(shape, resolution);
        grid_fill(&g);
        ffp_net_repair(g.n, g.value, g.inside, 1e-3F * g.step);
        sweep(&g);
        net = net_of(&g);
        quads = ffp_net_count_quads(&net);
        if (pass == 3 || (quads >= 3000 && quads <= 27000)) break;
        grid_free(&g);
        resolution =
            (int)ffp_max(24, ffp_min(160, (float)resolution * sqrtf((quads < 3000 ? 5000.0F : 22000.0F) /
                                                                    (float)(quads + 1))));
    }
    FfpNetCells cells = ffp_net_cells(&net);
    FfpMesh mesh = {.n_vertices = cells.count};
    mesh.positions = ffp_alloc((size_t)mesh.n_vertices * 3 + 4, sizeof(float));
    mesh.normals = ffp_alloc((size_t)mesh.n_vertices * 3 + 4, sizeof(float));
    mesh.triangles = ffp_alloc((size_t)quads * 6, sizeof(uint32_t));
#pragma omp parallel for schedule(static)
    for (int i = 0; i < mesh.n_vertices; i++)
        place_vertex(&g, cells.cells + 3 * (size_t)i, mesh.positions + 3 * (size_t)i,
                     mesh.normals + 3 * (size_t)i);
    ffp_net_connect(&net, &cells, add_quad, &mesh);
    ffp_net_cells_free(&cells);
    grid_free(&g);
    return mesh;
}

// Smallest enclosing ball by walking towards the furthest point with shrinking steps (Badoiu and Clarkson
// 2003).
static void enclosing_ball(const FfpMesh *mesh, int steps, float centre[3], float *radius) {
    double c[3] = {0, 0, 0};
    for (int i = 0; i < 3 * mesh->n_vertices; i++) c[i % 3] += mesh->positions[i];
    for (int k = 0; k < 3; k++) c[k] /= mesh->n_vertices;
    double furthest = 0;
    for (int step = 1; step <= steps; step++) {
        int far = 0;
        furthest = 0;
        for (int i = 0; i < mesh->n_vertices; i++) {
            const float *p = mesh->positions + 3 * (size_t)i;
            const double x = p[0] - c[0], y = p[1] - c[1], z = p[2] - c[2], d = x * x + y * y + z * z;
            if (d > furthest) furthest = d, far = i;
        }
        if (step == steps) break;
        for (int k = 0; k < 3; k++)
            c[k] += (mesh->positions[3 * (size_t)far + (size_t)k] - c[k]) / (step + 1);
    }
    for (int k = 0; k < 3; k++) centre[k] = (float)c[k];
    *radius = (float)sqrt(furthest);
}

void ffp_mesh_place(FfpMesh *mesh, const float rotation[9]) {
    float centre[3], radius;
    // The ball is right to one part in the number of steps. A user's mesh is placed to a thousandth.
    const int steps = mesh->two_sided && mesh->n_vertices < 1000000 ? 1024 : 64;
    enclosing_ball(mesh, steps, centre, &radius);
    const float scale = FFP_MESH_RADIUS / radius * 0.99999F; // rounding must not lead out of the sphere
    for (int i = 0; i < mesh->n_vertices; i++) {
        float *p = mesh->positions + 3 * (size_t)i, *n = mesh->normals + 3 * (size_t)i;
        const float q[3] = {(p[0] - centre[0]) * scale, (p[1] - centre[1]) * scale,
                            (p[2] - centre[2]) * scale};
        const float m[3] = {n[0], n[1], n[2]};
        for (int k = 0; k < 3; k++) {
            const float *r = rotation + 3 * k;
            p[k] = r[0] * q[0] + r[1] * q[1] + r[2] * q[2];
            n[k] = r[0] * m[0] + r[1] * m[1] + r[2] * m[2];
        }
    }
}

void ffp_mesh_free(FfpMesh *mesh) {
    ffp_free(mesh->positions);
    ffp_free(mesh->normals);
    ffp_free(mesh->triangles);
    ffp_free(mesh->uv);
    *mesh = (FfpMesh){0};
}
