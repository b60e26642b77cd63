// Help, version, and wrong usage.
#include <glob.h>
#include "core/base/cpu.h"
#include "product/cli/program.h"

enum { COMMANDS_MAX = 64 };
static char commands[COMMANDS_MAX][32]; // those that a file of the program's sources defines
static int n_commands;
static ProgramRun run;

// The names of the commands that a file defines: they stand first in each.
static void add_commands_of(const char *path) {
    static const char definition[] = "\nconst FfpCommand ffp_cli_", name[] = ".name = \"";
    char *text;
    size_t size;
    FfpError err = {0};
    if (!ffp_read_file(path, 1 << 20, &text, &size, &err)) fail_msg("%s", err.text);
    for (const char *at = text; (at = strstr(at, definition)); n_commands++) {
        assert_true(n_commands < COMMANDS_MAX);
        assert_non_null(at = strstr(at, name));
        assert_int_equal(sscanf(at + strlen(name), "%31[a-z]\"", commands[n_commands]), 1);
    }
    ffp_free(text);
}

static int group_setup(void **state) {
    glob_t files;
    if (scratch_setup(state) != 0 || glob(FFP_SOURCE_DIR "/src/product/cli/*.c", 0, NULL, &files) != 0)
        return -1;
    for (size_t i = 0; i < files.gl_pathc; i++) add_commands_of(files.gl_pathv[i]);
    globfree(&files);
    return n_commands < 16;
}

static void test_help_of_the_program_names_every_command(void **state) {
    (void)state;
    static const char *const groups[] = {"\nmake a capture:\n  studio ", "\nreconstruct:\n  reconstruct ",
                                         "\nlook:\n  render ",           "\nproject:\n  compensate ",
                                         "\nevaluate:\n  evaluate ",     "\ntrain:\n  generate "};
    run_program(&run, "--help");
    assert_int_equal(run.status, 0);
    assert_string_equal(run.err, "");
    const char *end = strstr(run.out, "\n  -"); // options
    assert_non_null(end);
    int named = 0;
    for (const char *at = run.out; (at = strstr(at, "\n  ")) && at < end; at++)
        named += at[3] >= 'a' && at[3] <= 'z';
    assert_int_equal(named, n_commands);
    for (int i = 0; i < n_commands; i++) {
        char line[64];
        snprintf(line, sizeof line, "\n  %.31s ", commands[i]);
        assert_non_null(strstr(run.out, line));
    }
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) assert_non_null(strstr(run.out, groups[i]));
    const char *look = strstr(run.out, "\nlook:\n"); // a heading for all commands of its group
    assert_null(strstr(look + 1, "\nlook:\n"));
}

static void check_same(const char *asked, const char *usual) {
    static ProgramRun other;
    run_program(&other, usual);
    run_program(&run, asked);
    assert_int_equal(run.status, 0);
    assert_string_equal(run.err, "");
    assert_string_equal(run.out, other.out);
}

static void test_help_is_a_word_too(void **state) {
    (void)state;
    check_same("help", "--help");
    check_same("help import", "import --help");
    run_program(&run, "help imprt");
    assert_int_equal(run.status, 2);
    assert_non_null(strstr(run.err, "did you mean import?"));
}

// It begins with a sentence and ends with examples, and no line is wider than a terminal.
static void check_help(const char *command) {
    char usage[64], example[64];
    snprintf(usage, sizeof usage, ".\n\nusage: ffprocams %.31s", command);
    snprintf(example, sizeof example, "\n  ffprocams %.31s ", command);
    const char *first_line = strchr(run.out, '\n');
    assert_non_null(first_line);
    assert_true(run.out[0] >= 'A' && run.out[0] <= 'Z');
    assert_int_equal(strncmp(first_line - 1, usage, strlen(usage)), 0);
    const char *examples = strstr(run.out, "\nexample");
    assert_non_null(examples);
    assert_non_null(strstr(examples, example));
    assert_null(strstr(examples, "\n  -")); // no options behind them
    for (const char *line = run.out; *line; line += strcspn(line, "\n") + 1) {
        if (strcspn(line, "\n") > 100) printf("%s: %s\n", command, line);
        assert_true(strcspn(line, "\n") <= 100);
    }
}

