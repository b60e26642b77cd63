// Pictures of Gaussians, in files.
#include "core/base/call.h"
#include "engine/pipeline/pictures.h"
#include "product/api/arguments.h"

void ffp_pictures_defaults_into(FfpPictures *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpPictures){.rate = 15}, sizeof(FfpPictures));
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
    FfpPictures own = ffp_pictures_defaults();
    Call call = {gaussians, capture, &own, 0};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_take_options(&own, options, "FfpPictures", err) ||
        !ffp_need(own.folder, "folder", err) || !ffp_need_texts(own.views, own.n_views, "views", err) ||
        !ffp_need_texts(own.patterns, own.n_patterns, "patterns", err) ||
        !ffp_check_drawing(own.drawing, err))
        return -1;
    return ffp_call_run(context, work, &call, err) ? call.written : -1;
}
