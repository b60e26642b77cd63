// Jobs: their words, what they say, and what is left of them on disk.
#define _GNU_SOURCE
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "rules.h"
#include "typed.h"

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
        if (i > 0) fputc(' ', out);
        ffp_studio_type(out, command->words[i]);
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
void ffp_studio_hear_text(FfpStudioJob *job, const char *line) {
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

void ffp_studio_hear_event(FfpStudioJob *job, const char *line) {
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

// --- From its beginning to its end. ---

bool ffp_studio_start(FfpStudio *studio, FfpStudioJob *job, const char *name) {
    if (job->end == FFP_JOB_RUNNING || studio->closing) return false;
    snprintf(job->name, sizeof job->name, "%s", name);
    job->end = FFP_JOB_RUNNING, job->stop = false, job->current = 0, job->logged = 0, job->log[0] = 0;
    job->error[0] = 0, job->failed = false;
    json_decref(job->findings);
    job->findings = json_array();
    job->began = now(), job->seconds = 0, job->stage[0] = 0;
    const bool runs = studio->platform->run(studio, job);
    if (!runs) job->end = FFP_JOB_FAILED;
    ffp_studio_changed(studio);
    return runs;
}

void ffp_studio_stop(FfpStudio *studio, FfpStudioJob *job) {
    if (job->end != FFP_JOB_RUNNING) return;
    studio->platform->stop(studio, job);
    job->stop = true;
}

bool ffp_studio_begin_command(FfpStudio *studio, FfpStudioJob *job, const char *descriptor,
                              char *words[FFP_STUDIO_WORDS + 3]) {
    if (job->stop || job->failed || job->current >= job->n_commands) return false;
    const FfpStudioCommand *command = &job->commands[job->current];
    char *typed = ffp_studio_typed(command), *prompt = NULL;
    if (typed && asprintf(&prompt, "$ %s", typed) >= 0) {
        ffp_studio_hear_text(job, prompt);
        free(prompt);
    }
    free(typed);
    job->stage[0] = 0, job->done = job->total = 0;
    words[0] = command->words[0], words[1] = (char *)"--events", words[2] = (char *)descriptor;
    memcpy(words + 3, command->words + 1, (size_t)command->count * sizeof *words); // with the NULL
    ffp_studio_changed(studio);
    if (command->failed) ffp_studio_end_command(job, "the command cannot be started");
    return !command->failed;
}

void ffp_studio_end_command(FfpStudioJob *job, const char *how) {
    job->stage[0] = 0;
    job->failed = how != NULL;
    if (how) ffp_studio_hear_text(job, how);
    job->current++;
}

void ffp_studio_end_job(FfpStudio *studio, FfpStudioJob *job) {
    char path[FFP_STUDIO_NAME];
    job->seconds = now() - job->began;
    job->end = job->stop ? FFP_JOB_STOPPED : job->failed ? FFP_JOB_FAILED : FFP_JOB_DONE;
    snprintf(path, sizeof path, "logs/%s.txt", job->name);
    if (!write_findings(studio, job) || !ffp_studio_write(studio, path, job->log, job->logged))
        snprintf(studio->notice, sizeof studio->notice, "%s cannot be written: %s", path, strerror(errno));
    ffp_studio_changed(studio);
}
