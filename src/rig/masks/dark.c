#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/steps.h"

typedef struct Level { // of what is darker than the median
    double middle, deviation;
} Level;

static double *greys_of(const FfpImage *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    double *out = ffp_alloc(pixels, sizeof *out);
    for (size_t i = 0; i < pixels; i++)
        out[i] =
            ((double)image->data[3 * i] + (double)image->data[3 * i + 1] + (double)image->data[3 * i + 2]) /
            3;
    return out;
}

// The mean of all pictures, smoothed. One channel.
static FfpImage mean_of(const FfpImage *images, int n, const FfpImage *like) {
    FfpImage sum = ffp_image_new(like->width, like->height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)sum.width * sum.height;
    int count = 0;
    for (int p = 0; p < n; p++) count += images[p].data != NULL;
    for (int p = 0; p < n; p++)
        for (ptrdiff_t i = 0; images[p].data && i < pixels; i++)
            sum.data[i] += (images[p].data[3 * i] + images[p].data[3 * i + 1] + images[p].data[3 * i + 2]) /
                           (real)(3 * count);
    FfpImage out = ffp_local_mean(&sum, SMOOTH);
    ffp_image_free(&sum);
    return out;
}

// Median and deviation of the darker half of n values, which are reordered.
static Level level_of(double *values, size_t n) {
    const double most = ffp_median(values, n);
    size_t lower = 0;
    for (size_t i = 0; i < n; i++)
        if (values[i] < most) values[lower++] = values[i];
    Level out = {lower > 0 ? ffp_median(values, lower) : most, 0};
    for (size_t i = 0; i < lower; i++) values[i] = fabs(values[i] - out.middle);
    out.deviation = fmax(lower > 0 ? 1.4826 * ffp_median(values, lower) : 0, DARK_NOISE_LEAST);
    return out;
}

static Level level_of_image(const FfpImage *mean) {
    const size_t pixels = (size_t)mean->width * (size_t)mean->height;
    double *values = ffp_alloc(pixels, sizeof *values);
    for (size_t i = 0; i < pixels; i++) values[i] = (double)mean->data[i];
    const Level out = level_of(values, pixels);
    ffp_free(values);
    return out;
}

// How much brighter than the background the bright parts of what is masked are, and how much is masked.
static double brightness_of(const FfpImage *mean, const FfpImage *mask, double middle, double *share) {
    const size_t pixels = (size_t)mean->width * (size_t)mean->height;
    double *values = ffp_alloc(pixels, sizeof *values);
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++)
        if (mask->data[i] > 0) values[n++] = (double)mean->data[i] - middle;
    const double out = n > 0 ? ffp_quantile(values, n, 0.95) : 0;
    *share = (double)n / (double)pixels;
    ffp_free(values);
    return out;
}

static bool mask_view(FfpImage *mask, const FfpCapture *capture, int v) {
    const FfpView *view = &capture->views[v];
    FfpImage mean = mean_of(view->images, capture->n_patterns, &view->images[capture->white]);
    const Level level = level_of_image(&mean);
    const double least = DARK_SIGMAS * level.deviation;
    double share;
    *mask = ffp_image_new(mean.width, mean.height, 1);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)mean.width * mean.height; i++)
        mask->data[i] = (double)mean.data[i] > level.middle + least;
    ffp_mask_drop_pieces(mask);
    ffp_mask_fill_specks(mask);
    const double bright = brightness_of(&mean, mask, level.middle, &share);
    ffp_image_free(&mean);
    return share > 0 && share < DARK_COVERED_MOST && least < DARK_EVEN * bright;
}

bool ffp_dark_masks(FfpImage *masks, const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        ffp_cancel_point();
        if (mask_view(&masks[v], capture, v)) continue;
        for (int k = 0; k <= v; k++) ffp_image_free(&masks[k]);
        return false;
    }
    return true;
}

bool ffp_dark_stage(const FfpCapture *capture, int view, const FfpEmptyStage *stage) {
    const FfpView *of = &capture->views[view];
    FfpImage seen = mean_of(of->images, capture->n_patterns, &of->images[capture->white]),
             empty = mean_of(stage->images, capture->n_patterns, &of->images[capture->white]);
    const size_t pixels = (size_t)seen.width * (size_t)seen.height;
    const Level level = level_of_image(&seen);
    double *values = ffp_alloc(pixels, sizeof *values);
    for (size_t i = 0; i < pixels; i++) values[i] = (double)empty.data[i];
    const double most = ffp_quantile(values, pixels, DARK_STAGE_QUANTILE);
    ffp_free(values);
    ffp_image_free(&seen), ffp_image_free(&empty);
    return most < level.middle + DARK_SIGMAS * level.deviation;
}

// A picture's background, the same everywhere.
static FfpImage even_image(const FfpImage *picture) {
    FfpImage out = ffp_image_new(picture->width, picture->height, 3);
    const size_t pixels = (size_t)out.width * (size_t)out.height;
    double *values = ffp_alloc(pixels, sizeof *values);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < pixels; i++) values[i] = (double)picture->data[3 * i + (size_t)c];
        const real middle = (real)level_of(values, pixels).middle;
        for (size_t i = 0; i < pixels; i++) out.data[3 * i + (size_t)c] = middle;
    }
    ffp_free(values);
    return out;
}

void ffp_dark_soften(const FfpCapture *capture, FfpView *view) {
    FfpEmptyStage stage = {.images = ffp_alloc((size_t)capture->n_patterns, sizeof *stage.images)};
    double *values = greys_of(&view->images[capture->white]);
    const Level level = level_of(values, (size_t)view->camera.width * (size_t)view->camera.height);
    for (int p = 0; p < capture->n_patterns; p++)
        if (view->images[p].data) stage.images[p] = even_image(&view->images[p]);
    ffp_soften_mask(capture, view, &stage, level.deviation);
    for (int p = 0; p < capture->n_patterns; p++) ffp_image_free(&stage.images[p]);
    ffp_free(stage.images), ffp_free(values);
}
