// Common code of benches that take turns with other programs (bench/peers): work that is done and timed once
// for every line that is read.
#ifndef FFP_BENCH_ON_REQUEST_H
#define FFP_BENCH_ON_REQUEST_H

#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "core/base/file.h"

// A moment: seconds of the process's processor time, of all its threads, and of wall clock.
typedef struct Moment {
    double processor, wall;
} Moment;

static inline Moment moment_now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (Moment){(double)time.tv_sec + 1e-9 * (double)time.tv_nsec, omp_get_wtime()};
}

// Both seconds since then, and what follows them on the line.
static inline void print_since(const Moment *then, char behind) {
    const Moment now = moment_now();
    printf("%.6f %.6f%c", now.processor - then->processor, now.wall - then->wall, behind);
}

typedef struct Requests {
    void *work;
    void (*run)(void *work);                    // does the work once and prints its seconds, one line
    void (*write)(const void *work, FILE *out); // the last run's results
} Requests;

static inline bool write_results(const Requests *r, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    r->write(r->work, out.stream);
    return ffp_output_commit(&out, err);
}

// Answers lines until there are no more: `run` by what run prints, `write FILE` by "written".
static inline bool serve(const Requests *r, FfpError *err) {
    char line[4096];
    while (fflush(stdout) == 0 && fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        if (strcmp(line, "run") == 0) {
            r->run(r->work);
        } else if (strncmp(line, "write ", 6) == 0) {
            if (!write_results(r, line + 6, err)) return false;
            puts("written");
        } else {
            return ffp_fail(err, FFP_ERROR_ARGUMENT, line, "neither `run` nor `write FILE`");
        }
    }
    return true;
}

#endif
