// Small helpers shared by the tests.
#ifndef FFP_TESTS_SUPPORT_H
#define FFP_TESTS_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
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

// The larger of two errors, and no number once one of them is none, which then is below no bound: fmax would
// leave it out.
static inline double worse(double a, double b) {
    return a > b || a != a ? a : b;
}

// As cmocka's, which lets pass what is infinite or no number.
#undef assert_float_equal
#define assert_float_equal(a, b, epsilon)                                                                    \
    require_float((float)(a), (float)(b), (float)(epsilon), __FILE__, __LINE__)
static inline void require_float(float a, float b, float epsilon, const char *file, int line) {
    if (a - b <= epsilon && b - a <= epsilon) return;
    print_error("%g is not %g\n", (double)a, (double)b);
    _fail(file, line);
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
