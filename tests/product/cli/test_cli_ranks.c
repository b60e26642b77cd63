#define _GNU_SOURCE // memmem
// `mpirun -n 2 ffprocams train`: processes make the run that one makes; a rank that is killed ends the job
// with a line that names it, and leaves a whole checkpoint to go on from. Skipped where there is no mpirun,
// or the program was built without MPI.
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include "core/base/log.h"
#include "program.h"

#define MPIRUN                                                                                               \
    "env OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1 "                       \
    "mpirun --oversubscribe -n 2 '" FFP_PROGRAM "' "

static const char config[] =
    "{\"model\": \"tiny\", \"resolution\": 16, \"views\": 2, \"targets\": 1, \"lollipops\": 1,"
    " \"pattern_side\": 64, \"samples\": 1, \"ambient_rays\": 1, \"supervised_inputs\": 1,"
    " \"supervised_targets\": 1, \"validate_every\": 0, \"log_every\": 1, \"pool\": 2, \"reuse\": 20,"
    " \"batch\": 2, \"steps\": %d, \"checkpoint_steps\": 3}";

static bool there_is_mpi(void) {
    if (system("mpirun --version 2>/dev/null | grep -q 'Open MPI'") != 0) {
        printf("skipped: there is no mpirun of Open MPI here\n");
        return false;
    }
    if (FFP_HAS_MPI) return true;
    printf("skipped: the program was built without MPI (FFPROCAMS_MPI)\n");
    return false;
}

static void write_config(int steps) {
    char text[sizeof config + 32];
    snprintf(text, sizeof text, config, steps);
    assert_true(ffp_write_file(in_scratch("config.json"), text, strlen(text), NULL));
}

// A shell's line in the scratch folder's company; its exit code, its words in the file "log".
static int shell(const char *format, const char *a, const char *b) {
    char arguments[1024], line[2048];
    snprintf(arguments, sizeof arguments, format, a, b);
    snprintf(line, sizeof line, "%s >'%s/log' 2>&1", arguments, scratch);
    const int status = system(line);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void read_log(char *text, size_t size) {
    text[0] = 0;
    FILE *file = fopen(in_scratch("log"), "r");
    if (!file) return;
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
}

static void fail_with_log(const char *what) {
    static char text[20000];
    read_log(text, sizeof text);
    fail_msg("%s\n%s", what, text);
}

// The step of its checkpoint, as `info` would read it; -1: there is none.
static int checkpoint_step(const char *out) {
    char path[FFP_PATH_MAX], *text, *at;
    size_t size;
    assert_true(ffp_join_path(path, out, "checkpoint.safetensors"));
    if (!ffp_is_file(path)) return -1;
    assert_true(ffp_read_file(path, 1 << 28, &text, &size, NULL));
    at = memmem(text, size, "\"step\":\"", 8);
    assert_non_null(at);
    const int step = (int)strtol(at + 8, NULL, 10);
    ffp_free(text);
    return step;
}

static bool same_weights(const char *a, const char *b) {
    char path[2][FFP_PATH_MAX], *text[2];
    size_t size[2];
    assert_true(ffp_join_path(path[0], a, "weights.safetensors") &&
                ffp_join_path(path[1], b, "weights.safetensors"));
    for (int i = 0; i < 2; i++) assert_true(ffp_read_file(path[i], 1 << 28, &text[i], &size[i], NULL));
    const bool same = size[0] == size[1] && memcmp(text[0], text[1], size[0]) == 0;
    ffp_free(text[0]), ffp_free(text[1]);
    return same;
}

// The losses of the steps in a run's metrics, into out [most]; returns their number.
static int losses_of(const char *out, double *losses, int most) {
    char path[FFP_PATH_MAX], *text;
    size_t size;
    int count = 0;
    assert_true(ffp_join_path(path, out, "metrics.jsonl"));
    assert_true(ffp_read_file(path, 1 << 24, &text, &size, NULL));
    for (char *at = text; at && count < most; at = strchr(at, '\n'), at = at ? at + 1 : NULL)
        if (sscanf(at, "{\"step\":%*d,\"loss\":%lf", &losses[count]) == 1) count++;
    ffp_free(text);
    return count;
}

static void two_processes_make_the_run_of_one(void **state) {
    (void)state;
    if (!there_is_mpi()) skip();
    double one[16], two[16];
    write_config(7);
    const char *path = in_scratch("config.json");
    if (shell("OMP_NUM_THREADS=1 '" FFP_PROGRAM "' train --out %s --config %s", in_scratch("one"), path))
        fail_with_log("one process");
    if (shell(MPIRUN "train --out %s --config %s", in_scratch("two"), path)) fail_with_log("two processes");
    if (shell(MPIRUN "train --out %s --config %s", in_scratch("again"), path)) fail_with_log("again");
    assert_int_equal(losses_of(in_scratch("one"), one, 16), 7);
    assert_int_equal(losses_of(in_scratch("two"), two, 16), 7);
    for (int i = 0; i < 7; i++)
        if (!(one[i] > two[i] - 1e-4 * one[i] && one[i] < two[i] + 1e-4 * one[i]))
            fail_msg("step %d: loss %g and %g", i, one[i], two[i]);
    assert_true(same_weights(in_scratch("two"), in_scratch("again")));
    assert_int_equal(checkpoint_step(in_scratch("two")), 7);
}

static void a_wrong_number_of_processes_is_refused(void **state) {
    (void)state;
    if (!there_is_mpi()) skip();
    static char text[20000];
    assert_true(ffp_write_file(in_scratch("odd.json"), "{\"batch\": 3}", 12, NULL));
    assert_true(shell(MPIRUN "train --out %s --config %s", in_scratch("odd"), in_scratch("odd.json")) != 0);
    read_log(text, sizeof text);
    if (!strstr(text, "3 scenes per step cannot be divided among 2 ranks")) fail_msg("%s", text);
    assert_false(ffp_is_file(in_scratch("odd/metrics.jsonl")));
}

static void rest(int ms) {
    nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L}, NULL);
}

