// OpenCV's part of a calibration, by its module (opencv_module.h).
#include <omp.h>
#include <stddef.h>
#include "rig/chessboard/opencv_module.h"

static const FfpCvModule *load(FfpError *err) {
    static FfpModule module = {.name = "opencv",
                               .version = FFP_CV_MODULE_VERSION,
                               .purpose = "calibrations are fitted by OpenCV",
                               .origin =
                                   "the package ffprocams-calibrate, or a build with libopencv-calib3d-dev"};
    return ffp_module_load(&module, err);
}

bool ffp_cv_available(FfpError *err) {
    return load(err) != NULL;
}

// One thread: OpenCV's fits solve thousands of small systems by LAPACK, whose threads would wait for each
// other.
static int begin_alone(void) {
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    return threads;
}

static bool end_alone(int threads, FfpCvOutcome outcome, const FfpCvMessage *message, FfpError *err) {
    omp_set_num_threads(threads);
    if (outcome == FFP_CV_NO_MEMORY)
        return ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory while %s", message->text);
    return outcome == FFP_CV_DONE ||
           ffp_fail(err, FFP_ERROR_FILE, NULL, "OpenCV failed while %s", message->text);
}

bool ffp_cv_chessboard(const unsigned char *grey, int width, int height, int columns, int rows,
                       double *corners, bool *found, FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->chessboard(grey, width, height, columns, rows, corners, found, &m), &m,
                     err);
}

bool ffp_cv_homography(const double *from, const double *to, int n, double tolerance, double h[9],
                       unsigned char *inside, bool *found, FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->homography(from, to, n, tolerance, h, inside, found, &m), &m, err);
}

bool ffp_cv_calibrate(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                      FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->calibrate(views, fixed, device, poses, &m), &m, err);
}

bool ffp_cv_pair(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second, double r[9],
                 double t[3], double *rms, double *whole, FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->pair(views, first, second, r, t, rms, whole, &m), &m, err);
}

bool ffp_cv_relative(const double *first, const double *second, int n, double tolerance, double r[9],
                     double t[3], unsigned char *inside, bool *found, FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->relative(first, second, n, tolerance, r, t, inside, found, &m), &m,
                     err);
}

bool ffp_cv_pose(const double *points, const double *rays, int n, double tolerance, double r[9], double t[3],
                 unsigned char *inside, bool *found, FfpError *err) {
    FfpCvMessage m;
    const FfpCvModule *module = load(err);
    if (!module) return false;
    const int threads = begin_alone();
    return end_alone(threads, module->pose(points, rays, n, tolerance, r, t, inside, found, &m), &m, err);
}
