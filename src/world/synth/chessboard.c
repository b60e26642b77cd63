#include "world/synth/chessboard.h"
#include <math.h>
#include "core/base/alloc.h"

enum { STEPS = 48 }; // a side, in triangles: lenses bend the long edges of large ones

void ffp_chessboard_point(const FfpChessboard *b, float x, float y, float point[3]) {
    for (int k = 0; k < 3; k++) point[k] = b->origin[k] + b->square * (x * b->right[k] + y * b->down[k]);
}

static void add_square(FfpMesh *mesh, int i, int j) {
    const uint32_t a = (uint32_t)(j * (STEPS + 1) + i), b = a + 1, c = a + STEPS + 1, d = c + 1;
    const uint32_t corners[6] = {a, c, b, b, c, d}; // anticlockwise as one sees it, y down
    for (int k = 0; k < 6; k++) mesh->triangles[3 * mesh->n_triangles + k] = corners[k];
    mesh->n_triangles += 2;
}

FfpMesh ffp_chessboard_mesh(const FfpChessboard *b) {
    const size_t vertices = (size_t)(STEPS + 1) * (STEPS + 1), triangles = (size_t)2 * STEPS * STEPS;
    FfpMesh mesh = {.n_vertices = (int)vertices,
                    .positions = ffp_alloc(3 * vertices + 1, sizeof(float)),
                    .normals = ffp_alloc(3 * vertices, sizeof(float)),
                    .triangles = ffp_alloc(3 * triangles, sizeof(uint32_t))};
    for (int j = 0; j <= STEPS; j++)
        for (int i = 0; i <= STEPS; i++) {
            const size_t at = 3 * ((size_t)j * (STEPS + 1) + (size_t)i);
            const float x = (float)(b->columns + 3) * (float)i / STEPS - 2,
                        y = (float)(b->rows + 3) * (float)j / STEPS - 2;
            ffp_chessboard_point(b, x, y, mesh.positions + at);
            for (int k = 0; k < 3; k++) {
                const int m = (k + 1) % 3, n = (k + 2) % 3;
                mesh.normals[at + (size_t)k] = b->down[m] * b->right[n] - b->down[n] * b->right[m];
            }
        }
    for (int j = 0; j < STEPS; j++)
        for (int i = 0; i < STEPS; i++) add_square(&mesh, i, j);
    return mesh;
}

void ffp_chessboard_look(const FfpChessboard *b, const float point[3], float albedo[3], float *roughness) {
    float x = 0, y = 0;
    for (int k = 0; k < 3; k++) {
        const float d = (point[k] - b->origin[k]) / b->square;
        x += d * b->right[k], y += d * b->down[k];
    }
    const bool margin = x < -1 || y < -1 || x > (float)b->columns || y > (float)b->rows;
    const bool black = !margin && ((int)floorf(x) + (int)floorf(y)) % 2 == 0;
    for (int c = 0; c < 3; c++) albedo[c] = black ? 0.04F : 0.85F;
    *roughness = 0.9F;
}
