// A fit by whatever the program may use for long work.
#include "base/device.h"
#include "capture/uploaded.h"
#include "refine/refine.h"

// The host's numbers back into the host's arrays, which are as many.
static void bring_back(FfpGaussians *here, const FfpGaussians *there) {
    const size_t n = (size_t)here->count * sizeof(real);
    ffp_memory_download(here->centre, there->centre, 3 * n);
    ffp_memory_download(here->scale, there->scale, 3 * n);
    ffp_memory_download(here->rotation, there->rotation, 4 * n);
    ffp_memory_download(here->opacity, there->opacity, n);
    ffp_memory_download(here->albedo, there->albedo, 3 * n);
    ffp_memory_download(here->roughness, there->roughness, n);
    ffp_memory_download(here->ambient, there->ambient, 3 * n);
}

bool ffp_refine_offered(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                        int n_patterns, const FfpRefineSettings *settings, FfpRefineResult *result,
                        FfpError *err) {
    const FfpDevice *device = ffp_device_offered();
    if (!device || ffp_device() || settings->density.on || settings->smooth > 0)
        return ffp_refine(gaussians, capture, patterns, n_patterns, settings, result, err);
    ffp_device_use(device);
    FfpCapture capture_there = ffp_capture_uploaded(capture);
    FfpGaussians there = ffp_gaussians_uploaded(gaussians);
    const bool ok = ffp_refine(&there, &capture_there, patterns, n_patterns, settings, result, err);
    if (ok) bring_back(gaussians, &there);
    ffp_gaussians_free(&there);
    ffp_capture_free(&capture_there);
    ffp_device_use(NULL);
    return ok;
}
