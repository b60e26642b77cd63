// How the GPU's benches take times.
#ifndef FFP_BENCH_GPU_TIMING_H
#define FFP_BENCH_GPU_TIMING_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/log.h"
#include "engine/cuda/cuda.h"

enum { GPU_REPEATS = 15, GPU_WARM = 3 };

static inline int gpu_ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// True if the device is the emulation, where only tiny sizes make sense.
static inline bool gpu_emulated(void) {
    return strstr(ffp_cuda_describe(), "emulated") != NULL;
}

typedef struct Bench Bench; // what a program works on, and its own

// Median seconds of one of `times` runs queued one behind the other, waited for together; warmed up. On the
// emulation one run.
static inline double gpu_seconds(void (*run)(Bench *), Bench *bench, int times) {
    const bool emulated = gpu_emulated();
    const int repeats = emulated ? 1 : GPU_REPEATS;
    double seconds[GPU_REPEATS];
    for (int i = 0; i < (emulated ? 1 : GPU_WARM); i++) run(bench);
    if (emulated) times = 1;
    for (int r = 0; r < repeats; r++) {
        ffp_device()->synchronise();
        const double begin = ffp_seconds();
        for (int i = 0; i < times; i++) run(bench);
        ffp_device()->synchronise();
        seconds[r] = (ffp_seconds() - begin) / times;
    }
    qsort(seconds, (size_t)repeats, sizeof *seconds, gpu_ascending);
    return seconds[repeats / 2];
}

// A line: milliseconds, and GB/s or TFLOP/s where the run moves `bytes` or does `operations` (0: unsaid).
static inline void gpu_report(const char *name, double seconds, double bytes, double operations) {
    printf("%-44s %9.4f ms", name, 1e3 * seconds);
    if (bytes > 0) printf(" %8.0f GB/s", bytes / seconds / 1e9);
    if (operations > 0) printf(" %8.2f TFLOP/s", operations / seconds / 1e12);
    printf("\n");
    fflush(stdout);
}

static inline void gpu_report_run(const char *name, Bench *bench, void (*run)(Bench *), int times,
                                  double bytes) {
    gpu_report(name, gpu_seconds(run, bench, times), bytes, 0);
}

// The device, in use from now on; NULL with a line on stderr.
static inline const FfpDevice *gpu_open(void) {
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (!device)
        fprintf(stderr, "%s\n", err.text);
    else
        ffp_device_use(device);
    return device;
}

#endif
