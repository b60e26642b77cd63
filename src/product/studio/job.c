// The program's other commands at work: one after the other, each in a terminal of its own, so that it tells
// its progress as it would to a user; what it says is kept, and ends on disk.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "work.h"

static double now(void) {
    struct timespec time = {0};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void ffp_studio_word(FfpStudioCommand *command, const char *format, ...) {
    char *word = NULL;
    va_list arguments;
    va_start(arguments, format);
    const bool made = command->count < FFP_STUDIO_WORDS && vasprintf(&word, format, arguments) >= 0;
    va_end(arguments);
    if (made)
        command->words[command->count++] = word;
    else
        command->failed = true;
}

static bool is_plain(const char *word) {
    return *word &&
           strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=,+:@%-") ==
               strlen(word);
}

FfpStudioCommand *ffp_studio_command(FfpStudioJob *job, const char *name) {
    FfpStudioCommand *c = &job->commands[job->n_commands++];
    ffp_studio_word(c, "ffprocams");
    ffp_studio_word(c, "%s", name);
    return c;
}

char *ffp_studio_typed(const FfpStudioCommand *command) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    for (int i = 0; i < command->count; i++) {
        const char *word = command->words[i];
        if (i > 0) fputc(' ', out);
        if (is_plain(word)) {
            fputs(word, out);
            continue;
        }
        fputc('\'', out);
        for (const char *c = word; *c; c++) {
            if (*c == '\'')
                fputs("'\\''", out);
            else
                fputc(*c, out);
        }
        fputc('\'', out);
    }
    fclose(out);
    return text;
}

void ffp_studio_clear(FfpStudioJob *job) {
    for (int k = 0; k < job->n_commands; k++)
        for (int i = 0; i < job->commands[k].count; i++) free(job->commands[k].words[i]);
    memset(job->commands, 0, sizeof job->commands);
    job->n_commands = job->current = 0;
}

// --- What it says. ---

// The oldest half goes when there is no room.
static void add_line(FfpStudioJob *job, const char *line) {
    const size_t length = strlen(line);
    if (length + 2 > sizeof job->log) return;
    while (job->logged + length + 2 > sizeof job->log) {
        const char *end = memchr(job->log + job->logged / 2, '\n', job->logged - job->logged / 2);
        const size_t gone = end ? (size_t)(end - job->log) + 1 : job->logged;
        memmove(job->log, job->log + gone, job->logged - gone);
        job->logged -= gone;
    }
    memcpy(job->log + job->logged, line, length);
    job->logged += length;
    job->log[job->logged++] = '\n';
    job->log[job->logged] = 0;
}

// "ffprocams: photographing 259/589, 25.2/s, 13 s left"
static bool read_progress(FfpStudioJob *job, const char *line) {
    static const char name[] = "ffprocams: ";
    if (strncmp(line, name, sizeof name - 1) != 0) return false;
    line += sizeof name - 1;
    const char *comma = strstr(line, "/s, ");
    if (!comma) return false;
    for (const char *slash = strchr(line, '/'); slash && slash < comma; slash = strchr(slash + 1, '/')) {
        const char *from = slash;
        while (from > line && from[-1] >= '0' && from[-1] <= '9') from--;
        char *end;
        if (from == slash || from == line) continue;
        const long long total = strtoll(slash + 1, &end, 10);
        if (*end != ',' || total <= 0) continue;
        job->done = strtoll(from, NULL, 10), job->total = total;
        snprintf(job->stage, sizeof job->stage, "%.*s", (int)(from - line - 1), line);
        return true;
    }
    return false;
}

typedef struct Terminal {
    char line[2048];
    size_t length;
    int escape; // characters of a control sequence so far
} Terminal;

// A control sequence (ECMA-48, 5.4) ends with a letter; the program clears its line of progress by one.
static void hear(FfpStudioJob *job, Terminal *t, char c) {
    if (t->escape > 0) {
        t->escape++;
        if (c >= '@' && !(t->escape == 2 && c == '[')) t->escape = 0;
    } else if (c == '\033') {
        t->escape = 1;
        t->length = 0;
    } else if (c == '\n') {
        t->line[t->length] = 0;
        if (t->length > 0 && !read_progress(job, t->line)) add_line(job, t->line);
        t->length = 0;
    } else if ((unsigned char)c >= ' ' && t->length + 1 < sizeof t->line) {
        t->line[t->length++] = c;
    }
}

// --- Processes. ---

// Everything between fork and exec is safe in a child of a program with threads.
static void become(const FfpStudio *studio, int terminal, char *const *words) {
    static const int usual[] = {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGCHLD, SIGHUP};
    sigset_t none;
    setsid(); // Ctrl-C is for the studio, which passes it on
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++) signal(usual[i], SIG_DFL);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    const int nothing = open("/dev/null", O_RDONLY);
    if (nothing < 0 || dup2(nothing, 0) < 0 || dup2(terminal, 1) < 0 || dup2(terminal, 2) < 0 ||
        fchdir(studio->root) != 0)
        _exit(126);
    execv("/proc/self/exe", words); // this program, even if another was installed in its place meanwhile
    _exit(127);
}

