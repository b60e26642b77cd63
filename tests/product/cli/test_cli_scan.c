// Labels: slow
// `ffprocams scan`: a generated scene, photographed from three places of a camera, and an object on a
// turntable, from photographs to the page by one line. Folders have names that a shell would take apart.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include "product/cli/program.h"

#define OUT "it's \"one\" walk"
#define QUOTED "'%s/it'\\''s \"one\" walk'" // of scratch

static ProgramRun run;
static char typed[32][2048]; // the commands that a run printed
static int n_typed;

static int setup(void **state) {
    if (scratch_setup(state) != 0 || run_format(&run, "patterns -o %s/p --projector 160x100", scratch) != 0)
        return -1;
    return run_format(&run,
                      "generate '%s/my shots' --photographs %s/p --rig walk --views 3 --split test --first 1 "
                      "--resolution 96 --preset smoke",
                      scratch, scratch) ||
           run_format(&run,
                      "generate %s/table --photographs %s/p --attitudes 0 --views 8 --seed 1 --split test "
                      "--first 15 "
                      "--resolution 96 --preset smoke",
                      scratch, scratch);
}

// Splits the run's text into the commands in it, without those that a step advises.
static void take_commands(void) {
    n_typed = 0;
    bool advised = false;
    for (char *line = strtok(run.out, "\n"); line; line = strtok(NULL, "\n")) {
        if (!advised && (strncmp(line, "ffprocams ", 10) == 0 || strncmp(line, "mkdir ", 6) == 0))
            snprintf(typed[n_typed++], sizeof typed[0], "%s", line);
        advised = strcmp(line, "now run") == 0;
    }
}

static int paste(const char *command) {
    static char line[sizeof run.err + 256];
    snprintf(line, sizeof line, "ffprocams() { '%s' \"$@\"; }; %s >/dev/null 2>&1", FFP_PROGRAM, command);
    return system(line);
}

static void check_steps(const char *const *steps, int n) {
    assert_int_equal(n_typed, n);
    for (int i = 0; i < n; i++)
        if (strncmp(typed[i], steps[i], strlen(steps[i])) != 0)
            fail_msg("%s is not '%s...'", typed[i], steps[i]);
}

static void check_results(void) {
    static const char *const names[] = {"calibration/cameras.txt", "capture/scene.json", "object.ply",
                                        "object.html", "report.html"};
    char path[256];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, OUT "/%s", names[i]);
        if (!ffp_is_file(in_scratch(path))) fail_msg("%s is not there", path);
    }
}

static const char *const walk_steps[] = {
    "mkdir -p ",         "ffprocams patterns ",    "ffprocams calibrate ",
    "ffprocams import ", "ffprocams reconstruct ", "ffprocams view ",
    "ffprocams info "};

static void one_line_does_it_and_each_command_can_be_pasted(void **state) {
    (void)state;
    char first[FFP_PATH_MAX], command[1024];
    const char *line = "scan '%s/my shots'/place-* --projector 160x100 -w 48 -o " QUOTED " %s";
    assert_int_equal(run_format(&run, line, scratch, scratch, "--dry-run"), 0);
    assert_string_equal(run.err, "");
    assert_false(ffp_is_folder(in_scratch(OUT)));
    char *planned = strdup(run.out);
    assert_int_equal(run_format(&run, line, scratch, scratch, ""), 0);
    assert_non_null(strstr(run.out, "3 of 3 places"));
    assert_non_null(strstr(run.err, "Gray codes decoded")); // the steps' own words
    take_commands();
    check_steps(walk_steps, 7);
    check_results();
    for (int i = 0; i < n_typed; i++) assert_non_null(strstr(planned, typed[i]));
    free(planned);
    snprintf(first, sizeof first, "%s", in_scratch("first"));
    assert_int_equal(rename(in_scratch(OUT), first), 0);
    for (int i = 0; i < n_typed; i++)
        if (paste(typed[i]) != 0) fail_msg("cannot be pasted: %s", typed[i]);
    check_results();
    snprintf(command, sizeof command, "cmp " QUOTED "/object.ply %s/first/object.ply", scratch, scratch);
    assert_int_equal(system(command), 0);
}

