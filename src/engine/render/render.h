// Projector-aware rendering of relightable Gaussians, forward and backward (docs/design/architecture.md,
// "light"). Rasterise a view once to G-buffers, then shade it under any number of patterns. These are the
// steps, at one sample a pixel; pass.h puts them together.
//
// All of it works on the device that the thread uses (core/base/device.h): the arrays of Gaussians,
// G-buffers, mappings, images and patterns are then in the device's memory, everything else stays on the
// host. Objects made on a device can only be used and freed there. The shadow map's planes belong to the
// raster, as on the CPU.
#ifndef FFP_RENDER_RENDER_H
#define FFP_RENDER_RENDER_H

#include <stdbool.h>
#include "core/base/real.h"
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/image.h"
#include "core/image/lookup.h"

typedef struct FfpRenderSettings {
    int samples;       // a side of the grid that looks at a pixel (pass.h): 2; 1 in the paper's form
    real blur;         // px^2 added to the 2D covariance: 0.002 (0.3 in the paper's form)
    bool compensation; // opacity times sqrt(det / det_blurred)
    real firmness;     // k: with d = opacity exp(-sigma), alpha = d (1 + k (1 - d)); 0: d itself, 1: as two
                       // splats that coincide, steeper towards the rim
    bool footprint;    // pattern averaged over the camera pixel's footprint; otherwise plain bilinear
    bool shadows;      // visibility from the projector
    int shadow_side;   // shadow map's longer side in pixels (160)
    real shadow_bias;  // depth slack as a share of the projector's distance (0.05)
    bool smooth;       // outlines of pictures finer than the photographs (outline.h); the CPU's, and without
                       // gradients
    bool even_light;   // light without n.l and falloff, as in GS-ProCams' released program
} FfpRenderSettings;
FfpRenderSettings ffp_render_defaults(void);
FfpRenderSettings ffp_render_paper(void);      // blur 0.3, no compensation, bilinear, no shadows
FfpRenderSettings ffp_render_gs_procams(void); // the paper's form in even light
enum { FFP_SAMPLES_MAX = 4 };                  // of FfpRenderSettings.samples
FfpRenderSettings ffp_render_settings(bool paper, int samples); // either; samples 0: as many as it has

// Accumulated attributes of one view; [height,width(,3)] each. Accumulations are raw sums of W_i b_i: shading
// divides.
typedef struct FfpGbuffer {
    int width, height;
    real *opacity;    // O = sum W
    real *depth;      // sum W z
    real *normal;     // sum W n, 3, n facing the camera
    real *albedo;     // sum W A, 3
    real *roughness;  // sum W rho
    real *ambient;    // sum W C_amb, 3
    real *scattered;  // sum W C_sc, 3; NULL: not blended
    real *distortion; // sum_ij W_i W_j |z_i - z_j| over ordered pairs (FF-ProCams, Eq. 22)
} FfpGbuffer;
FfpGbuffer ffp_gbuffer_new(int width, int height); // zeroed, without scattered light; also used for gradients
void ffp_gbuffer_add_scattered(FfpGbuffer *gbuffer); // zeroed; no change where it exists
void ffp_gbuffer_clear(FfpGbuffer *gbuffer);
void ffp_gbuffer_free(FfpGbuffer *gbuffer);

// The binned, sorted splats of one view: what the backward pass needs again.
typedef struct FfpRaster FfpRaster;
FfpRaster *ffp_raster_new(void); // reusable between views and steps
void ffp_raster_free(FfpRaster *raster);

// Projects, bins, sorts and blends (EWA splatting, 3DGS conventions; 16x16 tiles, alpha in [1/255, 0.99],
// T >= 1e-4). The normal of a splat is its shortest axis turned to the camera. Not drawn: opacity below
// 1/255, and splats nearer to the camera's plane than their own largest deviation. out has the camera's size.
void ffp_rasterise(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                   const FfpRenderSettings *settings, FfpGbuffer *out);
// ADDS to grad (same count as the Gaussians) the gradient of a loss whose gradient with respect to the
// G-buffer is grad_out. Must follow ffp_rasterise with the same arguments. The same bits for any number of
// threads.
void ffp_rasterise_backward(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                            const FfpRenderSettings *settings, const FfpGbuffer *out,
                            const FfpGbuffer *grad_out, FfpGaussians *grad);

