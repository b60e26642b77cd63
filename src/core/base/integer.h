// Integers: the smaller and the larger of two.
#ifndef FFP_BASE_INTEGER_H
#define FFP_BASE_INTEGER_H

static inline int ffp_smaller(int a, int b) {
    return a < b ? a : b;
}

static inline int ffp_larger(int a, int b) {
    return a > b ? a : b;
}

#endif
