// A calibration's files: what other programs read, and a report for people.
#ifndef FFP_CALIBRATE_CALIBRATE_H
#define FFP_CALIBRATE_CALIBRATE_H

#include "rig/chessboard/fit.h"
#include "rig/turntable/table.h"

// The calibration as OpenCV's FileStorage: XML or, by the name's ending (.yml, .yaml), YAML.
bool ffp_write_calibration(const FfpRigFit *fit, const char *path, FfpError *err);

// A page with the boards, their corners and errors, and what of the fields was covered. `table` may be NULL.
bool ffp_write_calibration_report(const FfpRigFit *fit, const FfpTableFit *table, const char *path,
                                  FfpError *err);

// {"axis", "point", "zero", "clockwise"} and, of an object, "angles", as `import --turntable` reads it, and
// how good it is. The point is that of the axis beside the board's middle: a board that stays where it lies
// on the table gives every calibration of the rig one world.
bool ffp_write_table(const FfpTableFit *fit, const char *path, FfpError *err);

#endif
