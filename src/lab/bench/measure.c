// Rows of the result, and the time of what runs again and again.
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "lab/bench/bench.h"

void ffp_bench_add(FfpBenchTable *table, const FfpBenchRow *row) {
    if (table->count == table->room) {
        table->room = table->room ? 2 * table->room : 32;
        table->rows = ffp_grow(table->rows, (size_t)table->room, sizeof *table->rows);
    }
    table->rows[table->count++] = *row;
}

FfpBenchClock ffp_bench_clock = {ffp_seconds, false};

double ffp_bench_time(void (*run)(void *), void *data, int least, double seconds) {
    double best = 1e30;
    const FfpBenchClock clock = ffp_bench_clock;
    if (!clock.exact) run(data);
    const double start = clock.now();
    for (int i = 0; clock.exact ? i < 1 : i < least || clock.now() - start < seconds; i++) {
        const double begin = clock.now();
        run(data);
        const double took = clock.now() - begin;
        if (took < best) best = took;
    }
    return 1e3 * best;
}
