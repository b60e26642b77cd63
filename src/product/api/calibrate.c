// The rig's own calibration, by a board or by the codes on anything.
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/calibrate/rig.h"
#include "rig/selfcal/selfcal.h"

FfpRigCalibration ffp_rig_calibration_defaults(void) {
    return (FfpRigCalibration){.width = 1920, .height = 1080};
}

typedef struct Call {
    const FfpRigCalibration *options;
    FfpRigCalibrationStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    return ffp_calibration_run(call->options, call->stats, err);
}

bool ffp_calibrate_rig(FfpContext *context, const FfpRigCalibration *options, FfpRigCalibrationStats *stats,
                       FfpError *err) {
    Call call = {options, stats};
    if (!ffp_need(options, "options", err) ||
        !ffp_need_texts(options->attitudes, options->n_attitudes, "attitudes", err) ||
        !ffp_need_texts(options->calibrations, options->n_calibrations, "calibrations", err) ||
        (options->turntable_board && options->n_angles > 0 && !ffp_need(options->angles, "angles", err)))
        return false;
    return ffp_call_run(context, work, &call, err);
}

FfpSelfCalibration ffp_self_calibration_defaults(void) {
    return (FfpSelfCalibration){.width = 1920, .height = 1080};
}

typedef struct SelfCall {
    const FfpSelfCalibration *options;
    FfpSelfCalibrationStats *stats;
} SelfCall;

static bool self_work(void *argument, FfpError *err) {
    const SelfCall *call = argument;
    return ffp_self_calibration_run(call->options, call->stats, err);
}

bool ffp_self_calibrate(FfpContext *context, const FfpSelfCalibration *options,
                        FfpSelfCalibrationStats *stats, FfpError *err) {
    SelfCall call = {options, stats};
    if (!ffp_need(options, "options", err) ||
        !ffp_need_texts(options->places, options->n_places, "places", err))
        return false;
    return ffp_call_run(context, self_work, &call, err);
}
