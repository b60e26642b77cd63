#include "core/capture/coverage.h"
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/numerics/rank.h"

#define LIT 0.02F // linear radiance: what white must add to a pixel before it counts as lit

static void clamp_to_unit(FfpImage *image) {
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    for (ptrdiff_t i = 0; i < pixels; i++) image->data[i] = fmin(fmax(image->data[i], (real)0), (real)1);
}

static const FfpImage *best_alpha(const FfpCapture *capture, const FfpImage *alphas) {
    if (capture->white >= 0 && alphas[capture->white].data) return &alphas[capture->white];
    if (capture->black >= 0 && alphas[capture->black].data) return &alphas[capture->black];
    for (int i = 0; i < capture->n_patterns; i++) {
        if (alphas[i].data) return &alphas[i];
    }
    return NULL;
}

// 1 where any picture exceeds the black one (or 0, where there is none) in any channel.
static FfpCoverageSource guess(const FfpCapture *capture, FfpView *view) {
    view->coverage = ffp_image_new(view->camera.width, view->camera.height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    const real *black = capture->black >= 0 ? view->images[capture->black].data : NULL;
    bool any = false;
    if (capture->scene) { // nothing to guess: everything belongs to it
        for (ptrdiff_t k = 0; k < pixels; k++) view->coverage.data[k] = 1;
        return FFP_COVERAGE_MASK;
    }
    for (int i = 0; i < capture->n_patterns; i++) {
        const real *image = view->images[i].data;
        any = any || image;
        for (ptrdiff_t k = 0; k < pixels && image && image != black; k++) {
            real most = 0;
            for (int c = 0; c < 3; c++) most = fmax(most, image[3 * k + c] - (black ? black[3 * k + c] : 0));
            if (most > LIT) view->coverage.data[k] = 1;
        }
    }
    return any ? FFP_COVERAGE_GUESSED : FFP_COVERAGE_NONE;
}

bool ffp_wants_mask(const FfpCapture *capture, const FfpImage *alphas, bool mask_first) {
    return mask_first || !best_alpha(capture, alphas);
}

FfpCoverageSource ffp_cover_view(const FfpCapture *capture, FfpView *view, const FfpImage *alphas,
                                 FfpImage *mask, bool applied) {
    const FfpImage *alpha = best_alpha(capture, alphas);
    if (mask->data) {
        view->coverage = *mask;
        *mask = (FfpImage){0};
        clamp_to_unit(&view->coverage);
        for (int i = 0; i < capture->n_patterns && !applied; i++)
            ffp_mask_apply(&view->coverage, &view->images[i]);
        return FFP_COVERAGE_MASK;
    }
    if (!alpha) return guess(capture, view);
    view->coverage = ffp_image_copy(alpha);
    clamp_to_unit(&view->coverage);
    return FFP_COVERAGE_ALPHA;
}

// --- The projector's strength. ---

// pi d^2 (white - black) of every `step`-th lit value, up to `room` of them; returns their number.
static size_t apparent_albedos(const FfpCapture *capture, size_t step, float *out, size_t room) {
    size_t count = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        double square = 0;
        for (int i = 0; i < 3; i++) {
            const double to = (double)capture->centre[i] - (double)view->projector.pose[4 * i + 3];
            square += to * to;
        }
        const size_t values = 3 * (size_t)view->camera.width * (size_t)view->camera.height;
        const real *white = view->images[capture->white].data, *black = view->images[capture->black].data;
        for (size_t i = 0; i < values && count < room; i += step) {
            if (view->coverage.data[i / 3] < 0.5F || white[i] - black[i] <= LIT) continue;
            out[count++] = (float)(4 * atan(1.0) * square * (double)(white[i] - black[i]));
        }
    }
    return count;
}

bool ffp_estimate_intensity(FfpCapture *capture, const char *file, FfpError *err) {
    const size_t room = 1000000; // plenty for a percentile
    size_t values = 0;
    for (int v = 0; v < capture->n_views; v++) {
        values += 3 * (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    }
    // 7 is prime to 3: a coarse step still meets all channels; up to the limit every value counts.
    size_t step = 1;
    while (values / step > room) step *= 7;
    float *albedos = ffp_alloc(room, sizeof *albedos);
    const size_t count = apparent_albedos(capture, step, albedos, room);
    if (count > 0) {
        const double intensity = (double)ffp_quantile(albedos, count, 0.95) / 0.8;
        for (int c = 0; c < 3; c++) capture->intensity[c] = (real)intensity;
    }
    ffp_free(albedos);
    return count > 0 || ffp_fail(err, FFP_ERROR_FILE, file,
                                 "no pixel is brighter under the white pattern than under the black one");
}
