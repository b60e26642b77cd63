// Gaussians for programs without projectors: one colour each, drawn in the plain form of 3DGS.
#ifndef FFP_EXPORT_SPLATS_H
#define FFP_EXPORT_SPLATS_H

#include "core/gaussians/gaussians.h"

typedef struct FfpSplats {
    int64_t count;
    real *centre;   // [count,3] in the axes asked for
    real *scale;    // [count,3] standard deviations
    real *rotation; // [count,4] w x y z
    real *opacity;  // [count]
    real *colour;   // [count,3] sRGB-encoded, 0 and above
} FfpSplats;

// `colour` [count,3]: linear radiance; `turn`: quaternion w x y z from the world to the file's axes.
// Gaussians of an opacity below 1/255, which no program draws, are left out; shapes and opacities stay as
// they are. Other programs draw o exp(-r^2 / 2), while ours are drawn firmer (FfpRenderSettings.firmness),
// and blur pixels more; measurements showed that making splats wider or more opaque to compensate loses more
// accuracy than it gains.
FfpSplats ffp_splats_new(const FfpGaussians *gaussians, const real *colour, const real turn[4]);
void ffp_splats_free(FfpSplats *splats);

// The reference layout of 3DGS: x y z nx ny nz f_dc_0..2 f_rest_0..44 opacity scale_0..2 rot_0..3.
bool ffp_splats_write_ply(const FfpSplats *splats, const char *path, FfpError *err);
// SPZ, version 3.
bool ffp_splats_write_spz(const FfpSplats *splats, const char *path, FfpError *err);
// glTF 2.0 with KHR_gaussian_splatting; `binary`: GLB.
bool ffp_splats_write_gltf(const FfpSplats *splats, const char *path, bool binary, FfpError *err);

#endif
