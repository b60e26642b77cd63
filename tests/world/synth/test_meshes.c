// All meshes: closed, wound outwards, in one piece, in their sphere, the right size, no two alike, of every
// genus up to 5, the same each time; and the splits.
// Labels: slow
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "support.h"
#include "world/shapes/mesh.h"
#include "world/shapes/mesh_measure.h"
#include "world/synth/dataset.h"
#include "world/synth/mesh_signature.h"
#include "world/synth/synth.h"

enum { MESHES = 150 };

static FfpMesh meshes[MESHES];

static int make_meshes(void **state) {
    (void)state;
    for (int i = 0; i < MESHES; i++) meshes[i] = ffp_mesh_make(i);
    return 0;
}

static int free_meshes(void **state) {
    (void)state;
    for (int i = 0; i < MESHES; i++) ffp_mesh_free(&meshes[i]);
    return 0;
}

typedef struct Edge {
    uint32_t low, high;
    int way; // +1 from low to high
} Edge;

static int compare_edges(const void *a, const void *b) {
    const Edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

// Every edge belongs to exactly two triangles, which run through it in opposite directions.
static void assert_closed(const FfpMesh *mesh) {
    const size_t count = (size_t)mesh->n_triangles * 3;
    Edge *edges = ffp_alloc(count * sizeof *edges, 1);
    assert_non_null(edges);
    for (size_t i = 0; i < count; i++) {
        const uint32_t a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        assert_true(a < (uint32_t)mesh->n_vertices && a != b);
        edges[i] = a < b ? (Edge){a, b, 1} : (Edge){b, a, -1};
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    assert_true(count % 2 == 0);
    for (size_t i = 0; i < count; i += 2) {
        assert_int_equal(compare_edges(&edges[i], &edges[i + 1]), 0);
        assert_int_equal(edges[i].way + edges[i + 1].way, 0);
        assert_true(i + 2 == count || compare_edges(&edges[i + 1], &edges[i + 2]) != 0);
    }
    ffp_free(edges);
}

static double volume(const FfpMesh *mesh) {
    double sum = 0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        const float *a = mesh->positions + 3 * mesh->triangles[3 * t],
                    *b = mesh->positions + 3 * mesh->triangles[3 * t + 1];
        const float *c = mesh->positions + 3 * mesh->triangles[3 * t + 2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

static void assert_shape(const FfpMesh *mesh) {
    double furthest = 0;
    for (int i = 0; i < mesh->n_vertices; i++) {
        const float *p = mesh->positions + 3 * i, *n = mesh->normals + 3 * i;
        furthest = worse(furthest, sqrt((double)p[0] * p[0] + (double)p[1] * p[1] + (double)p[2] * p[2]));
        assert_float_equal(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-4);
    }
    assert_true(furthest <= FFP_MESH_RADIUS && furthest > 0.999 * FFP_MESH_RADIUS);
    assert_in_range(mesh->n_triangles, 3000, 60000);
}

// The share of triangles whose smooth normals look the other way than their winding: only slivers at sharp
// edges may.
static double contrary(const FfpMesh *mesh) {
    int against = 0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *v = mesh->triangles + 3 * t;
        double e[2][3], n[3], dot = 0;
        for (int k = 0; k < 3; k++) {
            e[0][k] = mesh->positions[3 * v[1] + k] - mesh->positions[3 * v[0] + k];
            e[1][k] = mesh->positions[3 * v[2] + k] - mesh->positions[3 * v[0] + k];
        }
        for (int k = 0; k < 3; k++) {
            n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
            for (int c = 0; c < 3; c++) dot += n[k] * mesh->normals[3 * v[c] + k];
        }
        against += dot < 0;
    }
    return (double)against / mesh->n_triangles;
}

static void meshes_are_closed_and_face_outwards(void **state) {
    (void)state;
    assert_int_equal(ffp_mesh_count(), MESHES);
    for (int i = 0; i < MESHES; i++) {
        assert_closed(&meshes[i]);
        assert_shape(&meshes[i]);
        const double inside = volume(&meshes[i]), bent = contrary(&meshes[i]);
        if (inside < 0.02 || bent > 0.03)
            print_message("%s: volume %g, %g contrary\n", ffp_mesh_name(i), inside, bent);
        assert_true(inside > 0.02);
        assert_true(bent <= 0.03);
    }
}

static void names_are_unique(void **state) {
    (void)state;
    for (int i = 0; i < MESHES; i++)
        for (int j = 0; j < i; j++) assert_string_not_equal(ffp_mesh_name(i), ffp_mesh_name(j));
    assert_string_equal(ffp_mesh_name(-1), "unknown");
    assert_string_equal(ffp_mesh_name(MESHES), "unknown");
}

static FfpMesh mesh_of(void (*make)(FfpShape *)) {
    FfpShape *shape = ffp_alloc(sizeof *shape, 1);
    assert_non_null(shape);
    ffp_shape_init(shape, 7);
    make(shape);
    FfpMesh mesh = ffp_mesh_from_shape(shape);
    ffp_free(shape);
    const float upright[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    ffp_mesh_place(&mesh, upright);
    return mesh;
}

static void two_rings(FfpShape *shape) {
    ffp_add_torus(shape, ffp_v3(0, 0, 0), 0.5F, 0.1F, 0);
    ffp_add_torus(shape, ffp_v3(2, 0, 0), 0.5F, 0.1F, 0);
}

// A ball with a bubble inside and a crumb beside it.
static void littered_ball(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(1, 1, 1), 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.5F, 0.5F, 0.5F), 0));
    ffp_add_ellipsoid(shape, ffp_v3(1.2F, 0, 0), ffp_v3(0.1F, 0.1F, 0.1F), 0);
}

static void plain_ball(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(1, 1, 1), 0);
}

