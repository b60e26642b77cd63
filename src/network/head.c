#include "network/head.h"

#include <string.h>
#include <tgmath.h>
#include "base/device.h"
#include "tensor/tensor.h"

#define RATIO_TOLD_MAX ((real)0.68) // log2: what training shows (docs/training.md); beyond it weights guess
#define REACH_FOOTPRINTS 4          // of the context: depth differences beyond count as this

// The widths that both passes need.
typedef struct Widths {
    int dim, pixels, features, channels, joined, hidden, numbers;
} Widths;

static Widths head_widths(const FfpModelConfig *c) {
    const int numbers = ffp_head_numbers(c), channels = c->pixel_skip ? ffp_input_channels(c) : 0;
    const int features = c->pixel_skip ? c->pixel_features : numbers;
    return (Widths){.dim = c->dim,
                    .pixels = c->patch * c->patch,
                    .features = features,
                    .channels = channels,
                    .joined = features + channels,
                    .hidden = c->pixel_hidden,
                    .numbers = numbers};
}

int ffp_head_block(void) {
    return ffp_device() ? 1 << 16 : 1 << 13;
}

size_t ffp_head_features_count(const FfpModelConfig *config, int rows) {
    const Widths w = head_widths(config);
    return (size_t)rows * w.pixels * w.features;
}

void ffp_head_allocate(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena) {
    const Widths w = head_widths(config);
    const size_t block = (size_t)ffp_head_block();
    if (!ffp_device()) {
        head->slot = ffp_arena_take(arena, (size_t)rows, sizeof *head->slot);
        head->used = ffp_arena_take(arena, (size_t)rows, sizeof *head->used);
    }
    head->tokens = ffp_arena_take(arena, (size_t)rows * w.dim, sizeof(real));
    if (!config->pixel_skip) return;
    head->joined = ffp_arena_take(arena, block * w.joined, sizeof(real));
    head->apart = ffp_arena_take(arena, block * FFP_CONTEXT_CHANNELS, sizeof(real));
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        head->hidden[i] = ffp_arena_take(arena, block * w.hidden, sizeof(real));
        head->activated[i] = ffp_arena_take(arena, block * w.hidden, sizeof(real));
    }
}

void ffp_head_allocate_backward(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena) {
    const Widths w = head_widths(config);
    const size_t block = (size_t)ffp_head_block();
    head->dtokens = ffp_arena_take(arena, (size_t)rows * w.dim, sizeof(real));
    if (!config->pixel_skip) return;
    head->djoined = ffp_arena_take(arena, block * w.features, sizeof(real));
    head->dhidden = ffp_arena_take(arena, block * w.hidden, sizeof(real));
    head->dactivated = ffp_arena_take(arena, block * w.hidden, sizeof(real));
}

void ffp_head_select(FfpHead *head, int rows) {
    if (head->prepared) {
        head->n_used = head->prepared->n_used;
        return;
    }
    const int pixels = head->grid.patch * head->grid.patch;
    for (int i = 0; i < rows; i++) head->slot[i] = -1;
    for (int64_t g = 0; g < head->count; g++) {
        const FfpTaps taps = ffp_grid_taps(&head->grid, head->pixel[g]);
        for (int i = 0; i < taps.count; i++) head->slot[taps.place[i] / pixels] = 0;
    }
    head->n_used = 0;
    for (int i = 0; i < rows; i++) {
        if (head->slot[i] < 0) continue;
        head->slot[i] = head->n_used;
        head->used[head->n_used++] = i;
    }
}

// The tokens that are needed, one after another.
static void gather_tokens(FfpHead *head, const real *tokens, const Widths *w) {
    if (head->prepared) {
        ffp_device()->network->gather_rows(head->tokens, tokens, head->prepared->used, head->n_used, w->dim);
        return;
    }
    for (int i = 0; i < head->n_used; i++)
        memcpy(head->tokens + (size_t)i * w->dim, tokens + (size_t)head->used[i] * w->dim,
               (size_t)w->dim * sizeof *tokens);
}

void ffp_head_features(real *map, FfpHead *head, const real *tokens, const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    const FfpLayout *at = model->layout;
    const bool skip = model->config.pixel_skip;
    gather_tokens(head, tokens, &w);
    ffp_linear_forward(map, head->tokens, model->values + (skip ? at->features : at->head),
                       skip ? NULL : model->values + at->head_bias, head->n_used, w.dim,
                       w.pixels * w.features);
}

