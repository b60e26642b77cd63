// One pass of the network over one capture, forward and backward.
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/integer.h"
#include "core/tensor/tensor.h"
#include "engine/network/blocks.h"
#include "engine/network/inputs.h"
#include "engine/network/look.h"
#include "engine/network/mixer.h"
#include "engine/network/pixels.h"

typedef union FfpBlockActivations {
    FfpMambaActivations mamba;
    FfpTransformerActivations transformer;
} FfpBlockActivations;

// Token-wise memory depends on the configuration and the number of tokens alone: it stays from pass to pass,
// in an arena of its own, while run->arena is emptied for every capture.
typedef struct FfpActivations {
    FfpArena *arena;
    bool backward;                  // one may follow: every block keeps what it needs for that
    bool recompute;                 // or only its input: then blocks of a kind share what they need
    int held[2];                    // whose activations that is: of Mamba2, of Transformer; recompute only
    FfpModelConfig config;          // what the memory is laid out for; rows 0: nothing yet
    int rows, across, down, blocks; // tokens; tokens across and down a view
    FfpWidths widths;
    real *inputs;                           // [T, patch^2 channels]
    real *tokens, *token_mean, *token_rstd; // before the tokeniser's norm, [T, dim], [T]
    real *stream[FFP_MODULES_MAX];          // [T, dim] input of each block, and the last one's output
    FfpBlockActivations block[FFP_MODULES_MAX];
    real *final, *final_mean, *final_rstd;
    FfpScratch scratch;
    real *dstream, *dfinal; // [T, dim]; NULL before the first backward pass
    FfpHead head;
    real *features, *dfeatures; // maps of the head
    real *draw;                 // [block, numbers], backward only
    FfpMixer mixer;             // with appearance_cnn
    FfpPixels pixels;
    FfpLookPhotographs *photographs; // with looks, on the CPU; on a device they are in head.prepared
    FfpViewPass *pass;               // with looks
    real *seen[FFP_LOOKS_MAX];       // inputs of each look: of all Gaussians, or of one block where no
                                     // backward pass follows
    FfpPixelContext context;         // where the caller gave none
    FfpPrepared *prepared;           // on a device, of captures that the caller did not prepare
    FfpProfileTimes unread;          // where the times go when nobody asks
} FfpActivations;

FfpRun *ffp_run_new(bool backward) {
    FfpRun *run = ffp_alloc(1, sizeof *run);
    run->arena = ffp_arena_new();
    run->activations = ffp_alloc(1, sizeof *run->activations);
    run->activations->arena = ffp_arena_new();
    run->activations->backward = backward;
    run->looks = FFP_LOOKS_MAX;
    return run;
}

void ffp_run_free(FfpRun *run) {
    if (!run) return;
    ffp_pixel_context_free(&run->activations->context);
    ffp_prepared_free(run->activations->prepared);
    ffp_look_photographs_free(run->activations->photographs);
    ffp_view_pass_free(run->activations->pass);
    ffp_arena_free(run->activations->arena);
    ffp_free(run->activations);
    ffp_arena_free(run->arena);
    ffp_free(run);
}

size_t ffp_run_memory(const FfpRun *run) {
    return ffp_arena_high_water(run->arena) + ffp_arena_high_water(run->activations->arena);
}

static bool same_layout(const FfpModelConfig *a, const FfpModelConfig *b) {
    return strcmp(a->modules, b->modules) == 0 && a->dim == b->dim && a->patch == b->patch &&
           a->state == b->state && a->chunk == b->chunk && a->residual == b->residual &&
           a->match_input == b->match_input && a->pixel_skip == b->pixel_skip &&
           a->pixel_features == b->pixel_features && a->pixel_hidden == b->pixel_hidden &&
           a->appearance_cnn == b->appearance_cnn && a->looks == b->looks && a->look_hidden == b->look_hidden;
}

static real *take(FfpActivations *at, size_t columns) {
    return ffp_arena_take(at->arena, (size_t)at->rows * columns, sizeof(real));
}

static bool first_of_kind(const char *modules, int block) {
    return strchr(modules, modules[block]) == modules + block;
}

// A block of its own memory; without a backward pass to come, or with one that computes it again, the memory
// of the first block of its kind.
static void allocate_block(FfpActivations *at, int block) {
    const char *modules = at->config.modules;
    if ((!at->backward || at->recompute) && !first_of_kind(modules, block)) {
        at->block[block] = at->block[strchr(modules, modules[block]) - modules];
        return;
    }
    if (modules[block] == 'M')
        ffp_mamba_allocate(&at->block[block].mamba, &at->widths, at->rows, at->backward, at->arena);
    else
        ffp_transformer_allocate(&at->block[block].transformer, &at->widths, at->rows, at->arena);
}

