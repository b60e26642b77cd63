// Mapping to the projector and the model of light, one thread a pixel of the G-buffer.
#include "engine/cuda/launch.h"
#include "engine/cuda/render.h"
extern "C" {
#include "engine/render/map_pixel.h"
#include "engine/render/shade_pixel.h"
}

enum { BLOCK = 128 };

// Data that the formulas reach by pointers: a kernel's constant argument.
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
    int width, height, side; // of the picture; samples a side of its pixels
    bool lit;                // not black
    float on[4];             // FfpMapping.lit
    FfpSummed pattern;
} FfpPatternScene;

static unsigned blocks_for(const FfpGbuffer *g) {
    return ffp_blocks((size_t)g->width * (size_t)g->height, BLOCK);
}

static __device__ inline void add_around(const FfpGbuffer *g, ptrdiff_t p, int place, FfpAround *around) {
    around->opacity[place] = g->opacity[p];
    around->depth[place] = g->depth[p];
}

static __global__ void __launch_bounds__(BLOCK) map_pixels(const __grid_constant__ FfpLightScene scene) {
    const FfpMapper mapper = {&scene.gbuffer, &scene.camera, &scene.projector, &scene.settings, scene.shadow};
    const int width = scene.gbuffer.width, height = scene.gbuffer.height;
    const ptrdiff_t p = (ptrdiff_t)ffp_thread();
    const int x = (int)(p % width), y = (int)(p / width);
    FfpMapping out = scene.mapping;
    if (y >= height) return;
    FfpAround around = {};
    FfpMapPlace place = {};
    add_around(&scene.gbuffer, p, 0, &around);
    if (around.opacity[0] > FFP_OPACITY_MIN) {
        if (x > 0) add_around(&scene.gbuffer, p - 1, 1, &around);
        if (x + 1 < width) add_around(&scene.gbuffer, p + 1, 2, &around);
        if (y > 0) add_around(&scene.gbuffer, p - width, 3, &around);
        if (y + 1 < height) add_around(&scene.gbuffer, p + width, 4, &around);
        place = ffp_pattern_place(&mapper, x, y, &around);
    }
    ffp_map_place(&mapper, &place, p, &out);
}

void ffp_cuda_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                              const FfpCamera *projector, const FfpRenderSettings *settings,
                              FfpMapping *out) {
    FfpLightScene scene = {};
    scene.gbuffer = *gbuffer;
    scene.shadow = *shadow;
    scene.mapping = *out;
    scene.camera = *camera;
    scene.projector = *projector;
    scene.settings = *settings;
    ffp_launch(map_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK), scene);
}

static FfpLightScene light_scene(const FfpGbuffer *gbuffer, const FfpMapping *mapping,
                                 const FfpCamera *camera, const FfpCamera *projector) {
    FfpLightScene scene = {};
    scene.gbuffer = *gbuffer;
    scene.mapping = *mapping;
    scene.camera = *camera;
    scene.projector = *projector;
    return scene;
}

static __device__ inline FfpLitView view_of(const FfpLightScene *s) {
    return FfpLitView{&s->camera, &s->projector, s->mapping.even};
}

static __device__ inline FfpSums sums_at(const FfpLightScene *s, ptrdiff_t p) {
    const FfpGbuffer *g = &s->gbuffer;
    const float *n = g->normal + 3 * p, *a = g->albedo + 3 * p;
    return FfpSums{g->opacity[p],      g->depth[p],     {n[0], n[1], n[2]},
                   {a[0], a[1], a[2]}, g->roughness[p], s->mapping.visibility[p]};
}

static __global__ void __launch_bounds__(BLOCK)
    light_pixels(const __grid_constant__ FfpLightScene scene, FfpTransport out) {
    const int width = scene.gbuffer.width;
    const ptrdiff_t p = (ptrdiff_t)ffp_thread();
    if (p >= (ptrdiff_t)width * scene.gbuffer.height) return;
    const FfpLitView view = view_of(&scene);
    const FfpSums sums = sums_at(&scene, p);
    FfpArrival arrival = {{0, 0, 0}, {0, 0}};
    if (sums.visibility > 0) arrival = ffp_arrival(&view, (int)(p % width), (int)(p / width), &sums);
    for (int k = 0; k < 3; k++) out.factor[3 * p + k] = arrival.factor[k];
    for (int k = 0; k < 2; k++) out.uv[2 * p + k] = arrival.uv[k];
}

void ffp_cuda_light(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                    const FfpCamera *projector, FfpTransport *out) {
    ffp_launch(light_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               light_scene(gbuffer, mapping, camera, projector), *out);
}

