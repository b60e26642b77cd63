// A known device before a board: its pose, and the small least-squares problems of a turntable.
#ifndef FFP_CALIBRATE_POSE_H
#define FFP_CALIBRATE_POSE_H

#include <stdbool.h>
#include "calibrate/board.h"

// Differences [count] at a state moved by `by` [numbers] small numbers.
typedef void FfpDifferences(const void *state, const double *by, double *out);

// Moves a state to the least sum of squares by Levenberg and Marquardt with numeric derivatives (steps of
// `step`, one for each number). `move` changes the state. Returns the sum; `covariance` [numbers^2] or NULL:
// from the differences left over.
enum { FFP_NUMBERS_MAX = 10 };
typedef struct FfpDescent {
    void *state;
    FfpDifferences *differences;
    void (*move)(void *state, const double *by);
    int numbers, count;
    const double *step;
} FfpDescent;
double ffp_descend(const FfpDescent *problem, double *covariance);

// The median of n values, which it sorts; 0 of none.
double ffp_middle(double *values, int n);

// The ray (x, y, 1) that a device sees at a pixel; false where its lens has none.
bool ffp_device_ray(const FfpCvDevice *device, const double pixel[2], double ray[2]);
// Where it sees a point of its frame.
void ffp_device_project(const FfpCvDevice *device, const double point[3], double pixel[2]);

// Corner i in the board's frame, whose origin is its middle.
void ffp_board_point(const FfpBoard *board, int i, double point[3]);

typedef struct FfpBoardPose {
    double r[9], t[3]; // board (from its middle) to device
    double rms;        // pixels
} FfpBoardPose;
// From the attitude's corners in the camera. *found is false where no plane explains them.
bool ffp_board_pose(const FfpBoard *board, const FfpCvDevice *camera, const FfpAttitude *attitude,
                    FfpBoardPose *pose, bool *found, FfpError *err);

#endif
