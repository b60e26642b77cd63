// A chessboard in one attitude: its corners in the camera's picture and on the projector's panel. Pixel
// centres lie at integers here, as OpenCV has them.
#ifndef FFP_CHESSBOARD_BOARD_H
#define FFP_CHESSBOARD_BOARD_H

#include "core/image/image.h"
#include "rig/chessboard/opencv.h"

typedef struct FfpBoard {
    int columns, rows; // of corners inside the board
    double square;     // side of a square, the unit of length of all that comes out
} FfpBoard;

#define FFP_CLIPPED_LUMA 0.99 // of full scale: at the camera's limit

typedef enum FfpCornerState {
    FFP_CORNER_USED,
    FFP_CORNER_DARK,   // too few pixels around it could be decoded
    FFP_CORNER_UNEVEN, // what was decoded around it lies in no plane, or away from the others
    FFP_CORNER_FAR,    // its distance from where the calibration puts it is out of line
    FFP_CORNER_STATES
} FfpCornerState;

typedef struct FfpAttitude {
    const char *name;
    int n;                       // corners: columns * rows; 0: no board was found
    double *camera, *projector;  // [n,2]
    unsigned char *camera_state; // [n] FfpCornerState; of the camera only USED and FAR
    unsigned char *projector_state;
    double *camera_off, *projector_off; // [n,2] found minus where the device's own fit puts it
    double camera_rms, projector_rms;   // of the corners used, in each device's own fit
    double rms[2];                      // camera and projector, with one pose for both
    double normal[3];                   // of the board, in the camera's frame
    double clipped;                     // share of the board's light pixels that are saturated under white
    int dropped[2];                     // finest bits of columns and rows that the photographs do not resolve
    char problem[768];                  // why it is left out; "": it is not
    const char *finding;                // code of the finding that this is; NULL: of none
    FfpImage picture;                   // of the board, small, for the report; [height,width,1]
    double scale;                       // its pixels to one of the camera's
} FfpAttitude;

void ffp_attitude_free(FfpAttitude *attitude);
// Leaves it out by an error of its photographs.
void ffp_attitude_leave_out(FfpAttitude *attitude, const FfpError *why);

// A picture as camera values, sRGB-encoded luminance in [0,1]. [height,width,1]
bool ffp_board_read(FfpImage *grey, const char *path, FfpError *err);

// Looks for the board in a grey picture. Where there is none, or it goes on beyond its corners, the problem
// is set. False only where OpenCV fails.
bool ffp_board_find(const FfpBoard *board, const FfpImage *grey, FfpAttitude *attitude, FfpError *err);

// Which boards of other sizes are found there, as words for the user; "" for none.
bool ffp_board_guess(const FfpBoard *board, const FfpImage *grey, char text[160], FfpError *err);

// 1 on the board, up to the squares around its outermost corners, 0 elsewhere. [height,width,1]
FfpImage ffp_board_region(const FfpBoard *board, const FfpAttitude *attitude, int width, int height);

// Puts the corners on the projector's panel of `size` pixels by homographies of the positions around each
// (Moreno and Taubin 2012, section 3.2): map and the finest bits that it lacks as ffp_gray_decode_view has
// them. Sets a problem where they make no sense for a plane.
bool ffp_board_project(const FfpBoard *board, const FfpImage *map, const int dropped[2], const int size[2],
                       FfpAttitude *attitude, FfpError *err);

// From the board's squares to the camera's pixels, by the corners within `tolerance` pixels of it.
bool ffp_board_homography(const FfpBoard *board, const FfpAttitude *attitude, double tolerance, double h[9],
                          bool *found, FfpError *err);

// The place of corner i on the board, in squares.
static inline double ffp_corner_column(const FfpBoard *board, int i) {
    return i % board->columns;
}
static inline double ffp_corner_row(const FfpBoard *board, int i) {
    return i / board->columns; // NOLINT(bugprone-integer-division)
}

#endif
