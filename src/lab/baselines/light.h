// Inside the field's room: what the networks' outputs mean, and a point of the field in the light of
// core/base/brdf.h: radiance = ambient + A texture with A = f_r V (I / d^2) max(n.l, 0), so that one A serves
// every pattern.
#ifndef FFP_FIELD_LIGHT_H
#define FFP_FIELD_LIGHT_H

#include "engine/render/shade_pixel.h"
#include "lab/baselines/field.h"

#define FFP_FIELD_LOG_MAX 9.0F // of the density's logarithm: nothing comes through a step's length of that

FFP_FORMULA real ffp_field_sigmoid(real x) {
    return 1 / (1 + exp(-x));
}

// log(1 + exp(x)); its slope is the sigmoid.
FFP_FORMULA real ffp_softplus(real x) {
    return x > 15 ? x : log(1 + exp(x));
}

FFP_FORMULA real ffp_field_density(real raw) {
    return exp(raw < FFP_FIELD_LOG_MAX ? raw : FFP_FIELD_LOG_MAX);
}

// The networks' outputs for one point; rows of their outputs are `stride` apart.
typedef struct FfpFieldPoint {
    real normal[3], length; // unit; of the vector that it was before
    real albedo[3], roughness, ambient[3];
} FfpFieldPoint;

// The normal network adds to the direction from the object's centre: the guess that it starts from.
FFP_FORMULA FfpFieldPoint ffp_field_point(const real *geometry, const real *material, int64_t stride,
                                          const real at[3]) {
    FfpFieldPoint p;
    for (int k = 0; k < 3; k++) {
        p.normal[k] = at[k] + geometry[(FFP_GEOMETRY_NORMAL + k) * stride];
        p.albedo[k] = ffp_field_sigmoid(material[(FFP_MATERIAL_ALBEDO + k) * stride]);
        p.ambient[k] = ffp_softplus(material[(FFP_MATERIAL_AMBIENT + k) * stride]);
    }
    p.length = ffp_normalise3(p.normal);
    p.roughness = FFP_ROUGHNESS_MIN +
                  (1 - FFP_ROUGHNESS_MIN) * ffp_field_sigmoid(material[FFP_MATERIAL_ROUGHNESS * stride]);
    return p;
}

typedef struct FfpFieldPointGrad {
    real normal[3], albedo[3], roughness, ambient[3];
} FfpFieldPointGrad;

// Through ffp_field_point, into columns of the outputs' gradients.
FFP_FORMULA void ffp_field_point_backward(const FfpFieldPoint *p, const real *material,
                                          const FfpFieldPointGrad *d, int64_t stride, real *d_geometry,
                                          real *d_material) {
    const real along = ffp_dot3(d->normal, p->normal), per = p->length > 0 ? 1 / p->length : 0;
    for (int k = 0; k < 3; k++) {
        d_geometry[(FFP_GEOMETRY_NORMAL + k) * stride] = (d->normal[k] - along * p->normal[k]) * per;
        d_material[(FFP_MATERIAL_ALBEDO + k) * stride] = d->albedo[k] * p->albedo[k] * (1 - p->albedo[k]);
        d_material[(FFP_MATERIAL_AMBIENT + k) * stride] =
            d->ambient[k] * ffp_field_sigmoid(material[(FFP_MATERIAL_AMBIENT + k) * stride]);
    }
    const real share = (p->roughness - FFP_ROUGHNESS_MIN) / (1 - FFP_ROUGHNESS_MIN);
    d_material[FFP_MATERIAL_ROUGHNESS * stride] =
        d->roughness * (1 - FFP_ROUGHNESS_MIN) * share * (1 - share);
}

