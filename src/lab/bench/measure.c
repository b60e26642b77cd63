// Rows of the result, and the time of what runs again and again.
#include <omp.h>
#include "core/base/alloc.h"
#include "lab/bench/bench.h"

void ffp_bench_add(FfpBenchTable *table, const FfpBenchRow *row) {
    if (table->count == table->room) {
        table->room = table->room ? 2 * table->room : 32;
        table->rows = ffp_grow(table->rows, (size_t)table->room, sizeof *table->rows);
    }
    table->rows[table->count++] = *row;
}

double ffp_bench_time(void (*run)(void *), void *data, int least, double seconds) {
    double best = 1e30;
    run(data);
    const double start = omp_get_wtime();
    for (int i = 0; i < least || omp_get_wtime() - start < seconds; i++) {
        const double begin = omp_get_wtime();
        run(data);
        const double took = omp_get_wtime() - begin;
        if (took < best) best = took;
    }
    return 1e3 * best;
}
