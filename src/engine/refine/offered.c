// A fit on the device that is offered for long work, or on the CPU.
#include "core/base/device.h"
#include "core/base/log.h"
#include "core/capture/uploaded.h"
#include "engine/refine/fit.h"

bool ffp_refine_offered(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                        int n_patterns, const FfpRefineSettings *settings, FfpRefineResult *result,
                        FfpError *err) {
    const FfpDevice *device = ffp_device() ? NULL : ffp_device_offered();
    const char *beyond = device ? ffp_refine_beyond_devices(settings) : NULL;
    if (beyond) ffp_note("the fit runs on the CPU: %s has no code for the GPU", beyond);
    if (!device || beyond) return ffp_refine(gaussians, capture, patterns, n_patterns, settings, result, err);
    ffp_device_use(device);
    FfpCapture uploaded = {0};
    if (!settings->there) uploaded = ffp_capture_uploaded(capture, patterns, n_patterns);
    FfpGaussians there = ffp_gaussians_uploaded(gaussians);
    const bool ok = ffp_refine(&there, settings->there ? settings->there : &uploaded, patterns, n_patterns,
                               settings, result, err);
    if (ok) ffp_gaussians_download(gaussians, &there);
    ffp_gaussians_free(&there);
    if (!settings->there) ffp_capture_free(&uploaded);
    ffp_device_use(NULL);
    return ok;
}
