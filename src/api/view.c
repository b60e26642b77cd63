// The page that shows Gaussians in a browser.
#include <stdlib.h>
#include "api/arguments.h"
#include "api/relight.h"
#include "base/call.h"
#include "base/log.h"
#include "view/view.h"

#define PHOTOGRAPHS_MAX 4096

FfpViewing ffp_viewing_defaults(void) {
    return (FfpViewing){.photographs = 512};
}

typedef struct ViewCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpViewing *options;
    FfpViewingStats *stats;
} ViewCall;

static bool check(const FfpViewing *options, FfpError *err) {
    if (options->drawing.form == FFP_FORM_GS_PROCAMS)
        return ffp_fail(
            err, FFP_ERROR_UNSUPPORTED, "drawing",
            "the page draws light with its cosine and falloff only, which GS-ProCams' form has not");
    return (options->photographs >= 0 && options->photographs <= PHOTOGRAPHS_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "photographs", "%d pixels are not in 0 to %d",
                    options->photographs, PHOTOGRAPHS_MAX);
}

static bool view(void *argument, FfpError *err) {
    const ViewCall *call = argument;
    const FfpViewing *options = call->options;
    FfpCapture poses;
    FfpPageStats stats;
    if (!check(options, err)) return false;
    if (options->poses && !ffp_capture_read_targets(&poses, options->poses, call->capture, err)) return false;
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, NULL);
    const FfpPageSource source = {call->gaussians, call->capture, options->poses ? &poses : NULL, &settings,
                                  options->photographs};
    const bool ok = ffp_page_write(&source, options->file, &stats, err);
    if (options->poses) ffp_capture_free(&poses);
    if (!ok) return false;
    if (stats.patterns_left || stats.photographs_left)
        ffp_note("the page has room for %d of %d patterns and %d of %d photographs", stats.patterns,
                 stats.patterns + stats.patterns_left, stats.photographs,
                 stats.photographs + stats.photographs_left);
    if (call->stats)
        *call->stats =
            (FfpViewingStats){call->gaussians->count, stats.bytes, stats.patterns, stats.photographs};
    return true;
}

bool ffp_view(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
              const FfpViewing *options, FfpViewingStats *stats, FfpError *err) {
    ViewCall call = {gaussians, capture, options, stats};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(capture, "capture", err) ||
        !ffp_need(options, "options", err) || !ffp_need(options->file, "file", err) ||
        !ffp_check_drawing(options->drawing, err))
        return false;
    return ffp_call_run(context, view, &call, err);
}
