// What a file holds.
#include "core/base/call.h"
#include "core/base/text.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "product/describe/describe.h"

typedef struct Call {
    const char *path;
    const char *html;
    char *text;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    FfpText *text = ffp_text_new();
    const bool ok = ffp_describe(ffp_text_stream(text), call->path, err);
    if (ok)
        call->text = ffp_text_end(text);
    else
        ffp_text_free(text);
    return ok;
}

char *ffp_info(FfpContext *context, const char *path, FfpError *err) {
    Call call = {path, NULL, NULL};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, work, &call, err) ? call.text : NULL;
}

static bool report(void *argument, FfpError *err) {
    const Call *call = argument;
    return ffp_describe_report(call->path, call->html, err);
}

bool ffp_info_report(FfpContext *context, const char *path, const char *html, FfpError *err) {
    Call call = {path, html, NULL};
    return ffp_need(path, "path", err) && ffp_need(html, "html", err) &&
           ffp_call_run(context, report, &call, err);
}