// Starts the command at hand; its terminal, or -1.
static int start_command(FfpStudio *studio, FfpStudioJob *job) {
    int ours, theirs;
    const struct winsize wide = {.ws_row = 50, .ws_col = 2000};
    if (openpty(&ours, &theirs, NULL, NULL, &wide) != 0) return -1;
    fcntl(ours, F_SETFD, FD_CLOEXEC), fcntl(theirs, F_SETFD, FD_CLOEXEC);
    const pid_t child = fork();
    if (child == 0) become(studio, theirs, job->commands[job->current].words);
    close(theirs);
    if (child < 0) {
        close(ours);
        return -1;
    }
    job->process = child;
    return ours;
}

static void listen_to(FfpStudio *studio, FfpStudioJob *job, int terminal) {
    Terminal t = {.length = 0};
    char bytes[4096];
    for (ssize_t got; (got = read(terminal, bytes, sizeof bytes)) > 0 || (got < 0 && errno == EINTR);) {
        pthread_mutex_lock(&studio->lock);
        for (ssize_t i = 0; i < got; i++) hear(job, &t, bytes[i]);
        t.line[t.length] = 0;
        read_progress(job, t.line); // a line of progress has no end
        studio->version++;          // of nothing in the folder
        pthread_mutex_unlock(&studio->lock);
    }
    close(terminal);
}

// Whether it ended well. Called and left with the lock.
static bool run_command(FfpStudio *studio, FfpStudioJob *job) {
    char *typed = ffp_studio_typed(&job->commands[job->current]), line[64];
    int status = 0;
    job->stage[0] = 0, job->done = job->total = 0;
    if (typed) {
        char *prompt = NULL;
        if (asprintf(&prompt, "$ %s", typed) >= 0) add_line(job, prompt), free(prompt);
        free(typed);
    }
    const int terminal = job->commands[job->current].failed ? -1 : start_command(studio, job);
    ffp_studio_changed(studio);
    if (terminal < 0) {
        add_line(job, "the command cannot be started");
        return false;
    }
    pthread_mutex_unlock(&studio->lock);
    listen_to(studio, job, terminal);
    while (waitpid(job->process, &status, 0) < 0 && errno == EINTR) continue;
    pthread_mutex_lock(&studio->lock);
    job->process = 0, job->stage[0] = 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
    if (WIFSIGNALED(status))
        snprintf(line, sizeof line, "ended by signal %d", WTERMSIG(status));
    else
        snprintf(line, sizeof line, "exit status %d", WEXITSTATUS(status));
    add_line(job, line);
    return false;
}

static void *run_job(void *argument) {
    FfpStudio *studio = ((void **)argument)[0];
    FfpStudioJob *job = ((void **)argument)[1];
    char path[FFP_STUDIO_NAME];
    free(argument);
    pthread_mutex_lock(&studio->lock);
    bool ok = true;
    for (; ok && !job->stop && job->current < job->n_commands; job->current++) ok = run_command(studio, job);
    job->seconds = now() - job->began;
    job->end = job->stop ? FFP_JOB_STOPPED : ok ? FFP_JOB_DONE : FFP_JOB_FAILED;
    snprintf(path, sizeof path, "logs/%s.txt", job->name);
    if (!ffp_studio_write(studio, path, job->log, job->logged))
        snprintf(studio->notice, sizeof studio->notice, "%s cannot be written: %s", path, strerror(errno));
    ffp_studio_changed(studio);
    pthread_mutex_unlock(&studio->lock);
    return NULL;
}

bool ffp_studio_start(FfpStudio *studio, FfpStudioJob *job, const char *name) {
    void **argument = malloc(2 * sizeof *argument);
    if (!argument || job->end == FFP_JOB_RUNNING || studio->closing) return free(argument), false;
    if (job->joinable) pthread_join(job->thread, NULL); // it has ended: nobody waits
    argument[0] = studio, argument[1] = job;
    snprintf(job->name, sizeof job->name, "%s", name);
    job->end = FFP_JOB_RUNNING, job->stop = false, job->current = 0, job->logged = 0, job->log[0] = 0;
    job->began = now(), job->seconds = 0, job->stage[0] = 0;
    job->joinable = pthread_create(&job->thread, NULL, run_job, argument) == 0;
    if (!job->joinable) free(argument), job->end = FFP_JOB_FAILED;
    ffp_studio_changed(studio);
    return job->joinable;
}

void ffp_studio_stop(FfpStudioJob *job) {
    if (job->end != FFP_JOB_RUNNING) return;
    if (job->process > 0) kill(job->process, job->stop ? SIGKILL : SIGINT); // asked twice: at once
    job->stop = true;
}

void ffp_studio_join(FfpStudio *studio, FfpStudioJob *job) {
    pthread_mutex_lock(&studio->lock);
    ffp_studio_stop(job);
    pthread_mutex_unlock(&studio->lock);
    if (job->joinable) pthread_join(job->thread, NULL);
    job->joinable = false;
    ffp_studio_clear(job);
}
