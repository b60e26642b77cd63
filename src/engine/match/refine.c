#include "engine/match/refine.h"
#include <string.h>
#include "engine/match/kernels/kernels.h"

// A row's pixels from x on, as many as are fitted at a time.
static void refine_strip(real *out, const real *weight, const FfpSheet *sheet, const FfpFineSearch *search,
                         int x, int y, real range) {
    const int width = search->observed->width, half = search->steps / 2;
    const size_t first = (size_t)y * (size_t)width + (size_t)x;
    const int lanes = width - x < FFP_MATCH_LANES ? width - x : FFP_MATCH_LANES;
    bool any = false;
    for (int n = 0; n < lanes; n++) any |= weight[first + (size_t)n] > 0;
    if (!any) return;
    FfpRefinePixel *refine = ffp_match_kernels()->refine_pixel;
    FfpPlane planes[FFP_MATCH_LANES];
    ffp_fit_planes(planes, sheet, x, y);
    for (int n = 0; n < lanes; n++) {
        const FfpPlane *plane = &planes[n];
        if (weight[first + (size_t)n] <= 0 || plane->q0 <= 0) continue;
        const real step = (search->inverse ? range : range * plane->q0 * plane->q0) / (real)half;
        const real q = refine(search, plane, x + n, y, step);
        if (q > 0) out[first + (size_t)n] = 1 / q;
    }
}

void ffp_refine_depth(real *out, const real *depth, const real *weight, const FfpFineSearch *search,
                      real range) {
    const int width = search->observed->width, height = search->observed->height;
    memcpy(out, depth, (size_t)width * (size_t)height * sizeof(real));
    FfpSheet sheet = ffp_sheet_new(depth, weight, search->camera, FFP_FINE_PLANE_REACH);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x += FFP_MATCH_LANES)
            refine_strip(out, weight, &sheet, search, x, y, range);
    ffp_sheet_free(&sheet);
}
