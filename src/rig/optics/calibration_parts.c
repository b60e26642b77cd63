// Parts of calibrations that several formats share.
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/capture/manifest.h"
#include "rig/optics/calibration.h"
#include "rig/optics/matrix.h"

bool ffp_node_intrinsics(const FfpNode *field, double shift, FfpOptics *optics, FfpError *err) {
    double k[9];
    if (!ffp_node_matrix_of(field, 3, 3, k, err)) return false;
    if (fabs(k[3]) > 0 || fabs(k[6]) > 0 || fabs(k[7]) > 0 || fabs(k[8] - 1) > 1e-6)
        return ffp_node_fail(field, err, "is %s: rows must be fx 0 cx, 0 fy cy, 0 0 1",
                             k[2] == 0 && k[5] == 0 && fabs(k[6]) + fabs(k[7]) > 0 && fabs(k[8] - 1) <= 1e-6
                                 ? "transposed, as MATLAB writes camera matrices"
                                 : "not a camera matrix");
    if (fabs(k[1]) > 1e-6 * fabs(k[0])) return ffp_node_fail(field, err, "skewed pixels are not modelled");
    if (!(k[0] >= 1e-3 && k[4] >= 1e-3 && k[0] <= FFP_PIXELS_MAX && k[4] <= FFP_PIXELS_MAX))
        return ffp_node_fail(field, err, "focal lengths %g, %g are not positive numbers of pixels", k[0],
                             k[4]);
    if (!(fabs(k[2]) <= FFP_PIXELS_MAX && fabs(k[5]) <= FFP_PIXELS_MAX))
        return ffp_node_fail(field, err, "principal point %g, %g is too far away", k[2], k[5]);
    optics->fx = k[0], optics->fy = k[4];
    optics->cx = k[2] + shift, optics->cy = k[5] + shift;
    return true;
}

bool ffp_node_lens(const FfpNode *field, FfpOptics *optics, FfpError *err) {
    FfpMatrix lens;
    if (!ffp_node_matrix(field, &lens, err)) return false;
    const int n = lens.rows * lens.cols;
    if (lens.rows != 1 && lens.cols != 1)
        return ffp_node_fail(field, err, "must be one row or column of coefficients");
    if (n < 4) return ffp_node_fail(field, err, "%d coefficients; expected k1 k2 p1 p2 [k3]", n);
    for (int i = 5; i < n; i++) {
        if (lens.values[i] != 0) {
            return ffp_node_fail(
                field, err,
                "%d coefficients of an unknown distortion model; k1 k2 p1 p2 k3 are removed, "
                "so calibrate without rational, thin-prism or fisheye terms",
                n);
        }
    }
    for (int i = 0; i < 5; i++) optics->lens[i] = i < n ? lens.values[i] : 0;
    return true;
}

bool ffp_settle_size(FfpOptics *optics, const FfpNode *field, int width, int height, FfpError *err) {
    if (optics->width > 0 && (optics->width != width || optics->height != height)) {
        return ffp_node_fail(field, err, "%d x %d pixels, but %d x %d were given before", width, height,
                             optics->width, optics->height);
    }
    optics->width = width, optics->height = height;
    return true;
}

bool ffp_calibration_new_stops(FfpCalibration *calibration, const FfpNode *field, int n, FfpError *err) {
    if (calibration->n_stops > 0) return ffp_node_fail(field, err, "the views were already given");
    if (n < 1 || n > FFP_VIEWS_MAX)
        return ffp_node_fail(field, err, "%d views; 1 to %d are allowed", n, FFP_VIEWS_MAX);
    calibration->stops = ffp_alloc((size_t)n, sizeof *calibration->stops);
    calibration->n_stops = n;
    return true;
}

static bool name_stop(FfpCalibration *calibration, int stop, const FfpNode *field, const char *name,
                      size_t length, FfpError *err) {
    char *id = calibration->stops[stop].id;
    const bool fits = length < FFP_NAME_MAX;
    memcpy(id, name, fits ? length : 0);
    id[fits ? length : 0] = 0;
    if (!ffp_is_name(id)) return ffp_node_fail(field, err, "cannot derive a view's name from '%.100s'", name);
    for (int i = 0; i < stop; i++) {
        if (strcmp(calibration->stops[i].id, id) == 0)
            return ffp_node_fail(field, err, "duplicate view '%s'", id);
    }
    return true;
}

bool ffp_name_stop(FfpCalibration *calibration, int stop, const FfpNode *field, const char *id,
                   FfpError *err) {
    return name_stop(calibration, stop, field, id, strlen(id), err);
}

bool ffp_name_stop_by_file(FfpCalibration *calibration, int stop, const FfpNode *field, const char *path,
                           FfpError *err) {
    const char *base = ffp_basename(path), *dot = strrchr(base, '.');
    const size_t length = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    return name_stop(calibration, stop, field, base, length, err);
}

void ffp_place_projector(FfpCalibration *calibration, const double p2w[16]) {
    memcpy(calibration->p2c, p2w, sizeof calibration->p2c);
    calibration->has_projector_pose = true;
}
