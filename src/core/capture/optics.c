#include "core/capture/optics.h"

#define GRID 32 // cells a side on which a lens is looked at

// True if the lens keeps left and right, above and below at this point: the derivative's determinant, by
// central differences.
static bool keeps_order(const double lens[5], double x, double y) {
    const double h = 1e-5;
    double a[2], b[2], c[2], d[2];
    ffp_lens_distort(lens, x + h, y, &a[0], &a[1]);
    ffp_lens_distort(lens, x - h, y, &b[0], &b[1]);
    ffp_lens_distort(lens, x, y + h, &c[0], &c[1]);
    ffp_lens_distort(lens, x, y - h, &d[0], &d[1]);
    const double xx = a[0] - b[0], yx = a[1] - b[1], xy = c[0] - d[0], yy = c[1] - d[1];
    return xx * yy - xy * yx > 0 && xx > 0 && yy > 0;
}

bool ffp_optics_check(const FfpOptics *optics, const char *what, FfpError *err) {
    for (int i = 0; i <= GRID; i++) {
        for (int j = 0; j <= GRID; j++) {
            const double x = ((double)optics->width * j / GRID - optics->cx) / optics->fx;
            const double y = ((double)optics->height * i / GRID - optics->cy) / optics->fy;
            if (!keeps_order(optics->lens, x, y)) {
                return ffp_fail(err, FFP_ERROR_FILE, what,
                                "the lens distortion folds the picture over itself at pixel %.0f, %.0f: "
                                "its coefficients do not hold there; calibrate with points up to "
                                "the corners, or with fewer coefficients",
                                (double)optics->width * j / GRID, (double)optics->height * i / GRID);
            }
        }
    }
    return true;
}
