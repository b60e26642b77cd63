// One Gaussian as the numbers of a row in the PLY file, in the encodings of 3DGS and GS-ProCams.
#ifndef FFP_GAUSSIANS_ROW_H
#define FFP_GAUSSIANS_ROW_H

#include "core/gaussians/gaussians.h"

#define FFP_SH_C0 0.28209479177387814 // the constant spherical harmonic, 1 / (2 sqrt(pi))

// Order of the numbers in the files that we write.
enum {
    FFP_ROW_POSITION = 0,
    FFP_ROW_AMBIENT = 3,
    FFP_ROW_OPACITY = 6,
    FFP_ROW_SCALE = 7,
    FFP_ROW_ROTATION = 10,
    FFP_ROW_ALBEDO = 14,
    FFP_ROW_ROUGHNESS = 17,
    FFP_ROW_SCATTERED = 18, // only in files of Gaussians that scatter light
    FFP_ROW_NUMBERS = 21
};

// How many of them a file of these Gaussians has.
static inline int ffp_row_numbers(const FfpGaussians *gaussians) {
    return gaussians->scatters ? FFP_ROW_NUMBERS : FFP_ROW_SCATTERED;
}

// Name of the i-th number as a PLY property.
extern const char *const ffp_row_names[FFP_ROW_NUMBERS];

void ffp_row_encode(const FfpGaussians *gaussians, int64_t index, float row[FFP_ROW_NUMBERS]);
// The number (index into the names) whose value cannot be used; -1: there is none. Such are what is not
// finite (but for the opacity's logit, which may be infinite), a scale or ambient colour that overflows, and
// a rotation of length zero.
int ffp_row_refused(const float row[FFP_ROW_NUMBERS]);
// Writes Gaussian `index`, unless a number is refused, which is returned; otherwise -1.
int ffp_row_decode(const float row[FFP_ROW_NUMBERS], FfpGaussians *gaussians, int64_t index);

#endif