// Of mpirun's children the one that is the given rank.
static pid_t child_of(pid_t mpirun, int rank) {
    char line[256];
    snprintf(line, sizeof line,
             "for p in $(cat /proc/%ld/task/*/children); do tr '\\0' '\\n' </proc/$p/environ | "
             "grep -qx OMPI_COMM_WORLD_RANK=%d && echo $p; done",
             (long)mpirun, rank);
    FILE *pipe = popen(line, "r");
    long pid = 0;
    if (!pipe || fscanf(pipe, "%ld", &pid) != 1) pid = 0;
    if (pipe) pclose(pipe);
    return (pid_t)pid;
}

static pid_t start(const char *out, const char *path) {
    char line[2048];
    snprintf(line, sizeof line, "exec " MPIRUN "train --out %s --config %s >'%s/log' 2>&1", out, path,
             scratch);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    execl("/bin/sh", "sh", "-c", line, (char *)NULL);
    _exit(127);
}

// Waits for an exit, no longer than a minute; its code, -1 otherwise.
static int wait_for_end(pid_t child) {
    int status = 0;
    for (int i = 0; i < 600; i++, rest(100))
        if (waitpid(child, &status, WNOHANG) == child) return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return -1;
}

static void a_killed_rank_ends_the_job(void **state) {
    (void)state;
    if (!there_is_mpi()) skip();
    static char text[20000];
    write_config(1000000);
    const char *out = in_scratch("killed");
    const pid_t job = start(out, in_scratch("config.json"));
    for (int i = 0; i < 600 && checkpoint_step(out) < 3; i++) rest(100);
    if (checkpoint_step(out) < 3) fail_with_log("no checkpoint");
    const pid_t victim = child_of(job, 1);
    if (!victim) fail_with_log("no rank 1");
    assert_int_equal(kill(victim, SIGKILL), 0);
    assert_true(wait_for_end(job) > 0);
    read_log(text, sizeof text);
    if (!strstr(text, "rank 1 ")) fail_msg("%s", text);
    const int step = checkpoint_step(out);
    assert_int_equal(step % 3, 0);
    // another number of ranks goes on from it
    char stop[32];
    snprintf(stop, sizeof stop, "%d", step + 2);
    if (shell("OMP_NUM_THREADS=1 '" FFP_PROGRAM "' train --out %s --resume --stop-at %s", out, stop))
        fail_with_log("resumed");
    assert_int_equal(checkpoint_step(out), step + 2);
}

// Scenes that two processes make are those of one, and so are the scores that they find.
static void scenes_and_scores_are_shared(void **state) {
    (void)state;
    if (!there_is_mpi()) skip();
    static char one[20000], two[20000];
    static const char scenes[] = "generate %s --preset smoke --split train --resolution 16 --count 3 %s";
    char line[512];
    snprintf(line, sizeof line, "'" FFP_PROGRAM "' %s", scenes);
    if (shell(line, in_scratch("alone"), "")) fail_with_log("generate");
    snprintf(line, sizeof line, MPIRUN "%s", scenes);
    if (shell(line, in_scratch("shared"), "")) fail_with_log("generate, two processes");
    if (shell("diff -r %s %s", in_scratch("alone"), in_scratch("shared"))) fail_with_log("scenes differ");
    static const char rows[] = "evaluate --model none --polish 0 %s/train_0000[012] | cut -c 1-86%s";
    snprintf(line, sizeof line, "'" FFP_PROGRAM "' %s", rows);
    if (shell(line, in_scratch("alone"), "")) fail_with_log("evaluate");
    read_log(one, sizeof one);
    snprintf(line, sizeof line, MPIRUN "%s", rows);
    if (shell(line, in_scratch("alone"), "")) fail_with_log("evaluate, two processes");
    read_log(two, sizeof two);
    char *a = strstr(one, "capture "), *b = strstr(two, "capture ");
    if (!a || !b || strcmp(a, b) != 0) fail_msg("%s\n%s", one, two);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_processes_make_the_run_of_one),
        cmocka_unit_test(a_wrong_number_of_processes_is_refused),
        cmocka_unit_test(scenes_and_scores_are_shared),
        cmocka_unit_test(a_killed_rank_ends_the_job),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
