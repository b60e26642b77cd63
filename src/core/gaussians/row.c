#include "core/gaussians/row.h"
#include <float.h>
#include <math.h>

#define MARGIN 1e-6          // shares stay this far off 0 and 1, where a logit has no end
#define ROTATION_LEAST 1e-12 // length
#define SCALE_MIN 1e-30      // smaller ones would not survive the square in a covariance
#define LOG_SCALE_MAX 80.0   // exp of it fits a float,
#define AMBIENT_MAX 1e16     // and so does the radiance of this

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
                                                    "roughness",
                                                    "scattered_0",
                                                    "scattered_1",
                                                    "scattered_2"};

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

typedef struct Column {
    int first; // of the row's numbers
    double (*encode)(double), (*decode)(double);
    double most; // magnitude of one that can be used
} Column;

static const Column columns[FFP_ATTRIBUTES] = {
    [FFP_CENTRE] = {FFP_ROW_POSITION, as_it_is, as_it_is, FLT_MAX},
    [FFP_SCALE] = {FFP_ROW_SCALE, encode_scale, exp, LOG_SCALE_MAX},
    [FFP_ROTATION] = {FFP_ROW_ROTATION, as_it_is, as_it_is, FLT_MAX},
    [FFP_OPACITY] = {FFP_ROW_OPACITY, logit, sigmoid, INFINITY},
    [FFP_ALBEDO] = {FFP_ROW_ALBEDO, logit, sigmoid, FLT_MAX},
    [FFP_ROUGHNESS] = {FFP_ROW_ROUGHNESS, logit, sigmoid, FLT_MAX},
    [FFP_AMBIENT] = {FFP_ROW_AMBIENT, encode_ambient, decode_ambient, AMBIENT_MAX},
    [FFP_SCATTERED] = {FFP_ROW_SCATTERED, as_it_is, as_it_is, AMBIENT_MAX},
};

void ffp_row_encode(const FfpGaussians *gaussians, int64_t index, float row[FFP_ROW_NUMBERS]) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(gaussians, a);
        for (int i = 0; i < from.width; i++)
            row[columns[a].first + i] = (float)columns[a].encode((double)from.data[index * from.width + i]);
    }
}

static double length_of(const float q[4]) {
    double squared = 0;
    for (int c = 0; c < 4; c++) squared += (double)q[c] * (double)q[c];
    return sqrt(squared);
}

int ffp_row_refused(const float row[FFP_ROW_NUMBERS]) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        for (int n = columns[a].first; n < columns[a].first + ffp_attributes[a].width; n++)
            if (!(fabs((double)row[n]) <= columns[a].most)) return n; // NaN too
    return length_of(row + FFP_ROW_ROTATION) < ROTATION_LEAST ? FFP_ROW_ROTATION : -1;
}

int ffp_row_decode(const float row[FFP_ROW_NUMBERS], FfpGaussians *gaussians, int64_t index) {
    const int refused = ffp_row_refused(row);
    if (refused >= 0) return refused;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute to = ffp_attribute(gaussians, a);
        for (int i = 0; i < to.width; i++)
            to.data[index * to.width + i] = (real)columns[a].decode((double)row[columns[a].first + i]);
    }
    const double length = length_of(row + FFP_ROW_ROTATION);
    real *q = gaussians->rotation + 4 * index;
    for (int c = 0; c < 4; c++) q[c] = (real)((double)q[c] / length);
    return -1;
}