// Where each camera pixel's surface point lies in the projector, and whether light reaches it. Constants in
// the backward pass: footprint and visibility.
typedef struct FfpMapping {
    int width, height;
    real *uv;     // [.,2] projector pixels
    real *extent; // [.,2] footprint in projector pixels, >= 1 (1 when settings->footprint is off)
    real even;    // above 0: light is I / even^2 everywhere, whatever the cosine n.l: the distance between
                  // projector and the Gaussians' middle
    real lit[4];  // centre and size of the box on the pattern in which the Gaussians lie, pixels
    real *visibility; // [0,1], 0 where the point is outside the pattern, behind the projector or O too small
} FfpMapping;
FfpMapping ffp_mapping_new(int width, int height);
void ffp_mapping_free(FfpMapping *mapping);
// FfpMapping.even of these Gaussians: 0 where settings->even_light is off.
real ffp_even_light(const FfpGaussians *gaussians, const FfpCamera *projector,
                    const FfpRenderSettings *settings);
// FfpMapping.lit: the box around the centres of those that scatter light, within the projector's picture; all
// of it where none does.
void ffp_lit_box(const FfpGaussians *gaussians, const FfpCamera *projector, real lit[4]);
// Rasterises the shadow map with `raster` when shadows are on (so call it before or after, never between, a
// rasterise/backward pair that shares the raster).
void ffp_map_to_projector(FfpRaster *raster, const FfpGaussians *gaussians, const FfpGbuffer *gbuffer,
                          const FfpCamera *camera, const FfpCamera *projector,
                          const FfpRenderSettings *settings, FfpMapping *out);
// Its two parts, of which the second leaves out->even and ->lit as they are. The shadow map holds opacity and
// depth as the projector sees them, its longer side settings->shadow_side pixels, and is of size 0 when
// shadows are off or those of this projector are baked; its planes are the raster's.
FfpGbuffer ffp_shadow_map(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *projector,
                          const FfpRenderSettings *settings);
void ffp_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                         const FfpCamera *projector, const FfpRenderSettings *settings, FfpMapping *out);

// The transport of the projector's light in a view, independent of the pattern: a pixel's radiance is ambient
// + factor * intensity * pattern around uv. Also used for gradients.
typedef struct FfpTransport {
    int width, height;
    real *factor; // [.,3] f_r visibility max(n.l, 0) O / distance^2; 0 where no light comes to the camera
    real *uv;     // [.,2] pattern position
    real *look; // [.,9] what ffp_shade saw of the pattern, where light comes to the camera: its mean colour,
                // how that changes with u, and with v. NULL: not kept, the gradient looks again. The CPU's
} FfpTransport;
FfpTransport ffp_transport_new(int width, int height); // zeroed; nothing is kept
void ffp_transport_clear(FfpTransport *transport);
void ffp_transport_free(FfpTransport *transport);
// Pixels with O <= 0.001 get no light; roughness counts as at least 0.02.
void ffp_light(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
               const FfpCamera *projector, FfpTransport *out);
// ADDS to the G-buffer's gradient (depth included: through point, directions, distance and uv).
void ffp_light_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                        const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer);

// A view under one pattern, with the light that is scattered where the G-buffer holds it: linear radiance,
// unclamped, [height,width,3]. pattern NULL = black. Mapping and transport may have side x side samples for
// each pixel of the picture: its radiance is their mean, and the G-buffer is that of the means.
void ffp_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
               const real intensity[3], const FfpSummed *pattern, FfpImage *out);
// ffp_light and ffp_shade, for who wants one pattern alone.
void ffp_shade_once(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern,
                    FfpImage *out);
// If the transport keeps what a shading saw, that was the last and of this pattern. ADDS gradients: of the
// G-buffer to its ambient and scattered colours alone, of the transport, and where not NULL of the
// intensity and the pattern's summed-area adjoint (see lookup.h). On a device these two must be NULL: the
// program ends otherwise.
void ffp_shade_backward(const FfpMapping *mapping, const FfpTransport *transport, const real intensity[3],
                        const FfpSummed *pattern, const FfpImage *grad_image, FfpGbuffer *grad_gbuffer,
                        FfpTransport *grad_transport, real grad_intensity[3], FfpSummed *grad_pattern);
// ADDS the part of the pattern's adjoint that comes through its mean, if the G-buffer holds scattered light.
// On the CPU alone.
void ffp_shade_backward_level(const FfpGbuffer *gbuffer, const FfpMapping *mapping,
                              const FfpImage *grad_image, FfpSummed *grad_pattern);

#endif
