// `ffprocams bench`: everything measured, printed as a table and written as JSON.
#include <jansson.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/cpu.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "lab/bench/bench.h"

static double peak_of(FfpBound bound, const FfpPeaks *peaks) {
    return bound == FFP_BOUND_COPY ? peaks->copy : bound == FFP_BOUND_FMA ? peaks->fma : peaks->products;
}

// G operations or GB a second.
static double rate_of(const FfpBenchRow *row) {
    return row->work / row->ms * 1e-6;
}

double ffp_bench_share(const FfpBenchRow *row, const FfpPeaks *peaks) {
    return rate_of(row) / peak_of(row->bound, peaks);
}

static void print_table(FILE *out, const char *title, const FfpBenchTable *table, const FfpPeaks *peaks) {
    fprintf(out, "\n%-22s %-38s %9s %10s %7s %9s\n", title, "", "ms", "G/s", "share", "peak MB");
    for (int i = 0; i < table->count; i++) {
        const FfpBenchRow *row = &table->rows[i];
        fprintf(out, "%-22s %-38s %9.3f", row->name, row->shape, row->ms);
        if (row->work > 0)
            fprintf(out, " %6.0f %-3s %5.0f %%", rate_of(row), row->bound == FFP_BOUND_COPY ? "B" : "op",
                    100 * ffp_bench_share(row, peaks));
        else
            fprintf(out, " %10s %7s", "", "");
        if (row->peak_mb > 0) fprintf(out, " %9.0f", row->peak_mb);
        fprintf(out, "\n");
    }
}

static json_t *rows_of(const FfpBenchTable *table, const FfpPeaks *peaks, bool steps) {
    json_t *list = json_array();
    for (int i = 0; i < table->count; i++) {
        const FfpBenchRow *row = &table->rows[i];
        json_t *entry = json_pack("{ss ss sf}", "name", row->name, "shape", row->shape, "ms", row->ms);
        if (row->work > 0) {
            json_object_set_new(entry, row->bound == FFP_BOUND_COPY ? "gbs" : "gflops",
                                json_real(rate_of(row)));
            json_object_set_new(entry, "share", json_real(ffp_bench_share(row, peaks)));
        }
        if (steps && row->peak_mb > 0) json_object_set_new(entry, "peak_mb", json_real(row->peak_mb));
        json_array_append_new(list, entry);
    }
    return list;
}

static bool write_json(const char *path, const FfpPeaks *peaks, const FfpBenchTable *kernels,
                       const FfpBenchTable *steps, FfpError *err) {
    json_t *all = json_pack("{ss si s{sf sf sf} so so}", "cpu", ffp_cpu_name(ffp_cpu_level()), "threads",
                            omp_get_max_threads(), "peaks", "bf16_tile_gflops", peaks->products,
                            "fp32_fma_gflops", peaks->fma, "copy_gbs", peaks->copy, "kernels",
                            rows_of(kernels, peaks, false), "steps", rows_of(steps, peaks, true));
    char *text = json_dumps(all, JSON_INDENT(1) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(6));
    json_decref(all);
    if (!text) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    const bool ok = ffp_write_file(path, text, strlen(text), err);
    free(text);
    return ok;
}

bool ffp_bench(FILE *out, const char *json, FfpError *err) {
    FfpBenchTable kernels = {0}, steps = {0};
    if (!ffp_output_prepare(json, err)) return false;
    fprintf(out, "kernels for %s, %d threads\n", ffp_cpu_name(ffp_cpu_level()), omp_get_max_threads());
    const FfpPeaks peaks = ffp_bench_peaks();
    fprintf(out, "peaks: %.0f GFLOP/s in products, %.0f in fp32 multiply-adds, %.1f GB/s copied\n",
            peaks.products, peaks.fma, peaks.copy);
    ffp_note("measuring kernels");
    ffp_bench_kernels(&kernels);
    print_table(out, "kernel", &kernels, &peaks);
    ffp_note("measuring steps");
    ffp_bench_rasteriser(&steps);
    bool ok = ffp_bench_steps(&steps, err);
    if (ok) print_table(out, "step", &steps, &peaks);
    ok = ok && (!json || write_json(json, &peaks, &kernels, &steps, err));
    ffp_free(kernels.rows);
    ffp_free(steps.rows);
    return ok;
}
