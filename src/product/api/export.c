// Gaussians for other programs.
#include "product/export/export.h"
#include "core/base/call.h"
#include "product/api/arguments.h"

FfpExport ffp_export_defaults(void) {
    return (FfpExport){.resolution = 128};
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
    Call call = {gaussians, capture, options, stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(options, "options", err) ||
        !ffp_need(options->file, "file", err) || !ffp_check_drawing((FfpDrawing){.form = options->form}, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
