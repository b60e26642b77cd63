// Packed products, plain form.
#include "tensor/kernels/product.h"

#include <string.h>

#ifdef FFP_BF16
static inline FfpPacked narrow(real x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    if ((bits & 0x7FFFFFFF) > 0x7F800000) return (FfpPacked)(bits >> 16 | 0x40); // NaN stays NaN
    return (FfpPacked)((bits + 0x7FFF + (bits >> 16 & 1)) >> 16);
}
static inline real widen(FfpPacked x) {
    const uint32_t bits = (uint32_t)x << 16;
    real wide;
    memcpy(&wide, &bits, sizeof wide);
    return wide;
}
#else
static inline FfpPacked narrow(real x) {
    return x;
}
static inline real widen(FfpPacked x) {
    return x;
}
#endif

// Where number l of column j lies.
static size_t column_place(int j, int l, size_t depth) {
    return (size_t)(j / FFP_PACK_LINES) * FFP_PACK_LINES * depth +
           (size_t)(l / FFP_PACK_GROUP) * FFP_PACK_LINES * FFP_PACK_GROUP +
           (size_t)(j % FFP_PACK_LINES) * FFP_PACK_GROUP + (size_t)(l % FFP_PACK_GROUP);
}

void FFP_K(pack_rows)(FfpPacked *out, bool transpose, int m, int k, const real *a, int lda) {
    const size_t depth = ffp_packed_depth(k);
    memset(out, 0, ffp_packed_size(m, k) * sizeof *out);
    for (int i = 0; i < m; i++)
        for (int l = 0; l < k; l++)
            out[(size_t)i * depth + l] = narrow(transpose ? a[(size_t)l * lda + i] : a[(size_t)i * lda + l]);
}

void FFP_K(pack_columns)(FfpPacked *out, bool transpose, int k, int n, const real *b, int ldb) {
    const size_t depth = ffp_packed_depth(k);
    memset(out, 0, ffp_packed_size(n, k) * sizeof *out);
    for (int j = 0; j < n; j++)
        for (int l = 0; l < k; l++)
            out[column_place(j, l, depth)] =
                narrow(transpose ? b[(size_t)j * ldb + l] : b[(size_t)l * ldb + j]);
}

void FFP_K(product)(int m, int n, int k, real alpha, const FfpPacked *a, size_t a_depth, const FfpPacked *b,
                    size_t b_depth, real beta, real *c, int ldc) {
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < n; j++) {
            real sum = 0, *out = c + (size_t)i * ldc + j;
            for (int l = 0; l < k; l++)
                sum += widen(a[(size_t)i * a_depth + l]) * widen(b[column_place(j, l, b_depth)]);
            *out = alpha * sum + (beta == 0 ? 0 : beta * *out);
        }
    }
}
