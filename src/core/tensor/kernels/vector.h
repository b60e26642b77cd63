// The vector that a CPU level works with, as gcc's and clang's vector extension: inside the kernels folder
// only.
#ifndef FFP_TENSOR_KERNELS_VECTOR_H
#define FFP_TENSOR_KERNELS_VECTOR_H

#include <string.h>
#include "core/base/real.h"
#include "core/base/vector.h"

enum { FFP_LANES = FFP_VECTOR_BYTES / sizeof(real) };
typedef real FfpVector __attribute__((vector_size(FFP_VECTOR_BYTES)));

static inline FfpVector ffp_load(const real *from) {
    FfpVector vector;
    memcpy(&vector, from, sizeof vector);
    return vector;
}
static inline void ffp_store(real *to, FfpVector vector) {
    memcpy(to, &vector, sizeof vector);
}

// The first `count` lanes only; the others are 0 when loaded and stay as they are when stored. Any count.
#if defined(__AVX512F__) && !defined(FFP_REAL_DOUBLE)
static inline __mmask16 ffp_first_lanes(int count) {
    return count >= FFP_LANES ? 0xFFFF : count <= 0 ? 0 : (__mmask16)((1U << count) - 1);
}
static inline FfpVector ffp_load_masked(const real *from, int count) {
    return (FfpVector)_mm512_maskz_loadu_ps(ffp_first_lanes(count), from);
}
static inline void ffp_store_masked(real *to, FfpVector vector, int count) {
    _mm512_mask_storeu_ps(to, ffp_first_lanes(count), (__m512)vector);
}
#else
static inline FfpVector ffp_load_masked(const real *from, int count) {
    real lanes[FFP_LANES] = {0};
    if (count >= FFP_LANES) return ffp_load(from);
    for (int i = 0; i < count; i++) lanes[i] = from[i];
    return ffp_load(lanes);
}
static inline void ffp_store_masked(real *to, FfpVector vector, int count) {
    real lanes[FFP_LANES];
    if (count >= FFP_LANES) {
        ffp_store(to, vector);
        return;
    }
    ffp_store(lanes, vector);
    if (count <= 0) return; // told so, gcc 14 does not warn of a copy without bounds
    for (int i = 0; i < count; i++) to[i] = lanes[i];
}
#endif

#endif