void ffp_head_features_backward(real *dtokens, real *grad, FfpHead *head, const real *dmap,
                                const real *tokens, const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    const FfpLayout *at = model->layout;
    const bool skip = model->config.pixel_skip;
    gather_tokens(head, tokens, &w);
    ffp_linear_backward(head->dtokens, grad + (skip ? at->features : at->head),
                        skip ? NULL : grad + at->head_bias, dmap, head->tokens,
                        model->values + (skip ? at->features : at->head), head->n_used, w.dim,
                        w.pixels * w.features);
    if (head->prepared) {
        ffp_device()->network->scatter_rows(dtokens, head->dtokens, head->prepared->used, head->n_used,
                                            w.dim);
        return;
    }
    for (int i = 0; i < head->n_used; i++)
        memcpy(dtokens + (size_t)head->used[i] * w.dim, head->dtokens + (size_t)i * w.dim,
               (size_t)w.dim * sizeof *dtokens);
}

// Offset of a place's features in a map.
static size_t feature_offset(const FfpHead *head, int64_t place, const Widths *w) {
    const int slot = head->slot[place / w->pixels];
    return ((size_t)slot * w->pixels + (size_t)(place % w->pixels)) * w->features;
}

// What a pixel takes from the map, and its own inputs behind it: rows of `joined` numbers.
static void join(real *out, const FfpHead *head, int64_t first, int count, const real *map,
                 const FfpModelConfig *config, const Widths *w) {
    if (head->prepared) {
        ffp_device()->network->join(out, &head->prepared->taps, first, count, map, w->features,
                                    head->prepared->own, w->channels);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++) {
        const int64_t pixel = head->pixel[first + i];
        const FfpTaps taps = ffp_grid_taps(&head->grid, pixel);
        real *row = out + (size_t)i * w->joined;
        for (int k = 0; k < w->features; k++) row[k] = 0;
        for (int t = 0; t < taps.count; t++) {
            const real *from = map + feature_offset(head, taps.place[t], w), weight = taps.weight[t];
            for (int k = 0; k < w->features; k++) row[k] += weight * from[k];
        }
        if (w->channels) ffp_pixel_inputs(row + w->features, config, &head->seen, pixel);
    }
}

// The reverse of the features' part. One thread: neighbours share places, and the order of sums is part of
// the result.
static void part(real *dmap, const FfpHead *head, int64_t first, int count, const real *drow,
                 const Widths *w) {
    if (head->prepared) {
        ffp_device()->network->part(dmap, &head->prepared->taps, first, count, drow, w->features);
        return;
    }
    for (int i = 0; i < count; i++) {
        const FfpTaps taps = ffp_grid_taps(&head->grid, head->pixel[first + i]);
        const real *from = drow + (size_t)i * w->features;
        for (int t = 0; t < taps.count; t++) {
            real *to = dmap + feature_offset(head, taps.place[t], w), weight = taps.weight[t];
            for (int k = 0; k < w->features; k++) to[k] += weight * from[k];
        }
    }
}

bool ffp_head_has_apart(const FfpModelConfig *config, const FfpGrid *grid, const FfpStart *context) {
    return config->context_inputs && !grid->same && context;
}

void ffp_head_tell_apart(real *out, const int64_t *pixels, int64_t count, const FfpGrid *grid,
                         const FfpStart *near, const FfpStart *far) {
    const real ratio = sqrt((real)near->width * (real)near->height / ((real)far->width * (real)far->height));
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        const int64_t pixel = pixels[i];
        const FfpTaps taps = ffp_grid_taps(grid, pixel);
        real behind = near->t[pixel];
        for (int t = 0; t < taps.count; t++) behind -= taps.weight[t] * far->t[taps.pixel[t]];
        behind /= REACH_FOOTPRINTS * ratio * fmax(near->footprint[pixel], (real)1e-6);
        out[FFP_CONTEXT_CHANNELS * i] = fmin(log2(ratio), RATIO_TOLD_MAX);
        out[FFP_CONTEXT_CHANNELS * i + 1] = fmin(fmax(behind, -1), 1);
    }
}

static bool has_apart(const FfpHead *head, const FfpModelConfig *config) {
    return head->prepared ? head->prepared->apart_told
                          : ffp_head_has_apart(config, &head->grid, head->context);
}

