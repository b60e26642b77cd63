// Rows of pixels through the model of light (shade_pixel.h), and back.
#include <string.h>
#include "engine/render/kernels/kernels.h"
#include "engine/render/kernels/lanes.h"

// Light goes through the formulas in parts of a row, number by number in columns: loops that gcc vectorises.
enum { PART = 16 };

typedef struct SumColumns {
    real opacity[PART], depth[PART], normal[3][PART], albedo[3][PART], roughness[PART], visibility[PART];
} SumColumns;

typedef struct ArrivalColumns {
    real factor[3][PART], uv[2][PART];
} ArrivalColumns;

// Pixels p to p + count; there is no light on the others.
static void load_sums(const FfpLitScene *scene, ptrdiff_t p, int count, SumColumns *c) {
    const FfpGbuffer *g = scene->gbuffer;
    if (count < PART) memset(c, 0, sizeof *c);
    for (int i = 0; i < count; i++) {
        c->opacity[i] = g->opacity[p + i];
        c->depth[i] = g->depth[p + i];
        c->roughness[i] = g->roughness[p + i];
        c->visibility[i] = scene->mapping->visibility[p + i];
        for (int k = 0; k < 3; k++) {
            c->normal[k][i] = g->normal[3 * (p + i) + k];
            c->albedo[k][i] = g->albedo[3 * (p + i) + k];
        }
    }
}

ALWAYS_INLINE FfpSums sums_at(const SumColumns *c, int i) {
    return (FfpSums){c->opacity[i],
                     c->depth[i],
                     {c->normal[0][i], c->normal[1][i], c->normal[2][i]},
                     {c->albedo[0][i], c->albedo[1][i], c->albedo[2][i]},
                     c->roughness[i],
                     c->visibility[i]};
}

// True if light falls on any of the pixels.
static bool any_visible(const real *visibility, int count) {
    unsigned any = 0;
    for (int i = 0; i < count; i++) any |= visibility[i] > 0 ? 1 : 0;
    return any != 0;
}

__attribute__((flatten)) static void light_part(const FfpLitView *view, int x, int y, const SumColumns *sums,
                                                ArrivalColumns *out) {
#pragma GCC ivdep
    for (int i = 0; i < PART; i++) {
        const FfpSums here = sums_at(sums, i);
        const FfpArrival a = ffp_arrival(view, x + i, y, &here);
        out->factor[0][i] = a.factor[0], out->factor[1][i] = a.factor[1], out->factor[2][i] = a.factor[2];
        out->uv[0][i] = a.uv[0], out->uv[1][i] = a.uv[1];
    }
}

void FFP_K(light_row)(const FfpLitScene *scene, int y, FfpTransport *out) {
    const int width = scene->gbuffer->width;
    for (int x = 0; x < width; x += PART) {
        const int count = x + PART < width ? PART : width - x;
        const ptrdiff_t p = (ptrdiff_t)y * width + x;
        if (!any_visible(scene->mapping->visibility + p, count)) {
            memset(out->factor + 3 * p, 0, 3 * (size_t)count * sizeof(real));
            memset(out->uv + 2 * p, 0, 2 * (size_t)count * sizeof(real));
            continue;
        }
        SumColumns sums;
        ArrivalColumns arrival;
        load_sums(scene, p, count, &sums);
        light_part(&scene->view, x, y, &sums, &arrival);
        for (int i = 0; i < count; i++) {
            for (int k = 0; k < 3; k++) out->factor[3 * (p + i) + k] = arrival.factor[k][i];
            for (int k = 0; k < 2; k++) out->uv[2 * (p + i) + k] = arrival.uv[k][i];
        }
    }
}

// False where there is nothing.
static bool load_arrivals(const FfpTransport *t, ptrdiff_t p, int count, ArrivalColumns *c) {
    unsigned any = 0;
    for (int i = 0; i < 3 * count; i++) any |= t->factor[3 * p + i] != 0 ? 1 : 0;
    for (int i = 0; i < 2 * count; i++) any |= t->uv[2 * p + i] != 0 ? 1 : 0;
    if (!any) return false;
    if (count < PART) memset(c, 0, sizeof *c);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) c->factor[k][i] = t->factor[3 * (p + i) + k];
        for (int k = 0; k < 2; k++) c->uv[k][i] = t->uv[2 * (p + i) + k];
    }
    return true;
}

