// fminf and fmaxf without their rules for NaN, which make them library calls.
#ifndef FFP_SHAPES_SCALAR_H
#define FFP_SHAPES_SCALAR_H

static inline float ffp_min(float a, float b) {
    return a < b ? a : b;
}
static inline float ffp_max(float a, float b) {
    return a > b ? a : b;
}

#endif
