// Gaussians for other programs.
#include "product/export/export.h"
#include "core/base/call.h"
#include "product/api/arguments.h"

void ffp_export_defaults_into(FfpExport *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpExport){.resolution = 128}, sizeof(FfpExport));
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpExport *options;
    FfpExportStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    return ffp_export_run(call->gaussians, call->capture, call->options, call->stats, err);
}

bool ffp_export(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                const FfpExport *options, FfpExportStats *stats, FfpError *err) {
    FfpExport own = ffp_export_defaults();
    Call call = {gaussians, capture, &own, stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_take_options(&own, options, "FfpExport", err) ||
        !ffp_need(own.file, "file", err) || !ffp_check_drawing((FfpDrawing){.form = own.form}, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
