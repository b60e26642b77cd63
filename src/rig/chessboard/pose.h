// The pose of a known device in front of a board.
#ifndef FFP_CHESSBOARD_POSE_H
#define FFP_CHESSBOARD_POSE_H

#include <stdbool.h>
#include "rig/chessboard/board.h"

// Steps of a fit at most, and when another is not worth it (core/numerics/least_squares.h).
enum { FFP_FIT_STEPS = 60 };
#define FFP_FIT_WORTH 1e-12

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