static void genus_counts_handles(void **state) {
    (void)state;
    FfpMesh rings = mesh_of(two_rings), ball = mesh_of(littered_ball);
    int components = 0;
    assert_int_equal(ffp_mesh_genus(&rings, &components), 2);
    assert_int_equal(components, 2);
    assert_int_equal(ffp_mesh_genus(&ball, &components), 0);
    assert_int_equal(components, 1); // bubble and crumb are gone
    ffp_mesh_free(&rings);
    ffp_mesh_free(&ball);
}

static void meshes_are_in_one_piece_and_of_every_genus(void **state) {
    (void)state;
    int seen[6] = {0};
    for (int i = 0; i < MESHES; i++) {
        int components = 0;
        const int genus = ffp_mesh_genus(&meshes[i], &components);
        if (components != 1 || genus < 0 || genus > 9)
            print_message("%s: %d pieces, genus %d\n", ffp_mesh_name(i), components, genus);
        assert_int_equal(components, 1);
        assert_in_range(genus, 0, 9);
        if (genus < 6) seen[genus]++;
    }
    for (int genus = 0; genus < 6; genus++) assert_true(seen[genus] >= 3);
}

static void signature_knows_a_turned_object(void **state) {
    (void)state;
    const float turn[9] = {0, 0, 1, 0.6F, 0.8F, 0, -0.8F, 0.6F, 0};
    static float a[SIGNATURE], b[SIGNATURE];
    for (int i = 20; i < MESHES; i += 31) {
        FfpMesh mesh = ffp_mesh_make(i);
        mesh_signature(&mesh, a);
        ffp_mesh_place(&mesh, turn);
        mesh_signature(&mesh, b);
        double sum = 0;
        for (int k = 0; k < SIGNATURE; k++) sum += a[k];
        assert_float_equal(sum, 1, 1e-3);
        assert_true(signature_distance(a, b) < 0.01F);
        ffp_mesh_free(&mesh);
    }
    FfpMesh rings = mesh_of(two_rings), ball = mesh_of(plain_ball);
    mesh_signature(&rings, a);
    mesh_signature(&ball, b);
    assert_true(signature_distance(a, b) > 0.3F);
    ffp_mesh_free(&rings);
    ffp_mesh_free(&ball);
}

