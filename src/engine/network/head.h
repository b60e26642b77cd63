// From the encoder's tokens to the raw numbers of each Gaussian, and back: features of the context's pixels
// by one linear layer per token, their mean at the capture's pixel, and (with pixel_skip) the pixel MLP on
// them and the pixel's own inputs. Works in blocks of Gaussians, to limit the memory for pixels.
#ifndef FFP_NETWORK_HEAD_H
#define FFP_NETWORK_HEAD_H

#include "engine/network/context.h"
#include "engine/network/inputs.h"
#include "engine/network/layout.h"
#include "engine/network/prepared.h"

// Gaussians per block: few on the CPU, for its caches; more on a device, where starting work is expensive.
int ffp_head_block(void);

// Numbers of one token, pixel or Gaussian.
typedef struct FfpHeadWidths {
    int dim, pixels;        // of a token; pixels of its patch
    int features, channels; // that a pixel takes from the map; its own inputs, 0 without pixel_skip
    int gathered;           // both
    int hidden, numbers;    // the most of a pixel's layers; raw
} FfpHeadWidths;

typedef struct FfpHead {
    FfpHeadWidths widths;
    // Of the present capture:
    FfpInputSource source; // the pixels' own inputs
    FfpGrid grid;
    const FfpInitialisation *context; // the context's start, for context_inputs; NULL: none
    const int64_t *pixel;             // [Gaussians] their pixels in the capture
    const FfpPrepared *prepared;      // on a device all of these come from here; NULL on the CPU
    int64_t count;
    int n_used;
    int looks;        // that were taken
    bool looks_only;  // as FfpRun
    int *slot, *used; // [T] a token's row among those that a Gaussian needs, or -1; [T] the reverse
    // Scratch:
    real *tokens;                                                   // [T, dim] those that are needed
    real *gathered;                                                 // [block, features + channels]
    real *context_inputs;                                           // [block, context channels]
    real *hidden[FFP_HIDDEN_LAYERS], *activated[FFP_HIDDEN_LAYERS]; // [block, pixel_hidden]
    real *corrections;                                              // [block, numbers] with looks
    real *dtokens, *dgathered, *dhidden, *dactivated; // backward only; dgathered [block, features]
} FfpHead;

void ffp_head_allocate(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena);
void ffp_head_allocate_backward(FfpHead *head, const FfpModelConfig *config, int rows, FfpArena *arena);
size_t ffp_head_features_count(const FfpModelConfig *config, int rows); // numbers in a map of features

// True if pixels have inputs about their context (inputs.h, context_inputs), and these inputs: out [count,
// context channels]; near: the pixels' own start, far: the context's.
bool ffp_head_has_context_inputs(const FfpModelConfig *config, const FfpGrid *grid,
                                 const FfpInitialisation *context);
void ffp_head_context_inputs(real *out, const int64_t *pixels, int64_t count, const FfpGrid *grid,
                             const FfpInitialisation *near, const FfpInitialisation *far);

// Which tokens the Gaussians need: after source, grid, pixel and count are set.
void ffp_head_select(FfpHead *head, int rows);

// map [n_used, patch^2, features] from tokens [T, dim].
void ffp_head_features(real *map, FfpHead *head, const real *tokens, const FfpModel *model);
// ADDS parameter gradients; writes the rows of dtokens [T, dim] that are needed.
void ffp_head_features_backward(real *dtokens, real *grad, FfpHead *head, const real *dmap,
                                const real *tokens, const FfpModel *model);

// raw [count, numbers] of `count` <= ffp_head_block() Gaussians from `first` on.
void ffp_head_forward(real *raw, FfpHead *head, int64_t first, int count, const real *map,
                      const FfpModel *model);
// ADDS the correction of a look, which follows from `seen` (look.h).
void ffp_head_correct(real *raw, FfpHead *head, int64_t first, int count, const real *map, const real *seen,
                      int look, const FfpModel *model);
// ADDS to dmap and to the parameter gradients; seen: of each look. Recomputes the forward pass: cheaper than
// to keep it.
void ffp_head_backward(real *dmap, real *grad, FfpHead *head, int64_t first, int count, const real *draw,
                       const real *map, real *const seen[FFP_LOOKS_MAX], const FfpModel *model);

// --- pixel_layers.c: between head->gathered and raw. ---

typedef struct FfpPixelLayers {
    const FfpPixelLayout *at;
    const real *more; // [count, columns] the block's further inputs; NULL: none
    int columns;
} FfpPixelLayers;
// Those of the pixel MLP, with what the context tells the block's pixels.
FfpPixelLayers ffp_pixel_layers(FfpHead *head, int64_t first, int count, const FfpModel *model);

// numbers [count, ...] of the last layer.
void ffp_pixel_layers_forward(real *numbers, FfpHead *head, const FfpPixelLayers *layers, int count,
                              const FfpModel *model);
// ADDS to dfeatures [count, features] and to the parameter gradients; a pixel's own inputs need none.
// Recomputes the forward pass.
void ffp_pixel_layers_backward(real *dfeatures, real *grad, FfpHead *head, const FfpPixelLayers *layers,
                               int count, const real *draw, const FfpModel *model);

#endif
