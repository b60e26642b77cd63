// The predictors of the quality table: what a picture under another pattern must be, given depth and nothing
// else.
#include <stdlib.h>
#include <tgmath.h>

#include "base/arena.h"
#include "image/lookup.h"
#include "match/fill.h"
#include "match/line.h"
#include "match/match.h"
#include "match/matching.h"
#include "match/surface.h"

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

FfpImage ffp_predict_by_lookup(const FfpCapture *capture, int view_index, int pattern, const real *depth) {
    const FfpView *view = &capture->views[view_index];
    const int width = view->camera.width, height = view->camera.height;
    const size_t pixels = (size_t)width * (size_t)height;
    const real *black = view->images[capture->black].data, *white = view->images[capture->white].data;
    FfpImage out = ffp_image_new(width, height, 3);
    FfpSummed summed = ffp_summed_new(&capture->patterns[pattern].image);
    real *whole = ffp_alloc(pixels, sizeof(real)), *even = ffp_alloc(pixels, sizeof(real));
    for (size_t i = 0; i < pixels; i++) whole[i] = depth[i], even[i] = 1;
    ffp_fill_smoothly(whole, NULL, NULL, width, height);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            FfpPlane plane;
            real rgb[3] = {0, 0, 0};
            if (ffp_fit_plane(&plane, whole, even, &view->camera, x, y, 1)) {
                const real z = whole[(size_t)y * (size_t)width + (size_t)x];
                plane.q0 = 1 / z; // only the slant is the neighbours'
                look_up(&summed, view, &plane, x, y, rgb);
            }
            for (int c = 0; c < 3; c++) {
                const size_t i = 3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c;
                out.data[i] = ffp_srgb_encode(black[i] + (white[i] - black[i]) * rgb[c]);
            }
        }
    }
    free(whole), free(even);
    ffp_summed_free(&summed);
    return out;
}

void ffp_match_depth(const FfpCapture *capture, int view, int active, const FfpMatchSettings *settings,
                     real *depth) {
    const FfpCamera *camera = &capture->views[view].camera;
    FfpObservation seen = ffp_observe(capture, view, active);
    FfpBlurred pattern =
        ffp_blurred_new(&capture->patterns[active].image, ffp_typical_footprint(capture, view));
    real *confidence = ffp_alloc((size_t)camera->width * (size_t)camera->height, sizeof(real));
    ffp_match_view(depth, confidence, NULL, capture, view, &seen, &pattern, settings);
    ffp_fill_smoothly(depth, NULL, NULL, camera->width, camera->height);
    free(confidence);
    ffp_blurred_free(&pattern);
    ffp_observation_free(&seen);
}
