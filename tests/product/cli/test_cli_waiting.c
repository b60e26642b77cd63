// Threads sleep while they wait where the machine is busy, and as the user says where he has said it.
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include "program.h"

static pid_t spin(void) {
    const pid_t child = fork();
    if (child == 0)
        for (volatile unsigned i = 0;; i++) {
        }
    assert_true(child > 0);
    return child;
}

// True if the program's environment, as it works on, holds the variable; looks until the program has ended.
static bool works_with(const char *variable, const char *policy) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (policy)
            setenv("OMP_WAIT_POLICY", policy, 1);
        else
            unsetenv("OMP_WAIT_POLICY");
        setenv("OMP_NUM_THREADS", "2", 1);
        unsetenv("GOMP_SPINCOUNT");
        execl(FFP_PROGRAM, FFP_PROGRAM, "reconstruct", FFP_SOURCE_DIR "/data/sample", "--polish", "0", "-o",
              "waiting.ply", (char *)NULL);
        _exit(127);
    }
    char path[64], text[65536];
    bool found = false;
    int status = 0;
    snprintf(path, sizeof path, "/proc/%d/environ", (int)child);
    while (waitpid(child, &status, WNOHANG) == 0) {
        FILE *file = fopen(path, "rb");
        const size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
        if (file) fclose(file);
        text[size] = 0;
        for (const char *at = text; at < text + size; at += strlen(at) + 1)
            found |= strcmp(at, variable) == 0;
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    }
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    remove("waiting.ply");
    return found;
}

static void a_busy_machine(void **state) {
    (void)state;
    const long spinners = sysconf(_SC_NPROCESSORS_ONLN);
    pid_t *children = ffp_alloc((size_t)spinners, sizeof *children);
    for (long i = 0; i < spinners; i++) children[i] = spin();
    const bool passive = works_with("OMP_WAIT_POLICY=passive", NULL);
    const bool as_set = works_with("OMP_WAIT_POLICY=active", "active");
    for (long i = 0; i < spinners; i++) {
        kill(children[i], SIGKILL);
        waitpid(children[i], NULL, 0);
    }
    ffp_free(children);
    assert_true(passive);
    assert_true(as_set);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_busy_machine)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
