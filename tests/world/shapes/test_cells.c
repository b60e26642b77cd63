// Cellular noise against what it is defined by: the distances to the nearest two of a set of points.
#include <math.h>
#include "core/base/cpu.h"
#include "support.h"
#include "world/shapes/noise.h"

enum { SITES_MAX = 512, STEPS = 22 };

typedef struct Sites {
    int count;
    uint32_t id[SITES_MAX];
    double at[SITES_MAX][3];
} Sites;

static double distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

// The distance falls by one per unit towards the cell's point, to which its slope points. Two cells may share
// an id.
static void add_site(Sites *sites, const float p[3], uint32_t seed) {
    const FfpCells here = ffp_cells(p, seed);
    if (here.nearest < 0.1F) return; // too near for differences: another start will do
    double slope[3], at[3], length = 0;
    for (int a = 0; a < 3; a++) {
        float left[3] = {p[0], p[1], p[2]}, right[3] = {p[0], p[1], p[2]};
        left[a] -= 0.01F, right[a] += 0.01F;
        const FfpCells l = ffp_cells(left, seed), r = ffp_cells(right, seed);
        if (l.id != here.id || r.id != here.id) return; // the border is too near
        slope[a] = ((double)r.nearest - (double)l.nearest) / 0.02, length += slope[a] * slope[a];
    }
    for (int a = 0; a < 3; a++) at[a] = (double)p[a] - (double)here.nearest * slope[a] / sqrt(length);
    for (int i = 0; i < sites->count; i++)
        if (sites->id[i] == here.id && distance(sites->at[i], at) < 0.1) return;
    assert_true(sites->count < SITES_MAX);
    sites->id[sites->count] = here.id;
    memcpy(sites->at[sites->count++], at, sizeof at);
}

static void distances_are_those_of_the_nearest_two(void **state) {
    (void)state;
    const uint32_t seed = 41;
    Sites sites = {0};
    for (int i = 0; i < STEPS * STEPS * STEPS; i++) {
        const int x = i % STEPS, y = i / STEPS % STEPS, z = i / STEPS / STEPS;
        const float p[3] = {0.231F * (float)x - 2.5F, 0.231F * (float)y - 2.5F, 0.231F * (float)z - 2.5F};
        add_site(&sites, p, seed);
    }
    assert_true(sites.count > 60); // one a unit cube, and 5^3 cubes
    int compared = 0;
    for (int i = 0; i < 2000; i++) {
        const float p[3] = {0.8F * sinf((float)i), 0.8F * sinf(1.7F * (float)i),
                            0.8F * cosf(2.3F * (float)i)};
        const FfpCells cells = ffp_cells(p, seed);
        double nearest = 1e9, second = 1e9;
        uint32_t id = 0;
        for (int s = 0; s < sites.count; s++) {
            const double d = distance((double[3]){p[0], p[1], p[2]}, sites.at[s]);
            if (d < nearest)
                second = nearest, nearest = d, id = sites.id[s];
            else if (d < second)
                second = d;
        }
        // beyond one unit a point may lie outside of the 27 cubes
        if (nearest < 1) assert_true(fabs((double)cells.nearest - nearest) < 5e-3);
        if (second < 1) assert_true(fabs((double)cells.second - second) < 5e-3);
        if (second < 1 && second - nearest > 0.01) assert_int_equal(cells.id, id);
        compared += second < 1;
    }
    assert_true(compared > 1000);
}

// Each CPU level gives what the portable one gives, but for rounding.
static void levels_agree(void **state) {
    (void)state;
    const FfpCpuLevel used = ffp_cpu_level();
    for (int i = 0; i < 500; i++) {
        const float p[3] = {4 * sinf((float)i), 4 * sinf(1.7F * (float)i), 4 * cosf(2.3F * (float)i)};
        float plain[5] = {0};
        for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
            assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
            const FfpCells cells = ffp_cells(p, 5);
            const float values[5] = {ffp_noise(p, 3), ffp_fbm(p, 4, 4), ffp_ridges(p, 4, 3), cells.nearest,
                                     cells.second};
            for (int k = 0; k < 5; k++) {
                if (level == 0) plain[k] = values[k];
                assert_float_equal(values[k], plain[k], 1e-4F);
            }
        }
    }
    assert_true(ffp_cpu_set_level(used));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(distances_are_those_of_the_nearest_two),
                                       cmocka_unit_test(levels_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
