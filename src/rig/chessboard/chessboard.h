// A chessboard photographed in several attitudes, found in each.
#ifndef FFP_CHESSBOARD_CHESSBOARD_H
#define FFP_CHESSBOARD_CHESSBOARD_H

#include "rig/chessboard/fit.h"
#include "rig/shots/folders.h"

// Decodes and locates the board in every folder's photographs. An attitude that cannot be used gets a
// `problem`. Errors: a picture that cannot be read; cameras' pictures of two sizes; no board in any of them.
bool ffp_read_attitudes(FfpRigFit *fit, const FfpShotFolders *folders, FfpError *err);
void ffp_rig_fit_free(FfpRigFit *fit); // its attitudes

// Where the board is in each of `n` photographs, as JSON (docs/reference/formats/calibrations.md, "Where a
// board is"). Photographs without a board are listed, too, with what is wrong. Errors: a picture that cannot
// be read.
bool ffp_write_boards_seen(const FfpBoard *board, const char *const *photographs, int n, const char *path,
                           FfpError *err);

#endif