// Results are not made twice, except from a step that is named.
static void a_step_is_gone_on_from(void **state) {
    (void)state;
    const char *line = "scan '%s/my shots'/place-* --projector 160x100 -w 48 -o " QUOTED " %s";
    run_format(&run, line, scratch, scratch, "");
    assert_int_equal(run.status, 1);
    assert_string_equal(run.out, "");
    assert_non_null(strstr(run.err, "already exists and is not empty: remove it, or go on with --from STEP"));
    run_format(&run, line, scratch, scratch, "--from import");
    assert_int_equal(run.status, 1);
    assert_string_equal(run.out, "");
    assert_non_null(strstr(run.err, "walk/capture)"));
    assert_int_equal(remove(in_scratch(OUT "/object.ply")), 0);
    assert_int_equal(remove(in_scratch(OUT "/report.html")), 0);
    assert_int_equal(run_format(&run, line, scratch, scratch, "--from reconstruct"), 0);
    take_commands();
    check_steps(walk_steps + 4, 3);
    check_results();
}

// The line after "go on with: " in the last run's words.
static char *going_on(void) {
    static const char words[] = "ffprocams: go on with: ";
    char *line = strstr(run.err, words);
    assert_non_null(line);
    line += strlen(words);
    line[strcspn(line, "\n")] = 0;
    return line;
}

static void a_step_that_fails_ends_it(void **state) {
    (void)state;
    char command[1024];
    snprintf(command, sizeof command, "mkdir '%s/a b' && cp -r '%s/my shots/place-00' '%s/a b'", scratch,
             scratch, scratch);
    assert_int_equal(system(command), 0);
    run_format(&run, "scan '%s/a b/' --shown %s/p -w 48 -o %s/failing", scratch, scratch, scratch);
    assert_int_equal(run.status, 1);
    const char *fault = strstr(run.err, "ffprocams: error: ");
    assert_true(fault && !strstr(fault + 1, "ffprocams: error: ") &&
                strstr(fault, "1 of 1 places of the camera"));
    snprintf(command, sizeof command, "cp -r '%s/my shots/place-01' '%s/a b'", scratch, scratch);
    assert_int_equal(system(command), 0);
    assert_null(strstr(run.out, "import -c"));
    if (paste(going_on()) != 0) fail_msg("%s", run.err);
    assert_true(ffp_is_file(in_scratch("failing/object.html")));
    // The exit code is the step's, also in a process that was started to ignore how others end.
    run_format(&run, "scan %s/table --angles 8y45 --shown %s/p -o %s/usage", scratch, scratch, scratch);
    assert_int_equal(run.status, 2);
    assert_non_null(strstr(run.err, "not '8y45'"));
    assert_non_null(strstr(run.err, "--from calibrate"));
    snprintf(command, sizeof command,
             "bash -c \"trap '' CHLD; exec '%s' scan %s/table --angles 8y45 --shown %s/p -o %s/usage\" "
             ">/dev/null 2>&1",
             FFP_PROGRAM, scratch, scratch, scratch);
    if (system("command -v bash >/dev/null") == 0) assert_int_equal(system(command) >> 8, 2);
}

// Of a run with `--events 1`: no finding comes twice.
static void check_findings(void) {
    int found = 0;
    for (const char *at = run.out; (at = strstr(at, "{\"event\":\"finding\"")); found++) {
        char finding[1024];
        snprintf(finding, sizeof finding, "%.*s", (int)strcspn(at, "\n"), at);
        if (strstr(++at, finding)) fail_msg("told twice: %s", finding);
    }
    assert_true(found > 5);
}

