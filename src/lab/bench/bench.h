// Measures kernels and whole steps against the limits of this machine (`ffprocams bench`).
#ifndef FFP_BENCH_BENCH_H
#define FFP_BENCH_BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "core/base/error.h"

// Measured on all threads of OpenMP at once.
typedef struct FfpPeaks {
    double products; // GFLOP/s of the instructions that products use at the CPU level in use: bf16 pairs or
                     // tiles from registers, otherwise the same as fma
    double fma;      // GFLOP/s of fp32 multiply-adds from registers
    double copy;     // GB/s read and written by copying arrays far larger than the caches
} FfpPeaks;
FfpPeaks ffp_bench_peaks(void);

typedef enum FfpBound { FFP_BOUND_PRODUCTS, FFP_BOUND_FMA, FFP_BOUND_COPY } FfpBound;

// One line of the result. Useful operations only: a multiply-add is two; an exponential, a division and a
// square root are one each. Where copying is the bound, `work` is the bytes that must be read and written.
typedef struct FfpBenchRow {
    const char *name;
    char shape[64];
    double ms; // the minimum of the repetitions
    FfpBound bound;
    double work;    // operations, or bytes
    double peak_mb; // of memory, of whole steps; 0: not measured
} FfpBenchRow;

typedef struct FfpBenchTable {
    FfpBenchRow *rows;
    int count, room;
} FfpBenchTable;
void ffp_bench_add(FfpBenchTable *table, const FfpBenchRow *row);

// Share of the peak that bounds the row, 0..1.
double ffp_bench_share(const FfpBenchRow *row, const FfpPeaks *peaks);

// The clock of all rows: by default ffp_seconds. bench/kernel_counts.c puts a counter of instructions in its
// place, which is exact: there is one run of everything then, of one set of splats.
typedef struct FfpBenchClock {
    double (*now)(void);
    bool exact;
} FfpBenchClock;
extern FfpBenchClock ffp_bench_clock;

// Runs `run` at least `least` times and for `seconds`, after one run to warm up; the least milliseconds.
double ffp_bench_time(void (*run)(void *), void *data, int least, double seconds);

// The kernels of the tensor room at the sizes of `small`, and one large product with its backward forms.
void ffp_bench_kernels(FfpBenchTable *table);
// Rasterising and shading of splats laid as the network lays them; then encoder, training step and
// reconstruction of `small`, fresh from its initialisation, on a made-up scene. Errors: the scene's.
void ffp_bench_rasteriser(FfpBenchTable *table);
bool ffp_bench_steps(FfpBenchTable *table, FfpError *err);

// Measures everything, writes tables for people to `out`, and as JSON to a file unless `json` is NULL.
bool ffp_bench(FILE *out, const char *json, FfpError *err);

#endif
