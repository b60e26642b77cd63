// Depthwise causal convolution with SiLU, in both directions. Rows are counted along the direction: i = 0 is
// the last row when reversed. A thread has one channel and a run of rows, over which it slides.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}
#include "engine/cuda/columns.h"
#include "engine/cuda/warp.h"

enum { CHANNELS = 128, RUN = 16, TAPS = 4 }; // a block's channels; rows of a run; the network's taps

// A thread's part of its channel. W, at least conv's taps, is a constant; taps that do not exist come first
// and have weight 0.
template <int W> struct Column {
    float weight[W], bias;
    float x[W]; // rows i - W + 1 to i
};

static __device__ inline size_t row_at(const FfpDepthwise *conv, int i) {
    return (size_t)(conv->reverse ? conv->rows - 1 - i : i);
}

static __device__ inline float x_at(const FfpDepthwise *conv, int i, int channel) {
    return i < 0 || i >= conv->rows ? 0 : conv->x[row_at(conv, i) * conv->ldx + channel];
}

template <int W> static __device__ inline void shift(float window[W], float next) {
    for (int k = 0; k + 1 < W; k++) window[k] = window[k + 1];
    window[W - 1] = next;
}

// Just before row i.
template <int W>
static __device__ inline Column<W> column_before(const FfpDepthwise *conv, int channel, int i) {
    Column<W> c;
    c.bias = conv->bias[channel];
    c.x[0] = 0;
    for (int k = 0; k < W; k++) {
        const int tap = k - (W - conv->taps);
        c.weight[k] = tap < 0 ? 0 : conv->w[(size_t)channel * conv->taps + tap];
    }
    for (int k = 1; k < W; k++) c.x[k] = k - (W - conv->taps) < 0 ? 0 : x_at(conv, i - W + k, channel);
    return c;
}

// Slides to row i: what goes into the SiLU.
template <int W>
static __device__ inline float slide(Column<W> *c, const FfpDepthwise *conv, int channel, int i) {
    shift<W>(c->x, x_at(conv, i, channel));
    float pre = c->bias;
    for (int k = 0; k < W; k++) pre += c->weight[k] * c->x[k];
    return pre;
}

template <int W> static __global__ void run_forward(float *y, FfpDepthwise conv) {
    const int channel = (int)(blockIdx.x * CHANNELS + threadIdx.x), first = (int)blockIdx.y * RUN;
    if (channel >= conv.channels) return;
    Column<W> c = column_before<W>(&conv, channel, first);
    for (int i = first; i < min(first + RUN, conv.rows); i++) {
        const float pre = slide<W>(&c, &conv, channel, i);
        y[row_at(&conv, i) * conv.channels + channel] = pre * ffp_logistic(pre);
    }
}

// Row j gives its share dpre to the rows j - W + 1 to j: the gradient of row i is complete at j = i + W - 1.
// The thread adds to its own run of dx; dw and dbias of the run go to partial [runs, channels * taps +
// channels].
template <int W>
static __global__ void run_backward(FfpDepthwiseGradient grad, float *partial, const float *dy,
                                    FfpDepthwise conv) {
    const int channel = (int)(blockIdx.x * CHANNELS + threadIdx.x), first = (int)blockIdx.y * RUN;
    if (channel >= conv.channels) return;
    const int end = min(first + RUN, conv.rows);
    Column<W> c = column_before<W>(&conv, channel, first);
    float dw[W] = {0}, dbias = 0, dpre[W] = {0}; // dpre: of rows j - W + 1 to j
    for (int j = first; j < end + W - 1; j++) {
        float d = 0;
        if (j < conv.rows) {
            const float pre = slide<W>(&c, &conv, channel, j), s = ffp_logistic(pre);
            d = dy[row_at(&conv, j) * conv.channels + channel] * s * (1 + pre * (1 - s));
        }
        shift<W>(dpre, d);
        if (j < end) {
            dbias += d;
            for (int k = 0; k < W; k++) dw[k] += d * c.x[k];
        }
        const int i = j - W + 1;
        if (i < first) continue;
        float sum = 0;
        for (int k = 0; k < W; k++) sum += c.weight[k] * dpre[W - 1 - k];
        grad.x[row_at(&conv, i) * grad.ldx + channel] += sum;
    }
    partial += (size_t)blockIdx.y * conv.channels * (conv.taps + 1);
    for (int k = 0; k < W; k++)
        if (k >= W - conv.taps) partial[(size_t)channel * conv.taps + k - (W - conv.taps)] = dw[k];
    partial[(size_t)conv.channels * conv.taps + channel] = dbias;
}

void ffp_cuda_conv_forward(float *y, const FfpDepthwise *conv) {
    const dim3 grid(ffp_blocks((size_t)conv->channels, CHANNELS), ffp_blocks((size_t)conv->rows, RUN));
    ffp_launch(conv->taps <= TAPS ? run_forward<TAPS> : run_forward<FFP_CONV_TAPS_MAX>, grid, dim3(CHANNELS),
               y, *conv);
}

void ffp_cuda_conv_backward(const FfpDepthwiseGradient *grad, const FfpDepthwise *conv, const float *dy) {
    const int channels = conv->channels, taps = conv->taps;
    const dim3 grid(ffp_blocks((size_t)channels, CHANNELS), ffp_blocks((size_t)conv->rows, RUN));
    float *partial = ffp_cuda_column_partials((size_t)grid.y * channels * (taps + 1));
    ffp_launch(taps <= TAPS ? run_backward<TAPS> : run_backward<FFP_CONV_TAPS_MAX>, grid, dim3(CHANNELS),
               *grad, partial, dy, *conv);
    ffp_cuda_add_columns(partial, (int)grid.y, grad->w, channels * taps, grad->bias, channels);
}
