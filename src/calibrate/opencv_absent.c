// A build without OpenCV (cmake/opencv.cmake): what of `calibrate` is OpenCV's says what is missing.
#include "calibrate/opencv.h"

bool ffp_cv_there(FfpError *err) {
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, NULL,
                    "this build has no OpenCV, which calibrations are fitted by: install it (Debian's "
                    "libopencv-calib3d-dev), then configure and build again");
}

bool ffp_cv_chessboard(const unsigned char *grey, int width, int height, int columns, int rows,
                       double *corners, bool *found, FfpError *err) {
    (void)grey, (void)width, (void)height, (void)columns, (void)rows, (void)corners, (void)found;
    return ffp_cv_there(err);
}

bool ffp_cv_homography(const double *from, const double *to, int n, double tolerance, double h[9],
                       unsigned char *inside, bool *found, FfpError *err) {
    (void)from, (void)to, (void)n, (void)tolerance, (void)h, (void)inside, (void)found;
    return ffp_cv_there(err);
}

bool ffp_cv_calibrate(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                      FfpError *err) {
    (void)views, (void)fixed, (void)device, (void)poses;
    return ffp_cv_there(err);
}

bool ffp_cv_pair(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second, double r[9],
                 double t[3], double *rms, double *whole, FfpError *err) {
    (void)views, (void)first, (void)second, (void)r, (void)t, (void)rms, (void)whole;
    return ffp_cv_there(err);
}