static void prepare(FfpActivations *at, const FfpModelConfig *config, bool recompute, int rows, int across,
                    int down) {
    if (at->rows == rows && at->across == across && at->down == down && at->recompute == recompute &&
        same_layout(&at->config, config))
        return;
    FfpArena *arena = at->arena;
    ffp_arena_reset(arena);
    *at = (FfpActivations){.arena = arena,
                           .backward = at->backward,
                           .recompute = recompute,
                           .context = at->context,
                           .prepared = at->prepared,
                           .photographs = at->photographs,
                           .pass = at->pass,
                           .config = *config,
                           .rows = rows,
                           .across = across,
                           .down = down,
                           .blocks = (int)strlen(config->modules),
                           .widths = ffp_widths(config)};
    const size_t dim = (size_t)config->dim;
    if (!ffp_device())
        at->inputs = take(at, (size_t)config->patch * config->patch * ffp_input_channels(config));
    at->tokens = take(at, dim);
    at->token_mean = take(at, 1);
    at->token_rstd = take(at, 1);
    for (int i = 0; i <= at->blocks; i++)
        at->stream[i] = at->backward || i < 2 ? take(at, dim) : at->stream[i - 2];
    for (int i = 0; i < at->blocks; i++) allocate_block(at, i);
    at->final = take(at, dim);
    at->final_mean = take(at, 1);
    at->final_rstd = take(at, 1);
    at->scratch.inner = take(at, (size_t)at->widths.inner);
    at->scratch.kernel = ffp_arena_take(arena, ffp_kernel_scratch(&at->widths, rows), sizeof(real));
    ffp_head_allocate(&at->head, config, rows, arena);
    at->features = ffp_arena_take(arena, ffp_head_features_count(config, rows), sizeof(real));
    if (config->appearance_cnn) ffp_mixer_allocate(&at->mixer, config, rows, across, down, arena);
}

static void prepare_backward(FfpActivations *at) {
    if (at->dstream) return;
    const size_t dim = (size_t)at->config.dim, mlp = FFP_MLP_RATIO * dim;
    const size_t wide = (size_t)at->widths.projected > mlp ? (size_t)at->widths.projected : mlp;
    at->scratch.dwide = take(at, wide);
    at->scratch.dwide2 = take(at, wide);
    at->scratch.dinner = take(at, (size_t)at->widths.inner);
    at->scratch.dnarrow = take(at, dim);
    at->scratch.dnarrow2 = take(at, dim);
    at->dfinal = take(at, dim);
    at->dstream = take(at, dim);
    ffp_head_allocate_backward(&at->head, &at->config, at->rows, at->arena);
    at->dfeatures = ffp_arena_take(at->arena, ffp_head_features_count(&at->config, at->rows), sizeof(real));
    at->draw =
        ffp_arena_take(at->arena, (size_t)ffp_head_block() * ffp_head_numbers(&at->config), sizeof(real));
    if (at->config.appearance_cnn) ffp_mixer_allocate_backward(&at->mixer, &at->config, at->arena);
}

static FfpBlockPass block_pass(const FfpActivations *at, const FfpModel *model, FfpProfileTimes *times) {
    return (FfpBlockPass){model->values, &at->widths, at->rows, &at->scratch, times};
}

static void block_forward(FfpActivations *at, const FfpModel *model, int i, FfpProfileTimes *times) {
    const bool mamba = at->config.modules[i] == 'M';
    const FfpBlockPass pass = block_pass(at, model, times);
    const FfpBlockLayout *layout = &model->layout->blocks[i];
    at->held[!mamba] = i;
    if (mamba)
        ffp_mamba_forward(at->stream[i + 1], &at->block[i].mamba, at->stream[i], &layout->mamba, &pass);
    else
        ffp_transformer_forward(at->stream[i + 1], &at->block[i].transformer, at->stream[i],
                                &layout->transformer, &pass);
}

