// The benchmark measures: peaks in their order, every row timed, no share beyond what can be.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "lab/bench/bench.h"
#include "support.h"

static void counts_runs(void *data) {
    ++*(int *)data;
}

static void timing(void **state) {
    (void)state;
    int runs = 0;
    const double ms = ffp_bench_time(counts_runs, &runs, 5, 0);
    assert_int_equal(runs, 6); // one to warm up
    assert_true(ms >= 0 && ms < 1000);
}

static void table(void **state) {
    (void)state;
    FfpBenchTable table = {0};
    const FfpPeaks peaks = {.products = 100, .fma = 50, .copy = 10};
    for (int i = 0; i < 100; i++)
        ffp_bench_add(&table,
                      &(FfpBenchRow){.name = "row", .ms = i + 1, .bound = FFP_BOUND_COPY, .work = 1e6});
    assert_int_equal(table.count, 100);
    assert_true(fabs(ffp_bench_share(&table.rows[0], &peaks) - 0.1) < 1e-9); // 1 MB in 1 ms of 10 GB/s
    assert_true(fabs(table.rows[99].ms - 100) < 1e-9);
    ffp_free(table.rows);
}

static void kernels(void **state) {
    (void)state;
    const FfpPeaks peaks = ffp_bench_peaks();
    assert_true(peaks.fma > 0 && peaks.copy > 0 && peaks.products > 0);
    FfpBenchTable table = {0};
    ffp_bench_kernels(&table);
    assert_true(table.count > 10);
    for (int i = 0; i < table.count; i++) {
        const FfpBenchRow *row = &table.rows[i];
        assert_true(row->ms > 0 && row->work > 0);
        // Nothing multiplies faster than the registers; the rest is for a machine that was disturbed while
        // the peak was taken. Portable linear layers go to OpenBLAS, which has instructions of its own.
        if (row->bound == FFP_BOUND_PRODUCTS && ffp_cpu_level() != FFP_CPU_PORTABLE)
            assert_true(ffp_bench_share(row, &peaks) < 2);
    }
    ffp_free(table.rows);
}

// Told before anything is measured.
static void unwritable(void **state) {
    (void)state;
    FfpError err = {0};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    assert_false(ffp_bench(out, "/dev/null/bench.json", &err));
    assert_int_equal(fclose(out), 0);
    assert_int_equal(size, 0);
    assert_non_null(strstr(err.text, "/dev/null")); // no folder can be made there
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(timing), cmocka_unit_test(table),
                                       cmocka_unit_test(kernels), cmocka_unit_test(unwritable)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
