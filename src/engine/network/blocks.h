// The encoder's two kinds of block, forward and backward.
#ifndef FFP_NETWORK_BLOCKS_H
#define FFP_NETWORK_BLOCKS_H

#include "core/base/log.h"
#include "engine/network/layout.h"

// The values that a block keeps for its backward pass, T = rows. Its input x [T, dim] belongs to the caller.
typedef struct FfpMambaActivations {
    real *norm, *rstd; // [T, dim], [T]
    real *projected;   // [T, projected]
    struct {
        real *convolved, *scanned, *rstd; // [T, convolved], [T, inner], [T]
    } direction[2];
    real *summed; // [T, inner]
} FfpMambaActivations;

typedef struct FfpTransformerActivations {
    real *norm1, *mean1, *rstd1, *qkv, *log_sum,
        *attended; // [T, dim], [T], [T], [T, 3 dim], [heads, T], [T, dim]
    real *middle, *norm2, *mean2, *rstd2, *hidden, *activated; // .., [T, 4 dim], [T, 4 dim]
} FfpTransformerActivations;

// Shared by all blocks; contents last no longer than a call. The gradients are there from the first backward
// pass on.
typedef struct FfpScratch {
    real *kernel;             // the scan's and attention's
    real *inner;              // [T, inner]
    real *dwide, *dwide2;     // [T, widest of projected and 4 dim]
    real *dinner;             // [T, inner]
    real *dnarrow, *dnarrow2; // [T, dim]
} FfpScratch;

// A pass through blocks: the arguments common to all of them.
typedef struct FfpBlockPass {
    const real *values; // the model's, in which layouts are offsets
    const FfpWidths *widths;
    int rows;
    const FfpScratch *scratch;
    FfpProfileTimes *times; // where the seconds of their parts are added
} FfpBlockPass;

size_t ffp_kernel_scratch(const FfpWidths *widths, int rows);

// Without a backward pass to come, what one direction leaves behind is the other's memory.
void ffp_mamba_allocate(FfpMambaActivations *at, const FfpWidths *widths, int rows, bool backward,
                        FfpArena *arena);
// y = x + out_proj(sum over directions of norm(scan(conv(in_proj(norm(x)))))): Mamba2's block (Dao & Gu 2024,
// Sec. 7.1), scanned both ways as in Vim (Zhu et al. 2024, Alg. 1). x, y [rows, dim].
void ffp_mamba_forward(real *y, FfpMambaActivations *at, const real *x, const FfpMambaLayout *layout,
                       const FfpBlockPass *pass);
// dx [rows, dim]: in, the gradient of y; out, that of x. ADDS to grad, which is laid out as values.
void ffp_mamba_backward(real *dx, real *grad, const FfpMambaActivations *at, const real *x,
                        const FfpMambaLayout *layout, const FfpBlockPass *pass);

void ffp_transformer_allocate(FfpTransformerActivations *at, const FfpWidths *widths, int rows,
                              FfpArena *arena);
// m = x + proj(attention(qkv(norm(x)))), y = m + fc2(gelu(fc1(norm(m))))
void ffp_transformer_forward(real *y, FfpTransformerActivations *at, const real *x,
                             const FfpTransformerLayout *layout, const FfpBlockPass *pass);
void ffp_transformer_backward(real *dx, real *grad, const FfpTransformerActivations *at, const real *x,
                              const FfpTransformerLayout *layout, const FfpBlockPass *pass);

// Adds the time since *last to *part, and starts the next lap.
static inline void ffp_lap(double *last, double *part) {
    const double now = ffp_seconds();
    *part += now - *last;
    *last = now;
}

#endif