static void encode(FfpActivations *at, const FfpModel *model, FfpProfileTimes *times) {
    const FfpLayout *layout = model->layout;
    const int rows = at->rows, dim = at->widths.dim;
    const int in = at->config.patch * at->config.patch * ffp_input_channels(&at->config);
    double last = ffp_seconds();
    ffp_linear_forward(at->tokens, at->inputs, model->values + layout->tokeniser, NULL, rows, in, dim);
    ffp_layernorm_forward(at->stream[0], at->token_mean, at->token_rstd, at->tokens,
                          model->values + layout->tokeniser_norm, rows, dim);
    ffp_lap(&last, &times->tokenise);
    for (int i = 0; i < at->blocks; i++) {
        ffp_cancel_point();
        block_forward(at, model, i, times);
    }
    last = ffp_seconds();
    ffp_layernorm_forward(at->final, at->final_mean, at->final_rstd, at->stream[at->blocks],
                          model->values + layout->final_norm, rows, dim);
    ffp_lap(&last, &times->heads);
}

// Gaussians of the block that begins at `first`.
static int block_count(const FfpActivations *at, int64_t first) {
    const int64_t left = at->pixels.count - first, block = ffp_head_block();
    return (int)(left < block ? left : block);
}

// Raw numbers of all Gaussians.
static void head_forward(FfpActivations *at, const FfpModel *model) {
    const int numbers = ffp_head_numbers(&model->config);
    const bool mixed = model->config.appearance_cnn;
    ffp_head_select(&at->head, at->rows);
    ffp_head_features(at->features, &at->head, at->final, model);
    if (mixed) {
        ffp_mixer_forward(&at->mixer, at->final, model);
        ffp_head_features(at->mixer.features, &at->head, at->mixer.out, model);
    }
    for (int64_t first = 0; first < at->pixels.count; first += ffp_head_block()) {
        const int count = block_count(at, first);
        ffp_cancel_point();
        real *raw = at->pixels.raw + first * numbers;
        ffp_head_forward(raw, &at->head, first, count, at->features, model);
        if (!mixed) continue;
        ffp_head_forward(at->mixer.raw, &at->head, first, count, at->mixer.features, model);
        ffp_mixer_concatenate(raw, at->mixer.raw, count, numbers);
    }
}

// From the Gaussians' gradients to those of the tokens, at->dfinal.
static void head_backward(FfpActivations *at, real *grad_values, const FfpModel *model,
                          const FfpGaussians *grad, const real *grad_t) {
    const int numbers = ffp_head_numbers(&model->config);
    const bool mixed = model->config.appearance_cnn;
    const size_t size = (size_t)at->rows * at->widths.dim * sizeof(real),
                 map = ffp_head_features_count(&model->config, at->head.n_used) * sizeof(real);
    ffp_memory_zero(at->dfinal, size); // tokens that no Gaussian needs get no gradient
    ffp_memory_zero(at->dfeatures, map);
    if (mixed) {
        ffp_memory_zero(at->mixer.dout, size);
        ffp_memory_zero(at->mixer.dfeatures, map);
    }
    for (int64_t first = 0; first < at->pixels.count; first += ffp_head_block()) {
        const int count = block_count(at, first);
        ffp_pixels_splat_backward(at->draw, &at->pixels, first, count, &model->config, grad, grad_t);
        if (mixed) {
            ffp_mixer_split(at->draw, at->mixer.draw, count, numbers);
            ffp_head_backward(at->mixer.dfeatures, grad_values, &at->head, first, count, at->mixer.draw,
                              at->mixer.features, at->seen, model);
        }
        ffp_head_backward(at->dfeatures, grad_values, &at->head, first, count, at->draw, at->features,
                          at->seen, model);
    }
    if (at->head.looks_only) return;
    ffp_head_features_backward(at->dfinal, grad_values, &at->head, at->dfeatures, at->final, model);
    if (!mixed) return;
    ffp_head_features_backward(at->mixer.dout, grad_values, &at->head, at->mixer.dfeatures, at->mixer.out,
                               model);
    ffp_mixer_backward(&at->mixer, at->dfinal, grad_values, at->final, model);
}

// The caller's context, or one made for this pass; NULL with an error.
static const FfpPixelContext *use_context(FfpActivations *at, const FfpModelConfig *config,
                                          const FfpInputSource *source, const FfpPixelContext *given,
                                          FfpError *err) {
    ffp_pixel_context_free(&at->context);
    if (given) return given;
    return ffp_pixel_context_new(&at->context, config, source->capture, source->start, &source->active, 1,
                                 err)
               ? &at->context
               : NULL;
}

static FfpProfileTimes *forward_times(FfpRun *run) {
    return run->profile ? &run->profile->forward : &run->activations->unread;
}

