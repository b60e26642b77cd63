// Inside the render room: one pixel in the light C = f_r L max(n.l, 0) O + C_amb with the reflectance of
// base/brdf.h, and its gradient, one text for the CPU and the GPU. It is linear in the pattern: what the
// surface and the way of the light do is found once a view (ffp_light_pixel), what a pattern adds to that is
// a product (ffp_shade_pixel).
#ifndef FFP_RENDER_SHADE_PIXEL_H
#define FFP_RENDER_SHADE_PIXEL_H

#include "base/brdf.h"
#include "capture/project.h"
#include "image/lookup_box.h"
#include "render/formula.h"
#include "render/render.h"

#define FFP_LN2 0.693147180559945309F
#define FFP_ROUGHNESS_MIN 0.02F // below it the highlight's D is 0 / 0
// A summed normal shorter than this share of the opacity has cancelled out and tells no direction: it is not
// stretched to 1.
#define FFP_NORMAL_MIN 0.05F
#define FFP_COSINE_MIN 1e-6F // of n.l in even light, as GS-ProCams clamps it

// One lit pixel.
typedef struct FfpLit {
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

// One view: what the projector's light falls on.
typedef struct FfpLitView {
    const FfpGbuffer *gbuffer;
    const FfpMapping *mapping;
    const FfpCamera *camera, *projector;
} FfpLitView;

// Normal, albedo, roughness of the pixel: sums divided by the opacity, the normal to length 1 and turned to
// the viewer.
FFP_FORMULA void ffp_surface_attributes(const FfpGbuffer *g, int p, FfpLit *s) {
    const real *N = g->normal + 3 * p;
    for (int k = 0; k < 3; k++) s->albedo[k] = g->albedo[3 * p + k] / s->opacity;
    s->roughness = g->roughness[p] / s->opacity;
    s->rough_held = !(s->roughness > FFP_ROUGHNESS_MIN);
    if (s->rough_held) s->roughness = FFP_ROUGHNESS_MIN;
    const real length = sqrt(ffp_dot3(N, N)), least = FFP_NORMAL_MIN * s->opacity;
    s->normal_held = !(length > least);
    s->per_length = 1 / (s->normal_held ? least : length);
    s->turn = ffp_dot3(N, s->v) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) s->n[k] = s->turn * s->per_length * N[k];
}

// False where no projector light reaches the camera: only the ambient colour counts there.
FFP_FORMULA bool ffp_lit_geometry(const FfpLitView *view, int x, int y, FfpLit *s, real uv[2]) {
    const FfpGbuffer *g = view->gbuffer;
    const int p = y * g->width + x;
    const real visibility = view->mapping->visibility[p];
    s->opacity = g->opacity[p];
    if (!(visibility > 0) || !(s->opacity > FFP_OPACITY_MIN)) return false;
    s->z = g->depth[p] / s->opacity;
    if (!(s->z > 0)) return false;
    real point[3];
    ffp_surface_point(view->camera, (real)x + 0.5F, (real)y + 0.5F, s->z, point, s->slope);
    for (int k = 0; k < 3; k++) {
        s->l[k] = view->projector->pose[4 * k + 3] - point[k];
        s->v[k] = -s->slope[k];
    }
    s->distance = ffp_normalise3(s->l);
    ffp_normalise3(s->v);
    ffp_surface_attributes(g, p, s);
    s->nl = ffp_dot3(s->n, s->l), s->nv = ffp_dot3(s->n, s->v);
    for (int k = 0; k < 3; k++) s->h[k] = s->l[k] + s->v[k];
    s->h_length = ffp_normalise3(s->h);
    ffp_inverse_transform_point(view->projector->pose, point, s->in_projector);
    s->even = view->mapping->even > 0;
    s->nl_held = s->even && !(s->nl > FFP_COSINE_MIN);
    if (s->nl_held) s->nl = FFP_COSINE_MIN;
    if (!(s->nl > 0) || !(s->h_length > 0) || !(s->in_projector[2] > 0)) return false;
    s->nh = ffp_dot3(s->n, s->h), s->vh = ffp_dot3(s->v, s->h);
    const real away = s->even ? view->mapping->even : s->distance;
    s->cosine = s->even ? 1 : s->nl;
    s->arrives = visibility / (away * away);
    ffp_project(view->projector, point, &uv[0], &uv[1]);
    return true;
}

