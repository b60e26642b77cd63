// The parameter table: names, shapes, offsets, first values.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/rng.h"
#include "engine/network/inputs.h"
#include "engine/network/layout.h"
#include "engine/network/look.h"
#include "engine/network/splat.h"

#define LINEAR_DEVIATION 0.02F      // as in GPT (Radford et al. 2018, Sec. 4.1)
#define PLAIN_HEAD_DEVIATION 0.002F // near zero: a plain model starts at its formulas' own defaults

FfpWidths ffp_widths(const FfpModelConfig *config) {
    const int inner = 2 * config->dim, heads = inner / FFP_HEAD_DIM;
    return (FfpWidths){.dim = config->dim,
                       .inner = inner,
                       .state = config->state,
                       .chunk = config->chunk,
                       .convolved = inner + 2 * config->state,
                       .projected = 2 * inner + 2 * config->state + heads,
                       .scan_heads = heads,
                       .attention_heads = config->dim / FFP_HEAD_DIM};
}

int ffp_input_channels(const FfpModelConfig *config) {
    return FFP_PLAIN_CHANNELS + (config->match_input ? FFP_INITIALISATION_CHANNELS : 0);
}

int ffp_head_numbers(const FfpModelConfig *config) {
    return config->residual ? FFP_RESIDUAL_NUMBERS : FFP_PLAIN_NUMBERS;
}

// Appends a parameter of one (columns 0) or two dimensions; returns its offset.
static int64_t add(FfpModel *model, const char *prefix, const char *name, int64_t rows, int64_t columns,
                   FfpInit init, double scale) {
    FfpParameter *p = &model->parameters[model->n_parameters++];
    snprintf(p->name, sizeof p->name, "%s%s", prefix, name);
    p->rank = columns ? 2 : 1;
    p->shape[0] = rows;
    p->shape[1] = columns;
    p->count = columns ? rows * columns : rows;
    p->offset = model->count;
    p->decay = columns != 0;
    p->init = init;
    p->init_scale = (float)scale;
    model->count += p->count;
    return p->offset;
}

// Mamba2 block (Dao & Gu 2024, Sec. 7.1), bidirectional with one in_proj and one out_proj.
static void add_mamba(FfpModel *model, FfpMambaLayout *at, const char *prefix, double residual) {
    const FfpWidths w = ffp_widths(&model->config);
    at->norm = add(model, prefix, "norm", w.dim, 0, FFP_INIT_ONE, 0);
    at->in_proj = add(model, prefix, "in_proj", w.projected, w.dim, FFP_INIT_NORMAL, LINEAR_DEVIATION);
    for (int i = 0; i < 2; i++) {
        char inside[48];
        snprintf(inside, sizeof inside, "%s%s.", prefix, i ? "reverse" : "forward");
        const double bound = 1 / sqrt((double)FFP_CONV_TAPS);
        at->direction[i].conv =
            add(model, inside, "conv", w.convolved, FFP_CONV_TAPS, FFP_INIT_UNIFORM, bound);
        at->direction[i].conv_bias = add(model, inside, "conv_bias", w.convolved, 0, FFP_INIT_UNIFORM, bound);
        at->direction[i].dt_bias = add(model, inside, "dt_bias", w.scan_heads, 0, FFP_INIT_DT_BIAS, 0);
        at->direction[i].a_log = add(model, inside, "a_log", w.scan_heads, 0, FFP_INIT_A_LOG, 0);
        at->direction[i].d = add(model, inside, "d", w.scan_heads, 0, FFP_INIT_ONE, 0);
        at->direction[i].norm = add(model, inside, "norm", w.inner, 0, FFP_INIT_ONE, 0);
    }
    at->out_proj = add(model, prefix, "out_proj", w.dim, w.inner, FFP_INIT_NORMAL, residual);
}

