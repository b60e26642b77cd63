#include "match/refine.h"

#include <string.h>

#include "match/kernels/kernels.h"

#define PLANE_REACH 2 // the local plane is fitted to as many pixels

// A row's pixels from x on, as many as are fitted at a time.
static void refine_strip(real *out, const real *weight, const FfpSheet *sheet, const FfpView *view,
                         const FfpObservation *seen, const FfpBlurred *patterns, int x, int y, int steps,
                         real range) {
    const size_t first = (size_t)y * (size_t)seen->width + (size_t)x;
    const int lanes = seen->width - x < FFP_MATCH_LANES ? seen->width - x : FFP_MATCH_LANES, half = steps / 2;
    bool any = false;
    for (int n = 0; n < lanes; n++) any |= weight[first + (size_t)n] > 0;
    if (!any) return;
    FfpRefinePixel *refine = ffp_match_kernels()->refine_pixel;
    FfpPlane planes[FFP_MATCH_LANES];
    ffp_fit_planes(planes, sheet, x, y);
    for (int n = 0; n < lanes; n++) {
        const FfpPlane *plane = &planes[n];
        if (weight[first + (size_t)n] <= 0 || plane->q0 <= 0) continue;
        const real step = range * plane->q0 * plane->q0 / (real)half;
        const real q = refine(view, seen, patterns, plane, x + n, y, steps, step);
        if (q > 0) out[first + (size_t)n] = 1 / q;
    }
}

void ffp_refine_depth(real *out, const real *depth, const real *weight, const FfpView *view,
                      const FfpObservation *seen, const FfpBlurred *patterns, int steps, real range) {
    if (steps > FFP_REFINE_STEPS_MAX) steps = FFP_REFINE_STEPS_MAX;
    memcpy(out, depth, (size_t)seen->width * (size_t)seen->height * sizeof(real));
    FfpSheet sheet = ffp_sheet_new(depth, weight, &view->camera, PLANE_REACH);
    for (int y = 0; y < seen->height; y++)
        for (int x = 0; x < seen->width; x += FFP_MATCH_LANES)
            refine_strip(out, weight, &sheet, view, seen, patterns, x, y, steps, range);
    ffp_sheet_free(&sheet);
}
