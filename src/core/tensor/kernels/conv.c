// Depthwise causal convolution with SiLU (Mamba2: Dao & Gu 2024, Sec. 7.1), forwards or backwards along the
// tokens.
#include <string.h>
#include "core/base/integer.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/silu.h"

enum {
    ROWS = 128,     // of a block: a thread works along them, over all of a strip's channels
    CHANNELS = 512, // of a strip, whose weights stay in the cache
    COLUMNS = 64,   // of a strip of the backward pass
    TAPS = 4 // the network's; more are done as FFP_CONV_TAPS_MAX, those that do not exist with weight 0
};

// Some channels, their weights tap by tap.
typedef struct Strip {
    int channel, channels; // first and count
    real weights[FFP_CONV_TAPS_MAX][CHANNELS], bias[CHANNELS];
} Strip;

static void take_strip(Strip *strip, const FfpDepthwise *conv, int channel, int most) {
    strip->channel = channel;
    strip->channels = ffp_smaller(most, conv->channels - channel);
    for (int k = conv->taps; k < FFP_CONV_TAPS_MAX; k++)
        memset(strip->weights[k], 0, sizeof(real) * (size_t)strip->channels);
    for (int c = 0; c < strip->channels; c++) {
        strip->bias[c] = conv->bias[channel + c];
        for (int k = 0; k < conv->taps; k++)
            strip->weights[k][c] = conv->w[(size_t)(channel + c) * conv->taps + k];
    }
}

// The row of x that tap k of output row t reads, or -1: before the start, behind the end when reversed, or no
// such tap.
static inline int source_row(const FfpDepthwise *conv, int t, int k) {
    const int back = conv->taps - 1 - k;
    const int row = conv->reverse ? t + back : t - back;
    return k < conv->taps && row < conv->rows ? row : -1;
}

// The row that it reads of a strip; zeros where there is no row.
static inline const real *source(const FfpDepthwise *conv, const Strip *strip, int t, int k) {
    static const real zeros[CHANNELS];
    const int row = source_row(conv, t, k);
    return row < 0 ? zeros : conv->x + (size_t)row * conv->ldx + strip->channel;
}

// The `left` next channels of a row from c on, at most a vector's: the sum over the taps, then its SiLU.
// `taps`, at least conv's, is a constant, as is `left` where a whole vector is left.
static inline __attribute__((always_inline)) void forward_vector(real *y,
                                                                 const real *const x[FFP_CONV_TAPS_MAX],
                                                                 const Strip *strip, int c, int left,
                                                                 int taps) {
    FfpVector pre = ffp_load(strip->bias + c);
    FFP_UNROLL(8)
    for (int k = 0; k < taps; k++) pre += ffp_load(strip->weights[k] + c) * ffp_load_masked(x[k] + c, left);
    ffp_store_masked(y + c, ffp_silu_vector(pre), left);
}

// Row t of a strip.
static inline __attribute__((always_inline)) void forward_row(real *y, const FfpDepthwise *conv,
                                                              const Strip *strip, int t, int taps) {
    const real *x[FFP_CONV_TAPS_MAX];
    int c = 0;
    for (int k = 0; k < taps; k++) x[k] = source(conv, strip, t, k);
    for (; c + FFP_LANES <= strip->channels; c += FFP_LANES) forward_vector(y, x, strip, c, FFP_LANES, taps);
    if (c < strip->channels) forward_vector(y, x, strip, c, strip->channels - c, taps);
}

static void forward_block(real *y, const FfpDepthwise *conv, int row, int rows) {
    Strip strip;
    for (int channel = 0; channel < conv->channels; channel += CHANNELS) {
        take_strip(&strip, conv, channel, CHANNELS);
        for (int t = row; t < row + rows; t++) {
            real *y_row = y + (size_t)t * conv->channels + channel;
            if (conv->taps <= TAPS)
                forward_row(y_row, conv, &strip, t, TAPS);
            else
                forward_row(y_row, conv, &strip, t, FFP_CONV_TAPS_MAX);
        }
    }
}

