// Patterns under which cameras see their targets.
#ifndef FFP_PIPELINE_COMPENSATE_H
#define FFP_PIPELINE_COMPENSATE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/named.h"
#include "core/image/raw.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_compensate_images (ffprocams/render.h). `pictures`: the options' own, [n_targets], or NULL
// where targets are files. `stats` may be NULL.
FfpImages *ffp_compensation_run(const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpCompensation *options, const FfpRaw *pictures,
                                FfpCompensationStats *stats, FfpError *err);
// A copy that holds the photographs under black and white of the views that are solved for, at the size that
// patterns are solved for, where the capture has them in files (core/capture/photographs.h): for many runs,
// since each would read them. It shares everything else with the capture. If it fails, nothing has to be
// released.
bool ffp_compensation_hold(FfpCapture *held, const FfpCapture *capture, const FfpCompensation *options,
                           FfpError *err);
void ffp_compensation_release(FfpCapture *held, const FfpCapture *capture);
// The same into files: the work of ffp_compensate.
bool ffp_compensation_write(const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, const FfpRaw *pictures,
                            FfpCompensationStats *stats, FfpError *err);

#endif
