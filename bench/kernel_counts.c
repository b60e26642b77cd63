// Instructions of the kernels that `ffprocams bench` times, in millions, at the level of FFPROCAMS_CPU
// (script/test-arm --count).
//   kernel_counts COUNTER     the file in which bench/instructions.c counts while this runs
// Prints lines: million instructions, the kernel, its shape. One thread: the counter has no other.
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "lab/bench/bench.h"

static const volatile uint64_t *executed;

// In units that make the benches' milliseconds million instructions.
static double counted(void) {
    return 1e-9 * (double)*executed;
}

static bool map_counter(const char *path, FfpError *err) {
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    void *at = file < 0 ? MAP_FAILED : mmap(NULL, sizeof *executed, PROT_READ, MAP_SHARED, file, 0);
    if (file >= 0) close(file);
    if (at == MAP_FAILED) return ffp_fail(err, FFP_ERROR_FILE, path, "no counter");
    executed = at;
    return *executed > 0 || ffp_fail(err, FFP_ERROR_FILE, path, "nothing counts here");
}

int main(int argc, char **argv) {
    FfpError err = {0};
    FfpBenchTable table = {0};
    if (argc != 2) {
        fputs("usage: kernel_counts COUNTER\n", stderr);
        return 2;
    }
    const bool ok = ffp_cpu_check(&err) && map_counter(argv[1], &err);
    if (ok) {
        ffp_bench_clock = (FfpBenchClock){counted, true};
        ffp_bench_kernels(&table);
        ffp_bench_rasteriser(&table);
    }
    for (int i = 0; i < table.count; i++)
        printf("%9.1f  %-20s %s\n", table.rows[i].ms, table.rows[i].name, table.rows[i].shape);
    ffp_free(table.rows);
    if (!ok) fprintf(stderr, "kernel_counts: error: %s\n", err.text);
    return !ok;
}
