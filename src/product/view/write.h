// The page as the public header asks for it.
#ifndef FFP_VIEW_WRITE_H
#define FFP_VIEW_WRITE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"

// The work of ffp_write_page (ffprocams/render.h). `stats` may be NULL.
bool ffp_page_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPage *options,
                  FfpPageStats *stats, FfpError *err);

#endif
