// Gaussians for programs that do not simulate projectors.
#ifndef FFP_EXPORT_EXPORT_H
#define FFP_EXPORT_EXPORT_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"

// The work of ffp_export (ffprocams/render.h). `stats` may be NULL.
bool ffp_export_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                    FfpExportStats *stats, FfpError *err);

#endif
