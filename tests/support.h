// Small helpers shared by the tests.
#ifndef FFP_TESTS_SUPPORT_H
#define FFP_TESTS_SUPPORT_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <cmocka.h>

// Path of a file below ../shared (or $FFP_SHARED) into out; 0 with a printed line when it is absent: the test
// should skip().
static inline int shared_path(char out[1024], const char *name) {
    const char *root = getenv("FFP_SHARED");
    snprintf(out, 1024, "%s/%s", root ? root : FFP_SOURCE_DIR "/../shared", name);
    struct stat info;
    if (stat(out, &info) == 0) return 1;
    printf("skipped: %s is not here\n", out);
    return 0;
}

// At the beginning of a test that goes the way of another with other numbers: under sanitizers everything
// takes ten times as long, and a second time they see nothing new.
#ifdef FFP_SANITIZED
#define SAME_WAY_AGAIN() skip()
#define TIMES(n, sanitized) (sanitized) // how often the same is done
#else
#define SAME_WAY_AGAIN() (void)0
#define TIMES(n, sanitized) (n)
#endif

#endif
