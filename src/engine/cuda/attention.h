// Common parts of attention's two passes. Scores are whole matrices [queries, keys], for some heads and some
// queries at a time, so that they take no more than ffp_cuda_attention_bytes. They are kept to base 2: q
// carries log2(e) / sqrt(head_dim), so that the softmax weight is 2^score.
#ifndef FFP_CUDA_ATTENTION_H
#define FFP_CUDA_ATTENTION_H

#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}

#define FFP_ATTENTION_LN_2 0.69314718055994530942f
#define FFP_ATTENTION_LOG2_E 1.44269504088896340736f
enum {
    FFP_ATTENTION_DIM_MAX = 128, // of a head
    FFP_ATTENTION_EACH = FFP_ATTENTION_DIM_MAX / FFP_WARP
};

// Rows of bf16 numbers are filled up to multiples of 8, those of scores, too.
typedef struct FfpAttentionPlan {
    int rows, heads, dim, width;  // width = heads * dim
    int pad, keys;                // dim and rows, filled up
    int group, span;              // heads and queries at a time
    uint16_t *q, *k, *v, *dout;   // [heads, T, pad]: q, k normalised
    float *delta;                 // [heads, T]: dout . out
    float *dq, *dk;               // [heads, T, pad]
    float *scores, *dscores;      // [group, span, keys]: dscores = dout v^T
    uint16_t *weights, *dweights; // the same: P, and the gradient of the scores (to base e)
} FfpAttentionPlan;

// Ends the program with a message when a head is wider than FFP_ATTENTION_DIM_MAX.
FfpAttentionPlan ffp_cuda_attention_plan(const FfpAttentionShape *shape, float *scratch);

// q, k (normalised, with gains), v as bf16; if dout is not NULL, that and delta, too.
void ffp_cuda_attention_prepare(const FfpAttentionPlan *plan, const FfpAttentionInput *in, const float *dout,
                                const float *out);

// `group` heads from `head` on and `span` queries from `query` on.
typedef struct FfpAttentionTile {
    int head, group, query, span;
} FfpAttentionTile;

// out [span, keys] = x y^T of [T, pad] for each head
void ffp_cuda_attention_scores(float *out, const FfpAttentionPlan *plan, const FfpAttentionTile *part,
                               const uint16_t *x, const uint16_t *y);

// to [span, dim] = weights x of [T, pad] for each head; a head's rows begin `stride` behind the one's before.
void ffp_cuda_attention_sum(float *to, int ldt, size_t stride, const uint16_t *weights, const uint16_t *x,
                            const FfpAttentionPlan *plan, const FfpAttentionTile *part);

// The parts one after another: false after the last. Begin with {}.
bool ffp_cuda_attention_next(FfpAttentionTile *part, const FfpAttentionPlan *plan);

#endif
