// Events as lines of JSON for a program that runs this one: --events.
#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "cli.h"

static const double interval = 0.1; // seconds between two lines of a stage's progress

static FILE *events; // NULL: nobody listens
static json_t *kept; // findings; NULL: they are not wanted
static char stage[80];
static double told_at;

bool ffp_cli_open_events(const char *descriptor) {
    char *end;
    const long number = strtol(descriptor, &end, 10);
    if (!*descriptor || *end || number < 1 || number > 1 << 20) return false;
    if (fcntl((int)number, F_SETFD, FD_CLOEXEC) != 0) return false;
    events = fdopen((int)number, "w");
    return events != NULL;
}

int ffp_cli_events(void) {
    return events ? fileno(events) : -1;
}

// Takes the object. Text that is no UTF-8 makes none, and nothing is told of it.
static void put(json_t *object) {
    char *line =
        object ? json_dumps(object, JSON_COMPACT | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(6)) : NULL;
    json_decref(object);
    if (line) {
        fprintf(events, "%s\n", line);
        fflush(events);
    }
    free(line);
}

void ffp_cli_event_finding(const FfpFinding *finding) {
    char *text = events || kept ? ffp_finding_json(finding) : NULL;
    json_t *object = text ? json_loads(text, 0, NULL) : NULL;
    if (object && events) put(json_pack("{s:s, s:O}", "event", "finding", "finding", object));
    if (object && kept) json_array_append(kept, object);
    json_decref(object);
    ffp_free(text);
}

json_t *ffp_cli_keep_findings(void) {
    if (!kept) kept = json_array();
    return kept;
}

void ffp_cli_event_log(FfpLogLevel level, const char *text) {
    if (events)
        put(json_pack("{s:s, s:s}", "event", level == FFP_LOG_WARNING ? "warning" : "note", "text", text));
}

void ffp_cli_event_error(const FfpError *err) {
    if (events)
        put(json_pack("{s:s, s:b, s:s*, s:s, s:s*}", "event", "error", "fault", err->code == FFP_ERROR_FAULT,
                      "code", err->finding, "text", err->text, "where", err->where[0] ? err->where : NULL));
}

void ffp_cli_event_progress(const FfpProgress *p) {
    struct timespec time = {0};
    const char *name = p->stage ? p->stage : "";
    if (!events) return;
    clock_gettime(CLOCK_MONOTONIC, &time);
    const double now = (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
    if (strcmp(stage, name) == 0 && (!p->stage || now - told_at < interval)) return;
    snprintf(stage, sizeof stage, "%s", name);
    told_at = now;
    put(json_pack("{s:s, s:s, s:I, s:I, s:f}", "event", "progress", "stage", stage, "done",
                  (json_int_t)p->done, "total", (json_int_t)p->total, "left", p->left_s));
}
