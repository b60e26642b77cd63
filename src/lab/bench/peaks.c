// The machine's measured limits.
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/cpu.h"
#include "lab/bench/bench.h"
#include "lab/bench/kernels/peak.h"

static const FfpPeakKernels *const tables[FFP_CPU_LEVELS] = {
#define ENTRY(NAME, name, ...) [FFP_CPU_##NAME] = &ffp_##name##_peaks,
    FFP_EACH_LEVEL(ENTRY, ) //
};

enum { REPEATS = 12 };
#define ROUND_SECONDS 0.05

// GFLOP/s of all threads together: the best of several runs, each long enough for the clock.
static double measure(double (*loop)(int, float *)) {
    double best = 0;
    int rounds = 1000;
    for (int repeat = 0; repeat < REPEATS;) {
        double operations = 0;
        const double begin = omp_get_wtime();
#pragma omp parallel reduction(+ : operations)
        {
            float sink = 1e-3F;
            operations = loop(rounds, &sink);
            if (sink == 12345) abort(); // keeps the sums alive
        }
        const double took = omp_get_wtime() - begin;
        if (took < ROUND_SECONDS && rounds < 1 << 29) {
            rounds *= 2;
            continue;
        }
        if (operations / took > best) best = operations / took;
        repeat++;
    }
    return best * 1e-9;
}

static double measure_copy(void) {
    const size_t size = (size_t)256 << 20;
    char *from = ffp_alloc(size, 1), *to = ffp_alloc(size, 1);
    double best = 0;
    for (int repeat = 0; repeat < REPEATS / 2; repeat++) {
        const double begin = omp_get_wtime();
#pragma omp parallel
        {
            const size_t threads = (size_t)omp_get_num_threads(), me = (size_t)omp_get_thread_num();
            const size_t first = size / threads * me, end = me + 1 == threads ? size : first + size / threads;
            memcpy(to + first, from + first, end - first);
        }
        const double rate = 2e-9 * (double)size / (omp_get_wtime() - begin);
        if (repeat > 0 && rate > best) best = rate; // the first run pages the memory in
    }
    ffp_free(from);
    ffp_free(to);
    return best;
}

FfpPeaks ffp_bench_peaks(void) {
    const FfpPeakKernels *table = tables[ffp_cpu_level()];
    return (FfpPeaks){
        .products = measure(table->products), .fma = measure(table->fma), .copy = measure_copy()};
}
