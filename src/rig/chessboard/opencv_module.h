// OpenCV's part of a calibration: a module (core/base/module.h), loaded by opencv.c. The functions are those
// of opencv.h, with errors as codes and texts.
#ifndef FFP_CALIBRATE_OPENCV_MODULE_H
#define FFP_CALIBRATE_OPENCV_MODULE_H

#include "core/base/module.h"
#include "rig/chessboard/opencv.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { FFP_CV_MODULE_VERSION = 2 }; // of the table below

typedef enum FfpCvOutcome { FFP_CV_DONE, FFP_CV_FAILED, FFP_CV_NO_MEMORY } FfpCvOutcome;
typedef struct FfpCvMessage {
    char text[400];
} FfpCvMessage;

typedef struct FfpCvModule {
    int version;
    FfpCvOutcome (*chessboard)(const unsigned char *grey, int width, int height, int columns, int rows,
                               double *corners, bool *found, FfpCvMessage *message);
    FfpCvOutcome (*homography)(const double *from, const double *to, int n, double tolerance, double h[9],
                               unsigned char *inside, bool *found, FfpCvMessage *message);
    FfpCvOutcome (*calibrate)(const FfpCvViews *views, unsigned fixed, FfpCvDevice *device, double *poses,
                              FfpCvMessage *message);
    FfpCvOutcome (*pair)(const FfpCvViews *views, const FfpCvDevice *first, const FfpCvDevice *second,
                         double r[9], double t[3], double *rms, double *whole, FfpCvMessage *message);
    FfpCvOutcome (*relative)(const double *first, const double *second, int n, double tolerance, double r[9],
                             double t[3], unsigned char *inside, bool *found, FfpCvMessage *message);
    FfpCvOutcome (*pose)(const double *points, const double *rays, int n, double tolerance, double r[9],
                         double t[3], unsigned char *inside, bool *found, FfpCvMessage *message);
} FfpCvModule;

extern FFP_MODULE_EXPORT const FfpCvModule ffp_opencv_module;

#ifdef __cplusplus
}
#endif

#endif
