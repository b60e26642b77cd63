// The rig's own calibration, by a board or by the codes on anything.
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/calibrate/rig.h"
#include "rig/selfcal/selfcal.h"

void ffp_rig_calibration_defaults_into(FfpRigCalibration *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpRigCalibration){.width = 1920, .height = 1080},
                      sizeof(FfpRigCalibration));
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
    FfpRigCalibration own = ffp_rig_calibration_defaults();
    Call call = {&own, stats};
    if (!ffp_take_options(&own, options, "FfpRigCalibration", err) ||
        !ffp_need_texts(own.attitudes, own.n_attitudes, "attitudes", err) ||
        !ffp_need_texts(own.calibrations, own.n_calibrations, "calibrations", err) ||
        (own.turntable_board && own.n_angles > 0 && !ffp_need(own.angles, "angles", err)))
        return false;
    return ffp_call_run(context, work, &call, err);
}

void ffp_self_calibration_defaults_into(FfpSelfCalibration *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpSelfCalibration){.width = 1920, .height = 1080},
                      sizeof(FfpSelfCalibration));
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
    FfpSelfCalibration own = ffp_self_calibration_defaults();
    SelfCall call = {&own, stats};
    if (!ffp_take_options(&own, options, "FfpSelfCalibration", err) ||
        !ffp_need_texts(own.places, own.n_places, "places", err))
        return false;
    return ffp_call_run(context, self_work, &call, err);
}
