// From corners to the optics of camera and projector and the motion between them.
#ifndef FFP_CHESSBOARD_FIT_H
#define FFP_CHESSBOARD_FIT_H

#include "rig/chessboard/board.h"

enum { FFP_FIT_ATTITUDES_LEAST = 3 }; // Zhang 2000: as many give all intrinsics

typedef struct FfpRigFit {
    FfpBoard board;
    FfpAttitude *attitudes; // [n]; one with a problem is left out
    int n;
    bool linear;            // photographs hold linear light
    unsigned fixed[2];      // of camera and projector: FFP_CV_FIX_...
    FfpCvDevice devices[2]; // camera, projector: sizes given, the rest found
    double r[9], t[3];      // X_projector = R X_camera + T
    double rms;             // of all corners in both, with one pose of the board for both
    double spread;          // largest angle between two boards, degrees
} FfpRigFit;

// Fits all, leaving out corners and attitudes that are out of line; each is given in a note. Errors: fewer
// than FFP_FIT_ATTITUDES_LEAST attitudes are left (why, of each), boards all parallel, a focal length that
// they do not tell.
bool ffp_fit_rig(FfpRigFit *fit, FfpError *err);

int ffp_attitudes_used(const FfpRigFit *fit);
// True if the projector alone fits far worse than the camera: its own electronics bend its picture.
bool ffp_projector_bent(const FfpRigFit *fit);

// The normal of a board as a pinhole of a guessed focal length sees it in pictures of this size. Boards that
// are parallel in truth have the same normals at any focal length, since these are those of their common
// horizon.
bool ffp_board_normal(const FfpBoard *board, const FfpAttitude *attitude, int width, int height,
                      double normal[3], FfpError *err);

#endif
