#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/text.h"
#include "ffprocams.h"
#include "lab/bench/bench.h"

typedef struct Call {
    const char *json;
    char *text;
} Call;

static bool benchmark(void *argument, FfpError *err) {
    Call *call = argument;
    if (!ffp_output_prepare(call->json, err)) return false; // not when a minute is over
    FfpText *text = ffp_text_new();
    if (!ffp_bench(ffp_text_stream(text), call->json, err)) return false;
    call->text = ffp_text_end(text);
    return true;
}

char *ffp_benchmark(FfpContext *context, const char *json, FfpError *err) {
    Call call = {.json = json};
    return ffp_call_run(context, benchmark, &call, err) ? call.text : NULL;
}
