// The page that shows Gaussians in a browser.
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "product/view/write.h"

#define PHOTOGRAPHS_MAX 4096

void ffp_page_defaults_into(FfpPage *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpPage){.photographs = 512}, sizeof(FfpPage));
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
    FfpPage own = ffp_page_defaults();
    Call call = {gaussians, capture, &own, stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(capture, "capture", err) ||
        !ffp_take_options(&own, options, "FfpPage", err) || !ffp_need(own.file, "file", err) ||
        !ffp_check_drawing(own.drawing, err) || !check(&own, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
