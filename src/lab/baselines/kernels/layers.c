// Small fully connected networks on many points at once, forward and backward.
#include <tgmath.h>
#include "engine/render/kernels/lanes.h"
#include "lab/baselines/kernels/kernels.h"

enum { ROWS = 4, COLUMNS = 4 }; // of a block of results: rows, and vectors of points
_Static_assert(FFP_FIELD_BLOCK % (COLUMNS * LANES) == 0, "blocks of columns are whole");

// A matrix of weights as it lies, or on its side: element (o, i) at o * row + i * column.
typedef struct Weights {
    const real *at;
    const real *biases; // NULL: none
    int outputs, inputs;
    int64_t row, column;
    bool relu, add; // the results are added to what is there
} Weights;

// `rows` rows of results from o on, COLUMNS vectors of points from `from` on.
ALWAYS_INLINE void product_block(const Weights *w, int o, int rows, const real *in, real *out, int64_t stride,
                                 int64_t from) {
    Lanes sum[ROWS][COLUMNS];
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < COLUMNS; c++) sum[r][c] = lanes_all(w->biases ? w->biases[o + r] : 0);
    for (int i = 0; i < w->inputs; i++) {
        const Lanes *x = (const Lanes *)(in + i * stride + from);
        for (int r = 0; r < rows; r++) {
            const real weight = w->at[(o + r) * w->row + i * w->column];
            for (int c = 0; c < COLUMNS; c++) sum[r][c] += weight * x[c];
        }
    }
    for (int r = 0; r < rows; r++) {
        Lanes *y = (Lanes *)(out + (o + r) * stride + from);
        for (int c = 0; c < COLUMNS; c++) {
            if (w->relu) sum[r][c] = lanes_keep(sum[r][c], sum[r][c] > 0);
            y[c] = w->add ? y[c] + sum[r][c] : sum[r][c];
        }
    }
}

static void product(const Weights *w, const real *in, real *out, int64_t stride, int64_t from) {
    int o = 0;
    for (; o + ROWS <= w->outputs; o += ROWS) product_block(w, o, ROWS, in, out, stride, from);
    for (; o < w->outputs; o++) product_block(w, o, 1, in, out, stride, from);
}

static const real *input_of(const FfpNetRows *rows, int layer) {
    return layer ? rows->hidden[layer - 1] : rows->in;
}

// All layers of a few points, then the next ones: what lies between stays near.
void FFP_K(field_forward)(const FfpFieldNet *net, const real *parameters, const FfpNetRows *rows) {
    for (int64_t from = 0; from < rows->columns; from += (int64_t)COLUMNS * LANES)
        for (int i = 0; i < net->count; i++) {
            const FfpFieldLayer *layer = &net->layers[i];
            const Weights w = {.at = parameters + layer->weights,
                               .biases = parameters + layer->biases,
                               .outputs = layer->outputs,
                               .inputs = layer->inputs,
                               .row = layer->inputs,
                               .column = 1,
                               .relu = layer->relu};
            product(&w, input_of(rows, i), i + 1 < net->count ? rows->hidden[i] : rows->out, rows->stride,
                    from);
        }
}

static real sum_lanes(Lanes v) {
    real sum = 0;
    for (int l = 0; l < LANES; l++) sum += v[l];
    return sum;
}

// The gradient of a layer's weights, to which d out in^T is added.
typedef struct WeightsGradient {
    const real *d_out, *in; // [outputs or inputs, stride]
    int64_t stride, columns;
    int inputs;
    real *at; // [outputs, inputs]
} WeightsGradient;

// Rows o.., columns i.. of it.
ALWAYS_INLINE void weights_block(const WeightsGradient *g, int o, int rows, int i, int wide) {
    const real *d_out = g->d_out, *in = g->in;
    const int64_t stride = g->stride;
    Lanes sum[ROWS][COLUMNS];
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < wide; c++) sum[r][c] = (Lanes){0};
    for (int64_t p = 0; p < g->columns; p += LANES) {
        Lanes x[COLUMNS];
        for (int c = 0; c < wide; c++) x[c] = *(const Lanes *)(in + (i + c) * stride + p);
        for (int r = 0; r < rows; r++) {
            const Lanes d = *(const Lanes *)(d_out + (o + r) * stride + p);
            for (int c = 0; c < wide; c++) sum[r][c] += d * x[c];
        }
    }
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < wide; c++) g->at[(int64_t)(o + r) * g->inputs + i + c] += sum_lanes(sum[r][c]);
}

static void weights_rows(const WeightsGradient *g, int o, int rows) {
    int i = 0;
    if (rows == ROWS)
        for (; i + COLUMNS <= g->inputs; i += COLUMNS) weights_block(g, o, ROWS, i, COLUMNS);
    for (; i < g->inputs; i++)
        for (int r = 0; r < rows; r++) weights_block(g, o + r, 1, i, 1);
}

static void weights_backward(const FfpFieldLayer *layer, const real *d_out, const real *in, int64_t stride,
                             int64_t columns, real *grad) {
    const WeightsGradient g = {d_out, in, stride, columns, layer->inputs, grad + layer->weights};
    for (int o = 0; o < layer->outputs; o += ROWS)
        weights_rows(&g, o, layer->outputs - o < ROWS ? layer->outputs - o : ROWS);
    for (int o = 0; o < layer->outputs; o++) {
        Lanes sum = {0};
        for (int64_t p = 0; p < columns; p += LANES) sum += *(const Lanes *)(d_out + o * stride + p);
        grad[layer->biases + o] += sum_lanes(sum);
    }
}

// 0 where the ReLU's output is.
static void mask(real *d, const real *out, int width, int64_t stride, int64_t from) {
    for (int o = 0; o < width; o++)
        for (int c = 0; c < COLUMNS; c++) {
            Lanes *x = (Lanes *)(d + o * stride + from) + c;
            *x = lanes_keep(*x, ((const Lanes *)(out + o * stride + from))[c] > 0);
        }
}

void FFP_K(field_backward)(const FfpFieldNet *net, const real *parameters, const FfpNetRows *rows,
                           const real *d_out, int d_rows, bool add, real *d_in, real *const scratch[2],
                           real *grad) {
    const real *d = d_out;
    for (int i = net->count - 1; i >= 0; i--) {
        const FfpFieldLayer *layer = &net->layers[i];
        real *below = i ? scratch[i & 1] : d_in;
        const Weights w = {.at = parameters + layer->weights,
                           .outputs = i ? layer->inputs : d_rows,
                           .inputs = layer->outputs,
                           .row = 1,
                           .column = layer->inputs,
                           .add = !i && add};
        for (int64_t from = 0; from < rows->columns; from += (int64_t)COLUMNS * LANES) {
            product(&w, d, below, rows->stride, from);
            if (i) mask(below, rows->hidden[i - 1], layer->inputs, rows->stride, from);
        }
        weights_backward(layer, d, input_of(rows, i), rows->stride, rows->columns, grad);
        d = below;
    }
}

const FfpFieldKernels FFP_K(field) = {.encode = FFP_K(field_encode),
                                      .scatter = FFP_K(field_scatter),
                                      .forward = FFP_K(field_forward),
                                      .backward = FFP_K(field_backward)};
