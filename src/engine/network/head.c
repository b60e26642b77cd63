#include "engine/network/head.h"
#include <string.h>
#include "core/base/device.h"
#include "core/base/integer.h"
#include "core/tensor/tensor.h"

static FfpHeadWidths head_widths(const FfpModelConfig *c) {
    const int numbers = ffp_head_numbers(c), channels = c->pixel_skip ? ffp_input_channels(c) : 0;
    const int features = c->pixel_skip ? c->pixel_features : numbers;
    return (FfpHeadWidths){.dim = c->dim,
                           .pixels = c->patch * c->patch,
                           .features = features,
                           .channels = channels,
                           .gathered = features + channels,
                           .hidden = ffp_larger(c->pixel_hidden, c->looks ? c->look_hidden : 0),
                           .numbers = numbers};
}

int ffp_head_block(void) {
    return ffp_device() ? 1 << 16 : 1 << 13;
}

size_t ffp_head_features_count(const FfpModelConfig *config, int rows) {
    const FfpHeadWidths w = head_widths(config);
    return (size_t)rows * w.pixels * w.features;
}

void ffp_head_allocate(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena) {
    const FfpHeadWidths w = head_widths(config);
    head->widths = w;
    const size_t block = (size_t)ffp_head_block();
    if (!ffp_device()) {
        head->slot = ffp_arena_take(arena, (size_t)rows, sizeof *head->slot);
        head->used = ffp_arena_take(arena, (size_t)rows, sizeof *head->used);
    }
    head->tokens = ffp_arena_take(arena, (size_t)rows * w.dim, sizeof(real));
    if (!config->pixel_skip) return;
    if (config->looks) head->corrections = ffp_arena_take(arena, block * w.numbers, sizeof(real));
    head->gathered = ffp_arena_take(arena, block * w.gathered, sizeof(real));
    head->context_inputs = ffp_arena_take(arena, block * FFP_CONTEXT_CHANNELS, sizeof(real));
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        head->hidden[i] = ffp_arena_take(arena, block * w.hidden, sizeof(real));
        head->activated[i] = ffp_arena_take(arena, block * w.hidden, sizeof(real));
    }
}

