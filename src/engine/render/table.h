// The functions that a device provides for the render room (core/base/device.h): those of render.h and
// resolve.h under the same names, on arrays in the device's memory. Everything else in the room is built from
// these.
#ifndef FFP_RENDER_TABLE_H
#define FFP_RENDER_TABLE_H

#include "core/base/device.h"
#include "engine/render/render.h"
#include "engine/render/resolve.h"

typedef struct FfpDeviceRaster FfpDeviceRaster; // the device's part of an FfpRaster

typedef struct FfpRenderTable {
    FfpDeviceRaster *(*raster_new)(void);
    void (*raster_free)(void *raster);
    void (*rasterise)(FfpDeviceRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                      const FfpRenderSettings *settings, FfpGbuffer *out);
    void (*rasterise_backward)(FfpDeviceRaster *raster, const FfpGaussians *gaussians,
                               const FfpCamera *camera, const FfpRenderSettings *settings,
                               const FfpGbuffer *out, const FfpGbuffer *grad_out, FfpGaussians *grad);
    void (*map_with_shadow)(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                            const FfpCamera *projector, const FfpRenderSettings *settings, FfpMapping *out);
    void (*light)(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                  const FfpCamera *projector, FfpTransport *out);
    void (*light_backward)(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                           const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer);
    void (*shade)(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
                  const real intensity[3], const FfpSummed *pattern, FfpImage *out);
    // grad_intensity and grad_pattern must be NULL: their sums over pixels are the CPU's alone.
    void (*shade_backward)(const FfpMapping *mapping, const FfpTransport *transport, const real intensity[3],
                           const FfpSummed *pattern, const FfpImage *grad_image, FfpGbuffer *grad_gbuffer,
                           FfpTransport *grad_transport, real grad_intensity[3], FfpSummed *grad_pattern);
    void (*gbuffer_clear)(FfpGbuffer *gbuffer); // all planes there
    void (*average_plane)(const real *samples, int side, int width, int height, int channels, real *out);
    void (*average_gbuffer)(const FfpGbuffer *samples, int side, FfpGbuffer *out);
    void (*average_gbuffer_backward)(const FfpGbuffer *grad_out, int side, FfpGbuffer *grad_samples);
    void (*resolve)(const FfpImage *mean, const real *opacity, int side, FfpImage *picture);
    void (*resolve_backward)(const FfpImage *mean, const real *opacity, int side,
                             const FfpImage *grad_picture, FfpImage *grad_mean, real *grad_opacity);
} FfpRenderTable;

// Of the device that the thread works on; NULL: the CPU.
static inline const FfpRenderTable *ffp_render_table(void) {
    return ffp_device() ? ffp_device()->render : NULL;
}

#endif
