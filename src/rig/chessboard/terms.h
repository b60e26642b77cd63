// Which lens terms the photographs determine, and whether the calibration can do without the others.
#ifndef FFP_CHESSBOARD_TERMS_H
#define FFP_CHESSBOARD_TERMS_H

#include "rig/chessboard/fit.h"

// Standard deviations are those of each device's own fit. A lens term is left open by the photographs where
// its deviation is above half its value and moves the picture's corner by more than a pixel.
enum { FFP_TERMS = 9 };
extern const char *const ffp_term_names[FFP_TERMS]; // fx fy cx cy k1 k2 p1 p2 k3
double ffp_term(const FfpCvDevice *device, int term);
// By how many pixels a lens term of 1 moves the corner of the picture farthest from the principal point.
double ffp_term_reach(const FfpCvDevice *device, int term);
bool ffp_term_open(const FfpCvDevice *device, int term);

// Warns of the terms that are open, and tries to do with fewer: one that is still open is given up where
// boards that are held out in turn, from a fit to the others, lie where they should at least as well without
// it.
// False only where OpenCV fails.
bool ffp_judge_terms(const FfpRigFit *fit, FfpError *err);

#endif
