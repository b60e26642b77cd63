// Splats of other programs: one colour each, without material. Every reader fills in what its file says and
// leaves the rest to ffp_splat_complete.
#ifndef FFP_GAUSSIANS_ELSEWHERE_H
#define FFP_GAUSSIANS_ELSEWHERE_H

#include "core/gaussians/gaussians.h"
#include "core/gaussians/row.h"

// What such a splat does not say, once its row (f_dc, logits, logarithms) is decoded. Its colour is light and
// material in one: it becomes both the albedo (within [0,1]) and, as it looks without a projector, the
// ambient colour; the roughness becomes 0.5.
void ffp_splat_complete(FfpGaussians *gaussians, int64_t index);
// Decodes and completes; an error names the file, the splat and the number that cannot be used.
bool ffp_splat_put(FfpGaussians *gaussians, int64_t index, const float row[FFP_ROW_NUMBERS], const char *path,
                   FfpError *err);
void ffp_splats_note(const char *path); // says what was assumed

// SPZ, versions 1 to 3, as Niantic published it (github.com/nianticlabs/spz, README). Spherical harmonics
// beyond the constant are not used. Errors: not gzip, another magic or version, counts beyond the file or
// FFP_GAUSSIANS_MAX, data that ends early.
bool ffp_gaussians_read_spz(FfpGaussians *gaussians, const char *path, FfpError *err);
// glTF 2.0, JSON or GLB, with KHR_gaussian_splatting (github.com/KhronosGroup/glTF, extensions): the first
// primitive that has it. Attributes are floats or normalised integers, in the GLB's own buffer, in data URIs
// or in files beside the JSON. Errors: no such primitive; compressed splats; nodes with a transform; sizes
// beyond the buffers.
bool ffp_gaussians_read_gltf(FfpGaussians *gaussians, const char *path, FfpError *err);

#endif