static void add_transformer(FfpModel *model, FfpTransformerLayout *at, const char *prefix, double residual) {
    const int dim = model->config.dim, wide = FFP_MLP_RATIO * dim;
    at->norm1 = add(model, prefix, "norm1", dim, 0, FFP_INIT_ONE, 0);
    at->qkv = add(model, prefix, "qkv", 3 * dim, dim, FFP_INIT_NORMAL, LINEAR_DEVIATION);
    at->q_gain = add(model, prefix, "q_gain", FFP_HEAD_DIM, 0, FFP_INIT_ONE, 0);
    at->k_gain = add(model, prefix, "k_gain", FFP_HEAD_DIM, 0, FFP_INIT_ONE, 0);
    at->proj = add(model, prefix, "proj", dim, dim, FFP_INIT_NORMAL, residual);
    at->norm2 = add(model, prefix, "norm2", dim, 0, FFP_INIT_ONE, 0);
    at->fc1 = add(model, prefix, "fc1", wide, dim, FFP_INIT_NORMAL, LINEAR_DEVIATION);
    at->fc2 = add(model, prefix, "fc2", dim, wide, FFP_INIT_NORMAL, residual);
}

static void add_mixer(FfpModel *model, FfpLayout *at) {
    const int dim = model->config.dim, in = 9 * dim;
    for (int i = 0; i < 2; i++) {
        char prefix[32];
        snprintf(prefix, sizeof prefix, "appearance.conv.%d.", i);
        at->mixer[i] = add(model, prefix, "weight", dim, in, FFP_INIT_NORMAL, 1 / sqrt((double)in));
        at->mixer_bias[i] = add(model, prefix, "bias", dim, 0, FFP_INIT_ZERO, 0);
    }
}

// Layers from a token's features and a pixel's own inputs, and `more` numbers (NULL: none), to the raw ones.
static void add_pixel_layers(FfpModel *model, FfpPixelLayout *at, const char *name, int width,
                             const char *more, int columns, FfpInit init) {
    const FfpModelConfig *c = &model->config;
    int in = c->pixel_features + ffp_input_channels(c);
    char prefix[32];
    at->width = width;
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        snprintf(prefix, sizeof prefix, "%s.hidden.%d.", name, i);
        at->hidden[i] = add(model, prefix, "weight", width, in, FFP_INIT_NORMAL, 1 / sqrt((double)in));
        at->hidden_bias[i] = add(model, prefix, "bias", width, 0, FFP_INIT_ZERO, 0);
        in = width;
    }
    snprintf(prefix, sizeof prefix, "%s.", name);
    if (more) at->more = add(model, prefix, more, width, columns, init, 1 / sqrt((double)columns));
    snprintf(prefix, sizeof prefix, "%s.last.", name);
    at->last = add(model, prefix, "weight", ffp_head_numbers(c), in, FFP_INIT_ZERO, 0);
    at->last_bias = add(model, prefix, "bias", ffp_head_numbers(c), 0, FFP_INIT_ZERO, 0);
}

// The pixel MLP's layers are narrow: their deviation is 1 / sqrt(fan in), since 0.02 would let nothing
// through. Its last layer, and the token head of the residual form, start at zero: then the classical
// initialisation comes out.
static void add_head(FfpModel *model, FfpLayout *at) {
    const FfpModelConfig *c = &model->config;
    const int pixels = c->patch * c->patch, numbers = ffp_head_numbers(c);
    if (!c->pixel_skip) {
        at->head = add(model, "head.", "weight", pixels * numbers, c->dim,
                       c->residual ? FFP_INIT_ZERO : FFP_INIT_NORMAL, PLAIN_HEAD_DEVIATION);
        at->head_bias = add(model, "head.", "bias", pixels * numbers, 0, FFP_INIT_ZERO, 0);
        return;
    }
    at->features = add(model, "pixel.", "features", pixels * c->pixel_features, c->dim, FFP_INIT_NORMAL,
                       1 / sqrt((double)c->dim));
    add_pixel_layers(model, &at->pixel, "pixel", c->pixel_hidden, c->context_inputs ? "context" : NULL,
                     FFP_CONTEXT_CHANNELS, FFP_INIT_ZERO);
    for (int i = 0; i < c->looks; i++) {
        char name[16];
        snprintf(name, sizeof name, "look.%d", i);
        add_pixel_layers(model, &at->look[i], name, c->look_hidden, "errors", FFP_LOOK_SEEN + numbers,
                         FFP_INIT_NORMAL);
    }
}

