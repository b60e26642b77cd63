// Which point of the pattern lights each camera pixel, how much of the pattern the pixel covers, and what is
// in the way.
#include "base/arena.h"
#include "capture/capture.h"
#include "render/raster.h"

// A pixel's footprint is at most this many times what it would be if the surface faced the camera there: a
// steeper difference is a jump of depth, not a surface (a tilt of 76 degrees).
#define TILT_MAX 4

typedef struct Mapper {
    const FfpGbuffer *gbuffer;
    const FfpCamera *camera, *projector;
    const FfpRenderSettings *settings;
    FfpGbuffer shadow; // its size 0: no shadows
} Mapper;

// Pattern position of the surface seen by pixel (x, y) were its depth z; returns the depth from the
// projector.
static real pattern_position(const Mapper *m, int x, int y, real z, real uv[2]) {
    real point[3], slope[3];
    ffp_surface_point(m->camera, (real)x + 0.5F, (real)y + 0.5F, z, point, slope);
    return ffp_project(m->projector, point, &uv[0], &uv[1]);
}

static real length2(const real v[2]) {
    return v[0] * v[0] + v[1] * v[1];
}

// Change of the pattern position over one pixel step along an image axis: the one-sided difference to the
// neighbour nearest in depth (the other may lie beyond a depth jump), no more than TILT_MAX times that at
// constant depth, which also stands in where neither neighbour has a surface.
static void pattern_step(const Mapper *m, int x, int y, int along_x, int along_y, const real here[2], real z,
                         real step[2]) {
    const FfpGbuffer *g = m->gbuffer;
    real flat[2], least = INFINITY;
    if (!(pattern_position(m, x + along_x, y + along_y, z, flat) > 0)) {
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
        if (!(jump < least) || !(pattern_position(m, nx, ny, depth, there) > 0)) continue;
        least = jump;
        step[0] = there[0] - here[0], step[1] = there[1] - here[1];
    }
    const real most = TILT_MAX * TILT_MAX * length2(flat);
    if (length2(step) <= most) return;
    const real shrink = sqrt(most / length2(step));
    step[0] *= shrink, step[1] *= shrink;
}

// Sides of the box that has the variance of the pixel's parallelogram in the pattern; at least one pattern
// pixel.
static void pattern_extent(const Mapper *m, int x, int y, const real here[2], real z, real extent[2]) {
    real a[2], b[2];
    pattern_step(m, x, y, 1, 0, here, z, a);
    pattern_step(m, x, y, 0, 1, here, z, b);
    for (int k = 0; k < 2; k++) extent[k] = fmax(sqrt(a[k] * a[k] + b[k] * b[k]), (real)1);
}

// Share of the light that comes through to depth z at pattern position uv: the four nearest texels of the
// shadow map, each of which holds back its opacity when it lies nearer than z by more than the bias, mixed
// bilinearly.
static real light_through(const Mapper *m, const real uv[2], real z) {
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

static void map_pixel(const Mapper *m, int x, int y, FfpMapping *out) {
    const FfpGbuffer *g = m->gbuffer;
    const int p = y * g->width + x;
    real *uv = out->uv + 2 * p, *extent = out->extent + 2 * p;
    uv[0] = uv[1] = 0, extent[0] = extent[1] = 1, out->visibility[p] = 0;
    if (!(g->opacity[p] > FFP_OPACITY_MIN)) return;
    const real z = g->depth[p] / g->opacity[p];
    const real depth = pattern_position(m, x, y, z, uv);
    const bool inside =
        uv[0] >= 0 && uv[1] >= 0 && uv[0] <= (real)m->projector->width && uv[1] <= (real)m->projector->height;
    if (!(depth > 0) || !inside) return;
    out->visibility[p] = m->shadow.width ? light_through(m, uv, depth) : 1;
    if (m->settings->footprint) pattern_extent(m, x, y, uv, z, extent);
}

// The projector as a camera whose longer side has `side` pixels.
static FfpCamera shadow_camera(const FfpCamera *projector, int side) {
    FfpCamera c = *projector;
    const int longer = c.width > c.height ? c.width : c.height;
    c.width = c.width * side / longer, c.height = c.height * side / longer;
    c.width = c.width > 0 ? c.width : 1, c.height = c.height > 0 ? c.height : 1;
    const real sx = (real)c.width / (real)projector->width, sy = (real)c.height / (real)projector->height;
    c.fx *= sx, c.cx *= sx, c.fy *= sy, c.cy *= sy;
    return c;
}

FfpGbuffer ffp_shadow_map(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *projector,
                          const FfpRenderSettings *settings) {
    if (!settings->shadows) return (FfpGbuffer){0};
    const FfpCamera camera = shadow_camera(projector, settings->shadow_side > 0 ? settings->shadow_side : 1);
    FfpGbuffer *shadow = &raster->shadow;
    if (shadow->width != camera.width || shadow->height != camera.height) {
        ffp_gbuffer_free(shadow);
        const size_t pixels = (size_t)camera.width * (size_t)camera.height;
        shadow->width = camera.width, shadow->height = camera.height;
        shadow->opacity = ffp_alloc(pixels, sizeof(real));
        shadow->depth = ffp_alloc(pixels, sizeof(real));
    }
    ffp_rasterise(raster, gaussians, &camera, settings, shadow);
    return *shadow;
}

void ffp_map_with_shadow(const FfpGbuffer *shadow, const FfpGbuffer *gbuffer, const FfpCamera *camera,
                         const FfpCamera *projector, const FfpRenderSettings *settings, FfpMapping *out) {
    const Mapper m = {gbuffer, camera, projector, settings, *shadow};
#pragma omp parallel for schedule(static)
    for (int y = 0; y < gbuffer->height; y++)
        for (int x = 0; x < gbuffer->width; x++) map_pixel(&m, x, y, out);
}

void ffp_map_to_projector(FfpRaster *raster, const FfpGaussians *gaussians, const FfpGbuffer *gbuffer,
                          const FfpCamera *camera, const FfpCamera *projector,
                          const FfpRenderSettings *settings, FfpMapping *out) {
    const FfpGbuffer shadow = ffp_shadow_map(raster, gaussians, projector, settings);
    ffp_map_with_shadow(&shadow, gbuffer, camera, projector, settings, out);
}
