// From calibration files and photographs to a capture folder.
#ifndef FFP_RIG_IMPORT_H
#define FFP_RIG_IMPORT_H

#include "core/base/error.h"
#include "ffprocams.h" // options, types alone (engine/pipeline/reconstruct.h says why)

#define FFP_CODES_MOST 32 // photographs of Gray codes that are kept for fits

// The work of ffp_import_capture (ffprocams/rig.h): a capture folder, whole or not at all. Errors name the
// setting, or file and field.
bool ffp_import(const FfpImport *options, FfpError *err);

#endif
