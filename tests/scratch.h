// A folder of its own for a test program's files, below $FFP_SCRATCH or the current one. For
// cmocka_run_group_tests: scratch_setup and scratch_teardown.
#ifndef FFP_TESTS_SCRATCH_H
#define FFP_TESTS_SCRATCH_H

#include <unistd.h>
#include "core/base/file.h"
#include "support.h"

static char scratch[64];

static inline int scratch_setup(void **state) {
    (void)state;
    const char *above = getenv("FFP_SCRATCH");
    const int length = snprintf(scratch, sizeof scratch, "%s/scratch-XXXXXX", above ? above : "");
    if (length >= (int)sizeof scratch) return -1;
    if (!above) memmove(scratch, scratch + 1, (size_t)length); // relative
    return !mkdtemp(scratch);
}

static inline int scratch_teardown(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf -- '%s'", scratch);
    return system(command);
}

// The path of a file there; good until three more are asked for.
static inline const char *in_scratch(const char *name) {
    static char paths[4][FFP_PATH_MAX];
    static int turn = 0;
    turn = (turn + 1) % 4;
    assert_true(ffp_join_path(paths[turn], scratch, name));
    return paths[turn];
}

#endif
