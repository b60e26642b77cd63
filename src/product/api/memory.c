#include "product/api/memory.h"
#include <math.h>
#include "core/base/real.h"
#include "core/capture/manifest.h"
#include "core/capture/node.h"

FfpRaw ffp_raw_of(const FfpPicture *picture) {
    static const FfpRawType types[] = {FFP_RAW_U8, FFP_RAW_U16, FFP_RAW_F32};
    const FfpRawType unknown = (FfpRawType)(FFP_RAW_F32 + 1); // refused where the pixels are read
    const size_t type = (size_t)picture->type;
    return (FfpRaw){.data = picture->data,
                    .width = picture->width,
                    .height = picture->height,
                    .channels = picture->channels,
                    .type = type < sizeof types / sizeof *types ? types[type] : unknown,
                    .row_bytes = picture->row_bytes};
}

static bool in_range(double value, double low, double high) {
    return value >= low && value <= high; // false for what is not a number
}

bool ffp_camera_of(FfpCamera *camera, const FfpPinhole *pinhole, int least, const char *name, FfpError *err) {
    const double *p = pinhole->pose;
    if (!in_range(pinhole->width, least, FFP_IMAGE_SIDE_MAX) ||
        !in_range(pinhole->height, least, FFP_IMAGE_SIDE_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "a size of %d x %d is not in %d to %d", pinhole->width,
                        pinhole->height, least, FFP_IMAGE_SIDE_MAX);
    if (!in_range(pinhole->fx, 1e-3, FFP_PIXELS_MAX) || !in_range(pinhole->fy, 1e-3, FFP_PIXELS_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "focal lengths of %g and %g are out of range",
                        pinhole->fx, pinhole->fy);
    if (!in_range(fabs(pinhole->cx), 0, FFP_PIXELS_MAX) || !in_range(fabs(pinhole->cy), 0, FFP_PIXELS_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "a principal point of %g, %g is out of range",
                        pinhole->cx, pinhole->cy);
    *camera = (FfpCamera){.width = pinhole->width,
                          .height = pinhole->height,
                          .fx = (real)pinhole->fx,
                          .fy = (real)pinhole->fy,
                          .cx = (real)pinhole->cx,
                          .cy = (real)pinhole->cy};
    for (int i = 0; i < 16; i++) {
        if (!in_range(fabs(p[i]), 0, FFP_LENGTH_MAX))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "number %d of the pose is out of range", i);
        camera->pose[i] = (real)p[i];
    }
    const char *wrong = ffp_pose_settle(camera->pose, false);
    return !wrong || ffp_fail(err, FFP_ERROR_ARGUMENT, name, "pose: %s", wrong);
}

FfpPinhole ffp_pinhole_of(const FfpCamera *camera) {
    FfpPinhole pinhole = {.width = camera->width,
                          .height = camera->height,
                          .fx = (double)camera->fx,
                          .fy = (double)camera->fy,
                          .cx = (double)camera->cx,
                          .cy = (double)camera->cy};
    for (int i = 0; i < 16; i++) pinhole.pose[i] = (double)camera->pose[i];
    return pinhole;
}
