#include <tgmath.h>
#include "core/base/vec.h"
#include "rig/masks/masks.h"

#define WIDTH_MOST 240 // pixels of a view
#define GAP 4
#define BRIGHT 0.9F // encoded: what the brightest of an object gets
#define DIM 0.35F   // of what is not the object
#define TINT 0.5F   // share of a tint's colour

FfpImage ffp_contact_thumb(const FfpImage *photograph) {
    const int width = photograph->width < WIDTH_MOST ? photograph->width : WIDTH_MOST;
    const int height = (int)fmax(1, round((double)photograph->height * width / photograph->width));
    return ffp_image_resize(photograph, width, height);
}

static real brightest_of(const FfpImage *thumb) {
    real most = 1e-4F;
    const ptrdiff_t count = (ptrdiff_t)thumb->width * thumb->height * 3;
    for (ptrdiff_t i = 0; i < count; i++) most = fmax(most, thumb->data[i]);
    return most;
}

static bool is_object(const FfpImage *mask, int x, int y) {
    return x >= 0 && y >= 0 && x < mask->width && y < mask->height &&
           mask->data[(ptrdiff_t)y * mask->width + x] >= 0.5F;
}

static void put_pixel(const FfpImage *thumb, const FfpImage *mask, int x, int y, real gain, real out[3]) {
    const bool object = is_object(mask, x, y);
    const bool outline = object && !(is_object(mask, x - 1, y) && is_object(mask, x + 1, y) &&
                                     is_object(mask, x, y - 1) && is_object(mask, x, y + 1));
    for (int c = 0; c < 3; c++) {
        const real value =
            BRIGHT * ffp_srgb_encode(fmin(gain * thumb->data[3 * ((ptrdiff_t)y * thumb->width + x) + c], 1));
        out[c] = outline ? (real)(c == 0) : object ? value : DIM * value + (c == 2 ? 0.15F : 0);
    }
}

static void put_view(FfpImage *sheet, const FfpImage *thumb, const FfpImage *coverage, int left, int top) {
    FfpImage mask = ffp_image_resize(coverage, thumb->width, thumb->height);
    const real gain = 1 / brightest_of(thumb);
    for (int y = 0; y < thumb->height && top + y < sheet->height; y++)
        for (int x = 0; x < thumb->width && left + x < sheet->width; x++)
            put_pixel(thumb, &mask, x, y, gain,
                      sheet->data + 3 * ((ptrdiff_t)(top + y) * sheet->width + left + x));
    ffp_image_free(&mask);
}

FfpImage ffp_contact_picture(const FfpImage *thumb, const FfpImage *coverage) {
    FfpImage out = ffp_image_new(thumb->width, thumb->height, 3);
    put_view(&out, thumb, coverage, 0, 0);
    return out;
}

FfpImage ffp_contact_tinted(const FfpImage *thumb, const FfpImage *tint) {
    FfpImage out = ffp_image_resize(tint, thumb->width, thumb->height);
    const real gain = 1 / brightest_of(thumb);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)thumb->width * thumb->height; i++) {
        const real *p = thumb->data + 3 * i, mean = (p[0] + p[1] + p[2]) / 3;
        const real grey = BRIGHT * ffp_srgb_encode(fmin(gain * mean, 1));
        for (int c = 0; c < 3; c++) out.data[3 * i + c] = (1 - TINT) * grey + TINT * out.data[3 * i + c];
    }
    return out;
}

FfpImage ffp_contact_sheet(const FfpCapture *capture, const FfpImage *thumbs) {
    const int n = capture->n_views, columns = (int)ceil(sqrt((double)n)), rows = (n + columns - 1) / columns;
    int width = 1, height = 1;
    for (int v = 0; v < n; v++) {
        width = thumbs[v].width > width ? thumbs[v].width : width;
        height = thumbs[v].height > height ? thumbs[v].height : height;
    }
    FfpImage sheet = ffp_image_new(columns * (width + GAP), rows * (height + GAP), 3);
    for (int v = 0; v < n; v++)
        put_view(&sheet, &thumbs[v], &capture->views[v].coverage, v % columns * (width + GAP),
                 v / columns * (height + GAP));
    return sheet;
}
