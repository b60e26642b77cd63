// Help, version, and wrong usage.
#include "base/cpu.h"
#include "cli/program.h"

static const char *const commands[] = {"reconstruct", "render", "evaluate",   "generate", "train", "bench",
                                       "info",        "import", "compensate", "map",      "refine"};
static ProgramRun run;

static void test_help_of_the_program_names_every_command(void **state) {
    (void)state;
    run_program(&run, "--help");
    assert_int_equal(run.status, 0);
    assert_string_equal(run.err, "");
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        assert_non_null(strstr(run.out, commands[i]));
}

static void test_every_command_has_help_with_an_example(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        char arguments[64], usage[64];
        snprintf(arguments, sizeof arguments, "%s --help", commands[i]);
        snprintf(usage, sizeof usage, "usage: ffprocams %s ", commands[i]);
        run_program(&run, arguments);
        assert_int_equal(run.status, 0);
        assert_string_equal(run.err, "");
        assert_int_equal(strncmp(run.out, usage, strlen(usage)), 0);
        assert_non_null(strstr(run.out, "example: ffprocams "));
    }
}

static void test_version(void **state) {
    (void)state;
    run_program(&run, "--version");
    assert_int_equal(run.status, 0);
    assert_string_equal(run.out, "ffprocams " FFP_VERSION "\n");
}

static void test_wrong_usage_exits_2_and_says_where_to_read(void **state) {
    (void)state;
    static const char *const wrong[] = {
        "frobnicate",
        "reconstruct",
        "reconstruct capture",
        "reconstruct a b -o c.ply",
        "reconstruct a -o",
        "reconstruct a -o b.ply --frobnicate",
        "reconstruct a -o b.ply --polish some",
        "reconstruct a -o b.ply --noise nan",
        "reconstruct a -o b.ply --noise 1",
        "evaluate a --noise -0.01",
        "evaluate a --noise 0.01x",
        "reconstruct a -o b.ply --layers 0",
        "reconstruct a -o b.ply --device tpu",
        "evaluate a --device gpu",
        "train --out a --device 0",
        "evaluate a --layers some",
        "render",
        "render a.ply",
        "render a.ply --capture b",
        "render a.ply --capture b -o c --drawing bright",
        "evaluate",
        "evaluate a --predictor luck",
        "evaluate a --model none --predictor depth",
        "evaluate a b --gaussians c.ply",
        "evaluate a --show-pattern b.png",
        "evaluate a b c --targets x --targets y",
        "generate",
        "generate a b",
        "generate a --count many",
        "generate a --count 0",
        "generate a --split some",
        "generate a --preset large",
        "generate a --rig round",
        "generate a --views 0",
        "generate a --views 65",
        "generate a --resolution 99999999999999999999",
        "train",
        "train --out a b",
        "train --out a --steps -3",
        "train --out a --steps 10x",
        "train --out a --resume --initial b",
        "train --out a --resume --config b",
        "info",
        "info a b",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        run_program(&run, wrong[i]);
        if (run.status != 2) printf("%s: exit %d\n%s", wrong[i], run.status, run.err);
        assert_int_equal(run.status, 2);
        assert_int_equal(strncmp(run.err, "ffprocams: error: ", 18), 0);
        assert_non_null(strstr(run.err, "--help"));
        assert_string_equal(run.out, "");
    }
    run_program(&run, "");
    assert_int_equal(run.status, 2);
}

static void test_output_that_cannot_be_written_is_an_error(void **state) {
    (void)state;
    char command[1024];
    snprintf(command, sizeof command, "'%s' --help >/dev/full 2>%s.err", FFP_PROGRAM, scratch);
    const int status = system(command);
    assert_int_equal(status >> 8 & 0xff, 1);
    snprintf(command, sizeof command, "%s.err", scratch);
    read_text(command, run.err, sizeof run.err);
    assert_string_equal(run.err, "ffprocams: error: cannot write (standard output)\n");
}

static void test_kernels_that_cannot_run_here_are_an_error(void **state) {
    (void)state;
    setenv("FFPROCAMS_CPU", "sse9", 1);
    run_program(&run, "info nothing");
    unsetenv("FFPROCAMS_CPU");
    assert_int_equal(run.status, 1);
    assert_string_equal(run.err, "ffprocams: error: sse9 is none of portable, avx2, avx512, avx512bf16, amx "
                                 "(FFPROCAMS_CPU)\n");
    if (ffp_cpu_best() == FFP_CPU_AMX) return;
    setenv("FFPROCAMS_CPU", "amx", 1);
    run_program(&run, "info nothing");
    unsetenv("FFPROCAMS_CPU");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "cannot run amx"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_help_of_the_program_names_every_command),
        cmocka_unit_test(test_every_command_has_help_with_an_example),
        cmocka_unit_test(test_version),
        cmocka_unit_test(test_wrong_usage_exits_2_and_says_where_to_read),
        cmocka_unit_test(test_output_that_cannot_be_written_is_an_error),
        cmocka_unit_test(test_kernels_that_cannot_run_here_are_an_error),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
