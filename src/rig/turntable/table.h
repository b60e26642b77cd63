// The axis of a turntable from a chessboard that lies or stands on it, at known angles.
#ifndef FFP_TURNTABLE_TABLE_H
#define FFP_TURNTABLE_TABLE_H

#include "core/capture/capture.h"
#include "rig/chessboard/board.h"
#include "rig/shots/folders.h"
#include "rig/turntable/axis.h"

enum { FFP_TABLE_STOPS_LEAST = 3 };

typedef struct FfpTableStop {
    char view[FFP_NAME_MAX]; // which tells its photographs
    bool left_out;           // its angle is not known
} FfpTableStop;

typedef struct FfpTableFit {
    FfpAxis axis;   // camera coordinates, the square's unit; points up in the picture
    bool reversed;  // the angles given are left-handed about it
    double zero[3]; // from the axis to the board's middle at angle 0, unit vector; all 0: they are too near
    int n;          // stops
    const struct FfpTableStop *stops; // [n] of an object, whose angles these are; NULL: of the board
    const double *angles;             // [n] degrees, as given
    FfpAttitude *attitudes;           // [n]; camera alone; owned
    int used;
    double rms;         // pixels, over all corners with one board and one axis
    double tilt, shift; // standard deviations, the camera's with them: of the direction, degrees; of the
                        // place, across it
    double off_angle;   // root mean square of what each stop's own pose turns otherwise, degrees
} FfpTableFit;

// `folder` has one photograph for each angle, in natural order. The camera is known as well as its deviations
// say (0: nothing is known of that). Errors: another number of photographs, pictures of another size, fewer
// than FFP_TABLE_STOPS_LEAST with a board, angles all alike, poses that no turn by these angles explains.
bool ffp_fit_table(FfpTableFit *fit, const FfpBoard *board, const FfpCvDevice *camera, const char *folder,
                   const double *angles, int n_angles, FfpError *err);
void ffp_table_free(FfpTableFit *fit);

#endif
