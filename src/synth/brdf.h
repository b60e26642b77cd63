// The reflectance of the light model (docs/architecture.md): Lambert plus GGX with Schlick's Fresnel in its
// spherical-Gaussian form and the k = (rho+1)^2 / 8 visibility of Karis 2013.
#ifndef FFP_SYNTH_BRDF_H
#define FFP_SYNTH_BRDF_H

#include <math.h>
#include "synth/scalar.h"

// The specular term D F V; all directions unit, away from the surface, n.l and n.v positive.
static inline float ffp_brdf_specular(const float n[3], const float l[3], const float v[3], float roughness) {
    float h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
    const float scale = 1 / sqrtf(ffp_max(h[0] * h[0] + h[1] * h[1] + h[2] * h[2], 1e-12F));
    float nh = 0, vh = 0, nl = 0, nv = 0;
    for (int i = 0; i < 3; i++) {
        h[i] *= scale;
        nh += n[i] * h[i], vh += v[i] * h[i], nl += n[i] * l[i], nv += n[i] * v[i];
    }
    const float a = roughness * roughness, k = (roughness + 1) * (roughness + 1) / 8;
    const float spread = nh * nh * (a * a - 1) + 1;
    const float d = a * a / (3.14159265F * spread * spread);
    const float f = 0.04F + 0.96F * exp2f((-5.55473F * vh - 6.98316F) * vh);
    return d * f / (4 * (nv * (1 - k) + k) * (nl * (1 - k) + k));
}

#endif
