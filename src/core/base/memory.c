#include "core/base/memory.h"
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GROUPS "/sys/fs/cgroup"

// The number behind `key` at the beginning of a line, or the file's first when key is "". Negative: none.
static double read_number(const char *path, const char *key) {
    char line[256];
    double number = -1;
    FILE *file = fopen(path, "r");
    if (!file) return -1;
    while (number < 0 && fgets(line, sizeof line, file)) {
        if (strncmp(line, key, strlen(key)) != 0) continue;
        char *end, *from = line + strlen(key);
        const double read = strtod(from, &end);
        if (end == from) break; // "max": no limit
        number = read;
    }
    fclose(file);
    return number;
}

static double in_group(const char *group, const char *file, const char *key) {
    char path[2 * PATH_MAX];
    snprintf(path, sizeof path, GROUPS "%s/%s", group, file);
    return read_number(path, key);
}

// Memory that the limit of a group leaves: its page cache can be given back. Negative: it has none.
static double left_in_group(const char *group) {
    const double most = in_group(group, "memory.max", ""), used = in_group(group, "memory.current", "");
    const double cache = in_group(group, "memory.stat", "inactive_file ");
    if (most < 0 || used < 0) return -1;
    const double left = most - used + (cache > 0 ? cache : 0);
    return left > 0 ? left : 0;
}

static double least_known(double a, double b) {
    if (a < 0 || b < 0) return a < 0 ? b : a;
    return a < b ? a : b;
}

// The process's own group and all above it.
static double left_in_groups(void) {
    char group[PATH_MAX] = "";
    FILE *file = fopen("/proc/self/cgroup", "r");
    if (!file) return -1;
    const bool found = fscanf(file, "0::%4095[^\n]", group) == 1;
    fclose(file);
    double least = -1;
    for (char *slash = found ? group + strlen(group) : NULL; slash; slash = strrchr(group, '/')) {
        *slash = 0;
        least = least_known(least, left_in_group(group));
    }
    return least;
}

double ffp_memory_available(void) {
    const double machine = read_number("/proc/meminfo", "MemAvailable:");
    return least_known(machine < 0 ? -1 : 1024 * machine, left_in_groups());
}

bool ffp_memory_suffices(double bytes, const char *what, const char *advice, const char *where,
                         FfpError *err) {
    const double left = ffp_memory_available();
    return left < 0 || bytes <= left ||
           ffp_fail(err, FFP_ERROR_MEMORY, where, "%s need %.1f GB of memory; this machine has %.1f left%s%s",
                    what, bytes / 1e9, left / 1e9, *advice ? ": " : "", advice);
}

double ffp_memory_mark(void) {
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file) return -1;
    const bool written = fputs("5", file) >= 0; // sets VmHWM to VmRSS
    if (fclose(file) != 0 || !written) return -1;
    return ffp_memory_peak();
}

double ffp_memory_peak(void) {
    const double peak = read_number("/proc/self/status", "VmHWM:");
    return peak < 0 ? -1 : 1024 * peak;
}
