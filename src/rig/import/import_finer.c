// Import: outlines from photographs at more pixels than the capture has.
#include <math.h>
#include "core/base/alloc.h"
#include "rig/import/import_steps.h"
#include "rig/masks/masks.h"

#define WIDER 1.5      // photographs than the capture, from which on it pays
#define OTHER_MOST 0.4 // of the mask's area, by which a finer one of the same thing may differ

enum { TIMES = 2 }; // pixels a side for one of the capture's

static FfpCamera finer_camera(const FfpCamera *camera) {
    FfpCamera out = *camera;
    out.width *= TIMES, out.height *= TIMES;
    out.fx *= TIMES, out.fy *= TIMES, out.cx *= TIMES, out.cy *= TIMES;
    return out;
}

static bool read_view(FfpImporting *finer, int v, FfpError *err) {
    FfpImage *images = finer->capture.views[v].images;
    for (int p = 0; p < finer->capture.n_patterns; p++) {
        const char *path = finer->shots.pictures[v * FFP_PATTERNS_MAX + p];
        if (path && !ffp_importing_read_picture(finer, path, v, &images[p], NULL, err)) return false;
    }
    return ffp_importing_make_plain(finer, v, &images[finer->shots.black], &images[finer->shots.white], err);
}

static FfpImage means_of(const FfpImage *finer) {
    FfpImage out = ffp_image_new(finer->width / TIMES, finer->height / TIMES, 1);
    for (int y = 0; y < finer->height; y++)
        for (int x = 0; x < finer->width; x++)
            out.data[(ptrdiff_t)(y / TIMES) * out.width + x / TIMES] +=
                finer->data[(ptrdiff_t)y * finer->width + x] / (TIMES * TIMES);
    return out;
}

static bool is_alike(const FfpImage *mask, const FfpImage *shares) {
    double off = 0, area = 0;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++)
        off += fabs((double)(shares->data[i] - mask->data[i])), area += (double)mask->data[i];
    return off <= OTHER_MOST * area;
}

bool ffp_importing_refine_mask(FfpImporting *import, int v) {
    FfpView *coarse = &import->capture.views[v];
    FfpError none = {0};
    if (import->calibration.stops[v].camera.width < WIDER * coarse->camera.width) return false;
    FfpImporting finer = *import; // whose counts nobody reads
    finer.capture.views = ffp_alloc((size_t)import->capture.n_views, sizeof *finer.capture.views);
    FfpView *view = &finer.capture.views[v];
    view->camera = finer_camera(&coarse->camera);
    view->images = ffp_alloc((size_t)import->capture.n_patterns, sizeof *view->images);
    FfpCapture alone = finer.capture;
    alone.n_views = 1, alone.views = view;
    bool ok = read_view(&finer, v, &none) && ffp_dark_masks(&view->coverage, &alone);
    if (ok) {
        ffp_dark_soften(&alone, view);
        FfpImage shares = means_of(&view->coverage);
        ok = is_alike(&coarse->coverage, &shares);
        ffp_image_free(ok ? &coarse->coverage : &shares);
        if (ok) coarse->coverage = shares;
    }
    for (int p = 0; p < import->capture.n_patterns; p++) ffp_image_free(&view->images[p]);
    ffp_image_free(&view->coverage);
    ffp_free(view->images), ffp_free(finer.capture.views);
    return ok;
}
