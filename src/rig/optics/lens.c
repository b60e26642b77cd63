#include "rig/optics/lens.h"
#include <math.h>
#include <omp.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/real.h"

#define ASPECT_TOLERANCE 0.005 // of a rescaled picture: sides are whole pixels
#define WIDEN_MOST 0.25 // of a side, on each end of it: a lens that bends more than that is not followed
#define SAMPLES_MAX 64  // a side; beyond that pictures are shrunk in a coarser way

// --- Sizes. ---

static bool settle_scaled(FfpOptics *optics, int width, int height, const char *what, const char *path,
                          FfpError *err) {
    const double x = (double)width / optics->width, y = (double)height / optics->height;
    if (fabs(x / y - 1) > ASPECT_TOLERANCE) {
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "%d x %d pixels cannot be a scaled picture of the %d x %d at which the %s was "
                        "calibrated: the aspect ratio differs",
                        width, height, optics->width, optics->height, what);
    }
    optics->fx *= x, optics->cx *= x, optics->fy *= y, optics->cy *= y;
    return true;
}

static bool settle_cropped(FfpOptics *optics, const FfpCalibratedAt *at, int width, int height,
                           const char *what, const char *path, FfpError *err) {
    if (at->left < 0 || at->top < 0 || at->left > optics->width - width ||
        at->top > optics->height - height) {
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "%d x %d pixels starting at %d,%d do not lie within the %d x %d at which the %s was "
                        "calibrated",
                        width, height, at->left, at->top, optics->width, optics->height, what);
    }
    optics->cx -= at->left, optics->cy -= at->top;
    return true;
}

bool ffp_optics_settle(FfpOptics *optics, const FfpCalibratedAt *at, int width, int height, const char *what,
                       const char *path, FfpError *err) {
    char setting[32];
    snprintf(setting, sizeof setting, "%s.width", what);
    const FfpNode place = {.file = setting};
    if (at->width > 0 && !ffp_settle_size(optics, &place, at->width, at->height, err)) return false;
    if (optics->width == 0) {
        return ffp_fail(err, FFP_ERROR_ARGUMENT, setting,
                        "the calibration does not say at which image size its %s was calibrated: "
                        "give that size",
                        what);
    }
    if (at->fit == FFP_FIT_SCALED) {
        if (!settle_scaled(optics, width, height, what, path, err)) return false;
    } else if (at->fit == FFP_FIT_CROPPED) {
        if (!settle_cropped(optics, at, width, height, what, path, err)) return false;
    } else if (width != optics->width || height != optics->height) {
        snprintf(setting, sizeof setting, "%s.fit", what);
        return ffp_fail(err, FFP_ERROR_FILE, setting,
                        "%s: %d x %d pixels, but the %s was calibrated at %d x %d: if pictures were scaled "
                        "or cropped since, say so",
                        path, width, height, what, optics->width, optics->height);
    }
    optics->width = width, optics->height = height;
    return true;
}

// --- Pictures. ---

void ffp_optics_pinhole(const FfpOptics *optics, int width, FfpCamera *pinhole) {
    pinhole->width = width > 0 ? width : optics->width;
    pinhole->height = optics->height;
    if (pinhole->width != optics->width) {
        pinhole->height = (int)lround((double)optics->height * pinhole->width / optics->width);
        if (pinhole->height < 1) pinhole->height = 1;
    }
    const double x = (double)pinhole->width / optics->width, y = (double)pinhole->height / optics->height;
    pinhole->fx = (real)(optics->fx * x), pinhole->cx = (real)(optics->cx * x);
    pinhole->fy = (real)(optics->fy * y), pinhole->cy = (real)(optics->cy * y);
}

void ffp_optics_frame_all(const FfpOptics *optics, int border, FfpCamera *pinhole) {
    enum { STEPS = 64 }; // along each side
    double low[2] = {0, 0}, high[2] = {pinhole->width, pinhole->height};
    for (int i = 0; i < 4 * STEPS; i++) {
        const double along = (i / 4) / (double)(STEPS - 1), side = i % 4 / 2;
        const double x = (i % 2 ? along : side) * optics->width, y = (i % 2 ? side : along) * optics->height;
        double ray[2];
        if (!ffp_lens_undistort(optics->lens, (x - optics->cx) / optics->fx, (y - optics->cy) / optics->fy,
                                ray))
            continue;
        const double at[2] = {(double)pinhole->cx + (double)pinhole->fx * ray[0],
                              (double)pinhole->cy + (double)pinhole->fy * ray[1]};
        const double side_pixels[2] = {pinhole->width, pinhole->height};
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], fmax(at[k], -WIDEN_MOST * side_pixels[k]));
            high[k] = fmax(high[k], fmin(at[k], (1 + WIDEN_MOST) * side_pixels[k]));
        }
    }
    const int left = border + (int)ceil(-low[0]), top = border + (int)ceil(-low[1]);
    pinhole->width = left + border + (int)ceil(high[0]), pinhole->height = top + border + (int)ceil(high[1]);
    pinhole->cx += (real)left, pinhole->cy += (real)top;
}