// Geometry of the light at a point: fills in s, and factor: V I / d^2. `towards` is the camera's ray. False
// where the projector's light does not reach the side that the camera sees.
FFP_FORMULA bool ffp_field_lit(const FfpFieldPoint *p, const real at[3], const real towards[3],
                               const FfpCamera *projector, const real intensity[3], real visibility,
                               FfpLit *s, real factor[3], real A[3]) {
    for (int k = 0; k < 3; k++) {
        s->l[k] = projector->pose[4 * k + 3] - at[k];
        s->v[k] = -towards[k];
        s->n[k] = p->normal[k];
        A[k] = 0;
    }
    s->distance = ffp_normalise3(s->l);
    for (int k = 0; k < 3; k++) s->h[k] = s->l[k] + s->v[k];
    s->h_length = ffp_normalise3(s->h);
    s->nl = ffp_dot3(s->n, s->l);
    if (!(s->nl > 0) || !(s->h_length > 0)) return false;
    const real nv = ffp_dot3(s->n, s->v);
    s->nv = nv > 0 ? nv : 0;
    s->nh = ffp_dot3(s->n, s->h);
    s->vh = ffp_dot3(s->v, s->h);
    s->roughness = p->roughness;
    s->lobe = ffp_lobe(s->roughness, s->nl, s->nv, s->nh, s->vh);
    for (int k = 0; k < 3; k++) {
        factor[k] = visibility * intensity[k] / (s->distance * s->distance);
        s->f[k] = p->albedo[k] / FFP_PI + s->lobe.D * s->lobe.F * s->lobe.V;
        A[k] = s->f[k] * factor[k] * s->nl;
    }
    return true;
}

// From dA to normal, albedo and roughness, ADDED to d. The point itself does not move.
FFP_FORMULA void ffp_field_lit_backward(const FfpLit *s, const real factor[3], const real dA[3],
                                        FfpFieldPointGrad *d) {
    real d_lobe = 0, d_nl = 0, d_nv, d_nh, d_vh, d_roughness;
    for (int k = 0; k < 3; k++) {
        d->albedo[k] += dA[k] * factor[k] * s->nl / FFP_PI;
        d_lobe += dA[k] * factor[k] * s->nl;
        d_nl += dA[k] * factor[k] * s->f[k];
    }
    ffp_specular_backward(&s->lobe, s, d_lobe, &d_roughness, &d_nl, &d_nv, &d_nh, &d_vh);
    d->roughness += d_roughness;
    if (!(s->nv > 0)) d_nv = 0;
    for (int k = 0; k < 3; k++) d->normal[k] += d_nl * s->l[k] + d_nv * s->v[k] + d_nh * s->h[k];
}

// Where a point lies in the pattern, and how many of its pixels a camera's pixel covers there (`across`: its
// width in the field's units). False off the pattern.
FFP_FORMULA bool ffp_field_texel(const FfpCamera *projector, const real at[3], real across, real uv[2],
                                 real *extent) {
    const real z = ffp_project(projector, at, &uv[0], &uv[1]);
    if (!(z > 0) || !(uv[0] >= 0) || !(uv[1] >= 0) || !(uv[0] <= (real)projector->width) ||
        !(uv[1] <= (real)projector->height))
        return false;
    *extent = across * projector->fx / z;
    return true;
}

// A direction as the visibility network sees it: the real spherical harmonics of the first three bands
// without their factors, [FFP_FIELD_DIRECTION] in a column.
FFP_FORMULA void ffp_field_direction(const real d[3], int64_t stride, real *out) {
    const real x = d[0], y = d[1], z = d[2], xx = x * x, yy = y * y, zz = z * z;
    const real band[FFP_FIELD_DIRECTION] = {x,
                                            y,
                                            z,
                                            x * y,
                                            y * z,
                                            3 * zz - 1,
                                            x * z,
                                            xx - yy,
                                            y * (3 * xx - yy),
                                            x * y * z,
                                            y * (5 * zz - 1),
                                            z * (5 * zz - 3),
                                            x * (5 * zz - 1),
                                            z * (xx - yy),
                                            x * (xx - 3 * yy)};
    for (int i = 0; i < FFP_FIELD_DIRECTION; i++) out[i * stride] = band[i];
}

#endif
