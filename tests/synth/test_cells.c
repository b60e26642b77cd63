// Cellular noise against what it is defined by: the distances to the nearest two of a set of points.
#include <math.h>
#include "support.h"
#include "synth/noise.h"

enum { SITES_MAX = 512, STEPS = 22 };

typedef struct Sites {
    int count;
    uint32_t id[SITES_MAX];
    double at[SITES_MAX][3];
} Sites;

// The distance falls by one a unit towards the cell's point: its slope leads there.
static void add_site(Sites *sites, const float p[3], uint32_t seed) {
    const FfpCells here = ffp_cells(p, seed);
    if (here.nearest < 0.1F) return; // too near for differences: another start will do
    for (int i = 0; i < sites->count; i++)
        if (sites->id[i] == here.id) return;
    double slope[3], length = 0;
    for (int a = 0; a < 3; a++) {
        float left[3] = {p[0], p[1], p[2]}, right[3] = {p[0], p[1], p[2]};
        left[a] -= 0.01F, right[a] += 0.01F;
        const FfpCells l = ffp_cells(left, seed), r = ffp_cells(right, seed);
        if (l.id != here.id || r.id != here.id) return; // the border is too near
        slope[a] = ((double)r.nearest - (double)l.nearest) / 0.02, length += slope[a] * slope[a];
    }
    assert_true(sites->count < SITES_MAX);
    sites->id[sites->count] = here.id;
    for (int a = 0; a < 3; a++)
        sites->at[sites->count][a] = (double)p[a] - (double)here.nearest * slope[a] / sqrt(length);
    sites->count++;
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
    for (int i = 0; i < 2000; i++) {
        const float p[3] = {0.8F * sinf((float)i), 0.8F * sinf(1.7F * (float)i),
                            0.8F * cosf(2.3F * (float)i)};
        const FfpCells cells = ffp_cells(p, seed);
        double nearest = 1e9, second = 1e9;
        uint32_t id = 0;
        for (int s = 0; s < sites.count; s++) {
            const double d = hypot(hypot((double)p[0] - sites.at[s][0], (double)p[1] - sites.at[s][1]),
                                   (double)p[2] - sites.at[s][2]);
            if (d < nearest)
                second = nearest, nearest = d, id = sites.id[s];
            else if (d < second)
                second = d;
        }
        assert_true(fabs((double)cells.nearest - nearest) < 5e-3);
        assert_true(fabs((double)cells.second - second) < 5e-3);
        if (second - nearest > 0.01) assert_int_equal(cells.id, id);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(distances_are_those_of_the_nearest_two)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
