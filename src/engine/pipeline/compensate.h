// Patterns under which cameras see their targets.
#ifndef FFP_PIPELINE_COMPENSATE_H
#define FFP_PIPELINE_COMPENSATE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/named.h"
#include "core/image/raw.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_compensate_images (ffprocams.h). `pictures`: the options' own, [n_targets], or NULL where
// targets are files. `stats` may be NULL.
FfpImages *ffp_compensation_run(const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpCompensation *options, const FfpRaw *pictures,
                                FfpCompensationStats *stats, FfpError *err);
// The same into files: the work of ffp_compensate.
bool ffp_compensation_write(const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, const FfpRaw *pictures,
                            FfpCompensationStats *stats, FfpError *err);

#endif