// What tells the pixels of a block apart from their context, [count, context channels].
static const real *apart_of(FfpHead *head, int64_t first, int count) {
    if (head->prepared) return head->prepared->apart + FFP_CONTEXT_CHANNELS * first;
    ffp_head_tell_apart(head->apart, head->pixel + first, count, &head->grid, head->seen.start,
                        head->context);
    return head->apart;
}

// hidden [count, width] += apart weight^T, weight [width, channels].
static void add_apart(real *hidden, const real *apart, const real *weight, int count, int width) {
    if (ffp_device()) {
        ffp_device()->network->add_apart(hidden, apart, weight, count, width, FFP_CONTEXT_CHANNELS);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++)
        for (int k = 0; k < width; k++)
            for (int c = 0; c < FFP_CONTEXT_CHANNELS; c++)
                hidden[(size_t)i * width + k] +=
                    apart[FFP_CONTEXT_CHANNELS * i + c] * weight[FFP_CONTEXT_CHANNELS * k + c];
}

// The pixel MLP up to its last layer's input.
static void pixel_forward(FfpHead *head, int64_t first, int count, const real *map, const FfpModel *model,
                          const Widths *w) {
    const FfpLayout *at = model->layout;
    join(head->joined, head, first, count, map, &model->config, w);
    const real *x = head->joined;
    int in = w->joined;
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        ffp_linear_forward(head->hidden[i], x, model->values + at->hidden[i],
                           model->values + at->hidden_bias[i], count, in, w->hidden);
        if (i == 0 && has_apart(head, &model->config))
            add_apart(head->hidden[0], apart_of(head, first, count), model->values + at->context, count,
                      w->hidden);
        ffp_gelu_forward(head->activated[i], head->hidden[i], (size_t)count * w->hidden);
        x = head->activated[i];
        in = w->hidden;
    }
}

void ffp_head_forward(real *raw, FfpHead *head, int64_t first, int count, const real *map,
                      const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    const FfpLayout *at = model->layout;
    if (!model->config.pixel_skip) {
        join(raw, head, first, count, map, &model->config, &w);
        return;
    }
    pixel_forward(head, first, count, map, model, &w);
    ffp_linear_forward(raw, head->activated[FFP_HIDDEN_LAYERS - 1], model->values + at->last,
                       model->values + at->last_bias, count, w.hidden, w.numbers);
}

// The pixel MLP's gradients; djoined gets the part that goes back to the features. A pixel's own inputs need
// none.
static void pixel_backward(real *grad, FfpHead *head, int64_t first, int count, const real *draw,
                           const FfpModel *model, const Widths *w) {
    const FfpLayout *at = model->layout;
    const real *values = model->values;
    const int top = FFP_HIDDEN_LAYERS - 1;
    ffp_linear_backward(head->dactivated, grad + at->last, grad + at->last_bias, draw, head->activated[top],
                        values + at->last, count, w->hidden, w->numbers);
    for (int i = top; i >= 0; i--) {
        ffp_gelu_backward(head->dhidden, head->dactivated, head->hidden[i], (size_t)count * w->hidden);
        ffp_linear_backward(i ? head->dactivated : NULL, grad + at->hidden[i], grad + at->hidden_bias[i],
                            head->dhidden, i ? head->activated[i - 1] : head->joined, values + at->hidden[i],
                            count, i ? w->hidden : w->joined, w->hidden);
    }
    if (has_apart(head, &model->config))
        ffp_gemm(true, false, w->hidden, FFP_CONTEXT_CHANNELS, count, 1, head->dhidden, w->hidden,
                 apart_of(head, first, count), FFP_CONTEXT_CHANNELS, 1, grad + at->context,
                 FFP_CONTEXT_CHANNELS);
    ffp_gemm_mixed(false, false, count, w->features, w->hidden, 1, head->dhidden, w->hidden,
                   values + at->hidden[0], w->joined, 0, head->djoined, w->features);
}

void ffp_head_backward(real *dmap, real *grad, FfpHead *head, int64_t first, int count, const real *draw,
                       const real *map, const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    if (model->config.pixel_skip) {
        pixel_forward(head, first, count, map, model, &w);
        pixel_backward(grad, head, first, count, draw, model, &w);
        draw = head->djoined;
    }
    part(dmap, head, first, count, draw, &w);
}
