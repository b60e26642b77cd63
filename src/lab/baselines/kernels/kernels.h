// The loops of a field that exist once for each CPU level (core/base/level.h). Numbers of many points lie row
// by row, a row a quantity: rows are `stride` numbers apart, which is a multiple of FFP_FIELD_BLOCK, and so
// are the columns that are worked on.
#ifndef FFP_FIELD_KERNELS_KERNELS_H
#define FFP_FIELD_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "lab/baselines/field.h"

enum { FFP_FIELD_BLOCK = 64 }; // columns

static inline int64_t ffp_field_padded(int64_t count) {
    return (count + FFP_FIELD_BLOCK - 1) / FFP_FIELD_BLOCK * FFP_FIELD_BLOCK;
}

// Rows of a network's run.
typedef struct FfpNetRows {
    int64_t stride, columns;
    const real *in;
    real *hidden[FFP_FIELD_LAYERS - 1]; // [FFP_FIELD_WIDTH, stride]
    real *out;
} FfpNetRows;

// Features of the points (position: [3,stride], in [-1,1]) into [FFP_FIELD_ENCODED,stride]: trilinear
// interpolation of each level's grid points. Mueller et al. 2022, section 3.
typedef void FfpFieldEncode(const FfpFieldLayout *layout, const real *parameters, const real *position,
                            int64_t count, int64_t stride, real *encoded);
// ADDS one level's part of d encoded, taken back to the grid's numbers, to grad.
typedef void FfpFieldScatter(const FfpGridLevel *level, const real *position, int64_t count, int64_t stride,
                             const real *d_encoded, real *grad);
typedef void FfpFieldForward(const FfpFieldNet *net, const real *parameters, const FfpNetRows *rows);
// From d out (0 in columns without a point) to the numbers of the net, ADDED to grad, and to the first
// `d_rows` rows of d in: added if `add`, otherwise set. `scratch`: two areas of [FFP_FIELD_WIDTH, stride].
typedef void FfpFieldBackward(const FfpFieldNet *net, const real *parameters, const FfpNetRows *rows,
                              const real *d_out, int d_rows, bool add, real *d_in, real *const scratch[2],
                              real *grad);

typedef struct FfpFieldKernels {
    FfpFieldEncode *encode;
    FfpFieldScatter *scatter;
    FfpFieldForward *forward;
    FfpFieldBackward *backward;
} FfpFieldKernels;

FFP_LOOP_TABLES(FfpFieldKernels, field)

#ifdef FFP_LEVEL
FfpFieldEncode FFP_K(field_encode);
FfpFieldScatter FFP_K(field_scatter);
FfpFieldForward FFP_K(field_forward);
FfpFieldBackward FFP_K(field_backward);
#endif

#endif