// The input views are drawn with the run's Gaussians, whose raw numbers are corrected by what is wrong there.
static void look(FfpRun *run, const FfpModel *model, int round) {
    FfpActivations *at = run->activations;
    const FfpModelConfig *config = &model->config;
    const FfpPrepared *prepared = at->head.prepared;
    const FfpLookPhotographs *p = prepared ? prepared->photographs : at->photographs;
    const int numbers = ffp_head_numbers(config), width = FFP_LOOK_SEEN + numbers;
    const size_t area = (size_t)p->width * (size_t)p->height;
    real *maps = ffp_arena_take(run->arena, (size_t)p->views * area * FFP_LOOK_NUMBERS, sizeof *maps);
    const int64_t kept = at->backward ? at->pixels.count : block_count(at, 0);
    at->seen[round] = ffp_arena_take(run->arena, (size_t)(kept + 1) * (size_t)width, sizeof(real));
    if (!at->pass) {
        const FfpRenderSettings render =
            ffp_render_settings(ffp_model_is_paper_form(config), config->samples);
        at->pass = ffp_view_pass_new(&render);
    }
    ffp_look(maps, at->pass, &run->gaussians, p);
    const FfpLookInputs looked = {ffp_look_maps(p, maps), prepared ? prepared->pixel_there : run->pixel,
                                  run->gaussians.centre, at->pixels.raw, numbers};
    for (int64_t first = 0; first < at->pixels.count; first += ffp_head_block()) {
        const int count = block_count(at, first);
        real *seen = at->seen[round] + (at->backward ? first * width : 0);
        ffp_cancel_point();
        ffp_look_gather(seen, &looked, first, count);
        ffp_head_correct(at->pixels.raw + first * numbers, &at->head, first, count, at->features, seen, round,
                         model);
    }
}

// From the tokens' inputs and the list of pixels, which exist, to the Gaussians.
static bool pass_forward(FfpRun *run, const FfpModel *model, const char *name, FfpError *err) {
    FfpActivations *at = run->activations;
    FfpProfileTimes *times = forward_times(run);
    encode(at, model, times);
    double last = ffp_seconds();
    at->head.count = at->pixels.count;
    at->head.looks = ffp_smaller(run->looks, model->config.looks);
    head_forward(at, model);
    bool ok = ffp_pixels_splat(&at->pixels, run, &model->config);
    for (int i = 0; ok && i < at->head.looks; i++) {
        look(run, model, i);
        ok = ffp_pixels_splat(&at->pixels, run, &model->config);
    }
    ffp_lap(&last, &times->heads);
    return ok || ffp_fail(err, FFP_ERROR_FILE, name, "the model's output overflows");
}

bool ffp_model_forward_prepared(const FfpModel *model, FfpRun *run, const FfpPrepared *prepared,
                                FfpError *err) {
    FfpActivations *at = run->activations;
    const FfpModelConfig *config = &model->config;
    ffp_arena_reset(run->arena);
    prepare(at, config, run->recompute, prepared->tokens, prepared->across, prepared->down);
    at->inputs = prepared->inputs;
    at->pixels.count = prepared->count;
    at->pixels.base = prepared->base;
    at->pixels.raw =
        ffp_arena_take(run->arena, (size_t)(prepared->count + 1) * ffp_head_numbers(config), sizeof(real));
    run->pixel = prepared->pixel;
    at->head.prepared = prepared;
    return pass_forward(run, model, "the capture", err);
}

static bool prepare_there(FfpActivations *at, const FfpModelConfig *config, const FfpCapture *capture,
                          const FfpInitialisation *start, const FfpPixelContext *context, int active,
                          FfpError *err) {
    ffp_prepared_free(at->prepared);
    at->prepared = NULL;
    const FfpDevice *device = ffp_device_use(NULL);
    FfpPrepared *here = ffp_prepared_new(config, capture, start, context, active, err);
    ffp_device_use(device);
    if (!here) return false;
    at->prepared = ffp_prepared_uploaded(here);
    ffp_device_use(NULL);
    ffp_prepared_free(here);
    ffp_device_use(device);
    return true;
}