void FFP_K(conv_forward)(real *y, const FfpDepthwise *conv) {
#pragma omp parallel for schedule(static)
    for (int row = 0; row < conv->rows; row += ROWS)
        forward_block(y, conv, row, ffp_smaller(ROWS, conv->rows - row));
}

typedef struct Sums {
    real weights[FFP_CONV_TAPS_MAX][COLUMNS], bias[COLUMNS];
} Sums;

// The operands of row t of a strip, read and added to.
typedef struct Row {
    const real *dy, *x[FFP_CONV_TAPS_MAX];
    real *dx[FFP_CONV_TAPS_MAX];
} Row;

// As forward_vector. With s = sigmoid(pre), the gradient before the SiLU is dpre = dy s (1 + pre (1 - s)).
static inline __attribute__((always_inline)) void
backward_vector(Sums *sums, const Row *row, const Strip *strip, int c, int left, int taps) {
    FfpVector pre = ffp_load(strip->bias + c), seen[FFP_CONV_TAPS_MAX];
    FFP_UNROLL(8)
    for (int k = 0; k < taps; k++) {
        seen[k] = ffp_load_masked(row->x[k] + c, left);
        pre += ffp_load(strip->weights[k] + c) * seen[k];
    }
    const FfpVector s = ffp_sigmoid_vector(pre);
    const FfpVector dpre = ffp_load_masked(row->dy + c, left) * s * (1 + pre * (1 - s));
    ffp_store(sums->bias + c, ffp_load(sums->bias + c) + dpre);
    FFP_UNROLL(8)
    for (int k = 0; k < taps; k++) {
        const FfpVector dx = ffp_load_masked(row->dx[k] + c, left) + ffp_load(strip->weights[k] + c) * dpre;
        ffp_store(sums->weights[k] + c, ffp_load(sums->weights[k] + c) + dpre * seen[k]);
        ffp_store_masked(row->dx[k] + c, dx, left);
    }
}

static inline __attribute__((always_inline)) void backward_row(const FfpDepthwiseGradient *grad, Sums *sums,
                                                               const real *dy, const FfpDepthwise *conv,
                                                               const Strip *strip, int t, int taps) {
    real nowhere[COLUMNS] = {0};
    Row row = {.dy = dy + (size_t)t * conv->channels + strip->channel};
    for (int k = 0; k < taps; k++) {
        const int from = source_row(conv, t, k);
        row.x[k] = source(conv, strip, t, k);
        row.dx[k] = from < 0 ? nowhere : grad->x + (size_t)from * grad->ldx + strip->channel;
    }
    int c = 0;
    for (; c + FFP_LANES <= strip->channels; c += FFP_LANES)
        backward_vector(sums, &row, strip, c, FFP_LANES, taps);
    if (c < strip->channels) backward_vector(sums, &row, strip, c, strip->channels - c, taps);
}

static void add_sums(const FfpDepthwiseGradient *grad, const Sums *sums, const FfpDepthwise *conv,
                     const Strip *strip) {
    for (int c = 0; c < strip->channels; c++) {
        grad->bias[strip->channel + c] += sums->bias[c];
        for (int k = 0; k < conv->taps; k++)
            grad->w[(size_t)(strip->channel + c) * conv->taps + k] += sums->weights[k][c];
    }
}

// Neighbouring rows share rows of dx, so a thread owns whole columns: no two write the same place.
void FFP_K(conv_backward)(const FfpDepthwiseGradient *grad, const FfpDepthwise *conv, const real *dy) {
#pragma omp parallel for schedule(static)
    for (int channel = 0; channel < conv->channels; channel += COLUMNS) {
        Strip strip;
        take_strip(&strip, conv, channel, COLUMNS);
        Sums sums = {0};
        for (int t = 0; t < conv->rows; t++) {
            if (conv->taps <= TAPS)
                backward_row(grad, &sums, dy, conv, &strip, t, TAPS);
            else
                backward_row(grad, &sums, dy, conv, &strip, t, FFP_CONV_TAPS_MAX);
        }
        add_sums(grad, &sums, conv, &strip);
    }
}