__attribute__((flatten)) static void light_part_backward(const FfpLitView *view, int x, int y,
                                                         const SumColumns *sums, const ArrivalColumns *grad,
                                                         SumColumns *out) {
#pragma GCC ivdep
    for (int i = 0; i < PART; i++) {
        const FfpSums here = sums_at(sums, i);
        const FfpArrival d = {{grad->factor[0][i], grad->factor[1][i], grad->factor[2][i]},
                              {grad->uv[0][i], grad->uv[1][i]}};
        const FfpSums s = ffp_arrival_backward(view, x + i, y, &here, &d);
        out->opacity[i] = s.opacity;
        out->depth[i] = s.depth;
        out->roughness[i] = s.roughness;
        out->normal[0][i] = s.normal[0], out->normal[1][i] = s.normal[1], out->normal[2][i] = s.normal[2];
        out->albedo[0][i] = s.albedo[0], out->albedo[1][i] = s.albedo[1], out->albedo[2][i] = s.albedo[2];
    }
}

void FFP_K(light_row_backward)(const FfpLitScene *scene, int y, const FfpTransport *grad, FfpGbuffer *to) {
    const int width = scene->gbuffer->width;
    for (int x = 0; x < width; x += PART) {
        const int count = x + PART < width ? PART : width - x;
        const ptrdiff_t p = (ptrdiff_t)y * width + x;
        SumColumns sums, d;
        ArrivalColumns arrival;
        if (!load_arrivals(grad, p, count, &arrival)) continue;
        load_sums(scene, p, count, &sums);
        light_part_backward(&scene->view, x, y, &sums, &arrival, &d);
        for (int i = 0; i < count; i++) {
            to->opacity[p + i] += d.opacity[i];
            to->depth[p + i] += d.depth[i];
            to->roughness[p + i] += d.roughness[i];
            for (int k = 0; k < 3; k++) {
                to->normal[3 * (p + i) + k] += d.normal[k][i];
                to->albedo[3 * (p + i) + k] += d.albedo[k][i];
            }
        }
    }
}

void FFP_K(shade_row)(const FfpPatternLight *light, int y, const FfpGbuffer *gbuffer, FfpImage *out) {
    for (int x = 0; x < out->width; x++) {
        const ptrdiff_t p = (ptrdiff_t)y * out->width + x;
        ffp_shade_pixel(light, x, y, gbuffer->ambient + 3 * p,
                        gbuffer->scattered ? gbuffer->scattered + 3 * p : NULL, out->data + 3 * p);
    }
}

// The samples of pixel (x, y); d: of its radiance.
static void shade_pixel_backward(const FfpPatternLight *light, int x, int y, const real d[3],
                                 const FfpShadeGrad *grad, real grad_intensity[3]) {
    const int samples = light->side * light->side;
    const real share = 1 / (real)samples, d_sample[3] = {share * d[0], share * d[1], share * d[2]};
    for (int i = 0; i < samples; i++) {
        const ptrdiff_t s = ffp_sample_of(light, x, y, i);
        if (!ffp_sample_lit(light, s)) continue;
        const real *uv = light->transport->uv + 2 * s, *extent = light->extent + 2 * s;
        real d_texture[3];
        ffp_shade_sample_backward(light, s, d_sample, grad->transport, grad_intensity, d_texture);
        if (grad->pattern)
            ffp_lookup_backward_pattern(grad->pattern, uv[0], uv[1], extent[0], extent[1], d_texture);
    }
}

void FFP_K(shade_row_backward)(const FfpPatternLight *light, int y, const FfpShadeGrad *grad,
                               real grad_intensity[3]) {
    for (int x = 0; x < grad->image->width; x++) {
        const ptrdiff_t p = (ptrdiff_t)y * grad->image->width + x;
        const real *d = grad->image->data + 3 * p;
        if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
        for (int k = 0; k < 3; k++) grad->ambient[3 * p + k] += d[k];
        for (int k = 0; grad->scattered && k < 3; k++) grad->scattered[3 * p + k] += light->level[k] * d[k];
        if (light->pattern) shade_pixel_backward(light, x, y, d, grad, grad_intensity);
    }
}