bool ffp_model_forward(const FfpModel *model, FfpRun *run, const FfpCapture *capture,
                       const FfpInitialisation *start, const FfpPixelContext *context, int active,
                       FfpError *err) {
    FfpActivations *at = run->activations;
    FfpModelConfig taken = model->config; // without the looks that are left out
    taken.looks = ffp_smaller(run->looks, taken.looks);
    const FfpModelConfig *config = &taken;
    run->gaussians = (FfpGaussians){0};
    if (ffp_device())
        return prepare_there(at, config, capture, start, context, active, err) &&
               ffp_model_forward_prepared(model, run, at->prepared, err);
    const FfpInputSource source = {capture, start, start ? start->views : capture->n_views, active};
    ffp_arena_reset(run->arena);
    if (!ffp_inputs_check(config, &source, err)) return false;
    double last = ffp_seconds();
    context = use_context(at, config, &source, context, err);
    if (!context) return false;
    const FfpGrid grid = ffp_grid(config, capture, context);
    prepare(at, config, run->recompute, source.views * grid.across * grid.down, grid.across, grid.down);
    const FfpInputSource small = {&context->capture, start ? &context->start : NULL, source.views, active};
    ffp_inputs(at->inputs, config, &small);
    ffp_pixels_list(&at->pixels, run, config, &source);
    at->head.source = source;
    at->head.grid = grid;
    at->head.context = start ? &context->start : NULL;
    at->head.pixel = run->pixel;
    ffp_look_photographs_free(at->photographs);
    at->photographs = config->looks ? ffp_look_photographs_new(capture, source.views, active) : NULL;
    ffp_lap(&last, &forward_times(run)->tokenise);
    return pass_forward(run, model, capture->name, err);
}

// ADDS to grad_values; at->dstream: in, the gradient of the block's output; out, of its input.
static void block_backward(FfpActivations *at, const FfpModel *model, int i, real *grad_values,
                           FfpProfileTimes *times) {
    const bool mamba = at->config.modules[i] == 'M';
    if (at->recompute && at->held[!mamba] != i) block_forward(at, model, i, times);
    const FfpBlockPass pass = block_pass(at, model, times);
    const FfpBlockLayout *layout = &model->layout->blocks[i];
    if (mamba)
        ffp_mamba_backward(at->dstream, grad_values, &at->block[i].mamba, at->stream[i], &layout->mamba,
                           &pass);
    else
        ffp_transformer_backward(at->dstream, grad_values, &at->block[i].transformer, at->stream[i],
                                 &layout->transformer, &pass);
}

// Parameters lie in the order in which the forward pass comes to them (parameters.c): the backward pass
// completes their gradients from the end.
static void tell_ready(const FfpRun *run, int64_t first) {
    if (run->ready) run->ready(run->ready_user, first);
}

static int64_t first_of_block(const FfpModel *model, int i) {
    return model->config.modules[i] == 'M' ? model->layout->blocks[i].mamba.norm
                                           : model->layout->blocks[i].transformer.norm1;
}

void ffp_model_backward(const FfpModel *model, FfpRun *run, const FfpGaussians *grad, const real *grad_t,
                        real *grad_values) {
    FfpActivations *at = run->activations;
    const FfpLayout *layout = model->layout;
    const int rows = at->rows, dim = at->widths.dim;
    prepare_backward(at);
    FfpProfileTimes *times = run->profile ? &run->profile->backward : &at->unread;
    double last = ffp_seconds();
    at->head.looks_only = run->looks_only;
    head_backward(at, grad_values, model, grad, grad_t);
    if (run->looks_only) {
        tell_ready(run, 0);
        return;
    }
    ffp_layernorm_backward(at->dstream, grad_values + layout->final_norm, at->dfinal, at->stream[at->blocks],
                           at->final_mean, at->final_rstd, model->values + layout->final_norm, rows, dim);
    ffp_lap(&last, &times->heads);
    tell_ready(run, layout->final_norm);
    for (int i = at->blocks - 1; i >= 0; i--) {
        block_backward(at, model, i, grad_values, times);
        tell_ready(run, first_of_block(model, i));
    }
    last = ffp_seconds();
    ffp_layernorm_backward(at->dfinal, grad_values + layout->tokeniser_norm, at->dstream, at->tokens,
                           at->token_mean, at->token_rstd, model->values + layout->tokeniser_norm, rows, dim);
    ffp_linear_backward(NULL, grad_values + layout->tokeniser, NULL, at->dfinal, at->inputs,
                        model->values + layout->tokeniser, rows,
                        at->config.patch * at->config.patch * ffp_input_channels(&at->config), dim);
    ffp_lap(&last, &times->tokenise);
    tell_ready(run, 0);
}