static void a_turntable_and_a_calibration_that_is_known(void **state) {
    (void)state;
    static const char *const known[] = {"mkdir -p ", "ffprocams import -c ", "ffprocams reconstruct ",
                                        "ffprocams view ", "ffprocams info "};
    assert_int_equal(run_format(&run, "scan %s/table/view-* --angles 8x45 --shown %s/p -w 48 -o %s/vase",
                                scratch, scratch, scratch),
                     0);
    assert_non_null(strstr(run.out, "8 of 8 stops"));
    assert_true(ffp_is_file(in_scratch("vase/object.html")) && ffp_is_file(in_scratch("vase/axis.json")));
    assert_int_equal(
        run_format(&run,
                   "--events 1 scan %s/table/view-* --angles 8x45 --shown %s/p -c %s/vase/calibration.xml "
                   "-t %s/vase/axis.json -w 48 -o %s/known",
                   scratch, scratch, scratch, scratch, scratch),
        0);
    assert_non_null(
        strstr(run.out, "{\"event\":\"progress\",\"stage\":\"refining\"")); // of the commands that it runs
    check_findings();
    take_commands();
    check_steps(known, 5);
    assert_non_null(strstr(typed[1], "/table/view-*/*.*' "));
    assert_true(ffp_is_file(in_scratch("known/object.html")));
    assert_int_equal(run_format(&run, "scan %s/table --angles 8x45 --shown p -o b --dry-run", scratch), 0);
    assert_non_null(strstr(run.out, "/table/{view}/*.*' ")); // though it has a file, too
    assert_int_equal(
        run_format(&run, "scan %s/table/view-000 -c a.xml --projector 160x100 -o b --dry-run", scratch), 0);
    assert_non_null(strstr(run.out, "import -c a.xml --projector-size 160x100 --shown b/patterns -i"));
    assert_int_equal(
        run_format(&run, "scan %s/table/view-0*/ -c a -g '{view}/*' --scene -o b --dry-run", scratch), 0);
    assert_non_null(strstr(run.out, "import -c a --scene -i 'black,white="));
    assert_int_equal(
        run_format(&run,
                   "scan %s/table/view-* --attitudes a --board 9x6 --square 25 --angles 8x45 --shown p -o "
                   "b --dry-run",
                   scratch),
        0);
    assert_non_null(strstr(run.out, "calibrate a --board 9x6 --square 25 --shown p -o b/calibration.xml\n"));
    assert_non_null(strstr(run.out, "import -c b/calibration.xml -t 8x45 --fit-axis --shown p -i"));
}

// As other programs keep them: the codes of each place in a folder of their own, without black and white.
static void codes_alone_in_inner_folders(void **state) {
    (void)state;
    char command[1024];
    snprintf(command, sizeof command,
             "cd '%s' && for p in 'my shots'/place-*; do mkdir -p \"other/${p##*-}\" && cp -r \"$p\" "
             "\"other/${p##*-}/gray\"; done && rm other/*/gray/00[123]*",
             scratch);
    assert_int_equal(system(command), 0);
    assert_int_equal(
        run_format(&run, "scan %s/other/*/gray --projector 160x100 -w 48 -o %s/alone", scratch, scratch), 0);
    assert_non_null(strstr(run.out, "/other/{view}/gray/*.*'"));
    assert_non_null(strstr(run.err, "no photograph under black or white fits"));
    assert_true(ffp_is_file(in_scratch("alone/object.html")));
}

