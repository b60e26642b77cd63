#include "core/image/framing.h"
#include <math.h>
#include <string.h>
#include "core/base/log.h"

#define SAME_SHAPE 0.01

bool ffp_framing_check(FfpFraming framing, FfpError *err) {
    return ffp_check_choice((int)framing, FFP_FRAMING_PIXEL, "framing", err);
}

static bool same_shape(const FfpImage *image, int width, int height) {
    const double shape = (double)image->width / image->height, wanted = (double)width / height;
    return fabs(shape / wanted - 1) <= SAME_SHAPE;
}

// The middle of the picture in a frame of another size: what is beyond it is cut off, what is missing is 0.
static FfpImage centred(const FfpImage *image, int width, int height) {
    FfpImage out = ffp_image_new(width, height, image->channels);
    const int across = image->width < width ? image->width : width;
    const int down = image->height < height ? image->height : height;
    const size_t n = (size_t)image->channels;
    for (int y = 0; y < down; y++) {
        const size_t from = (size_t)((image->height - down) / 2 + y) * (size_t)image->width +
                            (size_t)((image->width - across) / 2);
        const size_t to = (size_t)((height - down) / 2 + y) * (size_t)width + (size_t)((width - across) / 2);
        memcpy(out.data + n * to, image->data + n * from, n * (size_t)across * sizeof *out.data);
    }
    return out;
}

// `longer` scaled to the shape of a : b, at least 1.
static int proportional(int longer, int a, int b) {
    return (int)fmax(1, round((double)longer * a / b));
}

// Cuts to the frame's shape, then changes the size.
static FfpImage covering(const FfpImage *image, int width, int height) {
    const int across = (int)fmin(image->width, proportional(image->height, width, height));
    const int down = (int)fmin(image->height, proportional(image->width, height, width));
    FfpImage cut = centred(image, across, down);
    FfpImage out = ffp_image_resize(&cut, width, height);
    ffp_image_free(&cut);
    return out;
}

static FfpImage contained(const FfpImage *image, int width, int height) {
    const int across = (int)fmin(width, proportional(height, image->width, image->height));
    const int down = (int)fmin(height, proportional(width, image->height, image->width));
    FfpImage small = ffp_image_resize(image, across, down);
    FfpImage out = centred(&small, width, height);
    ffp_image_free(&small);
    return out;
}

FfpImage ffp_image_framed(const FfpImage *image, int width, int height, FfpFraming framing) {
    if (framing == FFP_FRAMING_PIXEL) return centred(image, width, height);
    if (framing == FFP_FRAMING_STRETCH || same_shape(image, width, height))
        return ffp_image_resize(image, width, height);
    return framing == FFP_FRAMING_COVER ? covering(image, width, height) : contained(image, width, height);
}

void ffp_framing_note(const char *name, const FfpImage *image, int width, int height, FfpFraming framing) {
    static const char *const how[] = {[FFP_FRAMING_COVER] = "cropped to fill",
                                      [FFP_FRAMING_CONTAIN] = "fitted inside",
                                      [FFP_FRAMING_STRETCH] = "stretched to",
                                      [FFP_FRAMING_PIXEL] = "placed pixel for pixel in"};
    if (image->width == width && image->height == height) return;
    const bool resized = framing != FFP_FRAMING_PIXEL && same_shape(image, width, height);
    ffp_note("%s: %d x %d is %s %d x %d%s", name, image->width, image->height,
             resized ? "resized to" : how[framing], width, height,
             !resized && framing == FFP_FRAMING_COVER ? " ('contain' shows all of it)" : "");
}

bool ffp_framed_check(const char *path, int width, int height, FfpError *err) {
    int w, h;
    const long long least = 4LL * width * height;
    const long long most = least > FFP_FRAMED_PIXELS_MAX ? least : FFP_FRAMED_PIXELS_MAX;
    if (!ffp_image_read_size(&w, &h, path, err)) return false;
    if ((long long)w * h <= most) return true;
    const double share = sqrt((double)most / ((double)w * h));
    return ffp_fail(
        err, FFP_ERROR_FILE, path,
        "%d x %d pixels are too many for a frame of %d x %d: make it smaller first, at most %d x %d", w, h,
        width, height, (int)(share * w), (int)(share * h));
}
