// The predictors of the quality table: what a picture under another pattern must be, given depth and nothing
// else.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/image/lookup.h"
#include "engine/match/fill.h"
#include "engine/match/line.h"
#include "engine/match/match.h"
#include "engine/match/matching.h"
#include "engine/match/surface.h"

// Position in the projector of the plane's point `dx`, `dy` pixels beside the pixel's centre; false behind
// the projector.
static bool on_pattern(const FfpView *view, const FfpPlane *plane, int x, int y, real dx, real dy,
                       real uv[2]) {
    const FfpLine line = ffp_line(&view->camera, (real)x + 0.5F + dx, (real)y + 0.5F + dy, &view->projector);
    const real q = plane->q0 + plane->qx * dx + plane->qy * dy;
    return q > 0 && ffp_line_at(&line, 1 / q, &uv[0], &uv[1]) > 0;
}

// The pattern averaged over what the pixel covers of it: a box with the second moments of the pixel's image
// there.
static void look_up(const FfpSummed *pattern, const FfpView *view, const FfpPlane *plane, int x, int y,
                    real rgb[3]) {
    real at[2], right[2], left[2], low[2], high[2], extent[2];
    rgb[0] = rgb[1] = rgb[2] = 0;
    if (!on_pattern(view, plane, x, y, 0, 0, at)) return;
    const bool whole =
        on_pattern(view, plane, x, y, 0.5F, 0, right) && on_pattern(view, plane, x, y, -0.5F, 0, left) &&
        on_pattern(view, plane, x, y, 0, 0.5F, high) && on_pattern(view, plane, x, y, 0, -0.5F, low);
    for (int c = 0; c < 2; c++)
        extent[c] =
            whole
                ? sqrt((right[c] - left[c]) * (right[c] - left[c]) + (high[c] - low[c]) * (high[c] - low[c]))
                : 1;
    ffp_lookup(pattern, at[0], at[1], extent[0], extent[1], rgb);
}

// A row of the picture, encoded.
static void predict_row(real *out, const FfpSummed *pattern, const FfpCapture *capture, const FfpView *view,
                        const FfpSheet *sheet, int y) {
    const size_t first = (size_t)y * (size_t)sheet->width * 3;
    const real *black = view->images[capture->black].data + first,
               *white = view->images[capture->white].data + first;
    const real *inverse = sheet->inverse + (size_t)(y + sheet->reach) * (size_t)sheet->stride + sheet->reach;
    FfpPlane planes[FFP_MATCH_LANES] = {{0}};
    for (int x = 0; x < sheet->width; x++) {
        FfpPlane *plane = &planes[x % FFP_MATCH_LANES];
        real rgb[3] = {0, 0, 0};
        if (x % FFP_MATCH_LANES == 0) ffp_fit_planes(planes, sheet, x, y);
        plane->q0 = inverse[x]; // only the slant is the neighbours'
        if (inverse[x] > 0) look_up(pattern, view, plane, x, y, rgb);
        for (int i = 3 * x; i < 3 * x + 3; i++)
            out[first + (size_t)i] = ffp_srgb_encode(black[i] + (white[i] - black[i]) * rgb[i - 3 * x]);
    }
}

FfpImage ffp_predict_by_lookup(const FfpCapture *capture, int view_index, int pattern, const real *depth) {
    const FfpView *view = &capture->views[view_index];
    const int width = view->camera.width, height = view->camera.height;
    const size_t pixels = (size_t)width * (size_t)height;
    FfpImage out = ffp_image_new(width, height, 3);
    FfpSummed summed = ffp_summed_new(&capture->patterns[pattern].image);
    real *whole = ffp_alloc(pixels, sizeof(real)), *even = ffp_alloc(pixels, sizeof(real));
    for (size_t i = 0; i < pixels; i++) {
        whole[i] = depth[i];
        even[i] = 1;
    }
    ffp_fill_smoothly(whole, NULL, NULL, width, height);
    FfpSheet sheet = ffp_sheet_new(whole, even, &view->camera, 1);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) predict_row(out.data, &summed, capture, view, &sheet, y);
    ffp_sheet_free(&sheet);
    ffp_free(whole);
    ffp_free(even);
    ffp_summed_free(&summed);
    return out;
}

void ffp_match_depth(const FfpCapture *capture, int view, const int *patterns, int n,
                     const FfpMatchSettings *settings, real *depth) {
    const FfpCamera *camera = &capture->views[view].camera;
    FfpObservation observed = ffp_observe(capture, view, patterns, n);
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, view));
    real *confidence = ffp_alloc((size_t)camera->width * (size_t)camera->height, sizeof(real));
    ffp_match_view(depth, confidence, NULL, NULL, capture, view, &observed, &blurred, settings);
    ffp_fill_smoothly(depth, NULL, NULL, camera->width, camera->height);
    ffp_free(confidence);
    ffp_blurred_free(&blurred);
    ffp_observation_free(&observed);
}
