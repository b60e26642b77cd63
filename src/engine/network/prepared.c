#include "engine/network/prepared.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "engine/network/head.h"
#include "engine/network/inputs.h"
#include "engine/network/pixels.h"

typedef struct Source { // what is prepared from; the host's
    const FfpModelConfig *config;
    FfpInputSource source, small; // the capture and its context
    FfpGrid grid;
    const FfpInitialisation *context_initialisation; // NULL: none
} Source;

static void prepare_inputs(FfpPrepared *p, const Source *s) {
    const int patch = s->config->patch;
    const size_t width = (size_t)patch * patch * ffp_input_channels(s->config);
    p->inputs_count = (size_t)p->tokens * width;
    p->inputs = ffp_alloc(p->inputs_count, sizeof *p->inputs);
    ffp_inputs(p->inputs, s->config, &s->small);
}

static void prepare_pixels(FfpPrepared *p, const Source *s) {
    const size_t count = (size_t)p->count;
    p->base = ffp_alloc(count + 1, sizeof *p->base);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++)
        ffp_pixel_base(&p->base[g], &s->source, p->pixel[g], s->config->residual);
    if (!s->config->pixel_skip) return;
    p->channels = ffp_input_channels(s->config);
    p->own = ffp_alloc(count * (size_t)p->channels + 1, sizeof *p->own);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++)
        ffp_pixel_inputs(p->own + g * p->channels, s->config, &s->source, p->pixel[g]);
}

static void prepare_context_inputs(FfpPrepared *p, const Source *s) {
    p->has_context_inputs = ffp_head_has_context_inputs(s->config, &s->grid, s->context_initialisation);
    if (!p->has_context_inputs) return;
    p->context_inputs = ffp_alloc((size_t)p->count * FFP_CONTEXT_CHANNELS + 1, sizeof *p->context_inputs);
    ffp_head_context_inputs(p->context_inputs, p->pixel, p->count, &s->grid, s->source.start,
                            s->context_initialisation);
}

// The tokens in use get consecutive slots, in order: slot [tokens], -1 where unused.
static int32_t *number_slots(FfpPrepared *p, const Source *s) {
    const int pixels = s->config->patch * s->config->patch;
    int32_t *slot = ffp_alloc((size_t)p->tokens, sizeof *slot);
    p->used = ffp_alloc((size_t)p->tokens, sizeof *p->used);
    for (int i = 0; i < p->tokens; i++) slot[i] = -1;
    for (int64_t g = 0; g < p->count; g++) {
        const FfpTaps taps = ffp_grid_taps(&s->grid, p->pixel[g]);
        for (int i = 0; i < taps.count; i++) slot[taps.place[i] / pixels] = 0;
    }
    for (int i = 0; i < p->tokens; i++) {
        if (slot[i] < 0) continue;
        slot[i] = p->n_used;
        p->used[p->n_used++] = i;
    }
    return slot;
}

// The reverse of the rows: a counting sort, which keeps the order.
static void list_takers(FfpTapTable *t, int64_t entries) {
    int32_t *first = ffp_alloc((size_t)t->rows + 2, sizeof *first);
    t->taker = ffp_alloc((size_t)entries + 1, sizeof *t->taker);
    for (int64_t e = 0; e < entries; e++) first[t->row[e] + 2]++;
    for (int64_t r = 2; r < t->rows + 2; r++) first[r] += first[r - 1];
    for (int64_t e = 0; e < entries; e++) t->taker[first[t->row[e] + 1]++] = (int32_t)e;
    t->first = first;
}

static void prepare_taps(FfpPrepared *p, const Source *s) {
    const int pixels = s->config->patch * s->config->patch;
    FfpTapTable *t = &p->taps;
    int32_t *slot = number_slots(p, s);
    t->taps = s->grid.same ? 1 : 4;
    t->rows = (int64_t)p->n_used * pixels;
    const int64_t entries = p->count * t->taps;
    t->row = ffp_alloc((size_t)entries + 1, sizeof *t->row);
    t->weight = ffp_alloc((size_t)entries + 1, sizeof *t->weight);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++) {
        const FfpTaps taps = ffp_grid_taps(&s->grid, p->pixel[g]);
        for (int i = 0; i < t->taps; i++) {
            t->row[g * t->taps + i] =
                slot[taps.place[i] / pixels] * pixels + (int32_t)(taps.place[i] % pixels);
            t->weight[g * t->taps + i] = taps.weight[i];
        }
    }
    list_takers(t, entries);
    ffp_free(slot);
}

