// The parts of a calibration done by OpenCV: corners of a chessboard, homographies, and the fits of one
// device and of two. They are in a module (opencv_module.h), which is loaded on first use. Pixel centres are
// at integers here, as in OpenCV. Nothing here allocates memory from the call, so that no call is aborted
// from inside C++: results go into the caller's arrays.
#ifndef FFP_CHESSBOARD_OPENCV_H
#define FFP_CHESSBOARD_OPENCV_H

#include <stdbool.h>
#include "core/base/error.h"

#ifdef __cplusplus
extern "C" {
#endif

// False with an error that says what to install: there is no module.
bool ffp_cv_available(FfpError *err);

// The inner corners of a chessboard, `columns` x `rows`, in an 8-bit grey picture: *found, and `corners`
// [rows * columns, 2], row by row, refined to parts of a pixel.
bool ffp_cv_chessboard(const unsigned char *grey, int width, int height, int columns, int rows,
                       double *corners, bool *found, FfpError *err);

// H with to ~ H from for n points [n,2], robustly: `inside` [n] says which lie within `tolerance` (RANSAC,
// then least squares over those). *found is false where there is none.
bool ffp_cv_homography(const double *from, const double *to, int n, double tolerance, double h[9],
                       unsigned char *inside, bool *found, FfpError *err);

// Views of a board, one behind the other: counts[i] points each. `board` [sum,3] in its own frame, `first`
// and `second` [sum,2] in the pixels of one device and, for a pair, of another.
typedef struct FfpCvViews {
    int n;
    const int *counts;
    const double *board, *first, *second;
} FfpCvViews;

// Terms of a device that are not fitted. Lens terms are 0 then; the principal point stays the middle.
enum {
    FFP_CV_FIX_K1 = 1,
    FFP_CV_FIX_K2 = 2,
    FFP_CV_FIX_K3 = 4,
    FFP_CV_FIX_TANGENTIAL = 8,
    FFP_CV_FIX_CENTRE = 16,
    FFP_CV_FIX_ASPECT = 32 // fx = fy
};

typedef struct FfpCvDevice {
    int width, height;
    double matrix[9];    // 3x3
    double lens[5];      // k1 k2 p1 p2 k3
    double deviation[9]; // standard deviations of fx fy cx cy k1 k2 p1 p2 k3; 0 where it was not fitted
    double rms;          // pixels
} FfpCvDevice;

// Fits a device of the given size to `first` (Zhang 2000; OpenCV's calibrateCamera, extended by
// deviations). `poses` [n,6] gets each view's rotation vector
// and translation, board to device.
bool ffp_cv_calibrate(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                      FfpError *err);

// The motion X_second = R X_first + T of two devices that stay as they are (OpenCV's stereoCalibrate). `rms`
// [n,2] gets each view's root mean square distance in both devices; *whole that of all.
bool ffp_cv_pair(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second, double r[9],
                 double t[3], double *rms, double *whole, FfpError *err);

// The motion X_second = R X_first + t, |t| = 1, between two places of one camera that see the same n points
// along rays (x, y, 1), [n,2] each, robustly (the five-point method of Nister 2004 in RANSAC): `inside` [n]
// says which lie within `tolerance` of their epipolar lines, in front of both. *found is false where none
// explains eight of them.
bool ffp_cv_relative(const double *first, const double *second, int n, double tolerance, double r[9],
                     double t[3], unsigned char *inside, bool *found, FfpError *err);

// The motion X_camera = R X + t of a camera that sees n known points [n,3] along rays (x, y, 1), [n,2],
// robustly: `inside` [n] says which lie within `tolerance`. *found is false where none explains six of them.
bool ffp_cv_pose(const double *points, const double *rays, int n, double tolerance, double r[9], double t[3],
                 unsigned char *inside, bool *found, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
