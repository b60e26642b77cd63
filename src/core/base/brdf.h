// The reflectance of the light model (docs/design/architecture.md, "Light"), in real: Lambert plus a GGX lobe
// with Schlick's Fresnel in its spherical-Gaussian form and the k = (rho + 1)^2 / 8 visibility of Karis 2013,
// as in GS-ProCams. The simulator, the classical initialisation and the renderer share this light model.
#ifndef FFP_BASE_BRDF_H
#define FFP_BASE_BRDF_H

#include "core/base/vec.h"

#define FFP_F0 0.04F              // Fresnel reflectance at normal incidence
#define FFP_FRESNEL_2 (-5.55473F) // Schlick's power as 2^((FRESNEL_2 v.h + FRESNEL_1) v.h)
#define FFP_FRESNEL_1 (-6.98316F)

// The specular lobe's three factors D, F and V, with what their gradients need.
typedef struct FfpLobe {
    real a2, k;  // rho^4, (rho + 1)^2 / 8
    real c, q;   // (n.h)^2, no more than 1; c (a2 - 1) + 1
    real gv, gl; // (n.v)(1 - k) + k, and for l
    real power;  // Schlick's
    real D, F, V;
} FfpLobe;

// Schlick's power as one of two.
FFP_FORMULA real ffp_fresnel_exponent(real vh) {
    return (FFP_FRESNEL_2 * vh + FFP_FRESNEL_1) * vh;
}

// roughness in (0,1]; cosines of normal with light, viewer and the half vector; Schlick's power.
FFP_FORMULA FfpLobe ffp_lobe_of(real roughness, real nl, real nv, real nh, real power) {
    FfpLobe b;
    const real a = roughness * roughness;
    b.a2 = a * a;
    b.k = (roughness + 1) * (roughness + 1) / 8;
    const real square = nh * nh;
    b.c = square < 1 ? square : 1;
    b.q = (1 - b.c) + b.a2 * b.c; // so written it is at least a2, whatever is rounded
    b.gv = nv * (1 - b.k) + b.k;
    b.gl = nl * (1 - b.k) + b.k;
    b.power = power;
    b.D = b.a2 / (FFP_PI * b.q * b.q);
    b.F = FFP_F0 + (1 - FFP_F0) * b.power;
    b.V = 1 / (4 * b.gv * b.gl);
    return b;
}

// roughness in (0,1]; cosines of normal, light, viewer and the half vector between the latter two.
FFP_FORMULA FfpLobe ffp_lobe(real roughness, real nl, real nv, real nh, real vh) {
    return ffp_lobe_of(roughness, nl, nv, nh, exp2(ffp_fresnel_exponent(vh)));
}

// D F V; all directions unit, away from the surface, n.l and n.v positive.
FFP_FORMULA real ffp_brdf_specular(const real n[3], const real l[3], const real v[3], real roughness) {
    real h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    ffp_normalise3(h);
    const FfpLobe b = ffp_lobe(roughness, ffp_dot3(n, l), ffp_dot3(n, v), ffp_dot3(n, h), ffp_dot3(v, h));
    return b.D * b.F * b.V;
}

#endif