// 0.06: two apples that differ in their bumps lie 0.01 to 0.02 apart, a chair with and one
// without arms 0.05, two cacti with other arms 0.054.
static void no_two_meshes_are_alike(void **state) {
    (void)state;
    static float signature[MESHES][SIGNATURE];
    float least = 1;
    for (int i = 0; i < MESHES; i++) mesh_signature(&meshes[i], signature[i]);
    for (int i = 0; i < MESHES; i++)
        for (int j = 0; j < i; j++) {
            const float distance = signature_distance(signature[i], signature[j]);
            if (distance < 0.06F)
                print_message("%s and %s: %g\n", ffp_mesh_name(i), ffp_mesh_name(j), (double)distance);
            least = fminf(least, distance);
        }
    assert_true(least >= 0.06F);
}

static void a_mesh_depends_on_its_number_alone(void **state) {
    (void)state;
    const int threads = omp_get_max_threads();
    for (int i = 3; i < MESHES; i += 29) {
        omp_set_num_threads(1);
        FfpMesh a = ffp_mesh_make(i);
        omp_set_num_threads(2);
        FfpMesh b = ffp_mesh_make(i), c = ffp_mesh_make((i + 15) % MESHES);
        assert_int_equal(a.n_vertices, b.n_vertices);
        assert_int_equal(a.n_triangles, b.n_triangles);
        assert_memory_equal(a.positions, b.positions, (size_t)a.n_vertices * 12);
        assert_memory_equal(a.normals, b.normals, (size_t)a.n_vertices * 12);
        assert_memory_equal(a.triangles, b.triangles, (size_t)a.n_triangles * 12);
        // the next of the same family is another shape
        assert_true(a.n_vertices != c.n_vertices ||
                    memcmp(a.positions, c.positions, (size_t)a.n_vertices * 12) != 0);
        ffp_mesh_free(&a);
        ffp_mesh_free(&b);
        ffp_mesh_free(&c);
    }
    omp_set_num_threads(threads);
}

static void splits_are_disjoint_and_balanced(void **state) {
    (void)state;
    static const char *const names[3] = {"train", "validation", "test"};
    static const int sizes[3] = {105, 15, 30};
    int seen[MESHES] = {0};
    for (int s = 0; s < 3; s++) {
        int numbers[MESHES], per_family[15] = {0};
        assert_int_equal(ffp_split_meshes(names[s], numbers, MESHES), sizes[s]);
        for (int i = 0; i < sizes[s]; i++) {
            assert_in_range(numbers[i], 0, MESHES - 1);
            seen[numbers[i]]++;
            per_family[numbers[i] % 15]++;
        }
        for (int f = 0; f < 15; f++) assert_int_equal(per_family[f], sizes[s] / 15);
    }
    for (int i = 0; i < MESHES; i++) assert_int_equal(seen[i], 1);
    assert_int_equal(ffp_split_meshes("training", NULL, 0), 0);
}

static void every_pair_is_one_scene(void **state) {
    (void)state;
    const int64_t size = ffp_dataset_size("test");
    assert_int_equal(size, 30 * ffp_material_count());
    assert_int_equal(ffp_dataset_size(NULL), 150 * ffp_material_count());
    assert_int_equal(ffp_dataset_size("nothing"), 0);
    char *seen = ffp_alloc(150 * (size_t)ffp_material_count(), 1);
    assert_non_null(seen);
    for (int64_t i = 0; i < size; i++) {
        FfpSceneSpec spec = ffp_scene_defaults();
        ffp_dataset_scene("test", i, 5, &spec);
        char *pair = &seen[spec.mesh * ffp_material_count() + spec.material];
        assert_false(*pair);
        *pair = 1;
    }
    ffp_free(seen);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_are_closed_and_face_outwards),
        cmocka_unit_test(names_are_unique),
        cmocka_unit_test(genus_counts_handles),
        cmocka_unit_test(meshes_are_in_one_piece_and_of_every_genus),
        cmocka_unit_test(signature_knows_a_turned_object),
        cmocka_unit_test(no_two_meshes_are_alike),
        cmocka_unit_test(a_mesh_depends_on_its_number_alone),
        cmocka_unit_test(splits_are_disjoint_and_balanced),
        cmocka_unit_test(every_pair_is_one_scene),
    };
    return cmocka_run_group_tests(tests, make_meshes, free_meshes);
}
