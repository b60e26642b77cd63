#include "network/prepared.h"

#include <stdlib.h>
#include "base/arena.h"
#include "base/device.h"
#include "network/head.h"
#include "network/inputs.h"
#include "network/pixels.h"

typedef struct Source { // what is prepared from; the host's
    const FfpModelConfig *config;
    FfpSeen seen, small; // the capture and its context
    FfpGrid grid;
    const FfpStart *context_start; // NULL: none
} Source;

static void prepare_inputs(FfpPrepared *p, const Source *s) {
    const int patch = s->config->patch;
    const size_t width = (size_t)patch * patch * ffp_input_channels(s->config);
    real *inputs = ffp_alloc((size_t)p->tokens * width, sizeof *inputs);
    ffp_inputs(inputs, s->config, &s->small);
    p->inputs = ffp_memory_uploaded(inputs, (size_t)p->tokens * width, sizeof *inputs);
    free(inputs);
}

static void prepare_pixels(FfpPrepared *p, const Source *s) {
    const size_t count = (size_t)p->count;
    FfpPixelBase *base = ffp_alloc(count + 1, sizeof *base);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++)
        ffp_pixel_base(&base[g], &s->seen, p->pixel[g], s->config->residual);
    p->base = ffp_memory_uploaded(base, count + 1, sizeof *base);
    free(base);
    if (!s->config->pixel_skip) return;
    const int channels = ffp_input_channels(s->config);
    real *own = ffp_alloc(count * (size_t)channels + 1, sizeof *own);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++)
        ffp_pixel_inputs(own + g * channels, s->config, &s->seen, p->pixel[g]);
    p->own = ffp_memory_uploaded(own, count * (size_t)channels + 1, sizeof *own);
    free(own);
}

static void prepare_apart(FfpPrepared *p, const Source *s) {
    p->apart_told = ffp_head_has_apart(s->config, &s->grid, s->context_start);
    if (!p->apart_told) return;
    const size_t numbers = (size_t)p->count * FFP_CONTEXT_CHANNELS;
    real *apart = ffp_alloc(numbers + 1, sizeof *apart);
    ffp_head_tell_apart(apart, p->pixel, p->count, &s->grid, s->seen.start, s->context_start);
    p->apart = ffp_memory_uploaded(apart, numbers + 1, sizeof *apart);
    free(apart);
}

// The tokens in use get consecutive slots, in order: slot [tokens], -1 where unused.
static int32_t *number_slots(FfpPrepared *p, const Source *s) {
    const int pixels = s->config->patch * s->config->patch;
    int32_t *slot = ffp_alloc((size_t)p->tokens, sizeof *slot),
            *used = ffp_alloc((size_t)p->tokens, sizeof *used);
    for (int i = 0; i < p->tokens; i++) slot[i] = -1;
    for (int64_t g = 0; g < p->count; g++) {
        const FfpTaps taps = ffp_grid_taps(&s->grid, p->pixel[g]);
        for (int i = 0; i < taps.count; i++) slot[taps.place[i] / pixels] = 0;
    }
    for (int i = 0; i < p->tokens; i++) {
        if (slot[i] < 0) continue;
        slot[i] = p->n_used;
        used[p->n_used++] = i;
    }
    p->used = ffp_memory_uploaded(used, (size_t)p->tokens, sizeof *used);
    free(used);
    return slot;
}

// The reverse of row [entries]: a counting sort, which keeps the order.
static void upload_takers(FfpTapTable *t, const int32_t *row, int64_t entries) {
    int32_t *first = ffp_alloc((size_t)t->rows + 2, sizeof *first),
            *taker = ffp_alloc((size_t)entries + 1, sizeof *taker);
    for (int64_t e = 0; e < entries; e++) first[row[e] + 2]++;
    for (int64_t r = 2; r < t->rows + 2; r++) first[r] += first[r - 1];
    for (int64_t e = 0; e < entries; e++) taker[first[row[e] + 1]++] = (int32_t)e;
    t->first = ffp_memory_uploaded(first, (size_t)t->rows + 1, sizeof *first);
    t->taker = ffp_memory_uploaded(taker, (size_t)entries + 1, sizeof *taker);
    free(first);
    free(taker);
}

static void prepare_taps(FfpPrepared *p, const Source *s) {
    const int pixels = s->config->patch * s->config->patch;
    FfpTapTable *t = &p->taps;
    int32_t *slot = number_slots(p, s);
    t->taps = s->grid.same ? 1 : 4;
    t->rows = (int64_t)p->n_used * pixels;
    const int64_t entries = p->count * t->taps;
    int32_t *row = ffp_alloc((size_t)entries + 1, sizeof *row);
    real *weight = ffp_alloc((size_t)entries + 1, sizeof *weight);
#pragma omp parallel for schedule(static)
    for (int64_t g = 0; g < p->count; g++) {
        const FfpTaps taps = ffp_grid_taps(&s->grid, p->pixel[g]);
        for (int i = 0; i < t->taps; i++) {
            row[g * t->taps + i] = slot[taps.place[i] / pixels] * pixels + (int32_t)(taps.place[i] % pixels);
            weight[g * t->taps + i] = taps.weight[i];
        }
    }
    t->row = ffp_memory_uploaded(row, (size_t)entries + 1, sizeof *row);
    t->weight = ffp_memory_uploaded(weight, (size_t)entries + 1, sizeof *weight);
    upload_takers(t, row, entries);
    free(slot);
    free(row);
    free(weight);
}

static bool check(const FfpModelConfig *config, const FfpSeen *seen, FfpError *err) {
    if (config->appearance_cnn)
        return ffp_fail(err, "appearance_cnn", "this head is not on the device: use the CPU");
    return ffp_inputs_check(config, seen, err);
}

FfpPrepared *ffp_prepared_new(const FfpModelConfig *config, const FfpCapture *capture, const FfpStart *start,
                              const FfpContext *context, int active, FfpError *err) {
    const int views = start ? start->views : capture->n_views;
    const FfpSeen seen = {capture, start, views, active};
    FfpContext own = {0};
    if (!check(config, &seen, err)) return NULL;
    const FfpDevice *device = ffp_device_use(NULL); // a context is the CPU's
    const bool ok = context || ffp_context_new(&own, config, capture, start, active, err);
    ffp_device_use(device);
    if (!ok) return NULL;
    if (!context) context = &own;
    const FfpStart *context_start = start ? &context->start : NULL;
    const Source s = {config,
                      seen,
                      {&context->capture, context_start, views, active},
                      ffp_grid(config, capture, context),
                      context_start};
    FfpPrepared *p = ffp_alloc(1, sizeof *p);
    p->across = s.grid.across, p->down = s.grid.down;
    p->tokens = views * s.grid.across * s.grid.down;
    const int64_t all = ffp_pixels_all(&seen);
    p->pixel = ffp_alloc((size_t)all + 1, sizeof *p->pixel);
    p->count = ffp_pixels_select(p->pixel, config, &seen);
    prepare_inputs(p, &s);
    prepare_pixels(p, &s);
    prepare_taps(p, &s);
    prepare_apart(p, &s);
    ffp_device_use(NULL);
    ffp_context_free(&own);
    ffp_device_use(device);
    return p;
}

void ffp_prepared_free(FfpPrepared *p) {
    if (!p) return;
    void *const blocks[] = {p->inputs,     p->base,       p->used, p->taps.row, p->taps.weight,
                            p->taps.first, p->taps.taker, p->own,  p->apart};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) ffp_memory_free(blocks[i]);
    free(p->pixel);
    free(p);
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
