// From folders of photographs to a calibration file, a report and the axis of a turntable.
#ifndef FFP_CALIBRATE_CALIBRATE_H
#define FFP_CALIBRATE_CALIBRATE_H

#include "rig/calibrate/fit.h"
#include "rig/calibrate/shots.h"
#include "rig/calibrate/table.h"

// Decodes and locates the board in every folder's photographs. Every attitude that cannot serve has its
// problem. Errors: a picture that cannot be read; cameras' pictures of two sizes; no board in any of them.
bool ffp_read_attitudes(FfpRigFit *fit, const FfpShotFolders *folders, FfpError *err);
void ffp_rig_fit_free(FfpRigFit *fit); // its attitudes

// Where the board is in each of `n` photographs, as JSON (docs/reference/formats.md, "Where a board is").
// Photographs without a board are listed, too, with what is wrong. Errors: a picture that cannot be read.
bool ffp_write_boards_seen(const FfpBoard *board, const char *const *photographs, int n, const char *path,
                           FfpError *err);

// The calibration as OpenCV's FileStorage: XML or, by the name's ending (.yml, .yaml), YAML.
bool ffp_write_calibration(const FfpRigFit *fit, const char *path, FfpError *err);

// A page with the boards, their corners and errors, and what of the fields was covered. `table` may be NULL.
bool ffp_write_calibration_report(const FfpRigFit *fit, const FfpTableFit *table, const char *path,
                                  FfpError *err);

#endif
