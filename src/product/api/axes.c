// Splats of other programs, turned into a capture's world.
#include "engine/pipeline/axes.h"
#include "core/base/call.h"
#include "ffprocams.h"
#include "product/api/arguments.h"

typedef struct Call {
    FfpGaussians *gaussians;
    const char *path;
    const FfpCapture *capture;
    const FfpUp *up;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    if (!call->up)
        return ffp_gaussians_are_relightable(call->path) ||
               ffp_gaussians_find_axes(call->gaussians, call->capture, call->path, err);
    ffp_gaussians_stand(call->gaussians, *call->up == FFP_UP_Y, *call->up == FFP_UP_MINUS_Y);
    return true;
}

bool ffp_gaussians_turn(FfpContext *context, FfpGaussians *gaussians, const char *path,
                        const FfpCapture *capture, const FfpUp *up, FfpError *err) {
    Call call = {gaussians, path, capture, up};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(path, "path", err) ||
        !ffp_need(capture, "capture", err))
        return false;
    if (up && (unsigned)*up > FFP_UP_MINUS_Y)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "up", "invalid value %d", (int)*up);
    return ffp_call_run(context, work, &call, err);
}
