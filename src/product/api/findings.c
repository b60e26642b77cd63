// Findings about a capture, and findings as JSON.
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "product/api/json.h"
#include "rig/checks/checks.h"
#include "rig/findings/tell.h"

typedef struct Call {
    const FfpCapture *capture;
    FfpFinding *out;
    int count;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    FfpFindings found = {0};
    (void)err;
    ffp_rig_look(&found, call->capture, &call->capture->views[0].camera);
    call->out = ffp_findings_packed(&found);
    call->count = found.count;
    ffp_findings_free(&found);
    return true;
}

FfpFinding *ffp_capture_check(FfpContext *context, const FfpCapture *capture, int *count, FfpError *err) {
    Call call = {.capture = capture};
    if (!ffp_need_photographs(capture, err) || !ffp_need(count, "count", err)) return NULL;
    if (!ffp_call_run(context, work, &call, err)) return NULL;
    *count = call.count;
    return call.out;
}

// --- As JSON. ---

// Names of files are bytes.
static json_t *json_of(const char *text) {
    json_t *value = json_string(text);
    if (value) return value;
    char *plain = strdup(text);
    for (char *c = plain; c && *c; c++)
        if ((unsigned char)*c >= 0x80) *c = '?';
    value = plain ? json_string(plain) : NULL;
    free(plain);
    return value;
}

static void set_text(json_t *object, const char *key, const char *text) {
    if (text) json_object_set_new(object, key, json_of(text));
}

void ffp_put_json(FILE *out, const char *text) {
    json_t *value = json_of(text);
    char *dumped = json_dumps(value, JSON_ENCODE_ANY);
    fputs(dumped ? dumped : "\"\"", out);
    json_decref(value);
    free(dumped);
}

char *ffp_finding_json(const FfpFinding *finding) {
    static const char *const severities[] = {"ok", "note", "doubt", "fault"};
    if (!finding || (unsigned)finding->severity > FFP_FINDING_FAULT) return NULL;
    json_t *object = json_object();
    set_text(object, "code", finding->code);
    set_text(object, "severity", severities[finding->severity]);
    set_text(object, "subject", finding->subject);
    set_text(object, "view", finding->view);
    set_text(object, "other", finding->other);
    if (isfinite(finding->figure)) json_object_set_new(object, "figure", json_real(finding->figure));
    if (isfinite(finding->limit)) json_object_set_new(object, "limit", json_real(finding->limit));
    set_text(object, "text", finding->text);
    set_text(object, "advice", finding->advice);
    set_text(object, "setting", finding->setting);
    char *dumped = json_dumps(object, JSON_COMPACT | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(6));
    char *text = dumped ? ffp_try_alloc(strlen(dumped) + 1, 1) : NULL;
    if (text) strcpy(text, dumped);
    json_decref(object);
    free(dumped);
    return text;
}
