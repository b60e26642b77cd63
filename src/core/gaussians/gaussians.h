// The relightable Gaussians and their PLY file.
#ifndef FFP_GAUSSIANS_GAUSSIANS_H
#define FFP_GAUSSIANS_GAUSSIANS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "core/base/error.h"
#include "core/base/real.h"

#define FFP_GAUSSIANS_MAX 50000000
#define FFP_MADE_FROM 512 // bytes

// A projector that stood still while the photographs were taken leaves its shadows in the albedo, exactly as
// they were photographed: a renderer casts none from there, and its own from anywhere else.
typedef struct FfpBakedShadows {
    real light[3]; // the projector's place, world
    real within;   // a projector up to this far from it counts as the same, world units; 0: none are baked
} FfpBakedShadows;

typedef struct FfpGaussians {
    int64_t count;
    real *centre;    // [count,3] world
    real *scale;     // [count,3] standard deviations along the rotated axes, world units, > 0
    real *rotation;  // [count,4] unit quaternion w x y z: splat axes to world
    real *opacity;   // [count]   in [0,1]
    real *albedo;    // [count,3] linear diffuse albedo
    real *roughness; // [count]
    real *ambient;   // [count,3] linear radiance shown when the projector is black
    real *scattered; // [count,3] linear radiance that a white pattern adds in other ways than by its direct
                     // ray (bounces, light within things and lenses): it follows the pattern's mean. NULL is
                     // allowed where it is not looked at:
    bool scatters;   // any of it is above 0
    char made_from[FFP_MADE_FROM]; // structured-light patterns whose photographs they were fitted to, each
                                   // name with a '\n' after it; "": not known
    FfpBakedShadows baked;
} FfpGaussians;

// The attributes, in one table, through which code that treats them all alike goes (memory, gradients, files,
// the optimiser), so that a new one is a member above and a row there.
enum {
    FFP_CENTRE,
    FFP_SCALE,
    FFP_ROTATION,
    FFP_OPACITY,
    FFP_ALBEDO,
    FFP_ROUGHNESS,
    FFP_AMBIENT,
    FFP_SCATTERED,
    FFP_ATTRIBUTES
};
typedef struct FfpAttributeForm {
    const char *name; // as the public header calls its array
    int width;        // numbers per Gaussian
    size_t member;    // offset of its array in FfpGaussians
} FfpAttributeForm;
extern const FfpAttributeForm ffp_attributes[FFP_ATTRIBUTES];

typedef struct FfpAttribute {
    real *data; // [count, width]
    int width;
} FfpAttribute;
FfpAttribute ffp_attribute(const FfpGaussians *gaussians, int attribute);

// These four work on the device that the thread uses (core/base/device.h), by default the CPU; all others
// here work on the CPU.
FfpGaussians ffp_gaussians_new(int64_t count); // zeroed; also used for gradients, which have the same shape
FfpGaussians ffp_gaussians_copy(const FfpGaussians *from);
// Copies the numbers that hold for the whole set: baked and scatters.
void ffp_gaussians_take_notes(FfpGaussians *to, const FfpGaussians *from);
void ffp_gaussians_free(FfpGaussians *gaussians);
void ffp_gaussians_clear(FfpGaussians *gaussians); // all numbers become 0
// Copies the CPU's set to the device in use, and back; on the CPU these are plain copies. A downloaded set
// belongs to the CPU: call ffp_device_use(NULL) before ffp_gaussians_free.
FfpGaussians ffp_gaussians_uploaded(const FfpGaussians *host);
FfpGaussians ffp_gaussians_downloaded(const FfpGaussians *gaussians);
void ffp_gaussians_download(FfpGaussians *host, const FfpGaussians *gaussians); // into a set of as many
// centre <- centre * radius + offset, scale <- scale * radius, the baked light likewise: from the network's
// unit sphere back to the world.
void ffp_gaussians_transform(FfpGaussians *gaussians, const real offset[3], real radius);

// True if the shadows of a projector with this pose (row-major 4x4, projector to world) are baked.
bool ffp_shadows_are_baked(const FfpGaussians *gaussians, const real pose[16]);

// Takes out those of an opacity below FFP_OPACITY_LEAST, which no file holds (ffp_gaussians_write_drawn); the
// others keep their order. None is taken out where all are that faint.
void ffp_gaussians_keep_drawn(FfpGaussians *gaussians);

// Binary little-endian PLY with the 3DGS property names, plus base_color_0..2, roughness and, where any
// light is scattered, scattered_0..2 (see
// docs/reference/formats/gaussians.md): opens in splat viewers and reads back exactly in fp32 up to the
// logit/log encodings. Values are checked when read: counts, sizes, finite numbers. Splats of opacity below
// `opacity_min` are left out when writing (0 keeps all). Plain splats of other programs (3DGS, 2DGS, gsplat)
// are read too: their colour f_dc becomes albedo (within [0,1]) and ambient colour, the roughness is 0.5, and
// discs become 1 % as thick as their smaller radius; a note says so. f_rest is not used.
bool ffp_gaussians_write(const FfpGaussians *gaussians, const char *path, real opacity_min, FfpError *err);
#define FFP_OPACITY_LEAST ((real)1 / 255)
// Writes those that the rasteriser draws, with an opacity of at least FFP_OPACITY_LEAST; an error if there
// are none.
bool ffp_gaussians_write_drawn(const FfpGaussians *gaussians, const char *path, FfpError *err);
bool ffp_gaussians_read(FfpGaussians *gaussians, const char *path, FfpError *err);
// The same in a block of their own (ffp_gaussians_free, then ffp_free); an error if there are none.
FfpGaussians *ffp_gaussians_load(const char *path, FfpError *err);
// Which patterns a file names, as above.
bool ffp_gaussians_read_made_from(char made_from[FFP_MADE_FROM], const char *path, FfpError *err);
// True if a file holds Gaussians with albedo and roughness; false for anything else, and if there is no file.
bool ffp_gaussians_are_relightable(const char *path);
// Adds a pattern's name, once; names beyond the buffer are silently dropped.
void ffp_made_from_add(char made_from[FFP_MADE_FROM], const char *name);

#endif
