// Several views of one set of Gaussians under the same patterns, drawn into the caller's memory, and the
// gradients of what was drawn.
#ifndef FFP_PIPELINE_BATCH_H
#define FFP_PIPELINE_BATCH_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/raw.h"
#include "engine/render/pass.h"
#include "ffprocams.h" // maps, types alone (reconstruct.h says why)

// The job of one forward call; all arrays are the caller's.
typedef struct FfpBatchJob {
    const FfpGaussians *gaussians;         // its arrays must stay until the last backward call
    int n_views;                           // all cameras of one size, all projectors too
    const FfpCamera *cameras, *projectors; // [n_views]
    int n_patterns;
    const FfpImage *patterns; // [n_patterns] RGB of the projectors' size; data NULL: dark
    bool same_patterns;       // those of the last call instead
    real intensity[3];
    bool linear, gradients;
} FfpBatchJob;

// Passes, pattern tables and kept radiance: blocks of the handle that owns them (FfpBlocks), which must be in
// use during all of these calls.
typedef struct FfpBatch FfpBatch;
FfpBatch *ffp_batch_new(const FfpRenderSettings *settings);
void ffp_batch_free(FfpBatch *batch); // NULL is allowed
// pictures: [n_views, n_patterns, height, width, 3]; maps: NULL, or of each map NULL or [n_views, height,
// width, channels].
void ffp_batch_forward(FfpBatch *batch, const FfpBatchJob *job, float *pictures, float *const *maps);

// The last forward call's sizes, for who checks what it is given.
typedef struct FfpBatchShape {
    int64_t gaussians;
    int views, patterns, pattern_width, pattern_height;
    size_t pictures; // numbers of all of them
    bool gradients;  // they were announced
} FfpBatchShape;
FfpBatchShape ffp_batch_shape(const FfpBatch *batch);
// Gradients with respect to everything in `out` that is not NULL, which they replace.
void ffp_batch_backward(FfpBatch *batch, const float *grad_pictures, const float *const *grad_maps,
                        const FfpRenderGradients *out);

#endif
