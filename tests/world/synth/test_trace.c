// Rays against two squares in the planes z = 0 and z = -1, the upper one half as wide.
#include <math.h>
#include "support.h"
#include "world/synth/trace.h"

// positions have the padding that meshes have
static float positions[25] = {-0.5F, -0.5F, 0,  0.5F, -0.5F, 0,  0.5F, 0.5F, 0,  -0.5F, 0.5F, 0,
                              -1,    -1,    -1, 1,    -1,    -1, 1,    1,    -1, -1,    1,    -1};
static float normals[24] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
static uint32_t triangles[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};

static FfpTracer *tracer_of(FfpMesh *mesh) {
    *mesh = (FfpMesh){.n_vertices = 8,
                      .n_triangles = 4,
                      .positions = positions,
                      .normals = normals,
                      .triangles = triangles};
    FfpError err = {0};
    FfpTracer *tracer = ffp_tracer_new(mesh, &err);
    assert_non_null(tracer);
    return tracer;
}

// Rays from z = 2 straight down, at x = 0.3 k - 1: the squares are hit, or nothing is.
static void each_ray_has_its_hit(void **state) {
    (void)state;
    FfpMesh mesh;
    FfpTracer *tracer = tracer_of(&mesh);
    for (int count = 0; count <= FFP_RAYS; count++) {
        FfpRays rays = {.count = 0};
        FfpHit hits[FFP_RAYS];
        for (int k = 0; k < count; k++)
            ffp_rays_add(&rays, (float[3]){0.3F * (float)k - 0.9F, 0.1F, 2}, (float[3]){0, 0, -2});
        const unsigned found = ffp_trace_hits(tracer, &rays, true, hits);
        assert_int_equal(rays.count, count);
        assert_int_equal(found, (1U << (count < 7 ? count : 7)) - 1); // the last one passes at x = 1.2
        for (int k = 0; k < count && k < 7; k++) {
            const float x = 0.3F * (float)k - 0.9F, z = fabsf(x) < 0.5F ? 0 : -1;
            assert_float_equal(hits[k].t, (2 - z) / 2, 1e-6);
            const float want[3] = {x, 0.1F, z};
            for (int a = 0; a < 3; a++) {
                assert_float_equal(hits[k].point[a], want[a], 1e-6);
                assert_float_equal(hits[k].facet[a], a == 2, 1e-6);
                assert_float_equal(hits[k].normal[a], a == 2, 1e-6);
            }
            assert_int_equal(hits[k].triangle / 2, z < 0);
        }
    }
    ffp_tracer_free(tracer);
}

static void something_is_between(void **state) {
    (void)state;
    FfpMesh mesh;
    FfpTracer *tracer = tracer_of(&mesh);
    const float ways[5][3] = {{0, 0, -1.4F}, {0, 0, -1.6F}, {0, 0, 1}, {0.9F, 0, -2}, {0.9F, 0, -2.6F}};
    FfpRays rays = {.count = 0};
    for (int k = 0; k < 5; k++) ffp_rays_add(&rays, (float[3]){0, 0.1F, 1.5F}, ways[k]);
    assert_int_equal(ffp_trace_blocked(tracer, &rays), 1 << 1 | 1 << 4);
    rays.count = 0;
    assert_int_equal(ffp_trace_blocked(tracer, &rays), 0);
    ffp_tracer_free(tracer);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_ray_has_its_hit),
                                       cmocka_unit_test(something_is_between)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
