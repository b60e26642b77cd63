// The convolutional head for appearance that the paper compares with (its "CNN App. Head"): albedo, roughness
// and ambient colour are computed from tokens after two 3 x 3 convolutions over their view's grid of tokens,
// everything else from the encoder's tokens.
#ifndef FFP_NETWORK_MIXER_H
#define FFP_NETWORK_MIXER_H

#include "engine/network/layout.h"

#define FFP_APPEARANCE_NUMBERS 7 // the last of each Gaussian's: see splat.h

typedef struct FfpMixer {
    int rows, across, down, dim;                        // tokens; tokens of a view's picture; width
    real *columns;                                      // [rows, 9 dim] each token's neighbours, row by row
    real *hidden, *activated, *out;                     // [rows, dim]
    real *features, *raw;                               // of the head's second pass: map; [block, numbers]
    real *dcolumns, *dhidden, *dout, *dfeatures, *draw; // backward only
} FfpMixer;

void ffp_mixer_allocate(FfpMixer *mixer, const FfpModelConfig *config, int rows, int across, int down,
                        FfpArena *arena);
void ffp_mixer_allocate_backward(FfpMixer *mixer, const FfpModelConfig *config, FfpArena *arena);

// mixer->out from tokens [rows, dim].
void ffp_mixer_forward(FfpMixer *mixer, const real *tokens, const FfpModel *model);
// ADDS to dtokens [rows, dim] and to the parameters' gradient, from mixer->dout.
void ffp_mixer_backward(FfpMixer *mixer, real *dtokens, real *grad, const real *tokens,
                        const FfpModel *model);

// Combines the numbers of `count` Gaussians from the tokens with those from the mixed tokens: the appearance
// of the second replaces that of the first; and splits the gradient of the result again.
void ffp_mixer_concatenate(real *raw, const real *mixed, int64_t count, int numbers);
void ffp_mixer_split(real *draw, real *dmixed, int64_t count, int numbers);

#endif
