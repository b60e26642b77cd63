// Inside the render room: one pixel in the light C = f_r L max(n.l, 0) O + C_amb with the reflectance of
// core/base/brdf.h, and its gradient, one text for the CPU and the GPU. It is linear in the pattern: what the
// surface and the way of the light do is found once a view (ffp_light_pixel), what a pattern adds to that is
// a product (ffp_shade_pixel).
#ifndef FFP_RENDER_SHADE_PIXEL_H
#define FFP_RENDER_SHADE_PIXEL_H

#include "core/base/brdf.h"
#include "core/base/exp2.h"
#include "core/capture/project.h"
#include "core/image/lookup_box.h"
#include "engine/render/formula.h"
#include "engine/render/render.h"

#define FFP_LN2 0.693147180559945309F
#define FFP_ROUGHNESS_MIN 0.02F // what is smoother counts as this: at 0 the highlight's D is 0 / 0
// A summed normal shorter than this share of the opacity has cancelled out and tells no direction: it is not
// stretched to 1.
#define FFP_NORMAL_MIN 0.05F
#define FFP_COSINE_MIN 1e-6F // of n.l in even light, as GS-ProCams clamps it

// One pixel in the light.
typedef struct FfpLit {
    bool lit;
    real opacity, z;
    real albedo[3], roughness;
    bool rough_held;             // at FFP_ROUGHNESS_MIN
    real n[3], turn, per_length; // n = turn * per_length * N
    bool normal_held;            // at FFP_NORMAL_MIN
    real slope[3];               // d point / d z
    real in_projector[3];        // the point in the projector's frame
    real l[3], v[3], h[3], distance, h_length;
    real nl, nv, nh, vh;
    bool even;    // light without its cosine and falloff (FfpMapping.even)
    bool nl_held; // then, at FFP_COSINE_MIN
    real cosine;  // n.l, or 1 in even light
    real arrives; // visibility / distance^2, or that of the Gaussians' middle
    FfpLobe lobe;
    real f[3]; // reflectance
} FfpLit;

// One view: where the light comes from and who sees it.
typedef struct FfpLitView {
    const FfpCamera *camera, *projector;
    real even; // FfpMapping.even
} FfpLitView;

// The values of a pixel of the G-buffer and the mapping; its gradient likewise.
typedef struct FfpSums {
    real opacity, depth, normal[3], albedo[3], roughness, visibility;
} FfpSums;

// The light's transport at a pixel (FfpTransport); its gradient likewise.
typedef struct FfpArrival {
    real factor[3], uv[2];
} FfpArrival;

// Normal, albedo, roughness of the pixel: sums divided by the opacity, the normal to length 1 and turned to
// the viewer.
FFP_FORMULA void ffp_surface_attributes(const FfpSums *g, FfpLit *s) {
    const real *N = g->normal, per_opacity = 1 / s->opacity;
    for (int k = 0; k < 3; k++) s->albedo[k] = g->albedo[k] * per_opacity;
    const real roughness = g->roughness * per_opacity;
    s->rough_held = !(roughness > FFP_ROUGHNESS_MIN);
    s->roughness = s->rough_held ? FFP_ROUGHNESS_MIN : roughness;
    const real length = sqrt(ffp_dot3(N, N)), least = FFP_NORMAL_MIN * s->opacity;
    s->normal_held = !(length > least);
    s->per_length = 1 / (s->normal_held ? least : length);
    s->turn = ffp_dot3(N, s->v) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) s->n[k] = s->turn * s->per_length * N[k];
}

// As ffp_normalise3, without a branch.
FFP_FORMULA real ffp_unit3(real a[3]) {
    const real length = sqrt(ffp_dot3(a, a)), scale = length > 0 ? 1 / length : 0;
    for (int k = 0; k < 3; k++) a[k] *= scale;
    return length;
}

