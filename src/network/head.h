// From the encoder's tokens to the raw numbers of each Gaussian, and back: a linear head a token, or the
// pixel MLP. Works in blocks of token rows, so that what a pixel needs stays small; a block's pixels are one
// run of Gaussians.
#ifndef FFP_NETWORK_HEAD_H
#define FFP_NETWORK_HEAD_H

#include "network/layout.h"

typedef struct FfpHeadBlock {
    int64_t first, count; // Gaussians
    int first_token, tokens;
} FfpHeadBlock;

typedef struct FfpHead {
    // Of the present capture: which pixels have a Gaussian.
    int n_blocks;
    FfpHeadBlock *blocks;
    const int64_t *place; // [Gaussians] token * patch^2 + pixel inside the patch
    const real *inputs;   // [tokens, patch^2, channels]
    // Scratch for one block of at most A tokens and P pixels.
    int *slot, *used; // [A] a token's row among those with a Gaussian, or -1; [A] the reverse
    real *tokens;     // [A, dim]
    real *features;   // [A, patch^2, features]
    real *joined;     // [P, features + channels]
    real *hidden[FFP_HIDDEN_LAYERS], *activated[FFP_HIDDEN_LAYERS]; // [P, pixel_hidden]
    real *dtokens, *dfeatures, *djoined, *dhidden, *dactivated;     // backward only; djoined [P, features]
    real *draw;                                                     // [P, numbers]
} FfpHead;

int ffp_head_block_rows(int across); // token rows a block, for images of `across` tokens
void ffp_head_allocate(FfpHead *head, const FfpModelConfig *config, int across, FfpArena *arena);
void ffp_head_allocate_backward(FfpHead *head, const FfpModelConfig *config, int across, FfpArena *arena);

// raw [block->count, numbers] from tokens [T, dim].
void ffp_head_forward(real *raw, FfpHead *head, const FfpHeadBlock *block, const real *tokens,
                      const FfpModel *model);
// ADDS parameter gradients; writes the rows of dtokens [T, dim] that have a Gaussian in this block.
// Recomputes the forward pass: cheaper than to keep it.
void ffp_head_backward(real *dtokens, real *grad, FfpHead *head, const FfpHeadBlock *block, const real *draw,
                       const real *tokens, const FfpModel *model);

#endif