FFP_FORMULA void ffp_reflect(FfpLit *s) {
    s->lobe = ffp_lobe(s->roughness, s->nl, s->nv, s->nh, s->vh);
    for (int k = 0; k < 3; k++) s->f[k] = s->albedo[k] / FFP_PI + s->lobe.D * s->lobe.F * s->lobe.V;
}

// ffp_light
FFP_FORMULA void ffp_light_pixel(const FfpLitView *view, int x, int y, FfpTransport *out) {
    const int p = y * view->gbuffer->width + x;
    FfpLit s;
    real *factor = out->factor + 3 * p, *uv = out->uv + 2 * p;
    uv[0] = uv[1] = factor[0] = factor[1] = factor[2] = 0;
    if (!ffp_lit_geometry(view, x, y, &s, uv)) return;
    ffp_reflect(&s);
    for (int k = 0; k < 3; k++) factor[k] = s.f[k] * s.arrives * s.cosine * s.opacity;
}

// Gradients for the quantities a lit pixel's factor is made of.
typedef struct FfpLitGrad {
    real opacity, roughness;
    real albedo[3], n[3], l[3], h[3];
    real point[3];
} FfpLitGrad;

// Through D F V: from d = dL/d(DFV) to the roughness and the four cosines.
FFP_FORMULA void ffp_specular_backward(const FfpLobe *b, const FfpLit *s, real d, real *d_roughness,
                                       real *d_nl, real *d_nv, real *d_nh, real *d_vh) {
    const real dD = d * b->F * b->V, dF = d * b->D * b->V, dV = d * b->D * b->F, rho = s->roughness;
    const real dq = -2 * b->D / b->q * dD;
    const real da2 = dD / (FFP_PI * b->q * b->q) + dq * s->nh * s->nh;
    const real dgv = -b->V / b->gv * dV, dgl = -b->V / b->gl * dV;
    const real dk = dgv * (1 - s->nv) + dgl * (1 - s->nl);
    *d_nh = dq * 2 * s->nh * (b->a2 - 1);
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
        if (!s->even) d_nl += arriving * s->f[k] * s->opacity;
        d->albedo[k] = through / FFP_PI;
        d_lobe += through;
        if (!s->even) d_square -= through * s->f[k] / (s->distance * s->distance);
    }
    ffp_specular_backward(&s->lobe, s, d_lobe, &d->roughness, &d_nl, &d_nv, &d_nh, &d_vh);
    if (s->nl_held) d_nl = 0;
    real along_h = 0, along_l = 0;
    for (int k = 0; k < 3; k++) {
        d->n[k] = d_nl * s->l[k] + d_nv * s->v[k] + d_nh * s->h[k];
        d->h[k] = d_nh * s->n[k] + d_vh * s->v[k];
        along_h += d->h[k] * s->h[k];
    }
    for (int k = 0; k < 3; k++) {
        d->l[k] = d_nl * s->n[k] + (d->h[k] - along_h * s->h[k]) / s->h_length;
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

// Undoes ffp_surface_attributes and the division of the depth.
FFP_FORMULA void ffp_attributes_backward(const FfpLit *s, int p, FfpLitGrad *d, FfpGbuffer *grad) {
    real d_opacity = d->opacity;
    const real dz = ffp_dot3(d->point, s->slope), along = ffp_dot3(d->n, s->n);
    grad->depth[p] += dz / s->opacity;
    d_opacity -= dz * s->z / s->opacity;
    for (int k = 0; k < 3; k++) {
        grad->albedo[3 * p + k] += d->albedo[k] / s->opacity;
        d_opacity -= d->albedo[k] * s->albedo[k] / s->opacity;
        const real across = s->normal_held ? d->n[k] : d->n[k] - along * s->n[k];
        grad->normal[3 * p + k] += s->turn * s->per_length * across;
    }
    if (s->normal_held) d_opacity -= along / s->opacity;
    if (!s->rough_held) {
        grad->roughness[p] += d->roughness / s->opacity;
        d_opacity -= d->roughness * s->roughness / s->opacity;
    }
    grad->opacity[p] += d_opacity;
}

// ffp_light_backward
FFP_FORMULA void ffp_light_pixel_backward(const FfpLitView *view, int x, int y, const FfpTransport *grad,
                                          FfpGbuffer *grad_gbuffer) {
    const int p = y * view->gbuffer->width + x;
    const real *d_factor = grad->factor + 3 * p, *d_uv = grad->uv + 2 * p;
    if (d_factor[0] == 0 && d_factor[1] == 0 && d_factor[2] == 0 && d_uv[0] == 0 && d_uv[1] == 0) return;
    FfpLit s;
    FfpLitGrad d;
    real uv[2];
    if (!ffp_lit_geometry(view, x, y, &s, uv)) return;
    ffp_reflect(&s);
    ffp_reflect_backward(&s, d_factor, &d);
    ffp_position_backward(view->projector, &s, d_uv, &d);
    ffp_attributes_backward(&s, p, &d, grad_gbuffer);
}

// One picture: the light that a pattern sends.
typedef struct FfpPatternLight {
    const FfpTransport *transport;
    const real *extent;       // of the mapping
    const real *intensity;    // [3]
    const FfpSummed *pattern; // NULL: black
} FfpPatternLight;

// Whether pixel p shows anything of the pattern.
FFP_FORMULA bool ffp_pixel_lit(const FfpPatternLight *light, int p) {
    const real *factor = light->transport->factor + 3 * p;
    return light->pattern && (factor[0] != 0 || factor[1] != 0 || factor[2] != 0);
}

// Radiance that the pixel shows, linear, unclamped, times its opacity.
FFP_FORMULA void ffp_shade_pixel(const FfpPatternLight *light, int p, const real *ambient, real out[3]) {
    const real *factor = light->transport->factor + 3 * p, *uv = light->transport->uv + 2 * p;
    real texture[3] = {0, 0, 0};
    if (ffp_pixel_lit(light, p))
        ffp_box_mean(light->pattern, uv[0], uv[1], light->extent[2 * p], light->extent[2 * p + 1], texture);
    for (int k = 0; k < 3; k++) out[k] = ambient[3 * p + k] + factor[k] * light->intensity[k] * texture[k];
}

// Adds the gradients of the ambient colour, of the transport and of the intensity. d_texture: of the
// pattern's mean colour there; 0 where the pixel shows nothing of it.
FFP_FORMULA void ffp_shade_pixel_backward(const FfpPatternLight *light, int p, const real grad[3],
                                          real *d_ambient, FfpTransport *d_transport, real d_intensity[3],
                                          real d_texture[3]) {
    const real *factor = light->transport->factor + 3 * p, *uv = light->transport->uv + 2 * p;
    for (int k = 0; k < 3; k++) d_ambient[3 * p + k] += grad[k], d_texture[k] = 0;
    if (!ffp_pixel_lit(light, p) || (grad[0] == 0 && grad[1] == 0 && grad[2] == 0)) return;
    real texture[3], along_u[3], along_v[3];
    ffp_box_slopes(light->pattern, uv[0], uv[1], light->extent[2 * p], light->extent[2 * p + 1], texture,
                   along_u, along_v);
    for (int k = 0; k < 3; k++) {
        d_texture[k] = grad[k] * factor[k] * light->intensity[k];
        d_intensity[k] += grad[k] * factor[k] * texture[k];
        d_transport->factor[3 * p + k] += grad[k] * light->intensity[k] * texture[k];
        d_transport->uv[2 * p] += d_texture[k] * along_u[k];
        d_transport->uv[2 * p + 1] += d_texture[k] * along_v[k];
    }
}

#endif
