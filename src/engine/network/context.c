#include "engine/network/context.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/capture/reduce.h"
#include "engine/network/layout.h"

#define VIEWS_OF_TOKENS 16 // up to which config->tokens is the most; of more, each view keeps its share
#define EMPTY_WEIGHT 1e-4F // of a pixel without coverage against one that has it

// The larger sides a token grid may have: patches in `side` pixels times `scale`, at least one.
static int patches(int side, double scale, int patch) {
    const int count = (int)(side * scale / patch + 1e-6);
    return count > 0 ? count : 1;
}

double ffp_pixel_context_tokens(const FfpModelConfig *config, int views) {
    return (double)config->tokens * fmax((double)views / VIEWS_OF_TOKENS, 1);
}

void ffp_pixel_context_size(int *width, int *height, const FfpModelConfig *config, const FfpCapture *capture,
                            int views) {
    const FfpCamera *camera = &capture->views[0].camera;
    const int patch = config->patch;
    const double pixels = (double)views * camera->width * camera->height,
                 most = ffp_pixel_context_tokens(config, views) * patch * patch;
    const double scale = pixels > most ? sqrt(most / pixels) : 1;
    *width = patch * patches(camera->width, scale, patch);
    *height = patch * patches(camera->height, scale, patch);
}

bool ffp_pixel_context_new(FfpPixelContext *context, const FfpModelConfig *config, const FfpCapture *capture,
                           const FfpInitialisation *start, const int *patterns, int n, FfpError *err) {
    const int views = start ? start->views : capture->n_views;
    const FfpCamera *camera = &capture->views[0].camera;
    int width, height;
    *context = (FfpPixelContext){.capture = *capture};
    context->capture.n_views = views;
    if (start) context->start = *start;
    if (camera->width < config->patch || camera->height < config->patch)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name,
                        "images of %d x %d pixels are smaller than a patch of %d", camera->width,
                        camera->height, config->patch);
    ffp_pixel_context_size(&width, &height, config, capture, views);
    if (width == camera->width && height == camera->height) return true;
    int *photographs = ffp_alloc((size_t)n + 2, sizeof *photographs);
    photographs[0] = capture->black;
    photographs[1] = capture->white;
    memcpy(photographs + 2, patterns, (size_t)n * sizeof *photographs);
    context->capture = ffp_capture_reduced(capture, views, photographs, n + 2, width, height);
    ffp_free(photographs);
    context->start = (FfpInitialisation){0};
    context->reduced = true;
    FfpMatchSettings settings = ffp_match_defaults();
    if (start) settings.device = start->device;
    if (!start || ffp_initialisation_new(&context->start, &context->capture, patterns, n, &settings, err))
        return true;
    ffp_pixel_context_free(context);
    return false;
}

void ffp_pixel_context_free(FfpPixelContext *context) {
    if (context->reduced) {
        ffp_initialisation_free(&context->start);
        ffp_capture_reduced_free(&context->capture);
    }
    *context = (FfpPixelContext){0};
}

FfpGrid ffp_grid(const FfpModelConfig *config, const FfpCapture *capture, const FfpPixelContext *context) {
    const FfpCamera *camera = &capture->views[0].camera, *small = &context->capture.views[0].camera;
    return (FfpGrid){.width = camera->width,
                     .height = camera->height,
                     .patch = config->patch,
                     .across = small->width / config->patch,
                     .down = small->height / config->patch,
                     .same = !context->reduced,
                     .coverage = context->start.coverage};
}

static int64_t place_of(const FfpGrid *grid, int64_t view, int x, int y) {
    const int patch = grid->patch;
    const int64_t token = (view * grid->down + y / patch) * grid->across + x / patch;
    return (token * patch + y % patch) * patch + x % patch;
}

// The two neighbours of a position along a side of the context, and the second's weight.
static void along(int neighbours[2], real *weight, int at, int side, int side_out) {
    const real x = fmax(((real)at + 0.5F) * (real)side_out / (real)side - 0.5F, 0);
    const int low = (int)x < side_out - 1 ? (int)x : side_out - 1;
    neighbours[0] = low;
    neighbours[1] = low + 1 < side_out ? low + 1 : low;
    *weight = neighbours[1] > low ? x - (real)low : 0;
}

FfpTaps ffp_grid_taps(const FfpGrid *grid, int64_t pixel) {
    const int x = (int)(pixel % grid->width), y = (int)(pixel / grid->width % grid->height);
    const int64_t view = pixel / grid->width / grid->height;
    if (grid->same) return (FfpTaps){1, {pixel}, {place_of(grid, view, x, y)}, {1}};
    const int width = grid->across * grid->patch, height = grid->down * grid->patch;
    int columns[2], rows[2];
    real right, below, sum = 0;
    along(columns, &right, x, grid->width, width);
    along(rows, &below, y, grid->height, height);
    FfpTaps taps = {.count = 4};
    for (int i = 0; i < 4; i++) {
        const int column = columns[i % 2], row = rows[i / 2];
        taps.pixel[i] = (view * height + row) * width + column;
        taps.place[i] = place_of(grid, view, column, row);
        taps.weight[i] = (i % 2 ? right : 1 - right) * (i / 2 ? below : 1 - below);
        if (grid->coverage && !(grid->coverage[taps.pixel[i]] > 0)) taps.weight[i] *= EMPTY_WEIGHT;
        sum += taps.weight[i];
    }
    for (int i = 0; i < 4; i++) taps.weight[i] /= sum;
    return taps;
}