FfpModel *ffp_model_table(const FfpModelConfig *config, const char *where, FfpError *err) {
    if (!ffp_model_config_check(config, where, err)) return NULL;
    const size_t blocks = strlen(config->modules);
    FfpModel *model = ffp_alloc(1, sizeof *model);
    model->config = *config;
    model->parameters = ffp_alloc(16 + 8 * FFP_LOOKS_MAX + 16 * blocks, sizeof *model->parameters);
    model->layout = ffp_alloc(1, sizeof *model->layout);
    FfpLayout *at = model->layout;
    const int64_t in = (int64_t)config->patch * config->patch * ffp_input_channels(config);
    at->tokeniser = add(model, "tokeniser.", "weight", config->dim, in, FFP_INIT_NORMAL, LINEAR_DEVIATION);
    at->tokeniser_norm = add(model, "tokeniser.", "norm", config->dim, 0, FFP_INIT_ONE, 0);
    const double residual = LINEAR_DEVIATION / sqrt(2.0 * (double)blocks);
    for (size_t i = 0; i < blocks; i++) {
        char prefix[32];
        snprintf(prefix, sizeof prefix, "blocks.%zu.", i);
        if (config->modules[i] == 'M')
            add_mamba(model, &at->blocks[i].mamba, prefix, residual);
        else
            add_transformer(model, &at->blocks[i].transformer, prefix, residual);
    }
    at->final_norm = add(model, "final_", "norm", config->dim, 0, FFP_INIT_ONE, 0);
    if (config->appearance_cnn) add_mixer(model, at);
    add_head(model, at);
    return model;
}

// Inverse softplus of a step size: log(exp(dt) - 1) = dt + log(1 - exp(-dt)).
static double draw_dt_bias(FfpRng *rng) {
    const double low = log(1e-3), high = log(1e-1);
    const double dt = fmax(exp(low + (high - low) * (double)ffp_rng_uniform(rng)), 1e-4);
    return dt + log(-expm1(-dt));
}

static real draw(const FfpParameter *p, FfpRng *rng) {
    switch (p->init) {
    case FFP_INIT_ONE:
        return 1;
    case FFP_INIT_NORMAL:
        return (real)(p->init_scale * ffp_rng_normal(rng));
    case FFP_INIT_UNIFORM:
        return (real)ffp_rng_range(rng, -p->init_scale, p->init_scale);
    case FFP_INIT_DT_BIAS:
        return (real)draw_dt_bias(rng);
    case FFP_INIT_A_LOG:
        return (real)log((double)ffp_rng_range(rng, 1, 16));
    case FFP_INIT_ZERO:
        break;
    }
    return 0;
}

FfpModel *ffp_model_new(const FfpModelConfig *config, uint64_t seed, FfpError *err) {
    FfpModel *model = ffp_model_table(config, NULL, err);
    if (!model) return NULL;
    model->values = ffp_alloc((size_t)model->count, sizeof *model->values);
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        FfpRng rng =
            ffp_rng(seed, (uint64_t)i); // a stream each: a parameter's values do not hang on the others'
        for (int64_t k = 0; k < p->count; k++) model->values[p->offset + k] = draw(p, &rng);
    }
    return model;
}

static const FfpParameter *find(const FfpModel *model, const char *name) {
    for (int i = 0; i < model->n_parameters; i++)
        if (strcmp(model->parameters[i].name, name) == 0) return &model->parameters[i];
    return NULL;
}

void ffp_model_take_over(FfpModel *model, const FfpModel *from) {
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        const FfpParameter *q = find(from, p->name);
        if (q && q->rank == p->rank && memcmp(q->shape, p->shape, sizeof p->shape) == 0)
            memcpy(model->values + p->offset, from->values + q->offset,
                   (size_t)p->count * sizeof *model->values);
    }
}

void ffp_model_free(FfpModel *model) {
    if (!model) return;
    for (int i = 0; i < 2 * model->metadata_count; i++) ffp_free(model->metadata[i]);
    ffp_free(model->metadata);
    ffp_free(model->file);
    ffp_free(model->parameters);
    ffp_free(model->layout);
    ffp_free(model->values);
    ffp_free(model);
}
