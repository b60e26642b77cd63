#include "engine/network/mixer.h"
#include <string.h>
#include "core/tensor/tensor.h"
#include "engine/network/head.h"

enum { TAPS = 9 };

static real *take(FfpArena *arena, const FfpMixer *m, int columns) {
    return ffp_arena_take(arena, (size_t)m->rows * (size_t)columns, sizeof(real));
}

void ffp_mixer_allocate(FfpMixer *mixer, const FfpModelConfig *config, int rows, int across, int down,
                        FfpArena *arena) {
    *mixer = (FfpMixer){.rows = rows, .across = across, .down = down, .dim = config->dim};
    mixer->columns = take(arena, mixer, TAPS * config->dim);
    mixer->hidden = take(arena, mixer, config->dim);
    mixer->activated = take(arena, mixer, config->dim);
    mixer->out = take(arena, mixer, config->dim);
    mixer->features = ffp_arena_take(arena, ffp_head_features_count(config, rows), sizeof(real));
    mixer->raw =
        ffp_arena_take(arena, (size_t)ffp_head_block() * (size_t)ffp_head_numbers(config), sizeof(real));
}

void ffp_mixer_allocate_backward(FfpMixer *mixer, const FfpModelConfig *config, FfpArena *arena) {
    mixer->dcolumns = take(arena, mixer, TAPS * config->dim);
    mixer->dhidden = take(arena, mixer, config->dim);
    mixer->dout = take(arena, mixer, config->dim);
    mixer->dfeatures = ffp_arena_take(arena, ffp_head_features_count(config, mixer->rows), sizeof(real));
    mixer->draw =
        ffp_arena_take(arena, (size_t)ffp_head_block() * (size_t)ffp_head_numbers(config), sizeof(real));
}

// The token that a tap of another one sees; -1 outside the view's picture.
static int64_t neighbour(const FfpMixer *m, int64_t token, int tap) {
    const int64_t x = token % m->across + tap % 3 - 1, y = token / m->across % m->down + tap / 3 - 1;
    if (x < 0 || x >= m->across || y < 0 || y >= m->down) return -1;
    return token + (tap / 3 - 1) * (int64_t)m->across + tap % 3 - 1;
}

static void gather(const FfpMixer *m, const real *x) {
    const size_t dim = (size_t)m->dim;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < m->rows; i++)
        for (int tap = 0; tap < TAPS; tap++) {
            const int64_t from = neighbour(m, i, tap);
            real *to = m->columns + ((size_t)i * TAPS + (size_t)tap) * dim;
            if (from < 0)
                memset(to, 0, dim * sizeof *to);
            else
                memcpy(to, x + (size_t)from * dim, dim * sizeof *to);
        }
}

// ADDS to dx: of each token, what the taps that see it give back.
static void scatter(const FfpMixer *m, real *dx) {
    const size_t dim = (size_t)m->dim;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < m->rows; i++)
        for (int tap = 0; tap < TAPS; tap++) {
            const int64_t seen_by = neighbour(m, i, TAPS - 1 - tap);
            if (seen_by < 0) continue;
            const real *from = m->dcolumns + ((size_t)seen_by * TAPS + (size_t)tap) * dim;
            for (size_t k = 0; k < dim; k++) dx[(size_t)i * dim + k] += from[k];
        }
}

void ffp_mixer_forward(FfpMixer *m, const real *tokens, const FfpModel *model) {
    const FfpLayout *at = model->layout;
    const real *values = model->values;
    gather(m, tokens);
    ffp_linear_forward(m->hidden, m->columns, values + at->mixer[0], values + at->mixer_bias[0], m->rows,
                       TAPS * m->dim, m->dim);
    ffp_gelu_forward(m->activated, m->hidden, (size_t)m->rows * (size_t)m->dim);
    gather(m, m->activated);
    ffp_linear_forward(m->out, m->columns, values + at->mixer[1], values + at->mixer_bias[1], m->rows,
                       TAPS * m->dim, m->dim);
}

void ffp_mixer_backward(FfpMixer *m, real *dtokens, real *grad, const real *tokens, const FfpModel *model) {
    const FfpLayout *at = model->layout;
    const real *values = model->values;
    const size_t size = (size_t)m->rows * (size_t)m->dim;
    gather(m, m->activated);
    ffp_linear_backward(m->dcolumns, grad + at->mixer[1], grad + at->mixer_bias[1], m->dout, m->columns,
                        values + at->mixer[1], m->rows, TAPS * m->dim, m->dim);
    memset(m->dout, 0, size * sizeof *m->dout);
    scatter(m, m->dout);
    ffp_gelu_backward(m->dhidden, m->dout, m->hidden, size);
    gather(m, tokens);
    ffp_linear_backward(m->dcolumns, grad + at->mixer[0], grad + at->mixer_bias[0], m->dhidden, m->columns,
                        values + at->mixer[0], m->rows, TAPS * m->dim, m->dim);
    scatter(m, dtokens);
}

void ffp_mixer_concatenate(real *raw, const real *mixed, int64_t count, int numbers) {
    const int first = numbers - FFP_APPEARANCE_NUMBERS;
    for (int64_t i = 0; i < count; i++)
        memcpy(raw + i * numbers + first, mixed + i * numbers + first, FFP_APPEARANCE_NUMBERS * sizeof *raw);
}

void ffp_mixer_split(real *draw, real *dmixed, int64_t count, int numbers) {
    const int first = numbers - FFP_APPEARANCE_NUMBERS;
    memset(dmixed, 0, (size_t)count * (size_t)numbers * sizeof *dmixed);
    ffp_mixer_concatenate(dmixed, draw, count, numbers);
    for (int64_t i = 0; i < count; i++)
        memset(draw + i * numbers + first, 0, FFP_APPEARANCE_NUMBERS * sizeof *draw);
}
