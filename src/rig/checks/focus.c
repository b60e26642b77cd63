// Sharpness of the views, by the contrast between neighbouring pixels in the pattern on the object, without
// the object's own colours. It is alike in all views of a rig, and blur takes it away.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/capture/pixel.h"
#include "core/numerics/rank.h"
#include "rig/checks/measure.h"

#define PAIRS_LEAST 100

// Root mean square, to the right and down; NAN: too few pixels are lit.
static double contrast_of(const FfpCapture *capture, const FfpView *view, const FfpImage *shown) {
    const ptrdiff_t w = view->camera.width, pixels = w * view->camera.height;
    double sum = 0, pairs = 0;
    for (ptrdiff_t i = 0; i < pixels; i++)
        for (int down = 0; down < 2; down++) {
            const ptrdiff_t k = i + (down ? w : 1);
            real a[3], b[3];
            if (k >= pixels || (!down && k % w == 0) || view->coverage.data[i] < 1 ||
                view->coverage.data[k] < 1 || !ffp_lit_ratio(capture, view, shown, (size_t)i, a) ||
                !ffp_lit_ratio(capture, view, shown, (size_t)k, b))
                continue;
            for (int c = 0; c < 3; c++) sum += pow((double)(a[c] - b[c]), 2) / 3;
            pairs++;
        }
    ffp_cancel_point();
    return pairs < PAIRS_LEAST ? NAN : sqrt(sum / pairs);
}

int ffp_rig_blurred(const FfpCapture *capture, int active, double *left) {
    const int n = capture->n_views;
    double *contrasts = ffp_alloc(2 * (size_t)n, sizeof *contrasts), *sorted = contrasts + n;
    int judged = 0, odd = -1;
    for (int v = 0; v < n; v++) {
        const FfpImage *shown = &capture->views[v].images[active];
        contrasts[v] = shown->data ? contrast_of(capture, &capture->views[v], shown) : NAN;
        if (isnan(contrasts[v])) continue;
        sorted[judged++] = contrasts[v];
        if (odd < 0 || contrasts[v] < contrasts[odd]) odd = v;
    }
    const double usual = odd < 0 ? 0 : ffp_median(sorted, (size_t)judged); // 0: a pattern without contrast
    *left = usual > 0 ? contrasts[odd] / usual : 1;
    ffp_free(contrasts);
    return judged < FFP_RIG_VIEWS_TO_ACCUSE || !(usual > 0) ? -1 : odd;
}
