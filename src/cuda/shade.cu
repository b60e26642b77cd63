// Mapping to the projector and the model of light, one thread a pixel of the G-buffer.
#include "cuda/launch.h"
#include "cuda/render.h"
extern "C" {
#include "render/map_pixel.h"
#include "render/shade_pixel.h"
}

enum { BLOCK = 128 };

// What the formulas reach by pointers: a kernel's constant argument.
typedef struct FfpLightScene {
    FfpGbuffer gbuffer, shadow;
    FfpMapping mapping;
    FfpCamera camera, projector;
    FfpRenderSettings settings;
} FfpLightScene;

typedef struct FfpPatternScene {
    FfpTransport transport;
    const float *extent;
    float intensity[3];
    bool lit; // not black
    FfpSummed pattern;
} FfpPatternScene;

static unsigned blocks_for(const FfpGbuffer *g) {
    return ffp_blocks((size_t)g->width * (size_t)g->height, BLOCK);
}

static __global__ void __launch_bounds__(BLOCK) map_pixels(const __grid_constant__ FfpLightScene scene) {
    const FfpMapper mapper = {&scene.gbuffer, &scene.camera, &scene.projector, &scene.settings, scene.shadow};
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    FfpMapping out = scene.mapping;
    if (p < width * scene.gbuffer.height) ffp_map_pixel(&mapper, p % width, p / width, &out);
}

void ffp_cuda_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                              const FfpCamera *projector, const FfpRenderSettings *settings,
                              FfpMapping *out) {
    FfpLightScene scene = {};
    scene.gbuffer = *gbuffer, scene.shadow = *shadow, scene.mapping = *out;
    scene.camera = *camera, scene.projector = *projector, scene.settings = *settings;
    ffp_launch(map_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK), scene);
}

static FfpLightScene light_scene(const FfpGbuffer *gbuffer, const FfpMapping *mapping,
                                 const FfpCamera *camera, const FfpCamera *projector) {
    FfpLightScene scene = {};
    scene.gbuffer = *gbuffer, scene.mapping = *mapping;
    scene.camera = *camera, scene.projector = *projector;
    return scene;
}

static __global__ void __launch_bounds__(BLOCK)
    light_pixels(const __grid_constant__ FfpLightScene scene, FfpTransport out) {
    const FfpLitView view = {&scene.gbuffer, &scene.mapping, &scene.camera, &scene.projector};
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    if (p < width * scene.gbuffer.height) ffp_light_pixel(&view, p % width, p / width, &out);
}

void ffp_cuda_light(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, FfpTransport *out) {
    ffp_launch(light_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               light_scene(gbuffer, mapping, camera, projector), *out);
}

static __global__ void __launch_bounds__(BLOCK)
    light_pixels_backward(const __grid_constant__ FfpLightScene scene, FfpTransport grad,
                          FfpGbuffer grad_gbuffer) {
    const FfpLitView view = {&scene.gbuffer, &scene.mapping, &scene.camera, &scene.projector};
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    if (p < width * scene.gbuffer.height)
        ffp_light_pixel_backward(&view, p % width, p / width, &grad, &grad_gbuffer);
}

void ffp_cuda_light_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                             const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer) {
    ffp_launch(light_pixels_backward, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               light_scene(gbuffer, mapping, camera, projector), *grad, *grad_gbuffer);
}

static FfpPatternScene pattern_scene(const FfpMapping *mapping, const FfpTransport *transport,
                                     const real intensity[3], const FfpSummed *pattern) {
    FfpPatternScene scene = {};
    scene.transport = *transport, scene.extent = mapping->extent;
    for (int k = 0; k < 3; k++) scene.intensity[k] = intensity[k];
    scene.lit = pattern != NULL;
    if (pattern) scene.pattern = *pattern;
    return scene;
}

static __device__ inline FfpPatternLight light_of(const FfpPatternScene *s) {
    return FfpPatternLight{&s->transport, s->extent, s->intensity, s->lit ? &s->pattern : NULL};
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels(const __grid_constant__ FfpPatternScene scene, const float *ambient, float *out) {
    const FfpPatternLight light = light_of(&scene);
    const int p = (int)ffp_thread();
    if (p >= scene.transport.width * scene.transport.height) return;
    ffp_shade_pixel(&light, p, ambient, out + 3 * p);
}

void ffp_cuda_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
                    const real intensity[3], const FfpSummed *pattern, FfpImage *out) {
    ffp_launch(shade_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               pattern_scene(mapping, transport, intensity, pattern), gbuffer->ambient, out->data);
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels_backward(const __grid_constant__ FfpPatternScene scene, const float *grad_image,
                          float *d_ambient, FfpTransport d_transport) {
    const FfpPatternLight light = light_of(&scene);
    const int p = (int)ffp_thread();
    if (p >= scene.transport.width * scene.transport.height) return;
    float d_intensity[3] = {0, 0, 0}, d_texture[3];
    ffp_shade_pixel_backward(&light, p, grad_image + 3 * p, d_ambient, &d_transport, d_intensity, d_texture);
}

void ffp_cuda_shade_backward(const FfpMapping *mapping, const FfpTransport *transport,
                             const real intensity[3], const FfpSummed *pattern, const FfpImage *grad_image,
                             FfpGbuffer *grad_gbuffer, FfpTransport *grad_transport, real grad_intensity[3],
                             FfpSummed *grad_pattern) {
    if (grad_intensity || grad_pattern) {
        fprintf(stderr, "ffprocams: error: GPU: gradients of intensity and pattern are the CPU's alone\n");
        abort();
    }
    ffp_launch(shade_pixels_backward, dim3(blocks_for(grad_gbuffer)), dim3(BLOCK),
               pattern_scene(mapping, transport, intensity, pattern), grad_image->data, grad_gbuffer->ambient,
               *grad_transport);
}