// Pixel (x, y) and the way of the light there. From a pixel that is not `lit` no projector light reaches the
// camera: only the ambient colour counts there, and the other numbers may not be finite. No branches: the CPU
// takes a vector of pixels at a time.
FFP_FORMULA void ffp_lit_geometry(const FfpLitView *view, int x, int y, const FfpSums *g, FfpLit *s,
                                  real uv[2]) {
    const real visibility = g->visibility;
    s->opacity = g->opacity;
    s->z = g->depth / s->opacity;
    real point[3];
    ffp_surface_point(view->camera, (real)x + 0.5F, (real)y + 0.5F, s->z, point, s->slope);
    for (int k = 0; k < 3; k++) {
        s->l[k] = view->projector->pose[4 * k + 3] - point[k];
        s->v[k] = -s->slope[k];
    }
    s->distance = ffp_unit3(s->l);
    ffp_unit3(s->v);
    ffp_surface_attributes(g, s);
    const real nl = ffp_dot3(s->n, s->l);
    s->nv = ffp_dot3(s->n, s->v);
    for (int k = 0; k < 3; k++) s->h[k] = s->l[k] + s->v[k];
    s->h_length = ffp_unit3(s->h);
    ffp_inverse_transform_point(view->projector->pose, point, s->in_projector);
    s->even = view->even > 0;
    const real least = s->even ? FFP_COSINE_MIN : -2; // no cosine is below
    s->nl_held = !(nl > least);
    s->nl = s->nl_held ? least : nl;
    s->lit = (visibility > 0) & (s->opacity > FFP_OPACITY_MIN) & (s->z > 0) & (s->nl > 0) &
             (s->h_length > 0) & (s->in_projector[2] > 0);
    s->nh = ffp_dot3(s->n, s->h);
    s->vh = ffp_dot3(s->v, s->h);
    const real away = s->even ? view->even : s->distance;
    s->cosine = s->even ? 1 : s->nl;
    s->arrives = visibility / (away * away);
    ffp_in_picture(view->projector, s->in_projector, &uv[0], &uv[1]);
    s->lobe = ffp_lobe_of(s->roughness, s->nl, s->nv, s->nh, ffp_exp2(ffp_fresnel_exponent(s->vh)));
    for (int k = 0; k < 3; k++) s->f[k] = s->albedo[k] / FFP_PI + s->lobe.D * s->lobe.F * s->lobe.V;
}

// v if `so`, otherwise 0.
FFP_FORMULA real ffp_select(bool so, real v) {
    return so ? v : 0;
}

// ffp_light at pixel (x, y).
FFP_FORMULA FfpArrival ffp_arrival(const FfpLitView *view, int x, int y, const FfpSums *sums) {
    FfpLit s;
    real uv[2];
    ffp_lit_geometry(view, x, y, sums, &s, uv);
    const real scale = s.arrives * s.cosine * s.opacity;
    return (FfpArrival){{ffp_select(s.lit, s.f[0] * scale), ffp_select(s.lit, s.f[1] * scale),
                         ffp_select(s.lit, s.f[2] * scale)},
                        {ffp_select(s.lit, uv[0]), ffp_select(s.lit, uv[1])}};
}

// Gradients for the quantities a lit pixel's factor is made of.
typedef struct FfpLitGrad {
    real opacity, roughness;
    real albedo[3], n[3], l[3], h[3];
    real v[3]; // of the view direction: moves when the camera does
    real point[3];
} FfpLitGrad;

// Through D F V: from d = dL/d(DFV) to the roughness and the four cosines.
FFP_FORMULA void ffp_specular_backward(const FfpLobe *b, const FfpLit *s, real d, real *d_roughness,
                                       real *d_nl, real *d_nv, real *d_nh, real *d_vh) {
    const real dD = d * b->F * b->V, dF = d * b->D * b->V, dV = d * b->D * b->F, rho = s->roughness;
    const real dq = -2 * b->D / b->q * dD;
    const real da2 = dD / (FFP_PI * b->q * b->q) + dq * b->c;
    const real dgv = -b->V / b->gv * dV, dgl = -b->V / b->gl * dV;
    const real dk = dgv * (1 - s->nv) + dgl * (1 - s->nl);
    *d_nh = b->c < 1 ? dq * 2 * s->nh * (b->a2 - 1) : 0;
    *d_vh = dF * (1 - FFP_F0) * b->power * FFP_LN2 * (2 * FFP_FRESNEL_2 * s->vh + FFP_FRESNEL_1);
    *d_nv = dgv * (1 - b->k);
    *d_nl += dgl * (1 - b->k);
    *d_roughness = 4 * rho * rho * rho * da2 + (rho + 1) / 4 * dk;
}

