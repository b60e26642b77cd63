// Drawing several views into the caller's memory, and the gradients of what was drawn.
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "engine/pipeline/renderer.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

enum { VIEWS_MAX = 65536, PATTERNS_MAX = 4096 };

typedef struct ForwardCall {
    FfpRenderer *renderer;
    const FfpRenderBatch *given;
    float *pictures;
    size_t count;
    float *maps[FFP_MAP_COUNT];
} ForwardCall;

static bool check_numbers(size_t count, size_t numbers, FfpError *err) {
    return count == numbers || ffp_fail(err, FFP_ERROR_ARGUMENT, "count",
                                        "the pictures have %zu numbers, not %zu", numbers, count);
}

static bool check_maps(const void *maps, int n_maps, FfpError *err) {
    if (n_maps < 0 || n_maps > FFP_MAP_COUNT)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "n_maps", "%d is not in 0 to %d", n_maps, FFP_MAP_COUNT);
    return n_maps == 0 || ffp_need(maps, "maps", err);
}

static bool check_counts(const FfpRenderBatch *b, FfpError *err) {
    if (b->n_views < 1 || b->n_views > VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "n_views", "%d is not in 1 to %d", b->n_views, VIEWS_MAX);
    if (b->n_patterns < 0 || b->n_patterns > PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "n_patterns", "%d is not in 0 to %d", b->n_patterns,
                        PATTERNS_MAX);
    for (int c = 0; c < 3; c++)
        if (!(b->intensity[c] >= 0 && b->intensity[c] <= 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "%g is out of range", b->intensity[c]);
    return ffp_need(b->cameras, "cameras", err) && ffp_need(b->projectors, "projectors", err);
}

// n devices of one size.
static bool take_devices(FfpCamera *to, const FfpPinhole *from, int n, const char *name, FfpError *err) {
    char place[64];
    for (int i = 0; i < n; i++) {
        snprintf(place, sizeof place, "%s[%d]", name, i);
        if (!ffp_camera_of(&to[i], &from[i], 1, place, err)) return false;
        if (to[i].width != to[0].width || to[i].height != to[0].height)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, place, "%d x %d pixels; the first has %d x %d",
                            to[i].width, to[i].height, to[0].width, to[0].height);
    }
    return true;
}

static bool check_pattern_size(int width, int height, const FfpCamera *projector, const char *place,
                               FfpError *err) {
    return (width == projector->width && height == projector->height) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, place, "%d x %d pixels do not fit a projector of %d x %d", width,
                    height, projector->width, projector->height);
}

static bool take_patterns(FfpImage *to, const FfpRenderBatch *b, const FfpCamera *projector, FfpError *err) {
    char place[64];
    for (int p = 0; p < b->n_patterns; p++) {
        const FfpRaw raw = ffp_raw_of(&b->patterns[p]);
        snprintf(place, sizeof place, "patterns[%d]", p);
        if (raw.data && (!check_pattern_size(raw.width, raw.height, projector, place, err) ||
                         !ffp_raw_over_black(&to[p], NULL, &raw, place, err)))
            return false;
    }
    return true;
}

static bool check_same(const FfpBatch *batch, const FfpRenderBatch *b, const FfpCamera *projector,
                       FfpError *err) {
    const FfpBatchShape last = ffp_batch_shape(batch);
    if (last.patterns != b->n_patterns)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "same_patterns", "the renderer has %d patterns, not %d",
                        last.patterns, b->n_patterns);
    return last.patterns == 0 ||
           check_pattern_size(last.pattern_width, last.pattern_height, projector, "same_patterns", err);
}

