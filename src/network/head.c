#include "network/head.h"

#include <string.h>
#include "tensor/tensor.h"

#define BLOCK_TOKENS 128

// The widths that both passes need.
typedef struct Widths {
    int dim, pixels, features, channels, joined, hidden, numbers;
} Widths;

static Widths head_widths(const FfpModelConfig *c) {
    const int numbers = ffp_head_numbers(c), channels = ffp_input_channels(c);
    const int features = c->pixel_skip ? c->pixel_features : numbers;
    return (Widths){.dim = c->dim,
                    .pixels = c->patch * c->patch,
                    .features = features,
                    .channels = channels,
                    .joined = features + channels,
                    .hidden = c->pixel_hidden,
                    .numbers = numbers};
}

int ffp_head_block_rows(int across) {
    return across < BLOCK_TOKENS ? BLOCK_TOKENS / across : 1;
}

void ffp_head_allocate(FfpHead *head, const FfpModelConfig *config, int across, FfpArena *arena) {
    const Widths w = head_widths(config);
    const size_t tokens = (size_t)ffp_head_block_rows(across) * across, pixels = tokens * w.pixels;
    head->slot = ffp_arena_alloc(arena, tokens, sizeof *head->slot);
    head->used = ffp_arena_alloc(arena, tokens, sizeof *head->used);
    head->tokens = ffp_arena_alloc(arena, tokens * w.dim, sizeof(real));
    head->features = ffp_arena_alloc(arena, pixels * w.features, sizeof(real));
    if (!config->pixel_skip) return;
    head->joined = ffp_arena_alloc(arena, pixels * w.joined, sizeof(real));
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        head->hidden[i] = ffp_arena_alloc(arena, pixels * w.hidden, sizeof(real));
        head->activated[i] = ffp_arena_alloc(arena, pixels * w.hidden, sizeof(real));
    }
}

void ffp_head_allocate_backward(FfpHead *head, const FfpModelConfig *config, int across, FfpArena *arena) {
    const Widths w = head_widths(config);
    const size_t tokens = (size_t)ffp_head_block_rows(across) * across, pixels = tokens * w.pixels;
    head->dtokens = ffp_arena_alloc(arena, tokens * w.dim, sizeof(real));
    head->dfeatures = ffp_arena_alloc(arena, pixels * w.features, sizeof(real));
    head->draw = ffp_arena_alloc(arena, pixels * w.numbers, sizeof(real));
    if (!config->pixel_skip) return;
    head->djoined = ffp_arena_alloc(arena, pixels * w.features, sizeof(real));
    head->dhidden = ffp_arena_alloc(arena, pixels * w.hidden, sizeof(real));
    head->dactivated = ffp_arena_alloc(arena, pixels * w.hidden, sizeof(real));
}

// The tokens that have a Gaussian, one after another; returns how many.
static int gather_tokens(FfpHead *head, const FfpHeadBlock *block, const real *tokens, const Widths *w) {
    int count = 0;
    for (int i = 0; i < block->tokens; i++) head->slot[i] = -1;
    for (int64_t g = block->first; g < block->first + block->count; g++) {
        const int i = (int)(head->place[g] / w->pixels) - block->first_token;
        if (head->slot[i] >= 0) continue;
        head->slot[i] = count;
        head->used[count++] = i;
    }
    for (int i = 0; i < count; i++)
        memcpy(head->tokens + (size_t)i * w->dim,
               tokens + (size_t)(block->first_token + head->used[i]) * w->dim,
               (size_t)w->dim * sizeof *tokens);
    return count;
}

// Offset of a Gaussian's numbers in [gathered tokens, patch^2, features].
static size_t feature_offset(const FfpHead *head, const FfpHeadBlock *block, int64_t g, const Widths *w) {
    const int64_t place = head->place[g];
    const int slot = head->slot[place / w->pixels - block->first_token];
    return ((size_t)slot * w->pixels + (size_t)(place % w->pixels)) * w->features;
}

// What a pixel takes from its token, beside its own inputs (`joined` columns), or alone.
static void gather_pixels(real *out, int columns, const FfpHead *head, const FfpHeadBlock *block,
                          const Widths *w) {
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < block->count; i++) {
        const int64_t g = block->first + i;
        real *row = out + i * columns;
        memcpy(row, head->features + feature_offset(head, block, g, w), (size_t)w->features * sizeof *row);
        if (columns > w->features)
            memcpy(row + w->features, head->inputs + head->place[g] * w->channels,
                   (size_t)w->channels * sizeof *row);
    }
}

