// From a capture to Gaussians, step by step. The pipeline's options and results are types of the public
// header: twins of theirs would have the same fields with the same meaning, and every new option would have
// to be added in three places. Only types are taken from the header: nothing in the engine calls a public
// function, and the room links without them.
#ifndef FFP_PIPELINE_RECONSTRUCT_H
#define FFP_PIPELINE_RECONSTRUCT_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/network/network.h"
#include "ffprocams.h"

// The work of ffp_reconstruct (ffprocams/reconstruct.h), in the capture's own units. `stats` may be NULL.
FfpGaussians *ffp_reconstruction_run(const FfpCapture *capture, const FfpReconstruction *options,
                                     FfpReconstructionStats *stats, FfpError *err);

// How well its Gaussians reproduce the capture's photographs, with their noise, under the patterns that it
// used, and predict those of ffp_capture_unseen: sets the figures of `stats` in dB, least_view, unseen and
// score_s.
bool ffp_reconstruction_score(const FfpGaussians *gaussians, const FfpCapture *capture,
                              const FfpReconstruction *options, FfpReconstructionStats *stats, FfpError *err);

// The inputs of options->model's network from the capture, on the CPU: after the same steps as above, up to
// the forward pass. Release with ffp_prepared_free.
FfpPrepared *ffp_reconstruction_inputs(const FfpCapture *capture, const FfpReconstruction *options,
                                       FfpError *err);

#endif
