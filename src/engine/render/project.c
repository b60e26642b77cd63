// Which Gaussians are worked on where: chunks of the set, the same for any number of threads.
#include <string.h>
#include "engine/render/kernels/kernels.h"

// Splits the set and counts the Gaussians opaque enough to be seen.
static void split_chunks(FfpRaster *raster, const FfpGaussians *gaussians) {
    const int64_t share = (gaussians->count + FFP_CHUNKS - 1) / FFP_CHUNKS;
#pragma omp parallel for schedule(static)
    for (int c = 0; c < FFP_CHUNKS; c++) {
        const int64_t begin = c * share, end = begin + share, all = gaussians->count;
        FfpChunk chunk = {.begin = begin < all ? begin : all, .end = end < all ? end : all};
        for (int64_t i = chunk.begin; i < chunk.end; i++)
            chunk.drawn += gaussians->opacity[i] >= FFP_ALPHA_MIN;
        raster->chunks[c] = chunk;
    }
    raster->n_splats = 0;
    for (int c = 0; c < FFP_CHUNKS; c++) {
        raster->chunks[c].first = raster->n_splats;
        raster->n_splats += raster->chunks[c].drawn;
    }
}

void ffp_project_splats(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings) {
    split_chunks(raster, gaussians);
    ffp_raster_reserve((void **)&raster->splats, &raster->splats_size, (size_t)raster->n_splats + 1,
                       sizeof(FfpSplat));
    ffp_bin_reserve(raster);
    FfpProjectChunk *project = ffp_render_kernels()->project_chunk;
#pragma omp parallel for schedule(static)
    for (int c = 0; c < FFP_CHUNKS; c++) {
        project(raster, gaussians, camera, settings, &raster->chunks[c]);
        ffp_bin_count(raster, c);
    }
}

void ffp_project_splats_backward(const FfpRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 FfpGaussians *grad) {
    FfpProjectChunkBackward *backward = ffp_render_kernels()->project_chunk_backward;
#pragma omp parallel for schedule(static)
    for (int c = 0; c < FFP_CHUNKS; c++)
        backward(raster, gaussians, camera, settings, &raster->chunks[c], grad);
}