// Everything up to the last layer's input; returns the number of gathered tokens.
static int forward_features(FfpHead *head, const FfpHeadBlock *block, const real *tokens,
                            const FfpModel *model, const Widths *w) {
    const FfpLayout *at = model->layout;
    const real *values = model->values;
    const int count = gather_tokens(head, block, tokens, w), pixels = (int)block->count;
    const bool skip = model->config.pixel_skip;
    ffp_linear_forward(head->features, head->tokens, values + (skip ? at->features : at->head),
                       skip ? NULL : values + at->head_bias, count, w->dim, w->pixels * w->features);
    if (!skip) return count;
    gather_pixels(head->joined, w->joined, head, block, w);
    const real *x = head->joined;
    int in = w->joined;
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        ffp_linear_forward(head->hidden[i], x, values + at->hidden[i], values + at->hidden_bias[i], pixels,
                           in, w->hidden);
        ffp_gelu_forward(head->activated[i], head->hidden[i], (size_t)pixels * w->hidden);
        x = head->activated[i];
        in = w->hidden;
    }
    return count;
}

void ffp_head_forward(real *raw, FfpHead *head, const FfpHeadBlock *block, const real *tokens,
                      const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    const FfpLayout *at = model->layout;
    forward_features(head, block, tokens, model, &w);
    if (model->config.pixel_skip)
        ffp_linear_forward(raw, head->activated[FFP_HIDDEN_LAYERS - 1], model->values + at->last,
                           model->values + at->last_bias, (int)block->count, w.hidden, w.numbers);
    else
        gather_pixels(raw, w.numbers, head, block, &w);
}

// The pixel MLP's gradients; djoined gets the part that goes back to the token. A pixel's own inputs need
// none.
static void pixel_backward(real *grad, FfpHead *head, const FfpHeadBlock *block, const real *draw,
                           const FfpModel *model, const Widths *w) {
    const FfpLayout *at = model->layout;
    const real *values = model->values;
    const int pixels = (int)block->count, top = FFP_HIDDEN_LAYERS - 1;
    ffp_linear_backward(head->dactivated, grad + at->last, grad + at->last_bias, draw, head->activated[top],
                        values + at->last, pixels, w->hidden, w->numbers);
    for (int i = top; i >= 0; i--) {
        ffp_gelu_backward(head->dhidden, head->dactivated, head->hidden[i], (size_t)pixels * w->hidden);
        ffp_linear_backward(i ? head->dactivated : NULL, grad + at->hidden[i], grad + at->hidden_bias[i],
                            head->dhidden, i ? head->activated[i - 1] : head->joined, values + at->hidden[i],
                            pixels, i ? w->hidden : w->joined, w->hidden);
    }
    ffp_gemm_mixed(false, false, pixels, w->features, w->hidden, 1, head->dhidden, w->hidden,
                   values + at->hidden[0], w->joined, 0, head->djoined, w->features);
}

void ffp_head_backward(real *dtokens, real *grad, FfpHead *head, const FfpHeadBlock *block, const real *draw,
                       const real *tokens, const FfpModel *model) {
    const Widths w = head_widths(&model->config);
    const FfpLayout *at = model->layout;
    const bool skip = model->config.pixel_skip;
    const int count = forward_features(head, block, tokens, model, &w);
    if (skip) pixel_backward(grad, head, block, draw, model, &w);
    const real *dpixel = skip ? head->djoined : draw;
    memset(head->dfeatures, 0, (size_t)count * w.pixels * w.features * sizeof(real));
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < block->count; i++)
        memcpy(head->dfeatures + feature_offset(head, block, block->first + i, &w), dpixel + i * w.features,
               (size_t)w.features * sizeof(real));
    ffp_linear_backward(head->dtokens, grad + (skip ? at->features : at->head),
                        skip ? NULL : grad + at->head_bias, head->dfeatures, head->tokens,
                        model->values + (skip ? at->features : at->head), count, w.dim,
                        w.pixels * w.features);
    for (int i = 0; i < count; i++)
        memcpy(dtokens + (size_t)(block->first_token + head->used[i]) * w.dim,
               head->dtokens + (size_t)i * w.dim, (size_t)w.dim * sizeof *dtokens);
}
