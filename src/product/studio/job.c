// The program's other commands at work, one after the other: each writes what happens to a pipe (--events),
// from which the page has progress and findings, and its text to another. Both end on disk.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
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

// --- What happens. ---

static void copy_text(char *to, size_t size, const json_t *from) {
    const char *text = json_string_value(from);
    snprintf(to, size, "%s", text ? text : "");
}

static void take_event(FfpStudioJob *job, const char *line) {
    json_t *event = json_loads(line, 0, NULL), *finding = json_object_get(event, "finding");
    const char *kind = json_string_value(json_object_get(event, "event"));
    if (kind && strcmp(kind, "progress") == 0) {
        copy_text(job->stage, sizeof job->stage, json_object_get(event, "stage"));
        job->done = json_integer_value(json_object_get(event, "done"));
        job->total = json_integer_value(json_object_get(event, "total"));
    } else if (kind && strcmp(kind, "error") == 0) {
        copy_text(job->error, sizeof job->error, json_object_get(event, "text"));
    } else if (finding && json_array_size(job->findings) < FFP_STUDIO_FINDINGS) {
        json_array_append(job->findings, finding);
    }
    json_decref(event);
}

// --- Processes. ---

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

// Starts the command at hand, and the pipes to read from; false: it cannot be.
static bool start_command(FfpStudio *studio, FfpStudioJob *job, int from[PIPES]) {
    const FfpStudioCommand *command = &job->commands[job->current];
    char *words[FFP_STUDIO_WORDS + 3] = {command->words[0], "--events", "3"};
    int ends[PIPES], both[2];
    memcpy(words + 3, command->words + 1, (size_t)(command->count - 1) * sizeof *words);
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
    job->process = child;
    if (child >= 0) return true;
    for (int k = 0; k < PIPES; k++) close(from[k]);
    job->process = 0;
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
        if (line->length > 0) (which == EVENTS ? take_event : add_line)(job, line->text);
        line->length = 0;
    }
}

static void listen_to(FfpStudio *studio, FfpStudioJob *job, const int from[PIPES]) {
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
            pthread_mutex_lock(&studio->lock);
            if (got > 0) hear(job, &lines[k], k, bytes, (size_t)got);
            studio->version++; // of nothing in the folder
            pthread_mutex_unlock(&studio->lock);
        }
    }
    for (int k = 0; k < PIPES; k++) close(from[k]);
    free(lines);
}

// Runs the current command; true if it ended well. Called and left with the lock.
static bool run_command(FfpStudio *studio, FfpStudioJob *job) {
    char *typed = ffp_studio_typed(&job->commands[job->current]), line[64];
    int status = 0;
    job->stage[0] = 0, job->done = job->total = 0;
    if (typed) {
        char *prompt = NULL;
        if (asprintf(&prompt, "$ %s", typed) >= 0) add_line(job, prompt), free(prompt);
        free(typed);
    }
    int from[PIPES];
    const bool started = !job->commands[job->current].failed && start_command(studio, job, from);
    ffp_studio_changed(studio);
    if (!started) {
        add_line(job, "the command cannot be started");
        return false;
    }
    pthread_mutex_unlock(&studio->lock);
    listen_to(studio, job, from);
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

// The commands, and what they found, as logs/NAME.json.
static bool write_findings(FfpStudio *studio, FfpStudioJob *job) {
    char path[FFP_STUDIO_NAME];
    json_t *commands = json_array();
    for (int k = 0; k < job->n_commands; k++) {
        char *typed = ffp_studio_typed(&job->commands[k]);
        json_array_append_new(commands, json_string(typed ? typed : ""));
        free(typed);
    }
    json_t *all = json_pack("{s:o, s:O}", "commands", commands, "findings", job->findings);
    char *text = all ? json_dumps(all, JSON_INDENT(1) | JSON_PRESERVE_ORDER) : NULL;
    json_decref(all);
    snprintf(path, sizeof path, "logs/%s.json", job->name);
    const bool ok = text && ffp_studio_write(studio, path, text, strlen(text));
    free(text);
    return ok;
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
    if (!write_findings(studio, job) || !ffp_studio_write(studio, path, job->log, job->logged))
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
    job->error[0] = 0;
    json_decref(job->findings);
    job->findings = json_array();
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
    json_decref(job->findings);
    job->findings = NULL;
    ffp_studio_clear(job);
}
