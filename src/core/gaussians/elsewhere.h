// Splats of other programs: one colour each, without material. Every reader fills in what its file says and
// leaves the rest to ffp_splat_complete.
#ifndef FFP_GAUSSIANS_ELSEWHERE_H
#define FFP_GAUSSIANS_ELSEWHERE_H

#include "core/gaussians/gaussians.h"
#include "core/gaussians/row.h"

#define FFP_SPLAT_FILE_MAX (SIZE_MAX >> (sizeof(size_t) == 8 ? 32 : 1)) // bytes: 4 GiB

// What such a splat does not say, once its row (f_dc, logits, logarithms) is decoded. Its colour is light and
// material in one: it becomes both the albedo (within [0,1]) and, as it looks without a projector, the
// ambient colour; the roughness becomes 0.5.
void ffp_splat_complete(FfpGaussians *gaussians, int64_t index);
// Decodes and completes; an error names the file, the splat and the number that cannot be used.
bool ffp_splat_put(FfpGaussians *gaussians, int64_t index, const float row[FFP_ROW_NUMBERS], const char *path,
                   FfpError *err);
void ffp_splats_note(const char *path); // says what was assumed

// The extension of glTF that splats are in.
#define FFP_SPLAT_EXTENSION "KHR_gaussian_splatting"

// What an SPZ file is made of.
#define FFP_SPZ_MAGIC 0x5053474eU         // "NGSP"
#define FFP_SPZ_HEADER 16                 // bytes
#define FFP_SPZ_COLOUR 0.15               // of f_dc in a byte, around the middle
#define FFP_SPZ_SHORT 0.70710678118654752 // the largest that the three smaller parts of a unit quaternion get

// SPZ, versions 1 to 3, as Niantic published it (github.com/nianticlabs/spz, README). Spherical harmonics
// beyond the constant are not used. Errors: not gzip, another magic or version, counts beyond the file or
// FFP_GAUSSIANS_MAX, data that ends early or differs from its checksum.
bool ffp_gaussians_read_spz(FfpGaussians *gaussians, const char *path, FfpError *err);
// glTF 2.0, JSON or GLB, with KHR_gaussian_splatting (github.com/KhronosGroup/glTF, extensions): the one
// primitive that has it. Attributes are floats or normalised integers, in the GLB's own buffer, in data URIs
// or in files beside the JSON. Errors: no such primitive, or several; compressed splats; a
// transform on the way to them; sizes beyond the buffers; scales that are not above 0.
bool ffp_gaussians_read_gltf(FfpGaussians *gaussians, const char *path, FfpError *err);

#endif
