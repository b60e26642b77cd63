// Runs a command as a process of its own that shares this one's output.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include "cli.h"

extern char **environ;

static volatile sig_atomic_t child, stopped; // its process; the signal that ended the work

static void pass_on(int number) {
    const int before = errno;
    stopped = number;
    if (child > 0) kill((pid_t)child, number);
    errno = before;
}

// Ctrl-Z: both rest, and both go on; this one at once where no shell could continue it.
static void rest(int number) {
    const int before = errno;
    struct sigaction action;
    sigset_t only, mask;
    if (child > 0) kill((pid_t)child, SIGSTOP);
    sigaction(number, &(struct sigaction){.sa_handler = SIG_DFL}, &action);
    sigemptyset(&only);
    sigaddset(&only, number);
    raise(number);
    sigprocmask(SIG_UNBLOCK, &only, &mask); // it takes effect here
    sigprocmask(SIG_SETMASK, &mask, NULL);
    sigaction(number, &action, NULL);
    if (child > 0) kill((pid_t)child, SIGCONT);
    errno = before;
}

// A signal that this process was started to ignore (nohup) remains so.
static void handle(int number, void (*handler)(int)) {
    struct sigaction before;
    if (sigaction(number, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(number, &(struct sigaction){.sa_handler = handler}, NULL);
}

static bool is_self(const FfpList *words) {
    return strcmp(words->values[0], "ffprocams") == 0;
}

// The words and a NULL, after those of --events if there is somebody who listens; to be freed.
static const char **with_events(const FfpList *words, char descriptor[16]) {
    const char **all = calloc((size_t)words->count + 3, sizeof *all);
    const int events = is_self(words) ? ffp_cli_events() : -1, more = events >= 0 ? 2 : 0;
    if (!all) return NULL;
    memcpy(all + more, words->values, (size_t)words->count * sizeof *all);
    if (!more) return all;
    snprintf(descriptor, 16, "%d", events);
    all[0] = words->values[0], all[1] = "--events", all[2] = descriptor;
    fcntl(events, F_SETFD, 0); // the child inherits it
    return all;
}

// In its own process group: it hears of a signal once, by pass_on, though a terminal tells all of a group.
static int start(const FfpList *words, const sigset_t *mask, pid_t *process) {
    char descriptor[16];
    posix_spawnattr_t attributes;
    const char **all = with_events(words, descriptor);
    const char *program = is_self(words) ? "/proc/self/exe" : words->values[0];
    int failed = all ? posix_spawnattr_init(&attributes) : ENOMEM;
    if (!failed) {
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
        posix_spawnattr_setsigmask(&attributes, mask);
        failed = posix_spawnp(process, program, NULL, &attributes, (char *const *)all, environ);
        posix_spawnattr_destroy(&attributes);
    }
    free(all);
    return failed;
}

int ffp_cli_child(const FfpList *words) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
    int status = 0;
    pid_t process = 0, ended;
    sigset_t all, mask;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, &mask); // until it is known whom to pass signals on to
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) handle(signals[i], pass_on);
    handle(SIGTSTP, rest);
    signal(SIGCHLD, SIG_DFL); // where it is ignored, nobody knows how a process ended
    signal(SIGTTOU, SIG_IGN); // inherited: it writes from the background, also under `stty tostop`
    const int failed = stopped ? 0 : start(words, &mask, &process);
    child = failed ? 0 : process;
    sigprocmask(SIG_SETMASK, &mask, NULL);
    if (failed) {
        FfpError err = {.code = FFP_ERROR_IO};
        snprintf(err.text, sizeof err.text, "cannot start %s: %s", words->values[0], strerror(failed));
        return ffp_cli_fail(&err);
    }
    if (process == 0) return FFP_EXIT_FAILURE; // stopped before
    do ended = waitpid(process, &status, 0);
    while (ended < 0 && errno == EINTR);
    child = 0;
    if (ended < 0) return FFP_EXIT_FAILURE;
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    if (!stopped) fprintf(stderr, "ffprocams: error: ended by signal %d\n", WTERMSIG(status));
    return FFP_EXIT_FAILURE;
}

void ffp_cli_end_as_child(void) {
    if (!stopped) return;
    signal(stopped, SIG_DFL);
    raise(stopped);
}
