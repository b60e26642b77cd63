// The pre-norm Transformer block: attention with QK-norm, GELU MLP x4, no biases.
#include "core/tensor/tensor.h"
#include "engine/network/blocks.h"

static FfpAttentionShape attention_shape(const FfpWidths *widths, int rows) {
    return (FfpAttentionShape){.rows = rows, .heads = widths->attention_heads, .head_dim = FFP_HEAD_DIM};
}

size_t ffp_kernel_scratch(const FfpWidths *widths, int rows) {
    const FfpScanShape shape = {.rows = rows,
                                .heads = widths->scan_heads,
                                .head_dim = FFP_HEAD_DIM,
                                .state = widths->state,
                                .chunk = widths->chunk};
    const FfpAttentionShape heads = attention_shape(widths, rows);
    const size_t scan = ffp_scan_scratch(&shape), attention = ffp_attention_scratch(&heads);
    return scan > attention ? scan : attention;
}

void ffp_transformer_allocate(FfpTransformerActivations *at, const FfpWidths *widths, int rows,
                              FfpArena *arena) {
    const size_t t = (size_t)rows, dim = (size_t)widths->dim;
    real **tokens[] = {&at->norm1, &at->attended, &at->middle, &at->norm2};
    real **numbers[] = {&at->mean1, &at->rstd1, &at->mean2, &at->rstd2};
    for (int i = 0; i < 4; i++) {
        *tokens[i] = ffp_arena_take(arena, t * dim, sizeof(real));
        *numbers[i] = ffp_arena_take(arena, t, sizeof(real));
    }
    at->qkv = ffp_arena_take(arena, t * dim * 3, sizeof(real));
    at->log_sum = ffp_arena_take(arena, t * (size_t)widths->attention_heads, sizeof(real));
    at->hidden = ffp_arena_take(arena, t * dim * FFP_MLP_RATIO, sizeof(real));
    at->activated = ffp_arena_take(arena, t * dim * FFP_MLP_RATIO, sizeof(real));
}

static FfpAttentionInput attention_input(const FfpTransformerActivations *at,
                                         const FfpTransformerLayout *layout, const FfpBlockPass *pass) {
    return (FfpAttentionInput){at->qkv, pass->values + layout->q_gain, pass->values + layout->k_gain};
}

void ffp_transformer_forward(real *y, FfpTransformerActivations *at, const real *x,
                             const FfpTransformerLayout *layout, const FfpBlockPass *pass) {
    const FfpScratch *scratch = pass->scratch;
    FfpProfileTimes *times = pass->times;
    const real *values = pass->values;
    const FfpAttentionShape shape = attention_shape(pass->widths, pass->rows);
    const int rows = pass->rows, dim = pass->widths->dim, wide = FFP_MLP_RATIO * dim;
    double last = ffp_seconds();
    ffp_layernorm_forward(at->norm1, at->mean1, at->rstd1, x, values + layout->norm1, rows, dim);
    ffp_lap(&last, &times->other);
    ffp_linear_forward(at->qkv, at->norm1, values + layout->qkv, NULL, rows, dim, 3 * dim);
    ffp_lap(&last, &times->products);
    const FfpAttentionInput in = attention_input(at, layout, pass);
    ffp_attention_forward(at->attended, at->log_sum, &shape, &in, scratch->kernel);
    ffp_lap(&last, &times->attention);
    ffp_linear_residual_forward(at->middle, x, at->attended, values + layout->proj, rows, dim, dim);
    ffp_lap(&last, &times->products);
    ffp_layernorm_forward(at->norm2, at->mean2, at->rstd2, at->middle, values + layout->norm2, rows, dim);
    ffp_lap(&last, &times->other);
    ffp_linear_forward(at->hidden, at->norm2, values + layout->fc1, NULL, rows, dim, wide);
    ffp_lap(&last, &times->products);
    ffp_gelu_forward(at->activated, at->hidden, (size_t)rows * wide);
    ffp_lap(&last, &times->other);
    ffp_linear_residual_forward(y, at->middle, at->activated, values + layout->fc2, rows, wide, dim);
    ffp_lap(&last, &times->products);
}

void ffp_transformer_backward(real *dx, real *grad, const FfpTransformerActivations *at, const real *x,
                              const FfpTransformerLayout *layout, const FfpBlockPass *pass) {
    const FfpScratch *scratch = pass->scratch;
    FfpProfileTimes *times = pass->times;
    const real *values = pass->values;
    const FfpAttentionShape shape = attention_shape(pass->widths, pass->rows);
    const int rows = pass->rows, dim = pass->widths->dim, wide = FFP_MLP_RATIO * dim;
    const size_t count = (size_t)rows * dim;
    real *dactivated = scratch->dwide, *dhidden = scratch->dwide2, *dqkv = scratch->dwide;
    real *dnorm = scratch->dnarrow, *dattended = scratch->dnarrow, *dresidual = scratch->dnarrow2;
    double last = ffp_seconds();
    ffp_linear_backward(dactivated, grad + layout->fc2, NULL, dx, at->activated, values + layout->fc2, rows,
                        wide, dim);
    ffp_lap(&last, &times->products);
    ffp_gelu_backward(dhidden, dactivated, at->hidden, (size_t)rows * wide);
    ffp_lap(&last, &times->other);
    ffp_linear_backward(dnorm, grad + layout->fc1, NULL, dhidden, at->norm2, values + layout->fc1, rows, dim,
                        wide);
    ffp_lap(&last, &times->products);
    ffp_layernorm_backward(dresidual, grad + layout->norm2, dnorm, at->middle, at->mean2, at->rstd2,
                           values + layout->norm2, rows, dim);
    ffp_add(dx, dresidual, count);
    ffp_lap(&last, &times->other);
    ffp_linear_backward(dattended, grad + layout->proj, NULL, dx, at->attended, values + layout->proj, rows,
                        dim, dim);
    ffp_lap(&last, &times->products);
    const FfpAttentionInput in = attention_input(at, layout, pass);
    const FfpAttentionGradient out = {dqkv, grad + layout->q_gain, grad + layout->k_gain};
    ffp_attention_backward(&out, &shape, &in, at->attended, at->log_sum, dattended, scratch->kernel);
    ffp_lap(&last, &times->attention);
    ffp_linear_backward(dnorm, grad + layout->qkv, NULL, dqkv, at->norm1, values + layout->qkv, rows, dim,
                        3 * dim);
    ffp_lap(&last, &times->products);
    ffp_layernorm_backward(dresidual, grad + layout->norm1, dnorm, x, at->mean1, at->rstd1,
                           values + layout->norm1, rows, dim);
    ffp_add(dx, dresidual, count);
    ffp_lap(&last, &times->other);
}