// Black and white in each place's folder, the codes in one beside them; and the panel's size as a calibration
// has it.
static void codes_beside_black_and_white(void **state) {
    (void)state;
    char command[1024];
    snprintf(
        command, sizeof command,
        "cd '%s' && for p in 'my shots'/place-*; do d=beside/${p##*-} && mkdir -p $d/codes && cp \"$p\"/* "
        "$d/codes && mv $d/codes/00[12]* $d && rm $d/codes/003*; done",
        scratch);
    assert_int_equal(system(command), 0);
    assert_int_equal(run_format(&run, "scan %s/beside/* --projector 160x100 -w 48 --to import -o %s/sides",
                                scratch, scratch),
                     0);
    assert_non_null(strstr(run.out, "3 of 3 places"));
    assert_non_null(strstr(run.out, "/beside/{view}/codes/*.*'"));
    assert_null(strstr(run.err, "made from the codes"));
    take_commands();
    assert_true(strncmp(typed[2], "ffprocams import ", 17) == 0);
    snprintf(command, sizeof command, "calibrate %s/beside/* --without-board --projector 160x100 -o %s/again",
             scratch, scratch);
    assert_int_equal(run_format(&run, "%s", command), 0);
    const char *hint = strstr(run.out, "ffprocams import ");
    assert_true(hint && !strstr(run.out, "ffprocams patterns"));
    assert_non_null(strstr(hint, "/beside/{view}/codes/*' -i 'black,white="));
    assert_int_equal(run_format(&run, "scan %s/beside --projector 160x100 -o b --dry-run", scratch), 0);
    assert_non_null(strstr(run.out, "-g '"));
    snprintf(command, sizeof command, "touch '%s/beside/00/Thumbs.db'", scratch);
    assert_int_equal(system(command), 0);
    run_format(&run, "scan %s/beside/* --shown %s/p -o b --dry-run", scratch, scratch);
    assert_int_equal(run.status, 2);
    assert_non_null(strstr(run.err, "not --shown"));
    const char *line = "scan %s/beside/* %s -c %s/sides/calibration --scene --to import -w 48 -o b --dry-run";
    assert_int_equal(run_format(&run, line, scratch, "", scratch), 0);
    assert_null(strstr(run.out, "ffprocams patterns"));
    line = "scan '%s/my shots'/place-* -c " QUOTED "/calibration --scene -w 48 -o %s/sized";
    assert_int_equal(run_format(&run, line, scratch, scratch, scratch), 0);
    assert_non_null(strstr(run.err, "its projector has 160 x 100 pixels"));
    assert_true(ffp_is_file(in_scratch("sized/object.html")));
    run_format(&run, "patterns -c %s/sides/calibration --projector 9x9 -o %s/x", scratch, scratch);
    assert_int_equal(run.status, 2);
}

static void folders_that_cannot_be_named_are_refused(void **state) {
    (void)state;
    static const char *const wrong[][2] = {
        {"scan '%s/my shots/place-00' %s/table -o x", "must be in one folder"},
        {"scan %s/table/view-0* %s/table/view-180 -c a --angles 4x45 -o x",
         "more such folders than the 4 given"},
        {"scan %s/table/view-045 %s/table/view-000 -c a --angles 45,0 -o x", "not in natural order"},
        {"scan %s/nowhere %s/table -o x", "cannot open: No such file"},
        {"scan '%s/[' %s -o x", "rename the folder"},
        {"scan %s -g a -o %s", "--graycode requires --calibration"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char line[1024];
        snprintf(line, sizeof line, wrong[i][0], scratch, scratch);
        run_program(&run, line);
        if (run.status == 0 || !strstr(run.err, wrong[i][1]))
            fail_msg("%s: exit %d\n%s", line, run.status, run.err);
        assert_string_equal(run.out, "");
    }
    assert_false(ffp_is_folder("x"));
}

// --- Signals, while the first step, a `mkdir` of the test's own, is at work. ---

static pid_t scan, step;

static int end_processes(void **state) {
    (void)state;
    if (step > 0) kill(step, SIGKILL);
    if (scan > 0 && kill(scan, SIGKILL) == 0) waitpid(scan, NULL, 0);
    scan = step = 0;
    return 0;
}

// The text behind `key` in /proc/PROCESS/status; "": there is no such process.
static const char *status_of(pid_t process, const char *key) {
    static char text[4096];
    char name[64];
    snprintf(name, sizeof name, "/proc/%d/status", (int)process);
    FILE *file = fopen(name, "rb");
    text[file ? fread(text, 1, sizeof text - 1, file) : 0] = 0;
    if (file) fclose(file);
    const char *at = strstr(text, key);
    return at ? at + strlen(key) : "";
}

// Waits until the process is stopped, 'T', or asleep, 'S'.
static void wait_for(pid_t process, char what) {
    char is = 0;
    for (int i = 0; i < 1000 && is != what; i++) {
        if (i > 0) nanosleep(&(struct timespec){0, 10000000}, NULL);
        is = status_of(process, "State:\t")[0]; // read once: it changes
    }
    if (is != what)
        fail_msg("the %s is in the state %c, not %c, after 10 s", process == scan ? "scan" : "step",
                 is ? is : '-', what);
}

static void run_scan(int ignored, bool orphan) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP};
    const char *folder = in_scratch("ended"), *photographs = in_scratch("bin");
    if (orphan) setsid();
    if (!orphan) setpgid(0, 0);
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        sigaction(signals[i], &(struct sigaction){.sa_handler = signals[i] == ignored ? SIG_IGN : SIG_DFL},
                  NULL);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    setenv("PATH", in_scratch("bin"), 1);
    if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) _exit(126);
    execl(FFP_PROGRAM, "ffprocams", "scan", photographs, "-o", folder, (char *)NULL);
    _exit(127);
}