int ffp_optics_shrink_by(const FfpOptics *optics, double most) {
    int shrink = most > 1 ? (int)fmin(most, optics->width) : 1;
    while (optics->width % shrink != 0 || optics->height % shrink != 0) shrink--;
    return shrink;
}

FfpOptics ffp_optics_shrunk(const FfpOptics *optics, int shrink) {
    FfpOptics out = *optics;
    out.width /= shrink, out.height /= shrink;
    out.fx /= shrink, out.fy /= shrink;
    out.cx /= shrink, out.cy /= shrink;
    return out;
}

static int samples_across(double old_focal, double new_focal) {
    const double span = ceil(old_focal / new_focal - 1e-6);
    return span < 1 ? 1 : span > SAMPLES_MAX ? SAMPLES_MAX : (int)span;
}

// Inputs of a row of the pinhole.
typedef struct RowScratch {
    double *x, *y; // [width] where a sample of each pixel lies in the old picture
    double *sums;  // [width, channels]
} RowScratch;

// Where the pinhole's points (column + u, v) lie in the old picture.
static void place_samples(const FfpOptics *optics, const FfpCamera *pinhole, double u, double v,
                          const RowScratch *own) {
    const double y = (v - (double)pinhole->cy) / (double)pinhole->fy;
    for (int column = 0; column < pinhole->width; column++) {
        const double x = (column + u - (double)pinhole->cx) / (double)pinhole->fx;
        double at_x = 0, at_y = 0;
        ffp_lens_distort(optics->lens, x, y, &at_x, &at_y);
        own->x[column] = optics->cx + optics->fx * at_x, own->y[column] = optics->cy + optics->fy * at_y;
    }
}

// Adds the old picture's values where the samples lie in it.
static void add_samples(const FfpImage *image, int width, const RowScratch *own) {
    double *sum = own->sums;
    for (int column = 0; column < width; column++, sum += image->channels) {
        const double x = own->x[column], y = own->y[column];
        real value[4];
        if (!(x >= 0 && y >= 0 && x <= image->width && y <= image->height)) continue;
        ffp_image_sample(image, (real)x, (real)y, value);
        for (int c = 0; c < image->channels; c++) sum[c] += (double)value[c];
    }
}

FfpImage ffp_optics_rectify(const FfpOptics *optics, const FfpCamera *pinhole, const FfpImage *image) {
    if (ffp_lens_is_ideal(optics->lens) && pinhole->width == image->width && pinhole->height == image->height)
        return ffp_image_copy(image);
    FfpImage out = ffp_image_new(pinhole->width, pinhole->height, image->channels);
    const int across = samples_across(optics->fx, (double)pinhole->fx);
    const int down = samples_across(optics->fy, (double)pinhole->fy);
    const size_t width = (size_t)out.width, values = width * (size_t)out.channels;
    double *scratch = ffp_take((size_t)omp_get_max_threads(), (2 * width + values) * sizeof *scratch);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < out.height; row++) {
        double *first = scratch + (size_t)omp_get_thread_num() * (2 * width + values);
        const RowScratch own = {first, first + width, first + 2 * width};
        memset(own.sums, 0, values * sizeof *own.sums);
        for (int k = 0; k < across * down; k++) {
            const int x = k % across, y = k / across;
            place_samples(optics, pinhole, (x + 0.5) / across, row + (y + 0.5) / down, &own);
            add_samples(image, out.width, &own);
        }
        real *to = out.data + (size_t)row * values;
        for (size_t i = 0; i < values; i++) to[i] = (real)(own.sums[i] / (across * down));
    }
    ffp_free(scratch);
    return out;
}

enum { NEWTON_STEPS = 8 };

// Where the pinhole sees what the optics see at (x, y).
static void find_undistorted(const FfpOptics *optics, const FfpCamera *pinhole, double x, double y, double *u,
                             double *v) {
    const double at_x = (x - optics->cx) / optics->fx, at_y = (y - optics->cy) / optics->fy;
    double ray[2] = {at_x, at_y};
    for (int k = 0; k < NEWTON_STEPS; k++) ffp_lens_improve(optics->lens, at_x, at_y, ray);
    *u = (double)pinhole->cx + (double)pinhole->fx * ray[0];
    *v = (double)pinhole->cy + (double)pinhole->fy * ray[1];
}

FfpImage ffp_optics_distort(const FfpOptics *optics, const FfpCamera *pinhole, const FfpImage *image) {
    FfpImage out = ffp_image_new(optics->width, optics->height, image->channels);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < out.height; row++) {
        for (int column = 0; column < out.width; column++) {
            double u, v;
            find_undistorted(optics, pinhole, column + 0.5, row + 0.5, &u, &v);
            if (!(u >= 0 && v >= 0 && u <= image->width && v <= image->height)) continue;
            ffp_image_sample(image, (real)u, (real)v,
                             out.data +
                                 ((size_t)row * (size_t)out.width + (size_t)column) * (size_t)out.channels);
        }
    }
    return out;
}
