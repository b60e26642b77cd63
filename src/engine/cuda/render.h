// The render room's functions on the device (engine/render/table.h). Included behind launch.h.
#ifndef FFP_CUDA_RENDER_H
#define FFP_CUDA_RENDER_H

extern "C" {
#include "engine/render/table.h"
}

FfpDeviceRaster *ffp_cuda_raster_new();
void ffp_cuda_raster_free(void *raster);
void ffp_cuda_rasterise(FfpDeviceRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings, FfpGbuffer *out);
void ffp_cuda_rasterise_backward(FfpDeviceRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 const FfpGbuffer *out, const FfpGbuffer *grad_out, FfpGaussians *grad);

void ffp_cuda_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                              const FfpCamera *projector, const FfpRenderSettings *settings, FfpMapping *out);
void ffp_cuda_light(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, FfpTransport *out);
void ffp_cuda_light_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                             const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer);
void ffp_cuda_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
                    const real intensity[3], const FfpSummed *pattern, FfpImage *out);
void ffp_cuda_shade_backward(const FfpMapping *mapping, const FfpTransport *transport,
                             const real intensity[3], const FfpSummed *pattern, const FfpImage *grad_image,
                             FfpGbuffer *grad_gbuffer, FfpTransport *grad_transport, real grad_intensity[3],
                             FfpSummed *grad_pattern);

void ffp_cuda_gbuffer_clear(FfpGbuffer *gbuffer);
void ffp_cuda_average_plane(const real *samples, int side, int width, int height, int channels, real *out);
void ffp_cuda_average_gbuffer(const FfpGbuffer *samples, int side, FfpGbuffer *out);
void ffp_cuda_average_gbuffer_backward(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples);
void ffp_cuda_resolve(const FfpImage *mean, const real *opacity, int side, FfpImage *picture);
void ffp_cuda_resolve_backward(const FfpImage *mean, const real *opacity, int side,
                               const FfpImage *grad_picture, FfpImage *grad_mean, real *grad_opacity);

#endif
