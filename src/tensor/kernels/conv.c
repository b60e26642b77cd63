// Depthwise causal convolution with SiLU (Mamba2; network.md 3.1), forwards or backwards along the tokens.
#include "tensor/kernels/kernels.h"

#include "tensor/kernels/fastmath.h"

enum { ROWS = 32, CHANNELS = 64 }; // a block of rows and channels lives on the stack: 8 KB in fp32

typedef struct Conv {
    const real *x, *w, *bias;
    int ldx, rows, channels, taps;
    bool reverse;
} Conv;

typedef struct Block {
    int row, rows, channel, channels; // first and count
} Block;

static Block block_at(const Conv *conv, int row, int channel) {
    const int rows = conv->rows - row, channels = conv->channels - channel;
    return (Block){row, rows < ROWS ? rows : ROWS, channel, channels < CHANNELS ? channels : CHANNELS};
}

// The row of x that tap k of output row t reads, or -1 before the start (behind the end when reversed).
static int source_row(const Conv *conv, int t, int k) {
    const int back = conv->taps - 1 - k;
    const int row = conv->reverse ? t + back : t - back;
    return row < conv->rows ? row : -1;
}

static void tap_weights(real weights[CHANNELS], const Conv *conv, const Block *block, int k) {
    for (int c = 0; c < block->channels; c++)
        weights[c] = conv->w[(size_t)(block->channel + c) * conv->taps + k];
}

// pre = bias + sum over taps, before the SiLU
static void convolve(real pre[ROWS][CHANNELS], const Conv *conv, const Block *block) {
    for (int r = 0; r < block->rows; r++)
        for (int c = 0; c < block->channels; c++) pre[r][c] = conv->bias[block->channel + c];
    for (int k = 0; k < conv->taps; k++) {
        real weights[CHANNELS];
        tap_weights(weights, conv, block, k);
        for (int r = 0; r < block->rows; r++) {
            const int source = source_row(conv, block->row + r, k);
            if (source < 0) continue;
            const real *x = conv->x + (size_t)source * conv->ldx + block->channel;
            for (int c = 0; c < block->channels; c++) pre[r][c] += weights[c] * x[c];
        }
    }
}

void FFP_K(conv_forward)(real *y, const real *x, int ldx, const real *w, const real *bias, int rows,
                         int channels, int taps, bool reverse) {
    const Conv conv = {x, w, bias, ldx, rows, channels, taps, reverse};
#pragma omp parallel for collapse(2) schedule(static)
    for (int row = 0; row < rows; row += ROWS) {
        for (int channel = 0; channel < channels; channel += CHANNELS) {
            const Block block = block_at(&conv, row, channel);
            real pre[ROWS][CHANNELS];
            convolve(pre, &conv, &block);
            for (int r = 0; r < block.rows; r++) {
                real *y_row = y + (size_t)(row + r) * channels + channel;
#pragma omp simd
                for (int c = 0; c < block.channels; c++) y_row[c] = pre[r][c] * ffp_sigmoid(pre[r][c]);
            }
        }
    }
}

// pre becomes the gradient before the SiLU: dpre = dy s (1 + pre (1 - s)), s = sigmoid(pre)
static void silu_backward(real pre[ROWS][CHANNELS], const real *dy, const Conv *conv, const Block *block) {
    for (int r = 0; r < block->rows; r++) {
        const real *dy_row = dy + (size_t)(block->row + r) * conv->channels + block->channel;
#pragma omp simd
        for (int c = 0; c < block->channels; c++) {
            const real s = ffp_sigmoid(pre[r][c]);
            pre[r][c] = dy_row[c] * s * (1 + pre[r][c] * (1 - s));
        }
    }
}

// What one tap of a block gives to dx and dw.
static void tap_backward(real *dx, int lddx, real *dw, const real dpre[ROWS][CHANNELS], const Conv *conv,
                         const Block *block, int k) {
    real weights[CHANNELS], sum[CHANNELS] = {0};
    tap_weights(weights, conv, block, k);
    for (int r = 0; r < block->rows; r++) {
        const int source = source_row(conv, block->row + r, k);
        if (source < 0) continue;
        const real *x = conv->x + (size_t)source * conv->ldx + block->channel;
        real *dx_row = dx + (size_t)source * lddx + block->channel;
#pragma omp simd
        for (int c = 0; c < block->channels; c++) {
            dx_row[c] += weights[c] * dpre[r][c];
            sum[c] += dpre[r][c] * x[c];
        }
    }
    for (int c = 0; c < block->channels; c++) dw[(size_t)(block->channel + c) * conv->taps + k] += sum[c];
}

// Neighbouring rows share rows of dx, so a thread owns whole columns: no two write the same place.
void FFP_K(conv_backward)(real *dx, int lddx, real *dw, real *dbias, const real *dy, const real *x, int ldx,
                          const real *w, const real *bias, int rows, int channels, int taps, bool reverse) {
    const Conv conv = {x, w, bias, ldx, rows, channels, taps, reverse};
#pragma omp parallel for schedule(static)
    for (int channel = 0; channel < channels; channel += CHANNELS) {
        for (int row = 0; row < rows; row += ROWS) {
            const Block block = block_at(&conv, row, channel);
            real dpre[ROWS][CHANNELS];
            convolve(dpre, &conv, &block);
            silu_backward(dpre, dy, &conv, &block);
            for (int k = 0; k < taps; k++) tap_backward(dx, lddx, dw, dpre, &conv, &block, k);
            for (int r = 0; r < block.rows; r++)
                for (int c = 0; c < block.channels; c++) dbias[channel + c] += dpre[r][c];
        }
    }
}
