// Gaussians as programs without projectors take them: one colour each, drawn in the plain form of 3DGS.
#ifndef FFP_EXPORT_SPLATS_H
#define FFP_EXPORT_SPLATS_H

#include "gaussians/gaussians.h"

typedef struct FfpSplats {
    int64_t count;
    real *centre;   // [count,3] in the axes asked for
    real *scale;    // [count,3] standard deviations
    real *rotation; // [count,4] w x y z
    real *opacity;  // [count]
    real *colour;   // [count,3] sRGB-encoded, 0 and above
} FfpSplats;

typedef struct FfpSplatForm {
    real turn[4]; // quaternion w x y z from the world to the file's axes
    bool firm;    // the Gaussians are drawn firm (FfpRenderSettings.firmness 1), and turned into plain ones
} FfpSplatForm;

// `colour` [count,3]: linear radiance. Gaussians of an opacity below 1/255, which no program draws, are left
// out.
//
// A firm splat covers d (2 - d) with d = o exp(-r^2 / 2), a plain one o' exp(-r^2 / (2 s^2)). The plain one
// gets the same coverage in its middle, o' = o (2 - o), and in all: the integral of the former is
// 2 pi (2 o - o^2 / 2), of the latter 2 pi s^2 o', so that s^2 = (2 - o / 2) / (2 - o).
FfpSplats ffp_splats_new(const FfpGaussians *gaussians, const real *colour, const FfpSplatForm *form);
void ffp_splats_free(FfpSplats *splats);

// The reference layout of 3DGS: x y z nx ny nz f_dc_0..2 f_rest_0..44 opacity scale_0..2 rot_0..3.
bool ffp_splats_write_ply(const FfpSplats *splats, const char *path, FfpError *err);
// SPZ, version 3.
bool ffp_splats_write_spz(const FfpSplats *splats, const char *path, FfpError *err);
// glTF 2.0 with KHR_gaussian_splatting; `binary`: GLB.
bool ffp_splats_write_gltf(const FfpSplats *splats, const char *path, bool binary, FfpError *err);

#endif