// From the factor's gradient to n, l, albedo, roughness, and (by the inverse square) the point.
FFP_FORMULA void ffp_reflect_backward(const FfpLit *s, const real grad[3], FfpLitGrad *d) {
    real d_lobe = 0, d_nl = 0, d_square = 0, d_nv, d_nh, d_vh;
    d->opacity = 0;
    for (int k = 0; k < 3; k++) {
        const real arriving = grad[k] * s->arrives, through = arriving * s->opacity * s->cosine;
        d->opacity += arriving * s->f[k] * s->cosine;
        d_nl += s->even ? 0 : arriving * s->f[k] * s->opacity;
        d->albedo[k] = through / FFP_PI;
        d_lobe += through;
        d_square -= s->even ? 0 : through * s->f[k] / (s->distance * s->distance);
    }
    ffp_specular_backward(&s->lobe, s, d_lobe, &d->roughness, &d_nl, &d_nv, &d_nh, &d_vh);
    d_nl = s->nl_held ? 0 : d_nl;
    real along_h = 0, along_l = 0;
    for (int k = 0; k < 3; k++) {
        d->n[k] = d_nl * s->l[k] + d_nv * s->v[k] + d_nh * s->h[k];
        d->h[k] = d_nh * s->n[k] + d_vh * s->v[k];
        along_h += d->h[k] * s->h[k];
    }
    for (int k = 0; k < 3; k++) {
        const real through_h = (d->h[k] - along_h * s->h[k]) / s->h_length;
        d->l[k] = d_nl * s->n[k] + through_h;
        d->v[k] = d_nv * s->n[k] + d_vh * s->h[k] + through_h;
        along_l += d->l[k] * s->l[k];
    }
    // l = (projector - point) / distance; v does not move when the point slides along the camera's ray
    for (int k = 0; k < 3; k++)
        d->point[k] = -(d->l[k] - along_l * s->l[k]) / s->distance - 2 * d_square * s->distance * s->l[k];
}

// From the pattern position's gradient to the point.
FFP_FORMULA void ffp_position_backward(const FfpCamera *projector, const FfpLit *s, const real d_uv[2],
                                       FfpLitGrad *d) {
    const real *q = s->in_projector, du = d_uv[0] * projector->fx, dv = d_uv[1] * projector->fy;
    const real in_projector[3] = {du / q[2], dv / q[2], -(du * q[0] + dv * q[1]) / (q[2] * q[2])};
    real turned[3];
    ffp_rotate(projector->pose, in_projector, turned);
    for (int k = 0; k < 3; k++) d->point[k] += turned[k];
}

// Undoes ffp_surface_attributes and the division of the depth; 0 where the pixel is not lit.
FFP_FORMULA void ffp_attributes_backward(const FfpLit *s, const FfpLitGrad *d, FfpSums *grad) {
    const real dz = ffp_dot3(d->point, s->slope), along = ffp_dot3(d->n, s->n), per_opacity = 1 / s->opacity;
    const real d_roughness = s->rough_held ? 0 : d->roughness, turned = s->turn * s->per_length;
    const real held = s->normal_held ? 0 : along;
    real sum = dz * s->z + d_roughness * s->roughness + (along - held);
    for (int k = 0; k < 3; k++) {
        sum += d->albedo[k] * s->albedo[k];
        grad->albedo[k] = ffp_select(s->lit, d->albedo[k] * per_opacity);
        grad->normal[k] = ffp_select(s->lit, turned * (d->n[k] - held * s->n[k]));
    }
    grad->depth = ffp_select(s->lit, dz * per_opacity);
    grad->roughness = ffp_select(s->lit, d_roughness * per_opacity);
    grad->opacity = ffp_select(s->lit, d->opacity - sum * per_opacity);
    grad->visibility = 0;
}

// ffp_light_backward at pixel (x, y): the gradient of its sums.
FFP_FORMULA FfpSums ffp_arrival_backward(const FfpLitView *view, int x, int y, const FfpSums *sums,
                                         const FfpArrival *grad) {
    FfpLit s;
    FfpLitGrad d;
    FfpSums out;
    real uv[2];
    ffp_lit_geometry(view, x, y, sums, &s, uv);
    ffp_reflect_backward(&s, grad->factor, &d);
    ffp_position_backward(view->projector, &s, grad->uv, &d);
    ffp_attributes_backward(&s, &d, &out);
    return out;
}

// One picture: the light that a pattern sends. Each of its pixels is the mean of side x side samples, which
// are the transport's pixels.
typedef struct FfpPatternLight {
    const FfpTransport *transport;
    const real *extent;       // of the mapping
    const real *intensity;    // [3]
    const FfpSummed *pattern; // NULL: black
    int side;
    real level[3]; // the pattern's mean, which scattered light follows (ffp_pattern_level)
} FfpPatternLight;