static bool check(const FfpModelConfig *config, const FfpInputSource *source, FfpError *err) {
    if (config->appearance_cnn)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, "appearance_cnn",
                        "this head runs inside the library, on the CPU, alone");
    return ffp_inputs_check(config, source, err);
}

FfpPrepared *ffp_prepared_new(const FfpModelConfig *config, const FfpCapture *capture,
                              const FfpInitialisation *start, const FfpPixelContext *context, int active,
                              FfpError *err) {
    const int views = start ? start->views : capture->n_views;
    const FfpInputSource source = {capture, start, views, active};
    FfpPixelContext own = {0};
    if (!check(config, &source, err)) return NULL;
    if (!context && !ffp_pixel_context_new(&own, config, capture, start, &active, 1, err)) return NULL;
    if (!context) context = &own;
    const FfpInitialisation *context_initialisation = start ? &context->start : NULL;
    const Source s = {config,
                      source,
                      {&context->capture, context_initialisation, views, active},
                      ffp_grid(config, capture, context),
                      context_initialisation};
    FfpPrepared *p = ffp_alloc(1, sizeof *p);
    p->across = s.grid.across;
    p->down = s.grid.down;
    p->tokens = views * s.grid.across * s.grid.down;
    const int64_t all = ffp_pixels_all(&source);
    p->pixel = ffp_alloc((size_t)all + 1, sizeof *p->pixel);
    p->count = ffp_pixels_select(p->pixel, config, &source);
    prepare_inputs(p, &s);
    prepare_pixels(p, &s);
    prepare_taps(p, &s);
    prepare_context_inputs(p, &s);
    p->config = *config;
    if (config->looks) p->photographs = ffp_look_photographs_new(capture, views, active);
    ffp_pixel_context_free(&own);
    return p;
}

FfpPrepared *ffp_prepared_uploaded(const FfpPrepared *p) {
    const size_t count = (size_t)p->count, entries = count * (size_t)p->taps.taps;
    FfpPrepared *there = ffp_alloc(1, sizeof *there);
    *there = *p;
    there->pixel = ffp_alloc(count + 1, sizeof *p->pixel);
    memcpy(there->pixel, p->pixel, count * sizeof *p->pixel);
    there->inputs = ffp_memory_uploaded(p->inputs, p->inputs_count, sizeof *p->inputs);
    there->base = ffp_memory_uploaded(p->base, count + 1, sizeof *p->base);
    there->used = ffp_memory_uploaded(p->used, (size_t)p->tokens, sizeof *p->used);
    there->taps.row = ffp_memory_uploaded(p->taps.row, entries + 1, sizeof *p->taps.row);
    there->taps.weight = ffp_memory_uploaded(p->taps.weight, entries + 1, sizeof *p->taps.weight);
    there->taps.first = ffp_memory_uploaded(p->taps.first, (size_t)p->taps.rows + 1, sizeof *p->taps.first);
    there->taps.taker = ffp_memory_uploaded(p->taps.taker, entries + 1, sizeof *p->taps.taker);
    there->own = ffp_memory_uploaded(p->own, count * (size_t)p->channels + 1, sizeof *p->own);
    there->photographs = ffp_look_photographs_uploaded(p->photographs);
    if (p->photographs) there->pixel_there = ffp_memory_uploaded(p->pixel, count + 1, sizeof *p->pixel);
    there->context_inputs =
        ffp_memory_uploaded(p->context_inputs, count * FFP_CONTEXT_CHANNELS + 1, sizeof *p->context_inputs);
    return there;
}

void ffp_prepared_free(FfpPrepared *p) {
    if (!p) return;
    void *const blocks[] = {p->inputs,     p->base,       p->used, p->taps.row,       p->taps.weight,
                            p->taps.first, p->taps.taker, p->own,  p->context_inputs, p->pixel_there};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) ffp_memory_free(blocks[i]);
    ffp_look_photographs_free(p->photographs);
    ffp_free(p->pixel);
    ffp_free(p);
}

int64_t ffp_prepared_count(const FfpPrepared *prepared) {
    return prepared->count;
}

const int64_t *ffp_prepared_pixels(const FfpPrepared *prepared) {
    return prepared->pixel;
}

FfpModel ffp_model_uploaded(const FfpModel *model) {
    FfpModel there = *model;
    there.values = ffp_memory_uploaded(model->values, (size_t)model->count, sizeof(real));
    return there;
}
