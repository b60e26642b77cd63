// Inside the render room: which point of the pattern lights a camera pixel, how much of the pattern the pixel
// covers, and what is in the way; one text for the CPU and the GPU.
#ifndef FFP_RENDER_MAP_PIXEL_H
#define FFP_RENDER_MAP_PIXEL_H

#include "capture/project.h"
#include "render/formula.h"
#include "render/render.h"

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
    return ffp_project(m->projector, point, &uv[0], &uv[1]);
}

FFP_FORMULA real ffp_length2(const real v[2]) {
    return v[0] * v[0] + v[1] * v[1];
}

// Change of the pattern position over one pixel step along an image axis: the one-sided difference to the
// neighbour nearest in depth (the other may lie beyond a depth jump), no more than FFP_TILT_MAX times that at
// constant depth, which also stands in where neither neighbour has a surface.
FFP_FORMULA void ffp_pattern_step(const FfpMapper *m, int x, int y, int along_x, int along_y,
                                  const real here[2], real z, real step[2]) {
    const FfpGbuffer *g = m->gbuffer;
    real flat[2], least = INFINITY;
    if (!(ffp_pattern_position(m, x + along_x, y + along_y, z, flat) > 0)) {
        step[0] = step[1] = 0;
        return;
    }
    flat[0] -= here[0], flat[1] -= here[1];
    step[0] = flat[0], step[1] = flat[1];
    for (int side = -1; side <= 1; side += 2) {
        const int nx = x + side * along_x, ny = y + side * along_y;
        if (nx < 0 || ny < 0 || nx >= g->width || ny >= g->height) continue;
        const int n = ny * g->width + nx;
        if (!(g->opacity[n] > FFP_OPACITY_MIN)) continue;
        const real depth = g->depth[n] / g->opacity[n], jump = fabs(depth - z);
        real there[2];
        if (!(jump < least) || !(ffp_pattern_position(m, nx, ny, depth, there) > 0)) continue;
        least = jump;
        step[0] = there[0] - here[0], step[1] = there[1] - here[1];
    }
    const real most = FFP_TILT_MAX * FFP_TILT_MAX * ffp_length2(flat);
    if (ffp_length2(step) <= most) return;
    const real shrink = sqrt(most / ffp_length2(step));
    step[0] *= shrink, step[1] *= shrink;
}

// Sides of the box that has the variance of the pixel's parallelogram in the pattern; at least one pattern
// pixel.
FFP_FORMULA void ffp_pattern_extent(const FfpMapper *m, int x, int y, const real here[2], real z,
                                    real extent[2]) {
    real a[2], b[2];
    ffp_pattern_step(m, x, y, 1, 0, here, z, a);
    ffp_pattern_step(m, x, y, 0, 1, here, z, b);
    for (int k = 0; k < 2; k++) extent[k] = fmax(sqrt(a[k] * a[k] + b[k] * b[k]), (real)1);
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

FFP_FORMULA void ffp_map_pixel(const FfpMapper *m, int x, int y, FfpMapping *out) {
    const FfpGbuffer *g = m->gbuffer;
    const int p = y * g->width + x;
    real *uv = out->uv + 2 * p, *extent = out->extent + 2 * p;
    uv[0] = uv[1] = 0, extent[0] = extent[1] = 1, out->visibility[p] = 0;
    if (!(g->opacity[p] > FFP_OPACITY_MIN)) return;
    const real z = g->depth[p] / g->opacity[p];
    const real depth = ffp_pattern_position(m, x, y, z, uv);
    const bool inside =
        uv[0] >= 0 && uv[1] >= 0 && uv[0] <= (real)m->projector->width && uv[1] <= (real)m->projector->height;
    if (!(depth > 0) || !inside) return;
    out->visibility[p] = m->shadow.width ? ffp_light_through(m, uv, depth) : 1;
    if (m->settings->footprint) ffp_pattern_extent(m, x, y, uv, z, extent);
}

#endif