static void test_every_command_has_help_with_an_example(void **state) {
    (void)state;
    for (int i = 0; i < n_commands; i++) {
        char arguments[64];
        snprintf(arguments, sizeof arguments, "%.31s --help", commands[i]);
        run_program(&run, arguments);
        assert_int_equal(run.status, 0);
        assert_string_equal(run.err, "");
        check_help(commands[i]);
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
        "render a.ply --capture b -o c --intensity inf",
        "render a.ply --capture b -o ''",
        "render '' --capture b -o c",
        "evaluate a ''",
        "evaluate a --targets ''",
        "render a.ply --capture b -o c --intensity 1,2",
        "reconstruct a -o b.ply --noise 0x0",
        "view",
        "view a.ply",
        "view a.ply --capture b",
        "view a.ply --capture b -o c --photographs 5000",
        "evaluate a --viewer b.html",
        "evaluate",
        "evaluate a --predictor luck",
        "evaluate a --model none --predictor depth",
        "evaluate a b --gaussians c.ply",
        "evaluate a --show-pattern b.png",
        "evaluate a b c --targets x --targets y",
        "generate",
        "generate a b",
        "generate a --count many",
        "generate a --photographs",
        "generate a --photographs b --attitudes 65",
        "train --out a --captures",
        "train --out a --captures b --resume",
        "generate a --count 0",
        "generate a --split some",
        "generate a --preset large",
        "refine a -c b -o c --checkpoint d",
        "generate a --rig round",
        "generate a --views 0",
        "generate a --sensor read",
        "generate a --sensor read=",
        "generate a --sensor read=1x",
        "generate a --sensor rea=1",
        "generate a --sensor =1",
        "generate a --sensor reads=1",
        "generate a --views 361",
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

// Messages name the mistake, and what was probably meant.
static void test_mistakes_are_told_as_what_they_are(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *message;
    } wrong[] = {
        {"recnostruct a -o b.ply", "unknown command recnostruct: did you mean reconstruct?"},
        {"recon a", "unknown command recon: did you mean reconstruct?"},
        {"halp", "unknown command halp: did you mean --help?"},
        {"--verison", "unknown option --verison: did you mean --version?"},
        {"xylophone", "unknown command xylophone\n"},
        {"render a --capture b -o c --patern d", "unknown option --patern: did you mean --pattern?"},
        {"reconstruct a -output b", "unknown option -output: did you mean --output?"},
        {"import --projector a", "ambiguous option --projector: --projector-image or --projector-size"},
        {"render a --maps=yes", "--maps takes no value"},
        {"render a -q", "unknown option -q"},
        {"generate -o scenes", "unknown option -o: DIR stands alone, ffprocams generate DIR"},
        {"generate --output=scenes", "unknown option --output: DIR stands alone"},
        {"bench -o x", "unknown option -o"},
        {"render a -c b -o sub/relit.PNG",
         "--output is a folder for all pictures, not one picture: 'sub/relit'?"},
        {"reconstruct a -o", "--output needs a value: FILE.ply"},
        {"reconstruct a", "-o, --output FILE.ply is missing"},
        {"map a -o b", "-c, --capture CAPTURE is missing"},
        {"reconstruct a -o ''", "--output needs a value: FILE.ply"},
        {"reconstruct '' -o a", "CAPTURE is empty"},
        {"render a -c b -o c --samples=", "--samples needs a value: N"},
        {"render a -c b -o c --rate 3", "--rate requires --video"},
        {"generate a --attitudes 4", "--attitudes requires --photographs"},
        {"generate a --patterns b --photographs c", "--patterns cannot be combined with --photographs"},
        {"generate a --material b --materials c", "--materials cannot be combined with --material"},
        {"export a -o b --resolution 64", "--resolution requires --mesh"},
        {"export a -o b --camera-view c", "--camera-view requires --light"},
        {"export a -o b --projector-view c", "--projector-view requires --light"},
        {"evaluate a --show-pattern b", "--show-pattern requires --report"},
        {"calibrate a --board 9x6 --square 1 --angles 1,2", "--angles requires --turntable-board"},
        {"compensate a -c b -v 0 -t x -o c -g 2 --paint", "--gain cannot be combined with --paint"},
        {"align a -p b -p c -o d", "--pattern may be given only once"},
        {"render a --capture b -c b -o c", "--capture may be given only once"},
        {"compensate a -c b -v 0 -t x -g 1 --gain auto -o c", "--gain may be given only once"},
        {"train --out a --resume -r", "--resume may be given only once"},
        {"render a --samples 5", "--samples takes a number from 1 to 4, not '5'"},
        {"render a --rate 1.5", "--rate takes a number from 1 to 1000, not '1.5'"},
        {"refine a --seed -1", "--seed takes a number of at least 0, not '-1'"},
        {"refine a --noise 0.3", "--noise takes auto or a number from 0 to 0.2, not '0.3'"},
        {"reconstruct a --polish x", "--polish takes auto or a number of steps from 0 to 1000000, not 'x'"},
        {"reconstruct a --layers 0.4", "--layers takes auto, all or a number from 0.5 to 100, not '0.4'"},
        {"render a --drawing oil", "--drawing takes ours, paper or gs-procams, not 'oil'"},
        {"view a --drawing gs-procams", "--drawing takes ours or paper, not 'gs-procams'"},
        {"render a --orbit moon,4", "--orbit takes camera, projector or object and 1 to 9999 frames"},
        {"generate a --preset big", "--preset takes paper, smoke or training, not 'big'"},
        {"generate a --resolution 7", "--resolution takes a number from 8 to 4096, not '7'"},
        {"import --camera-size 640", "--camera-size takes width x height in pixels (1024x768), not '640'"},
        {"import -c a -o b c.jpg", "unexpected argument c.jpg: --images NAMES=FILES?"},
        {"info a b", "give exactly one FILE: unexpected argument b"},
        {"bench a", "unexpected argument a"},
        {"refine -c a -o b", "give exactly one FILE.ply"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        run_program(&run, wrong[i].arguments);
        const bool told = strncmp(run.err, "ffprocams: error: ", 18) == 0 &&
                          strncmp(run.err + 18, wrong[i].message, strlen(wrong[i].message)) == 0;
        if (run.status != 2 || !told) printf("%s: exit %d\n%s", wrong[i].arguments, run.status, run.err);
        assert_int_equal(run.status, 2);
        assert_true(told);
    }
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
    const char *highest = ffp_cpu_name((FfpCpuLevel)(FFP_CPU_LEVELS - 1));
    char end[64], refusal[64];
    snprintf(end, sizeof end, " or %s (FFPROCAMS_CPU)\n", highest);
    snprintf(refusal, sizeof refusal, "cannot run %s", highest);
    assert_non_null(strstr(run.err, "ffprocams: error: invalid value sse9: expected portable"));
    assert_non_null(strstr(run.err, end));
    if (ffp_cpu_best() == FFP_CPU_LEVELS - 1) return;
    setenv("FFPROCAMS_CPU", highest, 1);
    run_program(&run, "info nothing");
    unsetenv("FFPROCAMS_CPU");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, refusal));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_help_of_the_program_names_every_command),
        cmocka_unit_test(test_help_is_a_word_too),
        cmocka_unit_test(test_every_command_has_help_with_an_example),
        cmocka_unit_test(test_version),
        cmocka_unit_test(test_wrong_usage_exits_2_and_says_where_to_read),
        cmocka_unit_test(test_mistakes_are_told_as_what_they_are),
        cmocka_unit_test(test_output_that_cannot_be_written_is_an_error),
        cmocka_unit_test(test_kernels_that_cannot_run_here_are_an_error),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
