// Which side of the stored picture was up.
#include <string.h>
#include "core/image/codec.h"

// From 5 on rows and columns change places.
void ffp_orient_size(int *width, int *height, int orientation) {
    const int old = *width;
    if (orientation < 5) return;
    *width = *height;
    *height = old;
}

void ffp_orient_into(real *out, const FfpImage *image, int orientation) {
    int width = image->width, height = image->height;
    const bool across = orientation >= 5;
    // the stored picture's columns and rows are counted from the other end
    const bool right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    const size_t channels = (size_t)image->channels;
    ffp_orient_size(&width, &height, orientation);
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            const int column = across ? y : x, row = across ? x : y;
            const size_t from = (size_t)(below ? image->height - 1 - row : row) * (size_t)image->width +
                                (size_t)(right ? image->width - 1 - column : column);
            const size_t to = (size_t)y * (size_t)width + (size_t)x;
            memcpy(out + to * channels, image->data + from * channels, channels * sizeof *out);
        }
    }
}

void ffp_orient(FfpImage *image, int orientation) {
    if (orientation < 2 || orientation > 8) return;
    int width = image->width, height = image->height;
    ffp_orient_size(&width, &height, orientation);
    FfpImage out = ffp_image_new(width, height, image->channels);
    ffp_orient_into(out.data, image, orientation);
    ffp_image_free(image);
    *image = out;
}

const char *ffp_orientation_words(int orientation) {
    static const char *const words[9] = {"",
                                         "",
                                         "mirrored",
                                         "turned by 180 degrees",
                                         "turned by 180 degrees and mirrored",
                                         "turned clockwise by 90 degrees and mirrored",
                                         "turned clockwise by 90 degrees",
                                         "turned anticlockwise by 90 degrees and mirrored",
                                         "turned anticlockwise by 90 degrees"};
    return words[orientation >= 0 && orientation <= 8 ? orientation : 0];
}
