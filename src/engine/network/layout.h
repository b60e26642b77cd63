// The place of each layer's parameters in FfpModel.values, and the widths that follow from a configuration.
#ifndef FFP_NETWORK_LAYOUT_H
#define FFP_NETWORK_LAYOUT_H

#include "engine/network/network.h"

#define FFP_HEAD_DIM 64 // of attention and of Mamba2 alike
#define FFP_CONV_TAPS 4
#define FFP_MLP_RATIO 4
#define FFP_HIDDEN_LAYERS 2 // of the pixel MLP
#define FFP_TOKENS_MAX 65536

// All fields are offsets. parameters.c gives their shapes.
typedef struct FfpPixelLayout { // of layers that each pixel passes through separately
    int width;                  // hidden units
    int64_t hidden[FFP_HIDDEN_LAYERS], hidden_bias[FFP_HIDDEN_LAYERS], last, last_bias;
    int64_t more; // of the first hidden layer: of the context's inputs, or of what a look shows; 0: none
} FfpPixelLayout;

typedef struct FfpMambaLayout {
    int64_t norm, in_proj, out_proj;
    struct {
        int64_t conv, conv_bias, dt_bias, a_log, d, norm;
    } direction[2]; // first to last token, last to first
} FfpMambaLayout;

typedef struct FfpTransformerLayout {
    int64_t norm1, qkv, q_gain, k_gain, proj, norm2, fc1, fc2;
} FfpTransformerLayout;

typedef union FfpBlockLayout {
    FfpMambaLayout mamba;
    FfpTransformerLayout transformer;
} FfpBlockLayout;

typedef struct FfpLayout {
    int64_t tokeniser, tokeniser_norm, final_norm;
    int64_t head, head_bias; // without pixel_skip
    int64_t features;        // with it
    FfpPixelLayout pixel, look[FFP_LOOKS_MAX];
    int64_t mixer[2], mixer_bias[2]; // with appearance_cnn
    FfpBlockLayout blocks[FFP_MODULES_MAX];
} FfpLayout;

// Token-wise widths. A projected Mamba2 row is z [inner] | x [inner] | B [state] | C [state] | dt [heads]; x,
// B and C pass the convolution together.
typedef struct FfpWidths {
    int dim, inner, state, chunk, convolved, projected;
    int scan_heads, attention_heads;
} FfpWidths;

FfpWidths ffp_widths(const FfpModelConfig *config);
int ffp_input_channels(const FfpModelConfig *config); // numbers a pixel: see inputs.h
int ffp_head_numbers(
    const FfpModelConfig *config); // numbers a Gaussian before the heads' formulas: see splat.h

#endif
