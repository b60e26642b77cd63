#include "core/gaussians/row.h"
#include <math.h>

#define MARGIN 1e-6        // shares stay this far off 0 and 1, where a logit has no end
#define SCALE_MIN 1e-30    // smaller ones would not survive the square in a covariance
#define LOG_SCALE_MAX 80.0 // exp of it fits a float

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

static double as_it_is(double x) {
    return x;
}

static double encode_ambient(double c) {
    return (encode_colour(c) - 0.5) / FFP_SH_C0;
}

static double decode_ambient(double c) {
    return decode_colour(0.5 + FFP_SH_C0 * c);
}

static double encode_scale(double scale) {
    return log(fmax(scale, SCALE_MIN));
}

static double decode_scale(double x) {
    return fabs(x) > LOG_SCALE_MAX ? INFINITY : exp(x);
}

typedef struct Column {
    int first;                                   // of the row's numbers
    double (*encode)(double), (*decode)(double); // what cannot be used becomes infinite
} Column;

static const Column columns[FFP_ATTRIBUTES] = {
    [FFP_CENTRE] = {FFP_ROW_POSITION, as_it_is, as_it_is},
    [FFP_SCALE] = {FFP_ROW_SCALE, encode_scale, decode_scale},
    [FFP_ROTATION] = {FFP_ROW_ROTATION, as_it_is, as_it_is},
    [FFP_OPACITY] = {FFP_ROW_OPACITY, logit, sigmoid},
    [FFP_ALBEDO] = {FFP_ROW_ALBEDO, logit, sigmoid},
    [FFP_ROUGHNESS] = {FFP_ROW_ROUGHNESS, logit, sigmoid},
    [FFP_AMBIENT] = {FFP_ROW_AMBIENT, encode_ambient, decode_ambient},
};

void ffp_row_encode(const FfpGaussians *gaussians, int64_t index, float row[FFP_ROW_NUMBERS]) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(gaussians, a);
        for (int i = 0; i < from.width; i++)
            row[columns[a].first + i] = (float)columns[a].encode((double)from.data[index * from.width + i]);
    }
}

static bool normalise(real q[4]) {
    double length = 0;
    for (int c = 0; c < 4; c++) length += (double)q[c] * (double)q[c];
    length = sqrt(length);
    if (length < 1e-12) return false;
    for (int c = 0; c < 4; c++) q[c] = (real)((double)q[c] / length);
    return true;
}

int ffp_row_decode(const float row[FFP_ROW_NUMBERS], FfpGaussians *gaussians, int64_t index) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute to = ffp_attribute(gaussians, a);
        for (int i = 0; i < to.width; i++) {
            const int number = columns[a].first + i;
            const double value = columns[a].decode((double)row[number]);
            const bool endless = a == FFP_OPACITY && !isnan(row[number]); // the logits of 0 and 1
            if (!(isfinite(row[number]) || endless) || !isfinite((float)value)) return number;
            to.data[index * to.width + i] = (real)value;
        }
    }
    return normalise(gaussians->rotation + 4 * index) ? -1 : FFP_ROW_ROTATION;
}
