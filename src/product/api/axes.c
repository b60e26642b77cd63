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
        !ffp_need(capture, "capture", err) || (up && !ffp_check_choice((int)*up, FFP_UP_MINUS_Y, "up", err)))
        return false;
    return ffp_call_run(context, work, &call, err);
}
