// A machine that says of itself that it has little memory left: src/core/base/memory.c asks a file of the
// test's.
#ifndef FFP_TESTS_SHORT_OF_MEMORY_H
#define FFP_TESTS_SHORT_OF_MEMORY_H

#include <fcntl.h>
#include "scratch.h"

static const char *meminfo; // in place of the system's; NULL: that

// In place of the C library's, for what is linked into this program.
FILE *fopen(const char *restrict filename, const char *restrict modes) {
    const int how = *modes == 'r' ? O_RDONLY : O_WRONLY | O_CREAT | (*modes == 'a' ? O_APPEND : O_TRUNC);
    const bool ours = meminfo && strcmp(filename, "/proc/meminfo") == 0;
    const int fd = openat(AT_FDCWD, ours ? meminfo : filename, how, 0666);
    return fd >= 0 ? fdopen(fd, modes) : NULL;
}

static inline void leave_memory(const char *kilobytes) {
    static char path[FFP_PATH_MAX];
    char text[64];
    snprintf(text, sizeof text, "MemTotal: 99999999 kB\nMemAvailable: %s kB\n", kilobytes);
    assert_true(ffp_join_path(path, scratch, "meminfo"));
    assert_true(ffp_write_file(path, text, strlen(text), NULL));
    meminfo = path;
}

#endif
