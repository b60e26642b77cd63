// Inside the render room: which point of the pattern lights a camera pixel, how much of the pattern the pixel
// covers, and what is in the way; one text for the CPU and the GPU.
#ifndef FFP_RENDER_MAP_PIXEL_H
#define FFP_RENDER_MAP_PIXEL_H

#include "core/capture/project.h"
#include "engine/render/formula.h"
#include "engine/render/render.h"

// A pixel's footprint is at most this many times what it would be if the surface faced the camera there: a
// steeper difference is a jump of depth, not a surface (a tilt of 76 degrees).
#define FFP_TILT_MAX 4

typedef struct FfpMapper {
    const FfpGbuffer *gbuffer;
    const FfpCamera *camera, *projector;
    const FfpRenderSettings *settings;
    FfpGbuffer shadow; // its size 0: no shadows
} FfpMapper;

// Pattern position of the surface seen by pixel (x, y) were its depth z; returns the depth from the
// projector.
FFP_FORMULA real ffp_pattern_position(const FfpMapper *m, int x, int y, real z, real uv[2]) {
    real point[3], slope[3];
    ffp_surface_point(m->camera, (real)x + 0.5F, (real)y + 0.5F, z, point, slope);
    return ffp_projected(m->projector, point, &uv[0], &uv[1]);
}

FFP_FORMULA real ffp_length2(const real v[2]) {
    return v[0] * v[0] + v[1] * v[1];
}

// The sums of a pixel and of its neighbours: itself, left, right, above, below. Beyond the picture's edge
// there is nothing: 0.
typedef struct FfpAround {
    real opacity[5], depth[5];
} FfpAround;

// Change of the pattern position over one pixel step along an image axis: the one-sided difference to the
// neighbour nearest in depth (the other may lie beyond a depth jump), no more than FFP_TILT_MAX times that at
// constant depth, which also stands in where neither neighbour has a surface. `axis`: 0 along x, 1 along y.
// No branches, here and below: the CPU takes a vector of pixels at a time.
FFP_FORMULA void ffp_pattern_step(const FfpMapper *m, int x, int y, int axis, const FfpAround *around,
                                  const real here[2], real z, real step[2]) {
    const int along_x = 1 - axis, along_y = axis, before = 1 + 2 * axis; // the first neighbour of `around`
    real flat[2], least = INFINITY;
    const real ahead = ffp_pattern_position(m, x + along_x, y + along_y, z, flat);
    flat[0] -= here[0], flat[1] -= here[1];
    step[0] = flat[0], step[1] = flat[1];
    for (int i = 0; i < 2; i++) {
        const int side = 2 * i - 1;
        const real opacity = around->opacity[before + i], depth = around->depth[before + i] / opacity,
                   jump = fabs(depth - z);
        real there[2];
        const real away = ffp_pattern_position(m, x + side * along_x, y + side * along_y, depth, there);
        const bool nearer = (opacity > FFP_OPACITY_MIN) & (jump < least) & (away > 0);
        least = nearer ? jump : least;
        step[0] = nearer ? there[0] - here[0] : step[0];
        step[1] = nearer ? there[1] - here[1] : step[1];
    }
    const real most = FFP_TILT_MAX * FFP_TILT_MAX * ffp_length2(flat), length = ffp_length2(step);
    const real shrink = length <= most ? 1 : sqrt(most / length), kept = ahead > 0 ? shrink : 0;
    step[0] = ahead > 0 ? step[0] * kept : 0, step[1] = ahead > 0 ? step[1] * kept : 0;
}

// Where in the pattern the light of a pixel comes from. `inside`: the surface exists, in front of the
// projector and within the pattern; otherwise depth and extent mean nothing.
typedef struct FfpMapPlace {
    bool inside;
    real uv[2], extent[2], depth; // FfpMapping; from the projector
} FfpMapPlace;

// extent: sides of the box that has the variance of the pixel's parallelogram in the pattern; at least one
// pattern pixel.
FFP_FORMULA FfpMapPlace ffp_pattern_place(const FfpMapper *m, int x, int y, const FfpAround *around) {
    FfpMapPlace p;
    real a[2], b[2], uv[2];
    const bool surface = around->opacity[0] > FFP_OPACITY_MIN;
    const real z = around->depth[0] / around->opacity[0];
    p.depth = ffp_pattern_position(m, x, y, z, uv);
    ffp_pattern_step(m, x, y, 0, around, uv, z, a);
    ffp_pattern_step(m, x, y, 1, around, uv, z, b);
    p.inside = surface & (p.depth > 0) & (uv[0] >= 0) & (uv[1] >= 0) & (uv[0] <= (real)m->projector->width) &
               (uv[1] <= (real)m->projector->height);
    for (int k = 0; k < 2; k++) {
        const real extent = sqrt(a[k] * a[k] + b[k] * b[k]);
        p.extent[k] = extent > 1 ? extent : 1;
        p.uv[k] = surface ? uv[k] : 0;
    }
    return p;
}

// Share of the light that comes through to depth z at pattern position uv: the four nearest texels of the
// shadow map, each of which holds back its opacity when it lies nearer than z by more than the bias, mixed
// bilinearly.
FFP_FORMULA real ffp_light_through(const FfpMapper *m, const real uv[2], real z) {
    const FfpGbuffer *s = &m->shadow;
    const real x = uv[0] * (real)s->width / (real)m->projector->width - 0.5F;
    const real y = uv[1] * (real)s->height / (real)m->projector->height - 0.5F;
    const int x0 = (int)floor(x), y0 = (int)floor(y);
    real held = 0;
    for (int k = 0; k < 4; k++) {
        const int tx = x0 + (k & 1), ty = y0 + (k >> 1);
        if (tx < 0 || ty < 0 || tx >= s->width || ty >= s->height) continue;
        const real share = (1 - fabs(x - (real)tx)) * (1 - fabs(y - (real)ty));
        const int t = ty * s->width + tx;
        const real opacity = s->opacity[t];
        // depth is a sum too: compare opacity * z with it
        if (opacity > FFP_OPACITY_MIN && opacity * z * (1 - m->settings->shadow_bias) > s->depth[t])
            held += share * opacity;
    }
    return held < 1 ? 1 - held : 0;
}

// ffp_map_with_shadow: a pixel of it whose place is known.
FFP_FORMULA void ffp_map_place(const FfpMapper *m, const FfpMapPlace *place, ptrdiff_t pixel,
                               FfpMapping *out) {
    const bool wide = place->inside && m->settings->footprint;
    for (int k = 0; k < 2; k++) {
        out->uv[2 * pixel + k] = place->uv[k];
        out->extent[2 * pixel + k] = wide ? place->extent[k] : 1;
    }
    out->visibility[pixel] = 0;
    if (place->inside)
        out->visibility[pixel] = m->shadow.width ? ffp_light_through(m, place->uv, place->depth) : 1;
}

#endif
