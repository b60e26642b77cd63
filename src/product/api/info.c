// Descriptions of files.
#include "core/base/call.h"
#include "core/base/text.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "product/api/json.h"
#include "product/describe/describe.h"
#include "rig/findings/tell.h"

typedef struct Call {
    const char *path;
    const char *html;
    bool json;
    char *text;
} Call;

// Takes the text's place.
static FfpText *json_of(FfpText *text, const FfpFindings *found) {
    FfpText *json = ffp_text_new();
    FILE *out = ffp_text_stream(json);
    char *plain = ffp_text_end(text);
    fputs("{\"text\": ", out);
    ffp_put_json(out, plain);
    fputs(", \"findings\": [", out);
    for (int i = 0; i < found->count; i++) {
        char *one = ffp_finding_json(&found->items[i]);
        fprintf(out, "%s\n %s", i > 0 ? "," : "", one ? one : "null");
        ffp_free(one);
    }
    fputs("]}\n", out);
    ffp_free(plain);
    return json;
}

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    FfpText *text = ffp_text_new();
    FfpFindings found = {0};
    const bool ok = ffp_describe(ffp_text_stream(text), call->path, &found, err);
    if (ok) ffp_findings_pass(&found);
    if (ok && call->json) text = json_of(text, &found);
    if (ok)
        call->text = ffp_text_end(text);
    else
        ffp_text_free(text);
    ffp_findings_free(&found);
    return ok;
}

char *ffp_info(FfpContext *context, const char *path, FfpError *err) {
    Call call = {.path = path};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, work, &call, err) ? call.text : NULL;
}

char *ffp_info_json(FfpContext *context, const char *path, FfpError *err) {
    Call call = {.path = path, .json = true};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, work, &call, err) ? call.text : NULL;
}

static bool report(void *argument, FfpError *err) {
    const Call *call = argument;
    return ffp_describe_report(call->path, call->html, err);
}

bool ffp_info_report(FfpContext *context, const char *path, const char *html, FfpError *err) {
    Call call = {.path = path, .html = html};
    return ffp_need(path, "path", err) && ffp_need(html, "html", err) &&
           ffp_call_run(context, report, &call, err);
}
