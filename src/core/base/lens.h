// Lens distortion by OpenCV's Brown-Conrady model ("Camera Calibration and 3D Reconstruction" in its
// documentation; Brown 1966). `lens` is k1 k2 p1 p2 k3.
#ifndef FFP_BASE_LENS_H
#define FFP_BASE_LENS_H

#include <math.h>
#include <stdbool.h>

// Where the lens moves the ray (x, y, 1), with r^2 = x^2 + y^2:
//   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), likewise y' with p1 (r^2 + 2 y^2) +
//   2 p2 x y.
static inline void ffp_lens_distort(const double lens[5], double x, double y, double *distorted_x,
                                    double *distorted_y) {
    const double r2 = x * x + y * y, p1 = lens[2], p2 = lens[3];
    const double radial = 1 + r2 * (lens[0] + r2 * (lens[1] + r2 * lens[4]));
    *distorted_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    *distorted_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
}

static inline bool ffp_lens_is_ideal(const double lens[5]) {
    for (int i = 0; i < 5; i++)
        if (lens[i] != 0) return false;
    return true;
}

// One step of Newton's method towards the ray whose distorted place is (x, y); returns how far off it was.
static inline double ffp_lens_improve(const double lens[5], double x, double y, double ray[2]) {
    const double h = 1e-6;
    double at[2], right[2], below[2];
    ffp_lens_distort(lens, ray[0], ray[1], &at[0], &at[1]);
    ffp_lens_distort(lens, ray[0] + h, ray[1], &right[0], &right[1]);
    ffp_lens_distort(lens, ray[0], ray[1] + h, &below[0], &below[1]);
    const double off_x = x - at[0], off_y = y - at[1];
    const double xx = (right[0] - at[0]) / h, yx = (right[1] - at[1]) / h;
    const double xy = (below[0] - at[0]) / h, yy = (below[1] - at[1]) / h;
    const double determinant = xx * yy - xy * yx;
    ray[0] += (off_x * yy - off_y * xy) / determinant;
    ray[1] += (off_y * xx - off_x * yx) / determinant;
    return hypot(off_x, off_y);
}

// The ray (ray[0], ray[1], 1) that the lens moves to (x, y); false where there is none.
static inline bool ffp_lens_undistort(const double lens[5], double x, double y, double ray[2]) {
    ray[0] = x, ray[1] = y;
    if (ffp_lens_is_ideal(lens)) return true;
    double off = INFINITY;
    for (int i = 0; i < 20 && off > 1e-9; i++) off = ffp_lens_improve(lens, x, y, ray);
    return off <= 1e-9 && isfinite(ray[0]) && isfinite(ray[1]);
}

#endif
