// Drawing into memory: one view rasterised, any number of patterns.
#ifndef FFP_PIPELINE_RENDERER_H
#define FFP_PIPELINE_RENDERER_H

#include "core/base/call.h"
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/raw.h"
#include "engine/pipeline/batch.h"
#include "engine/render/pass.h"
#include "ffprocams.h" // drawing, maps and pixels, types alone (reconstruct.h says why)

typedef struct FfpRenderer {
    FfpBlocks blocks; // the pass's, which grows from call to call
    FfpRenderSettings settings;
    FfpViewPass *pass; // NULL: not aimed yet
    FfpSummed pattern; // shown last
    FfpCamera camera, projector;
    bool aimed, drawn; // by ffp_renderer_aim and ffp_renderer_forward, whose last call succeeded
    FfpBatch *batch;   // of views drawn together; NULL: none yet
} FfpRenderer;

FfpRenderer *ffp_renderer_make(FfpDrawing drawing);
void ffp_renderer_free(FfpRenderer *renderer);

// The handle's batch, with its blocks in use until the caller takes them out again (ffp_blocks_use(NULL)).
FfpBatch *ffp_renderer_batch(FfpRenderer *renderer);

// Rasterises for the camera and maps what it sees to the projector.
void ffp_renderer_draw(FfpRenderer *renderer, const FfpGaussians *gaussians, const FfpCamera *camera,
                       const FfpCamera *projector);

// A picture in the caller's memory, `size` bytes: sRGB-encoded RGB, U8 or F32 in [0,1], or linear RADIANCE;
// row_bytes 0: rows follow each other.
typedef struct FfpPictureOut {
    void *pixels;
    size_t size;
    FfpPixelType type;
    size_t row_bytes;
} FfpPictureOut;
// The view drawn last, under a pattern (without data: a dark projector) of a projector of that intensity.
bool ffp_renderer_relight(FfpRenderer *renderer, const FfpRaw *pattern, const double intensity[3],
                          FfpPictureOut out, FfpError *err);
// Its map, F32 [height,width,channels], into room for `count` numbers.
bool ffp_renderer_values(FfpRenderer *renderer, FfpMap map, float *out, size_t count, FfpError *err);

#endif
