// The layers that each pixel passes through separately (pixel_skip), and the features of its context.
#include <tgmath.h>
#include "core/base/device.h"
#include "core/tensor/tensor.h"
#include "engine/network/head.h"

#define RATIO_TOLD_MAX                                                                                       \
    ((real)0.68)           // log2: what training shows (docs/lab/notebook/tokens.md); beyond it weights guess
#define REACH_FOOTPRINTS 4 // of the context: depth differences beyond count as this

bool ffp_head_has_context_inputs(const FfpModelConfig *config, const FfpGrid *grid,
                                 const FfpInitialisation *context) {
    return config->context_inputs && !grid->same && context;
}

void ffp_head_context_inputs(real *out, const int64_t *pixels, int64_t count, const FfpGrid *grid,
                             const FfpInitialisation *near, const FfpInitialisation *far) {
    const real ratio = sqrt((real)near->width * (real)near->height / ((real)far->width * (real)far->height));
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        const int64_t pixel = pixels[i];
        const FfpTaps taps = ffp_grid_taps(grid, pixel);
        real behind = near->t[pixel];
        for (int t = 0; t < taps.count; t++) behind -= taps.weight[t] * far->t[taps.pixel[t]];
        behind /= REACH_FOOTPRINTS * ratio * fmax(near->footprint[pixel], (real)1e-6);
        out[FFP_CONTEXT_CHANNELS * i] = fmin(log2(ratio), RATIO_TOLD_MAX);
        out[FFP_CONTEXT_CHANNELS * i + 1] = fmin(fmax(behind, -1), 1);
    }
}

static bool uses_context_inputs(const FfpHead *head, const FfpModelConfig *config) {
    return head->prepared ? head->prepared->has_context_inputs
                          : ffp_head_has_context_inputs(config, &head->grid, head->context);
}

// The inputs that tell the pixels of a block from their context, [count, context channels].
static const real *context_inputs_of(FfpHead *head, int64_t first, int count) {
    if (head->prepared) return head->prepared->context_inputs + FFP_CONTEXT_CHANNELS * first;
    ffp_head_context_inputs(head->context_inputs, head->pixel + first, count, &head->grid, head->source.start,
                            head->context);
    return head->context_inputs;
}

FfpPixelLayers ffp_pixel_layers(FfpHead *head, int64_t first, int count, const FfpModel *model) {
    const bool told = uses_context_inputs(head, &model->config);
    return (FfpPixelLayers){&model->layout->pixel, told ? context_inputs_of(head, first, count) : NULL,
                            FFP_CONTEXT_CHANNELS};
}

// hidden [count, width] += more weight^T, weight [width, columns]. A look's many inputs make a product; for
// the context's two a loop is faster.
static void add_more(real *hidden, const FfpPixelLayers *layers, const real *weight, int count, int width) {
    const int columns = layers->columns;
    if (columns != FFP_CONTEXT_CHANNELS) {
        ffp_gemm_mixed(1, ffp_factor(layers->more, count, columns, columns),
                       ffp_transposed(ffp_factor(weight, width, columns, columns)), 1, hidden, width);
        return;
    }
    if (ffp_device()) {
        ffp_device()->network->add_context_inputs(hidden, layers->more, weight, count, width, columns);
        return;
    }
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; i++)
        for (int k = 0; k < width; k++)
            for (int c = 0; c < columns; c++)
                hidden[(size_t)i * width + k] += layers->more[columns * i + c] * weight[columns * k + c];
}

// From head->gathered to the last layer's input.
static void hidden_forward(FfpHead *head, const FfpPixelLayers *layers, int count, const FfpModel *model) {
    const FfpPixelLayout *at = layers->at;
    const real *x = head->gathered;
    const int width = at->width;
    int in = head->widths.gathered;
    for (int i = 0; i < FFP_HIDDEN_LAYERS; i++) {
        ffp_linear_forward(head->hidden[i], x, model->values + at->hidden[i],
                           model->values + at->hidden_bias[i], count, in, width);
        if (i == 0 && layers->more) add_more(head->hidden[0], layers, model->values + at->more, count, width);
        ffp_gelu_forward(head->activated[i], head->hidden[i], (size_t)count * width);
        x = head->activated[i];
        in = width;
    }
}

void ffp_pixel_layers_forward(real *numbers, FfpHead *head, const FfpPixelLayers *layers, int count,
                              const FfpModel *model) {
    const FfpPixelLayout *at = layers->at;
    hidden_forward(head, layers, count, model);
    ffp_linear_forward(numbers, head->activated[FFP_HIDDEN_LAYERS - 1], model->values + at->last,
                       model->values + at->last_bias, count, at->width, head->widths.numbers);
}

void ffp_pixel_layers_backward(real *dfeatures, real *grad, FfpHead *head, const FfpPixelLayers *layers,
                               int count, const real *draw, const FfpModel *model) {
    const FfpHeadWidths *w = &head->widths;
    const FfpPixelLayout *at = layers->at;
    const real *values = model->values;
    const int top = FFP_HIDDEN_LAYERS - 1, width = at->width;
    hidden_forward(head, layers, count, model);
    ffp_linear_backward(head->dactivated, grad + at->last, grad + at->last_bias, draw, head->activated[top],
                        values + at->last, count, width, w->numbers);
    for (int i = top; i >= 0; i--) {
        ffp_gelu_backward(head->dhidden, head->dactivated, head->hidden[i], (size_t)count * width);
        ffp_linear_backward(i ? head->dactivated : NULL, grad + at->hidden[i], grad + at->hidden_bias[i],
                            head->dhidden, i ? head->activated[i - 1] : head->gathered,
                            values + at->hidden[i], count, i ? width : w->gathered, width);
    }
    const FfpFactor dhidden = ffp_factor(head->dhidden, count, width, width);
    if (layers->more)
        ffp_gemm(1, ffp_transposed(dhidden),
                 ffp_factor(layers->more, count, layers->columns, layers->columns), 1, grad + at->more,
                 layers->columns);
    ffp_gemm_mixed(1, dhidden, ffp_factor(values + at->hidden[0], width, w->features, w->gathered), 1,
                   dfeatures, w->features);
}
