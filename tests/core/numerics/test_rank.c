// Ranks, medians and quantiles against sorted values: few and many, equal ones, infinite ones.
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include "core/base/rng.h"
#include "core/numerics/rank.h"
#include "support.h"

enum { MOST = 300 };

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// `kinds` different values, so that few of them are all alike; every seventh is infinite if asked for.
static void fill(double *values, float *floats, int n, int kinds, bool infinite, FfpRng *rng) {
    for (int i = 0; i < n; i++) {
        floats[i] = (float)ffp_rng_below(rng, (uint32_t)kinds) / 8;
        if (infinite && i % 7 == 3) floats[i] = INFINITY;
        values[i] = (double)floats[i];
    }
}

static void ranks_are_those_of_sorted_values(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(9, 0);
    double values[MOST], sorted[MOST];
    float floats[MOST];
    for (int round = 0; round < 2000; round++) {
        const int n = 1 + (int)ffp_rng_below(&rng, MOST - 1), rank = (int)ffp_rng_below(&rng, (uint32_t)n);
        fill(values, floats, n, round % 3 == 0 ? 2 : 10000, round % 5 == 0, &rng);
        memcpy(sorted, values, sizeof sorted);
        qsort(sorted, (size_t)n, sizeof *sorted, ascending);
        assert_true(ffp_rank(values, (size_t)n, (size_t)rank) == sorted[rank]);
        assert_true((double)ffp_rank(floats, (size_t)n, (size_t)rank) == sorted[rank]);
        assert_true(ffp_median(values, (size_t)n) == sorted[n / 2]);
        assert_true((double)ffp_median(floats, (size_t)n) == sorted[n / 2]);
        assert_true(ffp_quantile(values, (size_t)n, 0.9) == sorted[(int)(0.9 * (n - 1))]);
        assert_true(ffp_quantile(values, (size_t)n, 1.0) == sorted[n - 1]);
        qsort(values, (size_t)n, sizeof *values, ascending); // nothing is lost
        assert_memory_equal(values, sorted, (size_t)n * sizeof *values);
    }
}

static void nothing_has_the_median_zero(void **state) {
    (void)state;
    double none = 7;
    assert_true(ffp_median(&none, 0) == 0 && ffp_quantile(&none, 0, 0.5) == 0);
}

static void what_is_no_number_leads_nowhere(void **state) {
    (void)state;
    double values[9] = {NAN, 3, NAN, 1, NAN, NAN, 2, 5, NAN};
    for (size_t rank = 0; rank < 9; rank++) ffp_rank(values, (size_t)9, rank);
    int numbers = 0;
    for (int i = 0; i < 9; i++) numbers += isfinite(values[i]);
    assert_int_equal(numbers, 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(ranks_are_those_of_sorted_values),
                                       cmocka_unit_test(nothing_has_the_median_zero),
                                       cmocka_unit_test(what_is_no_number_leads_nowhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
