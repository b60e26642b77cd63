// The page that shows Gaussians in a browser.
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "product/view/write.h"

#define PHOTOGRAPHS_MAX 4096

FfpPage ffp_page_defaults(void) {
    return (FfpPage){.photographs = 512};
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPage *options;
    FfpPageStats *stats;
} Call;

static bool check(const FfpPage *options, FfpError *err) {
    if (options->drawing.form == FFP_FORM_GS_PROCAMS)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, "drawing",
                        "the page always draws light with cosine and falloff, which GS-ProCams' form lacks");
    return (options->photographs >= 0 && options->photographs <= PHOTOGRAPHS_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "photographs", "%d pixels are not in 0 to %d",
                    options->photographs, PHOTOGRAPHS_MAX);
}

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    return ffp_page_run(call->gaussians, call->capture, call->options, call->stats, err);
}

bool ffp_write_page(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                    const FfpPage *options, FfpPageStats *stats, FfpError *err) {
    Call call = {gaussians, capture, options, stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(capture, "capture", err) ||
        !ffp_need(options, "options", err) || !ffp_need(options->file, "file", err) ||
        !ffp_check_drawing(options->drawing, err) || !check(options, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
