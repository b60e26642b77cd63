// Numbers on their way into a packed operand (product.h). Inside the kernels folder only.
#ifndef FFP_TENSOR_KERNELS_NARROW_H
#define FFP_TENSOR_KERNELS_NARROW_H

#include "core/tensor/kernels/product.h"

// Rounded to nearest even. The quiet NaN that arithmetic makes stays one; no branch, so that loops vectorise.
static inline FfpPacked ffp_narrow(real x) {
#ifdef FFP_BF16
    union {
        real number;
        uint32_t bits;
    } wide = {.number = x};
    return (FfpPacked)((wide.bits + 0x7FFF + (wide.bits >> 16 & 1)) >> 16);
#else
    return x;
#endif
}

#endif
