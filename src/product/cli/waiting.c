// How OpenMP's threads wait for each other. By default libgomp's spin for some milliseconds: best on an idle
// machine, and on a busy one the way to make everybody, themselves first, wait for threads that only wait.
// The runtime reads its settings as it is loaded, so the program begins once more when they are to change.
#define _GNU_SOURCE // CPU_COUNT
#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include "cli.h"

#define POLICY "OMP_WAIT_POLICY"

enum { LOOKS = 3, PAUSE_NS = 500000 };

// A small file's text; "" where it is not there.
static void read_text(const char *path, char *text, size_t size) {
    text[0] = 0;
    FILE *file = fopen(path, "r");
    if (!file) return;
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
}

// Threads that want a processor now, this one among them (Linux, proc(5)); 0: not known.
static long runnable(void) {
    static char text[1 << 16]; // the line stands behind one for each processor
    read_text("/proc/stat", text, sizeof text);
    const char *line = strstr(text, "\nprocs_running ");
    return line ? strtol(line + strlen("\nprocs_running "), NULL, 10) : 0;
}

// Processors' worth of time that a container may use (cgroup v2, cpu.max); a large number: all.
static double quota(void) {
    char text[128], *end;
    read_text("/sys/fs/cgroup/cpu.max", text, sizeof text);
    const double most = strtod(text, &end), period = strtod(end, NULL);
    return end > text && most > 0 && period > 0 ? most / period : 1e9;
}

// Threads that the work will have.
static long own_threads(void) {
    cpu_set_t set;
    const char *wanted = getenv("OMP_NUM_THREADS");
    const long number = wanted ? strtol(wanted, NULL, 10) : 0;
    if (number > 0) return number;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : sysconf(_SC_NPROCESSORS_ONLN);
}

// True if others want the processors that the threads would fill. Looks more than once: who works may be
// waiting for something just then.
static bool is_busy(void) {
    const long processors = sysconf(_SC_NPROCESSORS_ONLN), threads = own_threads();
    if ((double)threads > quota()) return true;
    for (int look = 0; look < LOOKS; look++) {
        if (look > 0) nanosleep(&(struct timespec){.tv_nsec = PAUSE_NS}, NULL);
        if (runnable() - 1 + threads > processors) return true;
    }
    return false;
}

void ffp_cli_wait_passively(char **argv) {
    char own[PATH_MAX];
    if (getenv(POLICY) || getenv("GOMP_SPINCOUNT") || own_threads() < 2 || !is_busy()) return;
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length <= 0 || setenv(POLICY, "passive", 0) != 0) return;
    own[length] = 0;
    execv(own, argv); // where that fails the work is done as it is
    unsetenv(POLICY);
}
