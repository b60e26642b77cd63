// Where a module is not installed, what needs it says what to install, and leaves nothing behind; the rest
// works.
#include <unistd.h>
#include "program.h"

static ProgramRun run;

static void must_say(const char *arguments, const char *words) {
    run_program(&run, arguments);
    if (run.status != 1 || !strstr(run.err, words))
        fail_msg("%s: exit %d\n%s", arguments, run.status, run.err);
}

static char *in(const char *form) {
    static char lines[4][1024];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(lines[turn], sizeof lines[turn], form, scratch, scratch);
    return lines[turn];
}

static void what_is_missing_is_named(void **state) {
    (void)state;
    must_say(in("generate %s/scenes --preset smoke --count 1"), "ffprocams-world");
    must_say(in("train --out %s/run --steps 1"), "ffprocams-world");
    must_say(in("calibrate %s -o %s/rig.xml --board 9x6 --square 25 --projector 64x48"),
             "ffprocams-calibrate");
    assert_false(ffp_is_folder(in_scratch("scenes")) || ffp_is_folder(in_scratch("run")));
    run_program(&run, "info " FFP_SOURCE_DIR "/data/sample");
    assert_int_equal(run.status, 0);
}

// Embree is installed, Assimp is not.
static void meshes_need_a_module_of_their_own(void **state) {
    (void)state;
    char embree[FFP_PATH_MAX];
    snprintf(embree, sizeof embree, "%s", FFP_PROGRAM);
    snprintf(strrchr(embree, '/'), 64, "/libffprocams-embree.so");
    if (!ffp_is_file(embree)) skip();
    assert_int_equal(symlink(embree, in_scratch("libffprocams-embree.so")), 0);
    assert_true(ffp_write_file(in_scratch("a.obj"), "v 0 0 0\n", 8, NULL));
    must_say(in("generate %s/scenes --preset smoke --mesh %s/a.obj"), "libassimp-dev");
    run_program(&run, in("generate %s/scenes --preset smoke --resolution 16 --count 1"));
    if (run.status != 0) fail_msg("%s", run.err);
}

static int setup(void **state) {
    return scratch_setup(state) || setenv("FFPROCAMS_MODULES", scratch, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_missing_is_named),
                                       cmocka_unit_test(meshes_need_a_module_of_their_own)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
