#include "core/capture/pixel.h"

#define LIT 0.04F
#define CLIPPED 0.98F

bool ffp_is_background(const FfpImage *coverage, int x, int y) {
    for (int k = 0; k < 9; k++) {
        const int px = x + k % 3 - 1, py = y + k / 3 - 1;
        if (px < 0 || py < 0 || px >= coverage->width || py >= coverage->height) return false;
        if (coverage->data[(ptrdiff_t)py * coverage->width + px] > 0) return false;
    }
    return true;
}

bool ffp_is_lit(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    const real *black = view->images[capture->black].data + 3 * pixel,
               *white = view->images[capture->white].data + 3 * pixel;
    return white[0] - black[0] > LIT && white[1] - black[1] > LIT && white[2] - black[2] > LIT;
}

bool ffp_lit_ratio(const FfpCapture *capture, const FfpView *view, const FfpImage *photograph, size_t pixel,
                   real ratio[3]) {
    const real *black = view->images[capture->black].data + 3 * pixel,
               *white = view->images[capture->white].data + 3 * pixel, *seen = photograph->data + 3 * pixel;
    if (!ffp_is_lit(capture, view, pixel)) return false;
    for (int c = 0; c < 3; c++) {
        if (white[c] > CLIPPED) return false;
        ratio[c] = (seen[c] - black[c]) / (white[c] - black[c]);
    }
    return true;
}
