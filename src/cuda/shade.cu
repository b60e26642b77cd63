// Mapping to the projector and the model of light, one thread a pixel of the G-buffer.
#include "cuda/launch.h"
#include "cuda/render.h"
extern "C" {
#include "render/map_pixel.h"
#include "render/shade_pixel.h"
}

enum { BLOCK = 128 };

// What the formulas reach by pointers: a kernel's constant argument.
typedef struct FfpShadeScene {
    FfpGbuffer gbuffer, shadow;
    FfpMapping mapping;
    FfpCamera camera, projector;
    FfpRenderSettings settings;
    float intensity[3];
    bool lit; // not black
    FfpSummed pattern;
} FfpShadeScene;

static __device__ inline FfpShader shader_of(const FfpShadeScene *s) {
    return FfpShader{&s->gbuffer,   &s->mapping,  &s->camera,
                     &s->projector, s->intensity, s->lit ? &s->pattern : NULL};
}

static unsigned blocks_for(const FfpGbuffer *g) {
    return ffp_blocks((size_t)g->width * (size_t)g->height, BLOCK);
}

static __global__ void __launch_bounds__(BLOCK) map_pixels(const __grid_constant__ FfpShadeScene scene) {
    const FfpMapper mapper = {&scene.gbuffer, &scene.camera, &scene.projector, &scene.settings, scene.shadow};
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    FfpMapping out = scene.mapping;
    if (p < width * scene.gbuffer.height) ffp_map_pixel(&mapper, p % width, p / width, &out);
}

void ffp_cuda_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                              const FfpCamera *projector, const FfpRenderSettings *settings,
                              FfpMapping *out) {
    FfpShadeScene scene = {};
    scene.gbuffer = *gbuffer, scene.shadow = *shadow, scene.mapping = *out;
    scene.camera = *camera, scene.projector = *projector, scene.settings = *settings;
    ffp_launch(map_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK), scene);
}

static FfpShadeScene lit_scene(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                               const FfpCamera *projector, const real intensity[3],
                               const FfpSummed *pattern) {
    FfpShadeScene scene = {};
    scene.gbuffer = *gbuffer, scene.mapping = *mapping;
    scene.camera = *camera, scene.projector = *projector;
    for (int k = 0; k < 3; k++) scene.intensity[k] = intensity[k];
    scene.lit = pattern != NULL;
    if (pattern) scene.pattern = *pattern;
    return scene;
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels(const __grid_constant__ FfpShadeScene scene, float *out) {
    const FfpShader shader = shader_of(&scene);
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    if (p >= width * scene.gbuffer.height) return;
    float colour[3];
    ffp_shade_pixel(&shader, p % width, p / width, colour);
    for (int k = 0; k < 3; k++) out[3 * p + k] = colour[k];
}

void ffp_cuda_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern,
                    FfpImage *out) {
    const FfpShadeScene scene = lit_scene(gbuffer, mapping, camera, projector, intensity, pattern);
    ffp_launch(shade_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK), scene, out->data);
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels_backward(const __grid_constant__ FfpShadeScene scene, const float *grad_image,
                          FfpGbuffer grad_gbuffer) {
    const FfpShader shader = shader_of(&scene);
    const int width = scene.gbuffer.width, p = (int)ffp_thread();
    if (p >= width * scene.gbuffer.height) return;
    const float grad[3] = {grad_image[3 * p], grad_image[3 * p + 1], grad_image[3 * p + 2]};
    float grad_intensity[3] = {0, 0, 0};
    FfpLit lit;
    FfpLitGrad d;
    ffp_shade_pixel_backward(&shader, p % width, p / width, grad, &grad_gbuffer, grad_intensity, &lit, &d);
}

void ffp_cuda_shade_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                             const FfpCamera *projector, const real intensity[3], const FfpSummed *pattern,
                             const FfpImage *grad_image, FfpGbuffer *grad_gbuffer, real grad_intensity[3],
                             FfpSummed *grad_pattern) {
    if (grad_intensity || grad_pattern) {
        fprintf(stderr, "ffprocams: error: GPU: gradients of intensity and pattern are the CPU's alone\n");
        abort();
    }
    const FfpShadeScene scene = lit_scene(gbuffer, mapping, camera, projector, intensity, pattern);
    ffp_launch(shade_pixels_backward, dim3(blocks_for(gbuffer)), dim3(BLOCK), scene, grad_image->data,
               *grad_gbuffer);
}