static __global__ void __launch_bounds__(BLOCK)
    light_pixels_backward(const __grid_constant__ FfpLightScene scene, FfpTransport grad,
                          FfpGbuffer grad_gbuffer) {
    const int width = scene.gbuffer.width;
    const ptrdiff_t p = (ptrdiff_t)ffp_thread();
    if (p >= (ptrdiff_t)width * scene.gbuffer.height) return;
    const float *f = grad.factor + 3 * p, *uv = grad.uv + 2 * p;
    const FfpArrival d_arrival = {{f[0], f[1], f[2]}, {uv[0], uv[1]}};
    if (f[0] == 0 && f[1] == 0 && f[2] == 0 && uv[0] == 0 && uv[1] == 0) return;
    const FfpLitView view = view_of(&scene);
    const FfpSums sums = sums_at(&scene, p);
    const FfpSums d = ffp_arrival_backward(&view, (int)(p % width), (int)(p / width), &sums, &d_arrival);
    grad_gbuffer.opacity[p] += d.opacity;
    grad_gbuffer.depth[p] += d.depth;
    grad_gbuffer.roughness[p] += d.roughness;
    for (int k = 0; k < 3; k++) {
        grad_gbuffer.normal[3 * p + k] += d.normal[k];
        grad_gbuffer.albedo[3 * p + k] += d.albedo[k];
    }
}

void ffp_cuda_light_backward(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                             const FfpCamera *projector, const FfpTransport *grad, FfpGbuffer *grad_gbuffer) {
    ffp_launch(light_pixels_backward, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               light_scene(gbuffer, mapping, camera, projector), *grad, *grad_gbuffer);
}

static FfpPatternScene pattern_scene(const FfpMapping *mapping, const FfpTransport *transport,
                                     const real intensity[3], const FfpSummed *pattern,
                                     const FfpImage *picture) {
    FfpPatternScene scene = {};
    scene.width = picture->width;
    scene.height = picture->height;
    scene.side = transport->width / picture->width;
    scene.transport = *transport;
    scene.extent = mapping->extent;
    for (int k = 0; k < 3; k++) scene.intensity[k] = intensity[k];
    for (int k = 0; k < 4; k++) scene.on[k] = mapping->lit[k];
    scene.lit = pattern != NULL;
    if (pattern) scene.pattern = *pattern;
    return scene;
}

static __device__ inline FfpPatternLight light_of(const FfpPatternScene *s) {
    return FfpPatternLight{&s->transport, s->extent, s->intensity, s->lit ? &s->pattern : NULL,
                           s->side,       {0, 0, 0}};
}

static __device__ inline void find_level(const FfpPatternScene *s, const float *scattered,
                                         FfpPatternLight *light) {
    if (scattered) ffp_pattern_level(light->pattern, s->on, light->level);
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels(const __grid_constant__ FfpPatternScene scene, const float *ambient, const float *scattered,
                 float *out) {
    FfpPatternLight light = light_of(&scene);
    const ptrdiff_t p = (ptrdiff_t)ffp_thread();
    if (p >= (ptrdiff_t)scene.width * scene.height) return;
    find_level(&scene, scattered, &light);
    ffp_shade_pixel(&light, (int)(p % scene.width), (int)(p / scene.width), ambient + 3 * p,
                    scattered ? scattered + 3 * p : NULL, out + 3 * p);
}

void ffp_cuda_shade(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpTransport *transport,
                    const real intensity[3], const FfpSummed *pattern, FfpImage *out) {
    ffp_launch(shade_pixels, dim3(blocks_for(gbuffer)), dim3(BLOCK),
               pattern_scene(mapping, transport, intensity, pattern, out), gbuffer->ambient,
               gbuffer->scattered, out->data);
}

static __global__ void __launch_bounds__(BLOCK)
    shade_pixels_backward(const __grid_constant__ FfpPatternScene scene, const float *grad_image,
                          float *d_ambient, float *d_scattered, FfpTransport d_transport) {
    FfpPatternLight light = light_of(&scene);
    const ptrdiff_t p = (ptrdiff_t)ffp_thread();
    if (p >= (ptrdiff_t)scene.width * scene.height) return;
    const int samples = scene.side * scene.side;
    const float share = 1 / (float)samples, *d = grad_image + 3 * p;
    const float d_sample[3] = {share * d[0], share * d[1], share * d[2]};
    float d_intensity[3] = {0, 0, 0}, d_texture[3];
    for (int k = 0; k < 3; k++) d_ambient[3 * p + k] += d[k];
    find_level(&scene, d_scattered, &light);
    for (int k = 0; d_scattered && k < 3; k++) d_scattered[3 * p + k] += light.level[k] * d[k];
    for (int i = 0; i < samples; i++) {
        const ptrdiff_t s = ffp_sample_of(&light, (int)(p % scene.width), (int)(p / scene.width), i);
        if (ffp_sample_lit(&light, s))
            ffp_shade_sample_backward(&light, s, d_sample, &d_transport, d_intensity, d_texture);
    }
}

void ffp_cuda_shade_backward(const FfpMapping *mapping, const FfpTransport *transport,
                             const real intensity[3], const FfpSummed *pattern, const FfpImage *grad_image,
                             FfpGbuffer *grad_gbuffer, FfpTransport *grad_transport, real grad_intensity[3],
                             FfpSummed *grad_pattern) {
    if (grad_intensity || grad_pattern) {
        fprintf(stderr,
                "ffprocams: error: GPU: gradients of intensity and pattern are computed on the CPU only\n");
        abort();
    }
    ffp_launch(shade_pixels_backward, dim3(blocks_for(grad_gbuffer)), dim3(BLOCK),
               pattern_scene(mapping, transport, intensity, pattern, grad_image), grad_image->data,
               grad_gbuffer->ambient, grad_gbuffer->scattered, *grad_transport);
}
