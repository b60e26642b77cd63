// A ball and a torus as quads: closed, wound outwards, on the surface, of the right genus; noise, repaired.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/numerics/surface_nets.h"
#include "support.h"

enum { SIDE = 33 };
#define STEP 0.0625F

static float ball(const float p[3]) {
    return sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.7F;
}

static float torus(const float p[3]) {
    const float round = sqrtf(p[0] * p[0] + p[1] * p[1]) - 0.6F;
    return sqrtf(round * round + p[2] * p[2]) - 0.3F;
}

typedef struct Net {
    uint32_t *quads;
    int n;
} Net;

static void add(void *context, const uint32_t vertices[4], bool flipped) {
    Net *net = context;
    for (int k = 0; k < 4; k++) net->quads[4 * net->n + k] = vertices[flipped ? 3 - k : k];
    net->n++;
}

// Every edge once in each direction; returns how many edges there are.
static int check_closed(const Net *net, int vertices) {
    unsigned char *from_to = ffp_alloc((size_t)vertices * (size_t)vertices, 1);
    int edges = 0;
    for (int i = 0; i < 4 * net->n; i++) {
        const size_t a = net->quads[i], b = net->quads[i / 4 * 4 + (i + 1) % 4];
        assert_true(a != b && from_to[a * (size_t)vertices + b]++ == 0);
        edges += from_to[b * (size_t)vertices + a] == 1;
    }
    assert_int_equal(2 * edges, 4 * net->n);
    ffp_free(from_to);
    return edges;
}

// The volume by the divergence theorem: positive where quads are wound outwards.
static double volume_of(const Net *net, const float *at) {
    double six = 0;
    for (int q = 0; q < net->n; q++)
        for (int half = 1; half < 3; half++) {
            const float *a = at + 3 * (size_t)net->quads[4 * q],
                        *b = at + 3 * (size_t)net->quads[4 * q + half],
                        *c = at + 3 * (size_t)net->quads[4 * q + half + 1];
            six += (double)(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                            a[2] * (b[0] * c[1] - b[1] * c[0]));
        }
    return six / 6;
}

static void check_net(float (*distance)(const float p[3]), double volume, int euler) {
    static float value[SIDE * SIDE * SIDE];
    static uint8_t inside[SIDE * SIDE * SIDE];
    const FfpNetGrid grid = {{SIDE, SIDE, SIDE}, value, inside};
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        // moved, so that no point lies on the surface
        const float p[3] = {STEP * (float)(i % SIDE) - 1.003F, STEP * (float)(i / SIDE % SIDE) - 1.001F,
                            STEP * (float)(i / SIDE / SIDE) - 1.002F};
        value[i] = distance(p);
        inside[i] = value[i] < 0;
    }
    FfpNetCells cells = ffp_net_cells(&grid);
    const int quads = ffp_net_count_quads(&grid);
    Net net = {.quads = ffp_alloc((size_t)quads, 4 * sizeof *net.quads)};
    float *at = ffp_alloc((size_t)cells.count, 3 * sizeof *at);
    for (int i = 0; i < cells.count; i++) {
        ffp_net_crossing(&grid, cells.cells + 3 * (size_t)i, at + 3 * (size_t)i);
        const float low[3] = {-1.003F, -1.001F, -1.002F};
        for (int k = 0; k < 3; k++) at[3 * i + k] = low[k] + STEP * at[3 * i + k];
        assert_true(fabsf(distance(at + 3 * (size_t)i)) < 0.15F * STEP);
    }
    ffp_net_connect(&grid, &cells, add, &net);
    assert_int_equal(net.n, quads);
    assert_int_equal(cells.count - check_closed(&net, cells.count) + net.n, euler);
    const double found = volume_of(&net, at);
    if (!(fabs(found / volume - 1) < 0.03)) fail_msg("a volume of %g, not %g", found, volume);
    ffp_free(net.quads);
    ffp_free(at);
    ffp_net_cells_free(&cells);
}

static void a_ball_is_closed_and_round(void **state) {
    (void)state;
    check_net(ball, 4.0 / 3 * 3.14159265 * 0.343, 2);
}

static void a_torus_has_a_hole(void **state) {
    (void)state;
    check_net(torus, 2 * 3.14159265 * 3.14159265 * 0.6 * 0.09, 0);
}

// Inside and outside by chance: what meets at corners or edges alone is joined.
static void noise_is_closed_once_it_is_repaired(void **state) {
    (void)state;
    enum { SMALL = 11 };
    static float value[SMALL * SMALL * SMALL];
    static uint8_t inside[SMALL * SMALL * SMALL];
    const FfpNetGrid grid = {{SMALL, SMALL, SMALL}, value, inside};
    FfpRng rng = ffp_rng(3, 0);
    int filled = 0;
    for (int i = 0; i < SMALL * SMALL * SMALL; i++) {
        const int x = i % SMALL, y = i / SMALL % SMALL, z = i / SMALL / SMALL;
        const bool edge = x < 2 || y < 2 || z < 2 || x > SMALL - 3 || y > SMALL - 3 || z > SMALL - 3;
        value[i] = edge ? 1 : ffp_rng_uniform(&rng) - 0.15F;
        inside[i] = value[i] < 0;
        filled -= inside[i];
    }
    ffp_net_repair(grid.size, value, inside, 1e-3F);
    for (int i = 0; i < SMALL * SMALL * SMALL; i++) {
        filled += inside[i];
        assert_true(inside[i] == (value[i] < 0));
    }
    assert_true(filled > 0);
    FfpNetCells cells = ffp_net_cells(&grid);
    Net net = {.quads = ffp_alloc((size_t)ffp_net_count_quads(&grid), 4 * sizeof *net.quads)};
    ffp_net_connect(&grid, &cells, add, &net);
    assert_true(check_closed(&net, cells.count) > 100);
    ffp_free(net.quads);
    ffp_net_cells_free(&cells);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_ball_is_closed_and_round),
                                       cmocka_unit_test(a_torus_has_a_hole),
                                       cmocka_unit_test(noise_is_closed_once_it_is_repaired)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
