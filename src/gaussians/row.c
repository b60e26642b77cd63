#include "gaussians/row.h"

#include <math.h>

#define SH_C0 0.28209479177387814 // the constant spherical harmonic, 1 / (2 sqrt(pi))
#define MARGIN 1e-6               // shares stay this far off 0 and 1, where a logit has no end
#define SCALE_MIN 1e-30           // smaller ones would not survive the square in a covariance
#define LOG_SCALE_MAX 80.0        // exp of it fits a float

const char *const ffp_row_names[FFP_ROW_NUMBERS] = {"x",
                                                    "y",
                                                    "z",
                                                    "f_dc_0",
                                                    "f_dc_1",
                                                    "f_dc_2",
                                                    "opacity",
                                                    "scale_0",
                                                    "scale_1",
                                                    "scale_2",
                                                    "rot_0",
                                                    "rot_1",
                                                    "rot_2",
                                                    "rot_3",
                                                    "base_color_0",
                                                    "base_color_1",
                                                    "base_color_2",
                                                    "roughness"};

// The sRGB curve (IEC 61966-2-1), going on above 1 and mirrored below 0 so that every radiance reads back.
static double encode_colour(double c) {
    const double m = fabs(c);
    return copysign(m <= 0.0031308 ? 12.92 * m : 1.055 * pow(m, 1 / 2.4) - 0.055, c);
}

static double decode_colour(double c) {
    const double m = fabs(c);
    return copysign(m <= 0.04045 ? m / 12.92 : pow((m + 0.055) / 1.055, 2.4), c);
}

static double logit(double share) {
    const double p = fmin(fmax(share, MARGIN), 1 - MARGIN);
    return log(p / (1 - p));
}

static double sigmoid(double x) {
    return 1 / (1 + exp(-x));
}

void ffp_row_encode(const FfpGaussians *gaussians, int64_t index, float row[FFP_ROW_NUMBERS]) {
    for (int c = 0; c < 3; c++) {
        const int64_t i = 3 * index + c;
        row[FFP_ROW_POSITION + c] = (float)gaussians->centre[i];
        row[FFP_ROW_AMBIENT + c] = (float)((encode_colour((double)gaussians->ambient[i]) - 0.5) / SH_C0);
        row[FFP_ROW_SCALE + c] = (float)log(fmax((double)gaussians->scale[i], SCALE_MIN));
        row[FFP_ROW_ALBEDO + c] = (float)logit((double)gaussians->albedo[i]);
    }
    for (int c = 0; c < 4; c++) row[FFP_ROW_ROTATION + c] = (float)gaussians->rotation[4 * index + c];
    row[FFP_ROW_OPACITY] = (float)logit((double)gaussians->opacity[index]);
    row[FFP_ROW_ROUGHNESS] = (float)logit((double)gaussians->roughness[index]);
}

int ffp_row_decode(const float row[FFP_ROW_NUMBERS], FfpGaussians *gaussians, int64_t index) {
    for (int i = 0; i < FFP_ROW_NUMBERS; i++)
        if (!isfinite(row[i])) return i;
    for (int c = 0; c < 3; c++) {
        const int64_t i = 3 * index + c;
        const double ambient = decode_colour(0.5 + SH_C0 * (double)row[FFP_ROW_AMBIENT + c]);
        if (!isfinite((float)ambient)) return FFP_ROW_AMBIENT + c;
        if (fabs((double)row[FFP_ROW_SCALE + c]) > LOG_SCALE_MAX) return FFP_ROW_SCALE + c;
        gaussians->centre[i] = (real)row[FFP_ROW_POSITION + c];
        gaussians->ambient[i] = (real)ambient;
        gaussians->scale[i] = (real)exp((double)row[FFP_ROW_SCALE + c]);
        gaussians->albedo[i] = (real)sigmoid((double)row[FFP_ROW_ALBEDO + c]);
    }
    double length = 0;
    for (int c = 0; c < 4; c++)
        length += (double)row[FFP_ROW_ROTATION + c] * (double)row[FFP_ROW_ROTATION + c];
    length = sqrt(length);
    if (length < 1e-12) return FFP_ROW_ROTATION;
    for (int c = 0; c < 4; c++)
        gaussians->rotation[4 * index + c] = (real)((double)row[FFP_ROW_ROTATION + c] / length);
    gaussians->opacity[index] = (real)sigmoid((double)row[FFP_ROW_OPACITY]);
    gaussians->roughness[index] = (real)sigmoid((double)row[FFP_ROW_ROUGHNESS]);
    return -1;
}
