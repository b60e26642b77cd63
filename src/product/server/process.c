// The commands of jobs as processes: each writes what happens to a pipe (--events), from which the page has
// progress and findings, and its text to another.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include "work.h"

enum { TEXT, EVENTS, PIPES, OF_EVENTS = 3 }; // the descriptor of a command's events

// Everything between fork and exec is safe in a child of a program with threads.
static void become(const FfpStudio *studio, const int ends[PIPES], char *const *words) {
    static const int usual[] = {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGCHLD, SIGHUP};
    sigset_t none;
    setsid(); // Ctrl-C is for the studio, which passes it on
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++) signal(usual[i], SIG_DFL);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    const int nothing = open("/dev/null", O_RDONLY), events = fcntl(ends[EVENTS], F_DUPFD, 10),
              text = fcntl(ends[TEXT], F_DUPFD, 10); // out of the way of those that they become
    if (nothing < 0 || events < 0 || text < 0 || fchdir(studio->root) != 0 || dup2(nothing, 0) < 0 ||
        dup2(text, 1) < 0 || dup2(text, 2) < 0 || dup2(events, OF_EVENTS) < 0)
        _exit(126);
    if (nothing > OF_EVENTS) close(nothing);
    close(events), close(text);
    execv("/proc/self/exe", words); // this program, even if another was installed in its place meanwhile
    _exit(127);
}

// Starts a command, and the pipes to read from; false: it cannot be.
static bool start_command(const FfpStudio *studio, FfpStudioProcess *p, char *const *words, int from[PIPES]) {
    int ends[PIPES], both[2];
    for (int k = 0; k < PIPES; k++) {
        if (pipe2(both, O_CLOEXEC) != 0) {
            if (k > 0) close(from[0]), close(ends[0]);
            return false;
        }
        from[k] = both[0], ends[k] = both[1];
    }
    const pid_t child = fork();
    if (child == 0) become(studio, ends, words);
    for (int k = 0; k < PIPES; k++) close(ends[k]);
    p->process = child;
    if (child >= 0) return true;
    for (int k = 0; k < PIPES; k++) close(from[k]);
    p->process = 0;
    return false;
}

typedef struct Line {
    char text[1 << 14];
    size_t length; // of a line so far; longer ones are cut
} Line;

static void hear(FfpStudioJob *job, Line *line, int which, const char *bytes, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (bytes[i] != '\n') {
            if (line->length + 1 < sizeof line->text && (unsigned char)bytes[i] >= ' ')
                line->text[line->length++] = bytes[i];
            continue;
        }
        line->text[line->length] = 0;
        if (line->length > 0)
            (which == EVENTS ? ffp_studio_hear_event : ffp_studio_hear_text)(job, line->text);
        line->length = 0;
    }
}

static void listen_to(FfpStudioServer *server, FfpStudioJob *job, const int from[PIPES]) {
    Line *lines = calloc(PIPES, sizeof *lines);
    struct pollfd waiting[PIPES] = {{.fd = from[TEXT], .events = POLLIN},
                                    {.fd = from[EVENTS], .events = POLLIN}};
    char bytes[4096];
    while (lines && (waiting[TEXT].fd >= 0 || waiting[EVENTS].fd >= 0)) {
        if (poll(waiting, PIPES, -1) < 0) continue;
        for (int k = 0; k < PIPES; k++) {
            if (waiting[k].fd < 0 || !waiting[k].revents) continue;
            const ssize_t got = read(from[k], bytes, sizeof bytes);
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) waiting[k].fd = -1;
            pthread_mutex_lock(&server->lock);
            if (got > 0) hear(job, &lines[k], k, bytes, (size_t)got);
            server->studio.version++; // of nothing in the folder
            pthread_mutex_unlock(&server->lock);
        }
    }
    for (int k = 0; k < PIPES; k++) close(from[k]);
    free(lines);
}

// Runs a command to its end. Called and left with the lock.
static void run_command(FfpStudioServer *server, FfpStudioProcess *p, char *const *words) {
    char how[64];
    int status = 0, from[PIPES];
    if (!start_command(&server->studio, p, words, from)) {
        ffp_studio_end_command(p->job, "the command cannot be started");
        return;
    }
    pthread_mutex_unlock(&server->lock);
    listen_to(server, p->job, from);
    while (waitpid(p->process, &status, 0) < 0 && errno == EINTR) continue;
    pthread_mutex_lock(&server->lock);
    p->process = 0;
    if (WIFSIGNALED(status))
        snprintf(how, sizeof how, "ended by signal %d", WTERMSIG(status));
    else
        snprintf(how, sizeof how, "exit status %d", WEXITSTATUS(status));
    ffp_studio_end_command(p->job, WIFEXITED(status) && WEXITSTATUS(status) == 0 ? NULL : how);
}

static void *run_job(void *argument) {
    FfpStudioServer *server = ((void **)argument)[0];
    FfpStudioProcess *p = ((void **)argument)[1];
    char *words[FFP_STUDIO_WORDS + 3];
    free(argument);
    pthread_mutex_lock(&server->lock);
    while (ffp_studio_begin_command(&server->studio, p->job, "3", words)) run_command(server, p, words);
    ffp_studio_end_job(&server->studio, p->job);
    pthread_mutex_unlock(&server->lock);
    return NULL;
}

static FfpStudioProcess *process_of(FfpStudioServer *server, FfpStudioJob *job) {
    FfpStudioProcess *p = server->processes;
    while (p->job && p->job != job) p++; // each of the studio's jobs has one
    p->job = job;
    return p;
}

bool ffp_server_run(FfpStudio *studio, FfpStudioJob *job) {
    FfpStudioServer *server = (FfpStudioServer *)studio;
    FfpStudioProcess *p = process_of(server, job);
    void **argument = malloc(2 * sizeof *argument);
    if (!argument) return false;
    if (p->joinable) pthread_join(p->thread, NULL); // it has ended: nobody waits
    argument[0] = server, argument[1] = p;
    p->joinable = pthread_create(&p->thread, NULL, run_job, argument) == 0;
    if (!p->joinable) free(argument);
    return p->joinable;
}

void ffp_server_stop(FfpStudio *studio, FfpStudioJob *job) {
    const FfpStudioProcess *p = process_of((FfpStudioServer *)studio, job);
    if (p->process > 0) kill(p->process, job->stop ? SIGKILL : SIGINT);
}

void ffp_server_end_jobs(FfpStudioServer *server) {
    for (int i = 0; i < FFP_STUDIO_JOBS && server->processes[i].job; i++) {
        pthread_mutex_lock(&server->lock);
        ffp_studio_stop(&server->studio, server->processes[i].job);
        pthread_mutex_unlock(&server->lock);
        if (server->processes[i].joinable) pthread_join(server->processes[i].thread, NULL);
    }
}
