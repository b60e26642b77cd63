// Common parts of blending and its gradient: where a thread's pixel lies, and how a splat covers it. A block
// draws a tile, each of its warps 8x4 pixels.
#ifndef FFP_CUDA_TILE_H
#define FFP_CUDA_TILE_H

#include "engine/cuda/raster.h"

#define FFP_ALL_LANES 0xffffffffu

// A thread's pixel, and its warp's pixels, end exclusive.
typedef struct FfpTilePixel {
    int x, y, index; // index: -1 outside the image
    int4 warp;
} FfpTilePixel;

static __device__ inline FfpTilePixel ffp_tile_pixel(const FfpTiling *t) {
    const int tile = (int)blockIdx.x, warp = (int)threadIdx.x / FFP_WARP, lane = (int)threadIdx.x % FFP_WARP;
    const int across = (int)FFP_TILE / FFP_WARP_WIDTH;
    FfpTilePixel p;
    p.warp.x = tile % t->tiles_x * FFP_TILE + warp % across * FFP_WARP_WIDTH;
    p.warp.y = tile / t->tiles_x * FFP_TILE + warp / across * FFP_WARP_HEIGHT;
    p.warp.z = p.warp.x + FFP_WARP_WIDTH, p.warp.w = p.warp.y + FFP_WARP_HEIGHT;
    p.x = p.warp.x + lane % FFP_WARP_WIDTH, p.y = p.warp.y + lane / FFP_WARP_WIDTH;
    p.index = p.x < t->width && p.y < t->height ? p.y * t->width + p.x : -1;
    return p;
}

static __device__ inline bool ffp_boxes_meet(int4 a, int4 b) {
    return a.x < b.z && b.x < a.z && a.y < b.w && b.y < a.w;
}

// A splat over a pixel: its density d, what that covers, and alpha, which is 0 where below 1/255 or where the
// pixel has come to its end. (dx, dy) leads from the pixel's centre to the splat's.
typedef struct FfpCover {
    float dx, dy, density, covered, alpha, before; // before: the transmittance in front of the splat
} FfpCover;

// Moves the transmittance on. A pixel whose transmittance would fall to 1e-4 stops, without this splat, and
// is marked by 0.
static __device__ inline FfpCover ffp_cover_pixel(const FfpDeviceSplat *s, float x, float y, float firmness,
                                                  float *transmittance) {
    FfpCover c;
    c.dx = s->x - x;
    c.dy = s->y - y;
    c.before = *transmittance;
    const float t = (s->power[0] * c.dx + s->power[1] * c.dy) * c.dx + s->power[2] * c.dy * c.dy;
    c.density = s->opacity * exp2f(fmaxf(fminf(t, 0), -100)); // 2^-100 is far below 1/255 as well
    c.covered = c.density * (1 + firmness * (1 - c.density));
    const float alpha = c.covered >= FFP_ALPHA_MIN ? fminf(c.covered, FFP_ALPHA_MAX) : 0;
    const float next = c.before * (1 - alpha);
    const bool open = next > FFP_TRANSMITTANCE_MIN;
    c.alpha = open ? alpha : 0;
    *transmittance = open ? next : 0;
    return c;
}

// The planes of a G-buffer at a pixel, by channel.
static __device__ inline float *ffp_channel(const FfpGbuffer *g, int channel, ptrdiff_t pixel) {
    if (channel == 0) return g->opacity + pixel;
    if (channel < FFP_CHANNEL_NORMAL) return g->depth + pixel;
    if (channel < FFP_CHANNEL_ALBEDO) return g->normal + 3 * pixel + channel - FFP_CHANNEL_NORMAL;
    if (channel < FFP_CHANNEL_ROUGHNESS) return g->albedo + 3 * pixel + channel - FFP_CHANNEL_ALBEDO;
    if (channel < FFP_CHANNEL_AMBIENT) return g->roughness + pixel;
    if (channel < FFP_CHANNEL_SCATTERED) return g->ambient + 3 * pixel + channel - FFP_CHANNEL_AMBIENT;
    return g->scattered + 3 * pixel + channel - FFP_CHANNEL_SCATTERED;
}

#endif