// Job and batch are checked. The handle owns the contents of the batch afterwards.
static bool draw(ForwardCall *call, FfpBatchJob *job, FfpImage *patterns, FfpCamera *devices, FfpError *err) {
    const FfpRenderBatch *b = call->given;
    FfpCamera *projectors = devices + b->n_views;
    FfpBatch *batch = ffp_renderer_batch(call->renderer);
    ffp_blocks_use(NULL);
    if (!take_devices(devices, b->cameras, b->n_views, "cameras", err) ||
        !take_devices(projectors, b->projectors, b->n_views, "projectors", err) ||
        !check_numbers(call->count,
                       (size_t)b->n_views * (size_t)b->n_patterns * 3 * (size_t)devices->width *
                           (size_t)devices->height,
                       err) ||
        !(b->same_patterns ? check_same(batch, b, projectors, err)
                           : take_patterns(patterns, b, projectors, err)))
        return false;
    job->cameras = devices;
    job->projectors = projectors;
    job->patterns = patterns;
    ffp_renderer_batch(call->renderer);
    ffp_batch_forward(batch, job, call->pictures, call->maps);
    ffp_blocks_use(NULL);
    return call->renderer->drawn = true;
}

static bool forward(void *argument, FfpError *err) {
    ForwardCall *call = argument;
    const FfpRenderBatch *b = call->given;
    if (!ffp_check_arrays(&b->gaussians, err)) return false;
    const FfpGaussians gaussians = ffp_gaussians_of(&b->gaussians);
    FfpBatchJob job = {.gaussians = &gaussians,
                       .n_views = b->n_views,
                       .n_patterns = b->n_patterns,
                       .same_patterns = b->same_patterns,
                       .linear = b->linear,
                       .gradients = b->gradients};
    for (int c = 0; c < 3; c++) job.intensity[c] = (real)b->intensity[c];
    FfpCamera *devices = ffp_alloc(2 * (size_t)b->n_views, sizeof *devices);
    FfpImage *patterns = ffp_alloc((size_t)b->n_patterns + 1, sizeof *patterns);
    const bool ok = draw(call, &job, patterns, devices, err);
    for (int p = 0; p < b->n_patterns; p++) ffp_image_free(&patterns[p]);
    ffp_free(patterns);
    ffp_free(devices);
    return ok;
}

bool ffp_renderer_forward(FfpContext *context, FfpRenderer *renderer, const FfpRenderBatch *batch,
                          float *pictures, size_t count, float *const *maps, int n_maps, FfpError *err) {
    ForwardCall call = {renderer, batch, pictures, count, {NULL}};
    if (!ffp_need(renderer, "renderer", err)) return false;
    renderer->drawn = false; // whatever becomes of it
    if (!ffp_need(batch, "batch", err) || !check_counts(batch, err) ||
        (batch->n_patterns > 0 && !ffp_need(pictures, "pictures", err)) ||
        (batch->n_patterns > 0 && !batch->same_patterns && !ffp_need(batch->patterns, "patterns", err)) ||
        !check_maps(maps, n_maps, err))
        return false;
    for (int m = 0; m < n_maps; m++) call.maps[m] = maps[m];
    return ffp_call_run(context, forward, &call, err);
}

typedef struct BackwardCall {
    FfpRenderer *renderer;
    const float *pictures;
    size_t count;
    const float *maps[FFP_MAP_COUNT];
    const FfpRenderGradients *out;
} BackwardCall;

static bool backward(void *argument, FfpError *err) {
    const BackwardCall *call = argument;
    const FfpBatchShape shape =
        call->renderer->drawn ? ffp_batch_shape(call->renderer->batch) : (FfpBatchShape){0};
    if (shape.gaussians == 0 || !shape.gradients)
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, "renderer",
            "the last ffp_renderer_forward failed, or was without `gradients`, or there was none");
    if (call->pictures && !check_numbers(call->count, shape.pictures, err)) return false;
    ffp_batch_backward(ffp_renderer_batch(call->renderer), call->pictures, call->maps, call->out);
    ffp_blocks_use(NULL);
    return true;
}

bool ffp_renderer_backward(FfpContext *context, FfpRenderer *renderer, const float *pictures, size_t count,
                           const float *const *maps, int n_maps, const FfpRenderGradients *out,
                           FfpError *err) {
    BackwardCall call = {renderer, pictures, count, {NULL}, out};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(out, "out", err) || !check_maps(maps, n_maps, err))
        return false;
    for (int m = 0; m < n_maps; m++) call.maps[m] = maps[m];
    return ffp_call_run(context, backward, &call, err);
}
