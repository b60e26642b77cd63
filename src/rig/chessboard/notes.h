// Messages about the attitudes: each is given once, with the names of the attitudes that it applies to.
#ifndef FFP_CHESSBOARD_NOTES_H
#define FFP_CHESSBOARD_NOTES_H

#include "rig/chessboard/fit.h"

// Notes on what the photographs lack: overexposed boards, codes too fine for the camera.
void ffp_note_photographs(const FfpRigFit *fit);
// Attitudes and corners that were left out.
void ffp_note_left_out(const FfpRigFit *fit);
// Why attitudes are left out, "; NAMES: WHY" for each reason, as far as there is room.
void ffp_list_problems(const FfpRigFit *fit, char *text, size_t size);

#endif