void ffp_head_allocate_backward(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena) {
    const FfpHeadWidths w = head->widths;
    const size_t block = (size_t)ffp_head_block();
    head->dtokens = ffp_arena_take(arena, (size_t)rows * w.dim, sizeof(real));
    if (!config->pixel_skip) return;
    head->dgathered = ffp_arena_take(arena, block * w.features, sizeof(real));
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
static void gather_tokens(FfpHead *head, const real *tokens) {
    const int dim = head->widths.dim;
    if (head->prepared) {
        ffp_device()->network->gather_rows(head->tokens, tokens, head->prepared->used, head->n_used, dim);
        return;
    }
    for (int i = 0; i < head->n_used; i++)
        memcpy(head->tokens + (size_t)i * dim, tokens + (size_t)head->used[i] * dim,
               (size_t)dim * sizeof *tokens);
}

// The reverse: head->dtokens to the rows that are needed.
static void scatter_tokens(real *dtokens, const FfpHead *head) {
    const int dim = head->widths.dim;
    if (head->prepared) {
        ffp_device()->network->scatter_rows(dtokens, head->dtokens, head->prepared->used, head->n_used, dim);
        return;
    }
    for (int i = 0; i < head->n_used; i++)
        memcpy(dtokens + (size_t)head->used[i] * dim, head->dtokens + (size_t)i * dim,
               (size_t)dim * sizeof *dtokens);
}

void ffp_head_features(real *map, FfpHead *head, const real *tokens, const FfpModel *model) {
    const FfpHeadWidths *w = &head->widths;
    const FfpLayout *at = model->layout;
    const bool skip = model->config.pixel_skip;
    gather_tokens(head, tokens);
    ffp_linear_forward(map, head->tokens, model->values + (skip ? at->features : at->head),
                       skip ? NULL : model->values + at->head_bias, head->n_used, w->dim,
                       w->pixels * w->features);
}

void ffp_head_features_backward(real *dtokens, real *grad, FfpHead *head, const real *dmap,
                                const real *tokens, const FfpModel *model) {
    const FfpHeadWidths *w = &head->widths;
    const FfpLayout *at = model->layout;
    const bool skip = model->config.pixel_skip;
    gather_tokens(head, tokens);
    ffp_linear_backward(head->dtokens, grad + (skip ? at->features : at->head),
                        skip ? NULL : grad + at->head_bias, dmap, head->tokens,
                        model->values + (skip ? at->features : at->head), head->n_used, w->dim,
                        w->pixels * w->features);
    scatter_tokens(dtokens, head);
}

// Offset of a place's features in a map.
static size_t feature_offset(const FfpHead *head, int64_t place) {
    const FfpHeadWidths *w = &head->widths;
    const int slot = head->slot[place / w->pixels];
    return ((size_t)slot * w->pixels + (size_t)(place % w->pixels)) * w->features;
}

// The mean of the map's rows that each pixel takes, and its own inputs behind it: rows of `gathered` numbers.
static void gather_features(real *out, const FfpHead *head, int64_t first, int count, const real *map,
                            const FfpModelConfig *config) {
    const FfpHeadWidths *w = &head->widths;
    if (head->prepared) {
        ffp_device()->network->gather_features(out, &head->prepared->taps, first, count, map, w->features,
                                               head->prepared->own, w->channels);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++) {
        const int64_t pixel = head->pixel[first + i];
        const FfpTaps taps = ffp_grid_taps(&head->grid, pixel);
        real *row = out + (size_t)i * w->gathered;
        for (int k = 0; k < w->features; k++) row[k] = 0;
        for (int t = 0; t < taps.count; t++) {
            const real *from = map + feature_offset(head, taps.place[t]), weight = taps.weight[t];
            for (int k = 0; k < w->features; k++) row[k] += weight * from[k];
        }
        if (w->channels) ffp_pixel_inputs(row + w->features, config, &head->source, pixel);
    }
}

// The reverse of the features' part: ADDS to dmap what each pixel gives back, dfeatures [count, features].
// One thread: neighbours share places, and the order of sums is part of the result.
static void scatter_features(real *dmap, const FfpHead *head, int64_t first, int count,
                             const real *dfeatures) {
    const int features = head->widths.features;
    if (head->prepared) {
        ffp_device()->network->scatter_features(dmap, &head->prepared->taps, first, count, dfeatures,
                                                features);
        return;
    }
    for (int i = 0; i < count; i++) {
        const FfpTaps taps = ffp_grid_taps(&head->grid, head->pixel[first + i]);
        const real *from = dfeatures + (size_t)i * features;
        for (int t = 0; t < taps.count; t++) {
            real *to = dmap + feature_offset(head, taps.place[t]), weight = taps.weight[t];
            for (int k = 0; k < features; k++) to[k] += weight * from[k];
        }
    }
}

void ffp_head_forward(real *raw, FfpHead *head, int64_t first, int count, const real *map,
                      const FfpModel *model) {
    if (!model->config.pixel_skip) {
        gather_features(raw, head, first, count, map, &model->config);
        return;
    }
    gather_features(head->gathered, head, first, count, map, &model->config);
    const FfpPixelLayers layers = ffp_pixel_layers(head, first, count, model);
    ffp_pixel_layers_forward(raw, head, &layers, count, model);
}

static FfpPixelLayers look_layers(const FfpHead *head, const real *seen, int look, const FfpModel *model) {
    return (FfpPixelLayers){&model->layout->look[look], seen, FFP_LOOK_SEEN + head->widths.numbers};
}

void ffp_head_correct(real *raw, FfpHead *head, int64_t first, int count, const real *map, const real *seen,
                      int look, const FfpModel *model) {
    const FfpPixelLayers layers = look_layers(head, seen, look, model);
    gather_features(head->gathered, head, first, count, map, &model->config);
    ffp_pixel_layers_forward(head->corrections, head, &layers, count, model);
    ffp_add(raw, head->corrections, (size_t)count * head->widths.numbers);
}

void ffp_head_backward(real *dmap, real *grad, FfpHead *head, int64_t first, int count, const real *draw,
                       const real *map, real *const seen[FFP_LOOKS_MAX], const FfpModel *model) {
    if (model->config.pixel_skip) {
        gather_features(head->gathered, head, first, count, map, &model->config);
        ffp_memory_zero(head->dgathered, (size_t)count * head->widths.features * sizeof(real));
        FfpPixelLayers layers = ffp_pixel_layers(head, first, count, model);
        if (!head->looks_only)
            ffp_pixel_layers_backward(head->dgathered, grad, head, &layers, count, draw, model);
        for (int i = 0; i < head->looks; i++) {
            layers = look_layers(head, seen[i] + first * (FFP_LOOK_SEEN + head->widths.numbers), i, model);
            ffp_pixel_layers_backward(head->dgathered, grad, head, &layers, count, draw, model);
        }
        draw = head->dgathered;
    }
    scatter_features(dmap, head, first, count, draw);
}
