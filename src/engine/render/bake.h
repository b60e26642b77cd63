// The light of a projector, worked out at each Gaussian instead of each pixel: colours that stay when the
// Gaussians go to programs without lights.
#ifndef FFP_RENDER_BAKE_H
#define FFP_RENDER_BAKE_H

#include "engine/render/render.h"

typedef struct FfpBakeLight {
    const FfpCamera *projector;
    const real *intensity;    // [3], radiant, at pattern value 1
    const FfpSummed *pattern; // of the projector's size
    const real *eye;          // [3] from where the highlights are seen; NULL: none, the diffuse light alone
} FfpBakeLight;

// out [count,3]: linear radiance of each Gaussian, C = f L max(n.l, 0) + C_amb with the reflectance, the
// shadows and the pattern lookup of docs/design/architecture.md, "Light", or in even light, at its centre.
// Its normal is its shortest axis, turned to the eye, or without one to the projector; its footprint in the
// pattern is the box that has its own mean variance across the light. CPU only.
void ffp_bake(const FfpGaussians *gaussians, const FfpBakeLight *light, const FfpRenderSettings *settings,
              real *out);

#endif