// This program as `mkdir -p PATH`: writes its number there, and stays.
static int be_mkdir(const char *path) {
    FILE *file = fopen(path, "w");
    if (!file || fprintf(file, "%d", (int)getpid()) < 0 || fclose(file) != 0) return 1;
    return pause();
}

static void begin_scan(int ignored, bool orphan) {
    char command[512];
    snprintf(command, sizeof command, "mkdir -p %s/bin && ln -sf /proc/%d/exe %s/bin/mkdir && rm -f %s/ended",
             scratch, (int)getpid(), scratch, scratch);
    assert_int_equal(system(command), 0);
    scan = fork();
    if (scan == 0) run_scan(ignored, orphan);
    for (int i = 0; i < 60000 && step <= 0; i++) {
        FILE *file = fopen(in_scratch("ended"), "r");
        if (!file || fscanf(file, "%d", &step) != 1) step = 0;
        if (file) fclose(file);
        nanosleep(&(struct timespec){0, 10000000}, NULL);
    }
    if (step <= 0) fail_msg("no step after 10 minutes");
    wait_for(step, 'S');
}

// The scan ends by the signal, and its step with it.
static void check_end(int number) {
    int status;
    kill(scan, number);
    assert_int_equal(waitpid(scan, &status, 0), scan);
    scan = 0;
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == number);
    assert_string_equal(status_of(step, "State:\t"), "");
    step = 0;
}

static void a_signal_is_for_the_step_too(void **state) {
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        begin_scan(0, false);
        assert_int_equal(strtoull(status_of(step, "SigBlk:\t"), NULL, 16), 0);
        assert_true(strtoull(status_of(step, "SigIgn:\t"), NULL, 16) >> (SIGTTOU - 1) & 1);
        check_end(signals[i]);
    }
}

static void ctrl_z_is_for_the_step_too(void **state) {
    (void)state;
    begin_scan(0, false);
    for (int i = 0; i < 2; i++) {
        kill(scan, SIGTSTP);
        wait_for(scan, 'T'), wait_for(step, 'T');
        kill(scan, SIGCONT);
        wait_for(scan, 'S'), wait_for(step, 'S');
    }
    check_end(SIGTERM);
}

// Of nohup, and of Ctrl-Z where no shell could continue it.
static void ignored_signals_stay_ignored(void **state) {
    (void)state;
    begin_scan(SIGHUP, true);
    kill(scan, SIGHUP), kill(scan, SIGTSTP);
    nanosleep(&(struct timespec){0, 300000000}, NULL);
    wait_for(scan, 'S'), wait_for(step, 'S');
    check_end(SIGTERM);
}

int main(int argc, char **argv) {
    if (argc == 3 && strcmp(argv[1], "-p") == 0) return be_mkdir(argv[2]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_line_does_it_and_each_command_can_be_pasted),
        cmocka_unit_test(a_step_is_gone_on_from),
        cmocka_unit_test(a_step_that_fails_ends_it),
        cmocka_unit_test(a_turntable_and_a_calibration_that_is_known),
        cmocka_unit_test(codes_alone_in_inner_folders),
        cmocka_unit_test(codes_beside_black_and_white),
        cmocka_unit_test(folders_that_cannot_be_named_are_refused),
        cmocka_unit_test_teardown(a_signal_is_for_the_step_too, end_processes),
        cmocka_unit_test_teardown(ctrl_z_is_for_the_step_too, end_processes),
        cmocka_unit_test_teardown(ignored_signals_stay_ignored, end_processes),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