// The pattern's mean over the part of it that falls on the Gaussians (FfpMapping.lit); NULL: black.
FFP_FORMULA void ffp_pattern_level(const FfpSummed *pattern, const real lit[4], real level[3]) {
    for (int k = 0; k < 3; k++) level[k] = 0;
    if (pattern) ffp_box_mean(pattern, lit[0], lit[1], lit[2], lit[3], level);
}

// Sample i of the picture's pixel (x, y), row by row.
FFP_FORMULA ptrdiff_t ffp_sample_of(const FfpPatternLight *light, int x, int y, int i) {
    const int side = light->side;
    return ((ptrdiff_t)y * side + i / side) * light->transport->width + x * side + i % side;
}

// True if the sample shows anything of the pattern.
FFP_FORMULA bool ffp_sample_lit(const FfpPatternLight *light, ptrdiff_t sample) {
    const real *factor = light->transport->factor + 3 * sample;
    return light->pattern && (factor[0] != 0 || factor[1] != 0 || factor[2] != 0);
}

// A lit sample's look at the pattern: mean colour, and how it changes with u and v, three numbers each. Plain
// patterns are looked at again rather than kept.
FFP_FORMULA bool ffp_keeps_lookup(const FfpPatternLight *light) {
    return light->transport->look && !light->pattern->plain;
}

FFP_FORMULA void ffp_pattern_lookup(const FfpPatternLight *light, ptrdiff_t sample, real look[9]) {
    const real *uv = light->transport->uv + 2 * sample, *extent = light->extent + 2 * sample;
    ffp_box_slopes(light->pattern, uv[0], uv[1], extent[0], extent[1], look, look + 3, look + 6);
}

// Radiance that pixel (x, y) shows, linear, unclamped, times its opacity. scattered: of the G-buffer, or
// NULL.
FFP_FORMULA void ffp_shade_pixel(const FfpPatternLight *light, int x, int y, const real ambient[3],
                                 const real scattered[3], real out[3]) {
    const int samples = light->side * light->side;
    const real share = 1 / (real)samples;
    real sum[3] = {0, 0, 0};
    for (int i = 0; light->pattern && i < samples; i++) {
        const ptrdiff_t s = ffp_sample_of(light, x, y, i);
        if (!ffp_sample_lit(light, s)) continue;
        const real *uv = light->transport->uv + 2 * s, *extent = light->extent + 2 * s;
        real look[3], *texture = look;
        if (ffp_keeps_lookup(light))
            ffp_pattern_lookup(light, s, texture = light->transport->look + 9 * s);
        else
            ffp_box_mean(light->pattern, uv[0], uv[1], extent[0], extent[1], texture);
        for (int k = 0; k < 3; k++) sum[k] += light->transport->factor[3 * s + k] * texture[k];
    }
    for (int k = 0; k < 3; k++) out[k] = ambient[k] + share * light->intensity[k] * sum[k];
    for (int k = 0; scattered && k < 3; k++) out[k] += light->level[k] * scattered[k];
}

// From the gradient of a lit sample's radiance: adds those of the transport and of the intensity. d_texture:
// of the pattern's mean colour there.
FFP_FORMULA void ffp_shade_sample_backward(const FfpPatternLight *light, ptrdiff_t sample, const real grad[3],
                                           FfpTransport *d_transport, real d_intensity[3],
                                           real d_texture[3]) {
    const real *factor = light->transport->factor + 3 * sample;
    real seen[9];
    const bool kept = ffp_keeps_lookup(light);
    if (!kept) ffp_pattern_lookup(light, sample, seen);
    const real *texture = kept ? light->transport->look + 9 * sample : seen;
    const real *along_u = texture + 3, *along_v = texture + 6;
    for (int k = 0; k < 3; k++) {
        d_texture[k] = grad[k] * factor[k] * light->intensity[k];
        d_intensity[k] += grad[k] * factor[k] * texture[k];
        d_transport->factor[3 * sample + k] += grad[k] * light->intensity[k] * texture[k];
        d_transport->uv[2 * sample] += d_texture[k] * along_u[k];
        d_transport->uv[2 * sample + 1] += d_texture[k] * along_v[k];
    }
}

#endif
