// `train` as a process: Ctrl-C ends it within seconds, with a checkpoint to go on from, whatever its
// generator threads are doing.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include "core/base/log.h"
#include "program.h"

#ifdef FFP_SANITIZED
enum { PATIENCE_S = 90 };
#else
enum { PATIENCE_S = 20 }; // of busy cores; alone it takes a second or two
#endif

static void rest(int ms) {
    const struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&time, NULL);
}

static pid_t start_training(const char *out, const char *config) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    const int log = open(in_scratch("log"), O_WRONLY | O_CREAT | O_APPEND, 0666);
    dup2(log, 1);
    dup2(log, 2);
    execl(FFP_PROGRAM, FFP_PROGRAM, "train", "--out", out, "--config", config, (char *)NULL);
    _exit(127);
}

// Lines of the metrics so far; -1: the file is not there yet.
static int steps_done(const char *out) {
    char path[FFP_PATH_MAX], *text;
    size_t size;
    int lines = 0;
    assert_true(ffp_join_path(path, out, "metrics.jsonl"));
    if (!ffp_is_file(path) || !ffp_read_file(path, 1 << 24, &text, &size, NULL)) return -1;
    for (size_t i = 0; i < size; i++) lines += text[i] == '\n';
    ffp_free(text);
    return lines;
}

static void wait_for_steps(const char *out, int steps) {
    const double begin = ffp_seconds();
    while (steps_done(out) < steps && ffp_seconds() - begin < 6 * PATIENCE_S) rest(10);
    assert_true(steps_done(out) >= steps);
}

// The child's exit code; -1 when a signal ended it or it did not end in time.
static int wait_for_end(pid_t child) {
    const double begin = ffp_seconds();
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (ffp_seconds() - begin > PATIENCE_S) {
            kill(child, SIGKILL);
            waitpid(child, &status, 0);
            return -1;
        }
        rest(10);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Interrupts after `steps` steps; 0: when training has begun.
static void interrupt(const char *out, const char *config, int number, int steps) {
    char checkpoint[FFP_PATH_MAX];
    assert_true(ffp_join_path(checkpoint, out, "checkpoint.safetensors"));
    const pid_t child = start_training(out, config);
    wait_for_steps(out, steps);
    assert_int_equal(kill(child, number), 0);
    const double begin = ffp_seconds();
    assert_int_equal(wait_for_end(child), 0);
    printf("%s ended after %.2f s\n", ffp_basename(out), ffp_seconds() - begin);
    assert_true(ffp_is_file(checkpoint));
}

static void go_on_for_two_steps(const char *out) {
    char command[2 * FFP_PATH_MAX];
    const int done = steps_done(out);
    ProgramRun run;
    snprintf(command, sizeof command, "train --out %s --resume --stop-at %d", out, done + 2);
    run_program(&run, command);
    if (run.status != 0) fail_msg("%s", run.err);
    assert_int_equal(steps_done(out), done + 2);
}

static void write_config(const char *path, int resolution, int samples, int ambient_rays) {
    static const char form[] =
        "{\"model\": \"tiny\", \"resolution\": %d, \"views\": 2, \"targets\": 1, \"lollipops\": 1,"
        " \"pattern_side\": 64, \"samples\": %d, \"ambient_rays\": %d, \"supervised_inputs\": 1,"
        " \"supervised_targets\": 1, \"validate_every\": 0, \"log_every\": 1, \"pool\": 2, \"reuse\": 20,"
        " \"generators\": 2, \"queue\": 3}";
    char text[sizeof form + 32];
    const int length = snprintf(text, sizeof text, form, resolution, samples, ambient_rays);
    assert_true(ffp_write_file(path, text, (size_t)length, NULL));
}

// Before the first scene is ready: on a machine that has finished it by then, scenes that take four times as
// long are tried next.
static void interrupt_before_the_first_step(void) {
    char out[FFP_PATH_MAX];
    for (int samples = 16; samples <= 1024; samples *= 4) {
        snprintf(out, sizeof out, "%s_%d", in_scratch("first"), samples);
        write_config(in_scratch("longer.json"), 64, samples, 4);
        interrupt(out, in_scratch("longer.json"), SIGINT, 0);
        if (steps_done(out) == 0) return;
    }
    fail_msg("even the slowest scene was done before the signal came");
}

static void a_signal_ends_it_with_a_checkpoint(void **state) {
    (void)state;
    write_config(in_scratch("quick.json"), 16, 1, 1);
    write_config(in_scratch("slow.json"), 64, 16, 4);
    interrupt(in_scratch("full"), in_scratch("quick.json"), SIGINT, 8); // the queue is full
    go_on_for_two_steps(in_scratch("full"));
    interrupt_before_the_first_step();
    interrupt(in_scratch("middle"), in_scratch("slow.json"), SIGTERM, 1); // others in the making
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_signal_ends_it_with_a_checkpoint)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
