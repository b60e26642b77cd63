// Splats of other programs: one colour each, without material. Every reader fills in what its file says and
// leaves the rest to the set.
#ifndef FFP_GAUSSIANS_ELSEWHERE_H
#define FFP_GAUSSIANS_ELSEWHERE_H

#include "core/gaussians/gaussians.h"
#include "core/gaussians/row.h"

#define FFP_SPLAT_FILE_MAX (SIZE_MAX >> (sizeof(size_t) == 8 ? 32 : 1)) // bytes: 4 GiB

// A set while it is read, one row after the other.
typedef struct FfpSplatSet {
    FfpGaussians *gaussians;
    const char *path;
    int64_t offered, bad; // rows so far; those of them that cannot be used
    int64_t first_bad;
    int bad_number;           // of that row, index into ffp_row_names
    bool relightable;         // rows have albedo and roughness
    bool linear;              // colours are linear light, not sRGB
    bool harmonics, filtered; // there are spherical harmonics, or Mip-Splatting's filters, which are left out
} FfpSplatSet;

// Makes room for `count` splats.
void ffp_splats_begin(FfpSplatSet *set, FfpGaussians *gaussians, int64_t count, const char *path);
// Adds the splat of a given row (its f_dc, logits and logarithms), or counts it as bad where it cannot be
// used (ffp_row_decode). A scale whose logarithm is -inf is as thin as a disc of 2DGS: 1 % of the smallest
// other one. Without a material the colour is light and material in one: it becomes both the albedo (within
// [0,1]) and, as it looks without a projector, the ambient colour; the roughness becomes 0.5.
void ffp_splats_add(FfpSplatSet *set, const float given[FFP_ROW_NUMBERS]);
// Notes what was assumed and left out, and sizes and opacities that look as if they were not encoded. False,
// without a set, if the reader failed (`ok` is false) or more than a tenth of the rows are bad; the error
// names the first of them.
bool ffp_splats_end(FfpSplatSet *set, bool ok, FfpError *err);
void ffp_splats_note_rest(const char *path, int64_t bytes); // that a file goes on behind its splats
double ffp_opacity_logit(double share);                     // of an opacity; infinite for 0 and 1

// The extension of glTF that splats are in.
#define FFP_SPLAT_EXTENSION "KHR_gaussian_splatting"

// The parts of an SPZ file.
#define FFP_SPZ_MAGIC 0x5053474eU         // "NGSP"
#define FFP_SPZ_HEADER 16                 // bytes
#define FFP_SPZ_COLOUR 0.15               // of f_dc in a byte, around the middle
#define FFP_SPZ_SHORT 0.70710678118654752 // the largest that the three smaller parts of a unit quaternion get

// PLY with 3DGS's properties, or compressed as SuperSplat does: see ply_read.c.
bool ffp_gaussians_read_ply(FfpGaussians *gaussians, const char *path, FfpError *err);
// SPZ, versions 1 to 4, as Niantic published it (github.com/nianticlabs/spz, README); versions 2 and 3 also
// without gzip around them. Splats that are in other axes than SPZ's own by an extension (extensions/README)
// are turned into those. Spherical harmonics beyond the constant are not used. Errors: another magic or
// version, counts beyond the file or FFP_GAUSSIANS_MAX, data that ends early or differs from its checksum.
typedef struct FfpSpz FfpSpz;
FfpSpz *ffp_spz_open(const void *bytes, size_t size, const char *path, FfpError *err);
void ffp_spz_close(FfpSpz *spz); // NULL is allowed
int64_t ffp_spz_count(const FfpSpz *spz);
bool ffp_spz_has_harmonics(const FfpSpz *spz);
void ffp_spz_row(const FfpSpz *spz, int64_t at, float row[FFP_ROW_NUMBERS]);
bool ffp_gaussians_read_spz(FfpGaussians *gaussians, const char *path, FfpError *err);
// glTF 2.0, JSON or GLB, with KHR_gaussian_splatting (github.com/KhronosGroup/glTF, extensions): every
// primitive that has it, under its nodes' transforms. Attributes are floats or integers, in the GLB's own
// buffer, in data URIs or in files beside or below the JSON, or an SPZ in one of them. Errors: no such
// primitive; splats compressed otherwise; sizes beyond the buffers.
bool ffp_gaussians_read_gltf(FfpGaussians *gaussians, const char *path, FfpError *err);
// .splat (github.com/antimatter15/splat): rows of 32 bytes without a header.
bool ffp_gaussians_read_splat(FfpGaussians *gaussians, const char *path, FfpError *err);
// False, with what the file is, if splats, scenes and checkpoints of other programs begin like it, and what
// converts it. Otherwise it is not there, or is nothing that any command reads.
bool ffp_refuse_splats(const char *path, FfpError *err);

#endif
