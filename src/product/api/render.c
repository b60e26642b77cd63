// Pictures of Gaussians, in files.
#include "core/base/call.h"
#include "engine/pipeline/pictures.h"
#include "product/api/arguments.h"

FfpPictures ffp_pictures_defaults(void) {
    return (FfpPictures){.rate = 15};
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPictures *options;
    int written;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->written = ffp_pictures_run(call->gaussians, call->capture, call->options, err);
    return call->written >= 0;
}

int ffp_render_pictures(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                        const FfpPictures *options, FfpError *err) {
    Call call = {gaussians, capture, options, 0};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(options, "options", err) ||
        !ffp_need(options->folder, "folder", err) ||
        !ffp_need_texts(options->views, options->n_views, "views", err) ||
        !ffp_need_texts(options->patterns, options->n_patterns, "patterns", err) ||
        !ffp_check_drawing(options->drawing, err))
        return -1;
    return ffp_call_run(context, work, &call, err) ? call.written : -1;
}
